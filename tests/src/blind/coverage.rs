//! Does a 95 % interval hold the truth? Every parameter that rig and library state alike, friction and restitution too.

use rig::{Effect, Truth};
use serde::{Deserialize, Serialize};

use super::judged::Figure;
use super::proportion::Proportion;
use super::set::DiagnosedSet;

/// One interval beside its truth.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Covered {
    /// `friction`, `restitution`, or `effect.parameter`.
    pub parameter: String,
    /// The rig's value.
    pub truth: f64,
    /// The interval.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

impl Covered {
    /// Whether the interval holds the truth.
    pub fn holds(&self) -> bool {
        self.low <= self.truth && self.truth <= self.high
    }
}

/// How many intervals hold the truth: of all parameters, and of the two that every set has.
pub fn figures(covered: &[&Covered]) -> [Figure; 3] {
    let figure = |what, goal, parameter: Option<&str>| {
        let of_it = |c: &&&Covered| parameter.is_none_or(|name| c.parameter == name);
        Figure {
            what,
            goal,
            got: Proportion::of(covered.iter().filter(of_it), |c| c.holds()),
        }
    };
    [
        figure(
            "95 % intervals that hold the truth, all parameters",
            "92–97 %",
            None,
        ),
        figure("of these, friction", "", Some("friction")),
        figure("of these, restitution", "", Some("restitution")),
    ]
}

/// Parameters by the rig's effect and name and the library's, where both formulas give the parameter the same meaning; `true`
/// where that needs the rig's effect in the library's own form.
const ALIKE: &[(&str, &str, &str, &str, bool)] = &[
    ("viscous_drag", "c", "viscous_drag", "rate", false),
    (
        "quadratic_drag",
        "k",
        "quadratic_drag",
        "coefficient",
        false,
    ),
    ("table_tilt", "t_x", "table_tilt", "tilt_x", false),
    ("table_tilt", "t_y", "table_tilt", "tilt_y", false),
    ("table_bowl", "kappa", "table_bowl", "curvature", false),
    ("table_bowl", "center_x", "table_bowl", "center_x", false),
    ("table_bowl", "center_y", "table_bowl", "center_y", false),
    (
        "striker_angle_bias",
        "delta",
        "striker_angle_bias",
        "bias",
        false,
    ),
    (
        "speed_weakening_friction",
        "delta",
        "speed_weakening_friction",
        "rise",
        true,
    ),
    (
        "speed_weakening_friction",
        "v_s",
        "speed_weakening_friction",
        "speed",
        true,
    ),
    (
        "friction_patch",
        "center_x",
        "friction_patch",
        "center_x",
        false,
    ),
    (
        "friction_patch",
        "center_y",
        "friction_patch",
        "center_y",
        false,
    ),
    ("friction_patch", "radius", "friction_patch", "radius", true),
    ("friction_patch", "change", "friction_patch", "change", true),
    (
        "rectangular_patch",
        "center_x",
        "friction_patch",
        "center_x",
        false,
    ),
    (
        "rectangular_patch",
        "center_y",
        "friction_patch",
        "center_y",
        false,
    ),
    (
        "camera_rotation",
        "angle",
        "camera_rotation",
        "angle",
        false,
    ),
    (
        "off_centre_contact",
        "offset",
        "off_centre_contact",
        "offset",
        false,
    ),
];

/// Effects beside which the rig's friction keeps its meaning for the library, once the effect is named; those of the second list
/// where the rig has them in the library's own form.
const KEEPS_FRICTION: &[&str] = &[
    "viscous_drag",
    "quadratic_drag",
    "table_tilt",
    "warped_tilt",
    "table_bowl",
    "sine_bowl",
    "trough",
    "striker_angle_bias",
    "striker_angle_error",
    "angle_backlash",
    "striker_angle_by_session",
    "camera_angle_by_session",
    "off_centre_contact",
    "camera_rotation",
    "striker_speed_error",
    "tanh_speed",
    "rounded_speed",
    "speed_dependent_restitution",
    "viscoelastic_restitution",
    "yielding_restitution",
    "restitution_drift",
    "restitution_step",
    "camera_scale",
];
const KEEPS_FRICTION_AS_TEXTBOOK: &[&str] = &["speed_weakening_friction", "friction_patch"];
/// Effects beside which the rig's restitution loses its meaning: one factor of launch is the same thing.
const CHANGES_RESTITUTION: &[&str] = &[
    "striker_speed_error",
    "tanh_speed",
    "rounded_speed",
    "striker_error_by_place",
    "speed_by_reach",
    "speed_dependent_restitution",
    "viscoelastic_restitution",
    "yielding_restitution",
    "restitution_drift",
    "restitution_step",
    "off_centre_contact",
    "camera_lean",
    "camera_distortion",
    "brown_lens",
];

