//! Which hard sets are made: each is drawn at random from its seed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{Effect, Hidden, Truth};
use serde::{Deserialize, Serialize};
use values::Shape;

use super::super::form::{self, one_of, uniform};
use super::super::set::Make;
use super::super::size::{Probes, Shift};
use super::{answers, noise};

/// What a hard set is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HardKind {
    /// Nothing hidden but noise.
    Control,
    /// One phenomenon, at twice the floor and more.
    Single,
    /// One phenomenon, below twice the floor.
    Weak,
    /// Two or three, each at twice the floor and more.
    Several,
    /// What no candidate has, at twice the floor and more.
    Foreign,
}

/// Of each twenty sets, how many of each kind.
const OF_TWENTY: [(HardKind, usize); 5] = [
    (HardKind::Control, 10),
    (HardKind::Single, 4),
    (HardKind::Weak, 1),
    (HardKind::Several, 2),
    (HardKind::Foreign, 3),
];

/// A hard set: its seed says all of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HardCase {
    /// The key by which a run resumes.
    pub id: String,
    /// What it is for.
    pub kind: HardKind,
    /// Where everything random comes from.
    pub seed: u64,
}

/// A hard set as it was drawn.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Drawn {
    /// Phenomena that are hidden, by the rig's name; a wrong scale of the camera is none.
    pub hidden: Vec<String>,
    /// How large each is, in units of the noise floor.
    pub magnitudes: Vec<f64>,
    /// Strikes, and sessions that they are made in.
    pub strikes: usize,
    /// Number of sessions.
    pub sessions: usize,
    /// The rig, with effects, noise, and a rig file that may be wrong.
    pub truth: Truth,
}

impl Drawn {
    /// What the rig is to make.
    pub(super) fn make(&self) -> Make<'_> {
        Make {
            truth: &self.truth,
            strikes: self.strikes,
            sessions: Some(self.sessions),
            plan: None,
        }
    }
}

/// Sets from a first seed on; each has a seed of its own, and the share of each kind is the same in each twenty.
pub fn hard_cases(sets: usize, first: u64) -> Vec<HardCase> {
    let mut kinds: Vec<HardKind> = OF_TWENTY
        .iter()
        .flat_map(|(kind, count)| vec![*kind; *count])
        .collect();
    // Interleaved, so that a run that is cut short has all of them: steps of 7 visit each of the twenty once.
    kinds = (0..kinds.len())
        .map(|i| kinds[7 * i % kinds.len()])
        .collect();
    (0..sets)
        .map(|i| {
            let kind = kinds[i % kinds.len()];
            let seed = first + i as u64;
            HardCase {
                id: format!("hard-{}-s{seed}", name(kind)),
                kind,
                seed,
            }
        })
        .collect()
}

/// The kind in a word.
pub fn name(kind: HardKind) -> &'static str {
    match kind {
        HardKind::Control => "control",
        HardKind::Single => "single",
        HardKind::Weak => "weak",
        HardKind::Several => "several",
        HardKind::Foreign => "foreign",
    }
}

/// Numbers of strikes.
const STRIKES: [usize; 5] = [40, 60, 90, 120, 160];
/// Of the sets, the share that strikes a box, that is made in one session, and whose camera has a wrong scale.
const BOXES: f64 = 0.3;
const ONE_SESSION: f64 = 0.3;
const WRONG_SCALE: f64 = 0.1;
/// Magnitudes, drawn at equal shares of their logarithm.
const STRONG: (f64, f64) = (2.0, 4.0);
const WEAK: (f64, f64) = (0.5, 2.0);
/// Strengths in units of an effect's default beyond which it is no longer what a table or an arm shows; of what no candidate
/// has, any strength is allowed.
const STRONGEST: f64 = 6.0;
const STRONGEST_FOREIGN: f64 = 60.0;
/// Draws of an effect before the set is given up.
const TRIES: usize = 20;

