//! Parameters that rig and library state alike: does the interval hold the truth?

use diagnose::Found;
use rig::Truth;
use serde::{Deserialize, Serialize};

use super::cases::Case;

/// One interval beside its truth.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Covered {
    /// `effect.parameter`.
    pub parameter: String,
    /// The rig's value.
    pub truth: f64,
    /// The interval.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// Parameters by the rig's name and the library's, of effects whose formula is the same in both (`textbook` where the rig has
/// a form of its own besides).
const ALIKE: &[(&str, &str, &str, bool)] = &[
    ("viscous_drag", "c", "rate", false),
    ("quadratic_drag", "k", "coefficient", false),
    ("table_tilt", "t_x", "tilt_x", false),
    ("table_tilt", "t_y", "tilt_y", false),
    ("table_bowl", "kappa", "curvature", false),
    ("table_bowl", "center_x", "center_x", false),
    ("table_bowl", "center_y", "center_y", false),
    ("striker_angle_bias", "delta", "bias", false),
    ("speed_weakening_friction", "delta", "rise", true),
    ("speed_weakening_friction", "v_s", "speed", true),
    ("friction_patch", "center_x", "center_x", true),
    ("friction_patch", "center_y", "center_y", true),
    ("friction_patch", "radius", "radius", true),
    ("friction_patch", "change", "change", true),
];

/// The intervals of a diagnosis that named just what is hidden.
pub fn covered(case: &Case, truth: &Truth, found: &Found) -> Vec<Covered> {
    let named = &found.diagnosis.effects;
    let is_same = named.len() == case.hidden.len()
        && named.iter().all(|effect| case.hidden.contains(&effect.name));
    if !is_same {
        return Vec::new();
    }
    let mut all = Vec::new();
    for effect in named {
        let hidden = truth.hidden.0.iter().find(|h| h.name() == effect.name);
        for (name, theirs, ours, needs_textbook) in ALIKE {
            let is_alike = !needs_textbook || case.variant == "textbook";
            let Some((hidden, parameter)) = hidden
                .filter(|_| effect.name == *name && is_alike)
                .and_then(|h| Some((h, effect.parameters.get(*ours)?)))
            else {
                continue;
            };
            all.push(Covered {
                parameter: format!("{name}.{ours}"),
                truth: hidden.get(theirs).unwrap_or(f64::NAN),
                low: parameter.low,
                high: parameter.high,
            });
        }
    }
    all
}
