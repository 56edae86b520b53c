//! The grading table: which names are right for what is hidden, after the contract's table of effects and its classes.
//!
//! An answer is right where it has as many effects as are hidden, and each hidden phenomenon is one of them: by a right name, or
//! by a right name among those that the diagnosis says it cannot distinguish from it (`equivalent`).

use super::kind::HardKind;

/// A phenomenon that the rig can hide, and what is right to say of it: names, or verdicts without a name.
type Right = (&'static str, &'static [&'static str]);

const RIGHT: &[(HardKind, &[Right])] = &[
    (
        HardKind::Single,
        &[
            // Drag. Between powers 1 and 2 either name is the phenomenon.
            ("viscous_drag", &["viscous_drag"]),
            ("quadratic_drag", &["quadratic_drag"]),
            ("power_drag", &["viscous_drag", "quadratic_drag"]),
            // Friction that rises as the object slows.
            ("speed_weakening_friction", &["speed_weakening_friction"]),
            ("rational_stribeck", &["speed_weakening_friction"]),
            ("logarithmic_stribeck", &["speed_weakening_friction"]),
            // Friction that depends on the direction.
            ("anisotropic_friction", &["anisotropic_friction"]),
            ("cosine_grain", &["anisotropic_friction"]),
            // Friction that depends on the place.
            ("friction_patch", &["friction_patch"]),
            ("rectangular_patch", &["friction_patch"]),
            ("friction_gradient", &["friction_gradient"]),
            ("friction_step", &["friction_step"]),
            ("friction_map", &["friction_map"]),
            // What changes with time.
            ("friction_drift", &["friction_drift"]),
            ("running_in", &["friction_drift"]),
            ("linear_wear", &["friction_drift"]),
            ("friction_by_session", &["friction_by_session"]),
            ("friction_of_sessions", &["friction_by_session"]),
            ("restitution_drift", &["restitution_drift"]),
            ("restitution_step", &["restitution_drift"]),
            ("striker_angle_by_session", &["striker_angle_by_session"]),
            ("camera_angle_by_session", &["striker_angle_by_session"]),
            // The table's shape. A saddle is a bowl of two signs.
            ("table_tilt", &["table_tilt"]),
            ("warped_tilt", &["table_tilt"]),
            ("table_bowl", &["table_bowl"]),
            ("sine_bowl", &["table_bowl"]),
            ("trough", &["table_bowl"]),
            ("saddle", &["table_bowl", "table_map"]),
            ("table_map", &["table_map", "unexplained"]),
            // The arm and the impact.
            ("striker_speed_error", &["striker_speed_error"]),
            ("tanh_speed", &["striker_speed_error"]),
            ("rounded_speed", &["striker_speed_error"]),
            ("striker_angle_bias", &["striker_angle_bias"]),
            ("striker_angle_error", &["striker_angle_error"]),
            ("angle_backlash", &["striker_angle_error"]),
            ("off_centre_contact", &["off_centre_contact"]),
            (
                "speed_dependent_restitution",
                &["speed_dependent_restitution"],
            ),
            ("viscoelastic_restitution", &["speed_dependent_restitution"]),
            ("yielding_restitution", &["speed_dependent_restitution"]),
            // The camera.
            ("camera_rotation", &["camera_rotation"]),
            ("camera_distortion", &["camera_distortion"]),
            ("brown_lens", &["camera_distortion"]),
            ("off_centre_lens", &["camera_distortion", "unexplained"]),
            ("camera_lean", &["camera_lean"]),
        ],
    ),
    (
        HardKind::Foreign,
        &[
            ("air_jet", &["unexplained"]),
            ("sticky_line", &["unexplained"]),
            ("vibration", &["unexplained"]),
            ("magnet", &["unexplained"]),
            ("side_force", &["unexplained"]),
            ("swirl", &["unexplained"]),
            ("sloshing", &["unexplained"]),
            ("friction_ageing", &["unexplained"]),
            ("speed_ripple", &["unexplained"]),
            ("angle_ripple", &["unexplained"]),
            ("stitched_cameras", &["unexplained"]),
        ],
    ),
    (
        HardKind::Place,
        &[
            (
                "striker_error_by_place",
                &["striker_error_by_place", "unexplained"],
            ),
            ("speed_by_reach", &["striker_error_by_place", "unexplained"]),
            (
                "heading_by_bearing",
                &["striker_error_by_place", "unexplained"],
            ),
        ],
    ),
    (
        HardKind::Order,
        &[
            // Friction that changes once, for good or not, does change with the strike's number.
            ("friction_change", &["friction_drift", "unexplained"]),
            ("sanded_table", &["friction_drift", "unexplained"]),
            // What comes again and again is no drift, and no session has a friction of its own.
            ("friction_cycle", &["unexplained"]),
            ("wiped_table", &["unexplained"]),
            ("warming_arm", &["unexplained"]),
            ("pushed_camera", &["unexplained"]),
        ],
    ),
    (
        // Nothing that a command could foretell, or that stops show: whether it is seen is a matter of taste, a name is wrong.
        HardKind::Odd,
        &[
            ("two_objects", &["consistent", "unexplained"]),
            ("rolling_shutter", &["consistent", "unexplained"]),
        ],
    ),
];

/// What may be said without a name.
const VERDICTS: [&str; 2] = ["consistent", "unexplained"];

/// Library names that are the same by construction, or nearly so: two phenomena of one group are not hidden together.
const GROUPS: &[&[&str]] = &[
    &["viscous_drag", "quadratic_drag", "speed_weakening_friction"],
    &[
        "friction_patch",
        "friction_gradient",
        "friction_step",
        "friction_map",
    ],
    &["friction_drift", "friction_by_session"],
    &["table_tilt", "table_bowl"],
    &["striker_speed_error", "speed_dependent_restitution"],
    &[
        "striker_angle_bias",
        "striker_angle_error",
        "striker_angle_by_session",
        "off_centre_contact",
        "camera_rotation",
    ],
    &["camera_distortion", "camera_lean"],
];

pub fn phenomena(kind: HardKind) -> impl Iterator<Item = &'static str> {
    let listed = RIGHT.iter().filter(move |(of, _)| *of == kind.listed());
    listed.flat_map(|(_, all)| all.iter().map(|(hidden, _)| *hidden))
}

pub fn table() -> impl Iterator<Item = &'static Right> {
    RIGHT.iter().flat_map(|(_, all)| all.iter())
}

