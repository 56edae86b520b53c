//! Which sets of strikes are made.

use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Single,
    Pair,
    Control,
    Foreign,
}

impl Case {
    /// Whether a box is struck; sets of boxes are judged apart from the rest.
    pub fn is_box(&self) -> bool {
        self.variant == "box"
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Says all of it; the key by which a run resumes.
    pub id: String,
    pub kind: Kind,
    /// What is hidden, by name.
    pub hidden: Vec<String>,
    /// Root-mean-square shift of the stops that each effect makes, in units of the rig's noise floor.
    pub magnitude: f64,
    pub strikes: usize,
    /// Where everything random comes from.
    pub seed: u64,
    /// `plain` (the effect in a random form), `noise` (a camera three times as noisy), `dropped` (every tenth frame lost), `start` (friction believed to be
    /// twice or half as high), `textbook` (the effect in the library's own form, to see what intervals cover) or `box` (in place of
    /// the cylinder, struck on its face by a tip whose friction is believed to be two thirds of what it is).
    pub variant: String,
}

/// The contract's effects.
pub const EFFECTS: [&str; 15] = [
    "viscous_drag",
    "quadratic_drag",
    "speed_weakening_friction",
    "anisotropic_friction",
    "friction_patch",
    "friction_drift",
    "friction_by_session",
    "table_tilt",
    "table_bowl",
    "striker_speed_error",
    "striker_angle_bias",
    "speed_dependent_restitution",
    "off_centre_contact",
    "camera_rotation",
    "camera_distortion",
];

pub const FOREIGN: [&str; 3] = ["air_jet", "sticky_line", "vibration"];

/// Effects that are the same by construction, or nearly so (contract, section 5): a pair of one class is one effect.
pub const CLASSES: [&[&str]; 2] = [
    &[
        "striker_angle_bias",
        "camera_rotation",
        "off_centre_contact",
    ],
    &["striker_speed_error", "speed_dependent_restitution"],
];

/// Magnitudes in units of the noise floor.
pub const MAGNITUDES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// Effects along the slide: those for which a regression on accelerations has a term.
pub const SLIDING: &[&str] = EFFECTS.split_at(9).0;

pub const STRIKES: [usize; 2] = [40, 120];

/// Sets, each with a seed of its own: launches and camera scatter anew in each.
struct Cases {
    first: u64,
    all: Vec<Case>,
}

impl Cases {
    fn add(
        &mut self,
        kind: Kind,
        hidden: &[&str],
        magnitude: f64,
        (strikes, variant): (usize, &str),
    ) {
        let seed = self.first + self.all.len() as u64;
        let name = match kind {
            Kind::Control => "nothing".into(),
            _ => hidden.join("+"),
        };
        self.all.push(Case {
            id: format!("{name}-x{magnitude}-n{strikes}-{variant}-s{seed}"),
            kind,
            hidden: hidden.iter().map(|h| h.to_string()).collect(),
            magnitude,
            strikes,
            seed,
            variant: variant.into(),
        });
    }
}

/// All sets of the benchmark; `seeds` for each combination, and seeds from `first` on.
pub fn cases(seeds: u64, first: u64) -> Vec<Case> {
    let all = Vec::new();
    let mut sets = Cases { first, all };
    for variant in ["plain", "plain", "noise", "dropped", "start"] {
        for strikes in STRIKES {
            for _ in 0..10 * seeds {
                sets.add(Kind::Control, &[], 0.0, (strikes, variant));
            }
        }
    }
    for effect in EFFECTS {
        for magnitude in MAGNITUDES {
            for strikes in STRIKES {
                // Weak effects are there for the curve alone.
                let count = if magnitude < 2.0 { 1 } else { seeds };
                for i in 0..count {
                    let variant = if i % 2 == 0 { "plain" } else { "textbook" };
                    sets.add(Kind::Single, &[effect], magnitude, (strikes, variant));
                }
            }
        }
    }
    for effect in FOREIGN {
        for magnitude in [2.0, 4.0] {
            for strikes in STRIKES {
                for _ in 0..seeds {
                    sets.add(Kind::Foreign, &[effect], magnitude, (strikes, "plain"));
                }
            }
        }
    }
    for _ in 0..10 * seeds {
        sets.add(Kind::Control, &[], 0.0, (120, "box"));
    }
    for i in 0..10 * seeds as usize {
        let effect = EFFECTS[i % EFFECTS.len()];
        sets.add(Kind::Single, &[effect], 2.0, (120, "box"));
    }
    // Every effect meets others, never one of its own class.
    for step in 1..=seeds as usize {
        for (i, one) in EFFECTS.iter().enumerate() {
            let other = EFFECTS[(i + 3 * step + 1) % EFFECTS.len()];
            let is_one_class = CLASSES
                .iter()
                .any(|class| class.contains(one) && class.contains(&other));
            if !is_one_class && *one != other {
                sets.add(Kind::Pair, &[one, other], 2.0, (120, "plain"));
            }
        }
    }
    sets.all
}

/// The few sets that every test run makes: on other seeds than the benchmark's.
pub fn slice() -> Vec<Case> {
    let (first, all) = (9_000, Vec::new());
    let mut sets = Cases { first, all };
    let (few, many) = ((40, "plain"), (120, "plain"));
    sets.add(Kind::Control, &[], 0.0, few);
    sets.add(Kind::Control, &[], 0.0, (120, "noise"));
    sets.add(Kind::Single, &["table_tilt"], 2.0, few);
    sets.add(Kind::Single, &["friction_patch"], 4.0, many);
    sets.add(Kind::Single, &["speed_weakening_friction"], 2.0, many);
    sets.add(Kind::Single, &["camera_distortion"], 2.0, many);
    sets.add(Kind::Foreign, &["vibration"], 4.0, many);
    sets.add(Kind::Pair, &["table_tilt", "viscous_drag"], 2.0, many);
    sets.all
}