/// The intervals of a set. Friction and restitution count where nothing is hidden, whatever was said; where effects are hidden,
/// they and the effects' parameters count where each name is just what is hidden (`hidden`, by the rig's names).
pub(super) fn covered(hidden: &[String], is_textbook: bool, done: &DiagnosedSet) -> Vec<Covered> {
    let named = &done.found.diagnosis.effects;
    let names = named
        .iter()
        .map(|e| (e.name.clone(), Vec::new()))
        .collect::<Vec<_>>();
    let is_exact = named.len() == hidden.len() && super::hard::said(hidden, &names) == hidden.len();
    if !hidden.is_empty() && !is_exact {
        return Vec::new();
    }
    let mut all = base(is_textbook, done);
    for effect in &done.truth.hidden.0 {
        for (theirs, parameter, library, name, needs_textbook) in ALIKE {
            let Some(found) = named.iter().find(|e| e.name == *library) else {
                continue;
            };
            if effect.name() != *theirs || (*needs_textbook && !is_textbook) {
                continue;
            }
            if let (Some(truth), Some(found)) = (effect.get(parameter), found.parameters.get(*name))
            {
                all.push(Covered {
                    parameter: format!("{library}.{name}"),
                    truth,
                    low: found.low,
                    high: found.high,
                });
            }
        }
    }
    all
}

/// Friction and restitution, where they have one truth: of the world with what was named, or of the identified one.
fn base(is_textbook: bool, done: &DiagnosedSet) -> Vec<Covered> {
    let world = done.found.world.as_ref().unwrap_or(&done.input.world);
    let truth = &done.truth;
    let effects = || truth.hidden.0.iter().map(Effect::name);
    let keeps_friction = effects().all(|name| {
        KEEPS_FRICTION.contains(&name)
            || (is_textbook && KEEPS_FRICTION_AS_TEXTBOOK.contains(&name))
    });
    let keeps_restitution = effects().all(|name| !CHANGES_RESTITUTION.contains(&name));
    let scale = 1.0 + camera_scale(truth);
    let mut all = Vec::new();
    let mut add = |name: &str, truth: f64| {
        let estimate = world.parameters.get(name);
        if let Some((low, high)) = estimate.and_then(|e| Some((e.low?, e.high?))) {
            all.push(Covered {
                parameter: name.into(),
                truth,
                low,
                high,
            });
        }
    };
    if keeps_friction {
        // Lengths that the camera reports too long make decelerations and speeds as much too large.
        add("friction", truth.friction * scale * wander(done));
    }
    if keeps_restitution {
        add("restitution", (1.0 + truth.restitution) * scale - 1.0);
    }
    all
}

/// Share by which the camera's scale is too long.
fn camera_scale(truth: &Truth) -> f64 {
    let scale = truth.hidden.0.iter().find(|e| e.name() == "camera_scale");
    scale.and_then(|e| e.get("excess")).unwrap_or(0.0)
}

/// Mean factor that a wandering friction had over the strikes: a walk has no mean of its own.
fn wander(done: &DiagnosedSet) -> f64 {
    let wanders = done
        .truth
        .noise
        .0
        .iter()
        .any(|n| n.name() == "friction_wander");
    let factors: Vec<f64> = done.really.iter().filter_map(|s| s.friction).collect();
    if !wanders || factors.is_empty() {
        return 1.0;
    }
    (factors.iter().map(|f| f.ln()).sum::<f64>() / factors.len() as f64).exp()
}
