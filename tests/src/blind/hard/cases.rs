//! Which hard sets are made: each is drawn at random from its seed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{Effect, Hidden, PlannedStrike, StrikeIndex, Truth};
use serde::{Deserialize, Serialize};
use values::Shape;

use super::super::form;
use super::super::form::{one_of, uniform};
use super::super::set::Make;
use super::super::size::{Probes, Shift};
use super::design::Design;
use super::kind::{HardKind, OF_TWENTY};
use super::{answers, noise};

/// A hard set: its seed says all of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HardCase {
    /// The key by which a run resumes.
    pub id: String,
    pub kind: HardKind,
    /// Where everything random comes from.
    pub seed: u64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Drawn {
    /// Phenomena that are hidden, by the rig's name; a wrong scale of the camera is none.
    pub hidden: Vec<String>,
    /// How large each is, in units of the noise floor.
    pub magnitudes: Vec<f64>,
    pub design: Design,
    /// The strikes that are made, in their order.
    pub plan: Vec<PlannedStrike>,
    /// Strikes of them that no log has: from which, and up to which.
    pub missing: (usize, usize),
    pub sessions: usize,
    /// The rig, with effects, noise, and a rig file that may be wrong.
    pub truth: Truth,
}

impl Drawn {
    pub(super) fn make(&self) -> Make<'_> {
        Make {
            truth: &self.truth,
            strikes: self.plan.len(),
            sessions: Some(self.sessions),
            plan: Some(self.plan.clone()),
            missing: self.missing.0..self.missing.1,
        }
    }

    pub fn strikes(&self) -> usize {
        self.plan.len() - (self.missing.1 - self.missing.0)
    }

    fn a_session(&self) -> usize {
        self.plan.len().div_ceil(self.sessions)
    }

    /// Whether what is hidden could be told by one who knows its form: the squares of its shifts, in units of the floor, sum to so much that
    /// the right one of two forms is named in 99 of 100 sets (T = 21.6) though friction, launch or noise take half of it.
    pub fn is_detectable(&self) -> bool {
        let all = |m: &f64| self.strikes() as f64 * m * m >= 2.0 * 21.6;
        self.magnitudes.iter().all(all)
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
                id: format!("hard-{}-s{seed}", kind.name()),
                kind,
                seed,
            }
        })
        .collect()
}

/// Shares of the sets that strike a box, that are made in one session, and whose camera has a wrong scale.
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
/// Strikes of the plan by which a phenomenon's size is measured.
const PROBES: usize = 24;
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
    if case.kind == HardKind::Order {
        // A walk may look like anything that changes with the order.
        truth
            .noise
            .0
            .retain(|kind| kind.name() != "friction_wander");
    }
    let design = Design::draw(case.kind, &mut random);
    let plan = design.plan(&truth, &mut random)?;
    let sessions = if random.random::<f64>() < ONE_SESSION {
        1
    } else {
        2 + (3.0 * random.random::<f64>()) as usize
    };
    let from = (uniform(&mut random, 0.2, 0.6) * plan.len() as f64) as usize;
    let mut drawn = Drawn {
        hidden: Vec::new(),
        magnitudes: Vec::new(),
        missing: match design {
            Design::Gaps => (from, from + plan.len() / 4),
            _ => (0, 0),
        },
        design,
        plan,
        sessions,
        truth,
    };
    let count = match case.kind {
        HardKind::Control | HardKind::Odd => 0,
        HardKind::Several if random.random::<f64>() < 0.3 => 3,
        HardKind::Several => 2,
        _ => 1,
    };
    if case.kind == HardKind::Odd {
        let odd = noise::odd(&mut random);
        drawn.hidden.push(odd.name().to_string());
        drawn.truth.noise.0.push(odd);
    }
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
    let all: Vec<&str> = answers::phenomena(kind).collect();
    let plain = Truth {
        hidden: Hidden::none(),
        ..drawn.truth.clone()
    };
    let a_session = drawn.a_session();
    let strikes = (0..PROBES).map(|_| {
        let order = (random.random::<f64>() * drawn.plan.len() as f64) as usize;
        let strike = drawn.plan[order];
        let session = order / a_session;
        (
            strike.initial(),
            strike.command(),
            StrikeIndex { session, order },
        )
    });
    let probes = Probes::new(&plain, strikes.collect())?;
    let floor = probes.floor(drawn.strikes())?;
    for _ in 0..TRIES {
        let name = *one_of(random, &all);
        let (low, high) = if kind == HardKind::Weak { WEAK } else { STRONG };
        let magnitude = low * (high / low).powf(random.random::<f64>());
        let needs_sessions = name.ends_with("_by_session")
            || name.ends_with("_of_sessions")
            || name == "warming_arm";
        let can_be_told = |other: &String| answers::can_be_distinguished(name, other);
        if (needs_sessions && drawn.sessions < 2) || !drawn.hidden.iter().all(can_be_told) {
            continue;
        }
        let mut effect = Effect::named(name)?;
        form::draw(&mut effect, (drawn.plan.len(), a_session), random);
        let strongest = match kind {
            HardKind::Foreign => STRONGEST_FOREIGN,
            _ => STRONGEST,
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
            assert_eq!(one.plan, again.plan);
            assert_eq!(one.hidden.is_empty(), case.kind == HardKind::Control);
            assert!(one.magnitudes.iter().all(|m| (0.5..=4.0).contains(m)));
        }
    }
}