/// What is right to say of what is hidden: names, and verdicts.
pub fn right(hidden: &str) -> &'static [&'static str] {
    table()
        .find(|(name, _)| *name == hidden)
        .map_or(&[], |(_, right)| *right)
}

pub fn is_nameable(hidden: &str) -> bool {
    right(hidden).iter().any(|said| !VERDICTS.contains(said))
}

/// Whether two phenomena may be hidden together: nothing that is right for one is right or nearly right for the other.
pub fn can_be_distinguished(one: &str, other: &str) -> bool {
    let (one, other) = (right(one), right(other));
    let in_group = |group: &[&str], names: &[&str]| names.iter().any(|name| group.contains(name));
    !one.iter().any(|name| other.contains(name))
        && !GROUPS
            .iter()
            .any(|group| in_group(group, one) && in_group(group, other))
}

/// A named effect and those that the diagnosis says it cannot distinguish from it.
pub type Named = (String, Vec<String>);

fn says(named: &Named, hidden: &str) -> bool {
    let (name, equivalent) = named;
    let right = right(hidden);
    right.contains(&name.as_str()) || equivalent.iter().any(|e| right.contains(&e.as_str()))
}

/// Number of hidden phenomena that are said, each by a named effect of its own.
pub fn said(hidden: &[String], named: &[Named]) -> usize {
    // So few of both that all assignments can be tried.
    match hidden.split_first() {
        None => 0,
        Some((first, others)) => {
            let without = said(others, named);
            let with = (0..named.len())
                .filter(|i| says(&named[*i], first))
                .map(|i| {
                    let mut left = named.to_vec();
                    left.remove(i);
                    1 + said(others, &left)
                })
                .max()
                .unwrap_or(0);
            with.max(without)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(list: &[(&str, &[&str])]) -> Vec<Named> {
        list.iter()
            .map(|(name, equivalent)| {
                let equivalent = equivalent.iter().map(|e| e.to_string()).collect();
                (name.to_string(), equivalent)
            })
            .collect()
    }

    #[test]
    fn the_table_has_everything_that_the_rig_hides_and_only_names_of_the_contract() {
        for effect in rig::Effect::all() {
            let is_noise = effect.name() == "camera_scale";
            let is_listed = table().any(|(name, _)| *name == effect.name());
            let name = effect.name();
            assert!(
                is_listed != is_noise,
                "`{name}` needs a row: what may be said of it"
            );
        }
        for (hidden, right) in table() {
            let is_odd = phenomena(HardKind::Odd).any(|odd| odd == *hidden);
            assert_eq!(rig::NoiseKind::named(hidden).is_some(), is_odd, "{hidden}");
            let is_known =
                |said: &&str| VERDICTS.contains(said) || rig::Effect::named(said).is_some();
            assert!(right.iter().all(is_known), "{hidden}");
        }
    }

    #[test]
    fn each_named_effect_says_one_hidden_thing() {
        let hidden = ["rectangular_patch".to_string(), "trough".to_string()];
        let both = named(&[("table_bowl", &[]), ("friction_patch", &[])]);
        assert_eq!(said(&hidden, &both), 2);
        // One name with a class cannot stand for both.
        let one = named(&[("table_bowl", &["friction_patch"])]);
        assert_eq!(said(&hidden, &one), 1);
        assert_eq!(said(&hidden, &named(&[("camera_lean", &[])])), 0);
    }

    #[test]
    fn near_equivalents_are_not_hidden_together() {
        assert!(!can_be_distinguished("viscous_drag", "rational_stribeck"));
        assert!(!can_be_distinguished("tanh_speed", "yielding_restitution"));
        assert!(can_be_distinguished("tanh_speed", "cosine_grain"));
    }
}