/// Draws a set; `None` where the rig cannot make it.
pub fn draw(case: &HardCase) -> Option<Drawn> {
    let mut random = ChaCha8Rng::seed_from_u64(case.seed);
    let shape = if random.random::<f64>() < BOXES {
        Shape::Box
    } else {
        Shape::Cylinder
    };
    let mut truth = Truth::demo(&Truth::demo_rig(shape), case.seed);
    truth.hidden = Hidden::none();
    truth.friction = uniform(&mut random, 0.15, 0.30);
    truth.restitution = uniform(&mut random, 0.40, 0.60);
    truth.noise = noise::draw(&mut random);
    let strikes = *one_of(&mut random, &STRIKES);
    let sessions = if random.random::<f64>() < ONE_SESSION {
        1
    } else {
        2 + (3.0 * random.random::<f64>()) as usize
    };
    let mut drawn = Drawn {
        hidden: Vec::new(),
        magnitudes: Vec::new(),
        strikes,
        sessions,
        truth,
    };
    let count = match case.kind {
        HardKind::Control => 0,
        HardKind::Several if random.random::<f64>() < 0.3 => 3,
        HardKind::Several => 2,
        HardKind::Single | HardKind::Weak | HardKind::Foreign => 1,
    };
    for _ in 0..count {
        add(&mut drawn, case.kind, &mut random)?;
    }
    if random.random::<f64>() < WRONG_SCALE {
        let mut scale = Effect::named("camera_scale")?;
        scale.set("excess", uniform(&mut random, -0.05, 0.05));
        drawn.truth.hidden.0.push(scale);
    }
    Some(drawn)
}

/// Adds one more phenomenon that can be distinguished from those that are there.
fn add(drawn: &mut Drawn, kind: HardKind, random: &mut ChaCha8Rng) -> Option<()> {
    let is_foreign = kind == HardKind::Foreign;
    let all = answers::phenomena(!is_foreign);
    let plain = Truth {
        hidden: Hidden::none(),
        ..drawn.truth.clone()
    };
    let probes = Probes::new(&plain, (drawn.strikes, drawn.sessions), random)?;
    let floor = probes.floor(drawn.strikes)?;
    for _ in 0..TRIES {
        let name = *one_of(random, &all);
        let (low, high) = if kind == HardKind::Weak { WEAK } else { STRONG };
        let magnitude = low * (high / low).powf(random.random::<f64>());
        let needs_sessions = name.ends_with("_by_session") || name.ends_with("_of_sessions");
        let can_be_told = |other: &String| answers::can_be_distinguished(name, other);
        if (needs_sessions && drawn.sessions < 2) || !drawn.hidden.iter().all(can_be_told) {
            continue;
        }
        let mut effect = Effect::named(name)?;
        form::draw(&mut effect, drawn.strikes, random);
        let strongest = if is_foreign {
            STRONGEST_FOREIGN
        } else {
            STRONGEST
        };
        let scaled = probes.scaled(&effect, magnitude * floor, Shift::Unabsorbed, strongest);
        let Some(effect) = scaled else { continue };
        drawn.truth.hidden.0.push(effect);
        drawn.hidden.push(name.to_string());
        drawn.magnitudes.push(magnitude);
        return Some(());
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_twenty_sets_hold_all_kinds_and_seeds_differ() {
        let all = hard_cases(40, 5);
        for twenty in all.chunks(20) {
            for (kind, count) in OF_TWENTY {
                assert_eq!(twenty.iter().filter(|c| c.kind == kind).count(), count);
            }
        }
        let mut seeds: Vec<u64> = all.iter().map(|c| c.seed).collect();
        seeds.dedup();
        assert_eq!(seeds.len(), 40);
    }

    #[test]
    fn a_set_is_drawn_alike_each_time_and_as_large_as_it_says() {
        // Development seeds; those of a page are used once.
        for case in hard_cases(20, 11_000_000) {
            let (one, again) = (draw(&case), draw(&case));
            let (Some(one), Some(again)) = (one, again) else {
                panic!("{} cannot be made", case.id);
            };
            assert_eq!(one.truth, again.truth);
            assert_eq!(one.hidden.is_empty(), case.kind == HardKind::Control);
            assert!(one.magnitudes.iter().all(|m| (0.5..=4.0).contains(m)));
        }
    }
}
