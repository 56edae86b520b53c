//! Does a 95 % interval hold the truth? Every parameter that rig and library state alike, friction and restitution too.

use rig::{Effect, Truth};
use serde::{Deserialize, Serialize};

use super::judged::{Figure, Proportion};
use super::set::DiagnosedSet;

/// One interval beside its truth.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Covered {
    /// `friction`, `restitution`, or `effect.parameter`.
    pub parameter: String,
    /// The rig's value.
    pub truth: f64,
    pub low: f64,
    pub high: f64,
}

impl Covered {
    pub fn holds(&self) -> bool {
        self.low <= self.truth && self.truth <= self.high
    }
}

/// Proportion of intervals that hold the truth: of all parameters, and of the two that every set has.
pub fn figures(covered: &[&Covered]) -> [Figure; 3] {
    let figure = |what, goal, parameter: Option<&str>| {
        let of_it = |c: &&&Covered| parameter.is_none_or(|name| c.parameter == name);
        let got = Proportion::of(covered.iter().filter(of_it), |c| c.holds());
        Figure::new(what, goal, got)
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

/// Parameters by the rig's effect and name and the library's, where both formulas give the parameter the same meaning; with a `*`
/// where that needs the rig's effect in the library's own form.
const ALIKE: &str = "\
viscous_drag.c = viscous_drag.rate
quadratic_drag.k = quadratic_drag.coefficient
table_tilt.t_x = table_tilt.tilt_x
table_tilt.t_y = table_tilt.tilt_y
table_bowl.kappa = table_bowl.curvature
table_bowl.center_x = table_bowl.center_x
table_bowl.center_y = table_bowl.center_y
striker_angle_bias.delta = striker_angle_bias.bias
speed_weakening_friction.delta = speed_weakening_friction.rise *
speed_weakening_friction.v_s = speed_weakening_friction.speed *
friction_patch.center_x = friction_patch.center_x
friction_patch.center_y = friction_patch.center_y
friction_patch.radius = friction_patch.radius *
friction_patch.change = friction_patch.change *
rectangular_patch.center_x = friction_patch.center_x
rectangular_patch.center_y = friction_patch.center_y
camera_rotation.angle = camera_rotation.angle
off_centre_contact.offset = off_centre_contact.offset";

/// Effects beside which the rig's friction keeps its meaning for the library, once the effect is named; those of the second list
/// where the rig has them in the library's own form.
const KEEPS_FRICTION: &str = "\
    viscous_drag quadratic_drag table_tilt warped_tilt table_bowl sine_bowl trough striker_angle_bias
    striker_angle_error angle_backlash striker_angle_by_session camera_angle_by_session off_centre_contact
    camera_rotation striker_speed_error tanh_speed rounded_speed speed_dependent_restitution
    viscoelastic_restitution yielding_restitution restitution_drift restitution_step camera_scale";
const KEEPS_FRICTION_AS_TEXTBOOK: &str = "speed_weakening_friction friction_patch";
/// Effects beside which the rig's restitution loses its meaning: one factor of launch is the same thing.
const CHANGES_RESTITUTION: &str = "\
    striker_speed_error tanh_speed rounded_speed striker_error_by_place speed_by_reach speed_dependent_restitution
    viscoelastic_restitution yielding_restitution restitution_drift restitution_step off_centre_contact
    camera_lean camera_distortion brown_lens";

fn lists(list: &str, name: &str) -> bool {
    list.split_whitespace().any(|listed| listed == name)
}

/// The rows of [`ALIKE`].
fn alike() -> impl Iterator<Item = ([&'static str; 2], [&'static str; 2], bool)> {
    ALIKE.lines().filter_map(|line| {
        let (theirs, library) = line.split_once(" = ")?;
        let plain = library.trim_end_matches(" *");
        let halves = |both: &'static str| both.split_once('.').map(|(a, b)| [a, b]);
        Some((halves(theirs)?, halves(plain)?, plain != library))
    })
}

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
        for ([theirs, parameter], [library, name], needs_textbook) in alike() {
            let Some(found) = named.iter().find(|e| e.name == library) else {
                continue;
            };
            if effect.name() != theirs || (needs_textbook && !is_textbook) {
                continue;
            }
            if let (Some(truth), Some(found)) = (effect.get(parameter), found.parameters.get(name))
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
        lists(KEEPS_FRICTION, name) || (is_textbook && lists(KEEPS_FRICTION_AS_TEXTBOOK, name))
    });
    let keeps_restitution = effects().all(|name| !lists(CHANGES_RESTITUTION, name));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_is_the_rigs_and_the_librarys() {
        assert_eq!(alike().count(), ALIKE.lines().count());
        for ([theirs, parameter], [library, name], _) in alike() {
            let effect = Effect::named(theirs).expect("the rig's");
            assert!(effect.get(parameter).is_some(), "{theirs}.{parameter}");
            let spec = world::effects::effect(library).expect("the library's");
            assert!(spec.parameter(name).is_some(), "{library}.{name}");
        }
    }
}
