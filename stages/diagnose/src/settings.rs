//! How to diagnose, and from what.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use values::{Rig, Split, Strike};
use world::World;

use crate::{
    Thresholds,
    before::{CameBefore, came_before},
};

/// How to diagnose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnose {
    /// Strikes that fit and choose, at most this many.
    pub most_strikes: usize,
    /// Effects that may be added.
    pub most_effects: usize,
    /// Strikes proposed at the most.
    pub next_strikes: usize,
    /// Seeds the bootstrap.
    pub seed: u64,
    /// What decides whether an effect is named.
    pub thresholds: Thresholds,
}

impl Default for Diagnose {
    fn default() -> Self {
        Self {
            most_strikes: 120,
            most_effects: 5,
            next_strikes: 12,
            seed: 0,
            thresholds: Thresholds::default(),
        }
    }
}

impl Diagnose {
    /// The strikes that it looks at, in their order: a sample over all sessions that fits and chooses, and all that judge. The
    /// sample is those of the smallest ids, which are hashes: as data grows, few strikes enter it.
    pub fn sample(&self, strikes: &[Strike]) -> Vec<Strike> {
        let is_judge = |strike: &Strike| strike.split == Split::Test;
        let mut ids: Vec<&str> = strikes
            .iter()
            .filter(|strike| !is_judge(strike))
            .map(|strike| strike.id.as_str())
            .collect();
        ids.sort_unstable();
        let last = ids.get(self.most_strikes).copied();
        strikes
            .iter()
            .filter(|strike| is_judge(strike) || last.is_none_or(|last| strike.id.as_str() < last))
            .cloned()
            .collect()
    }
}

/// The strikes, and the world that they are held against.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Input {
    /// The rig.
    pub rig: Rig,
    /// The identified world, without effects.
    pub world: World,
    /// Strikes in order of time; those of [`Split::Test`] judge the gap and take no other part.
    pub strikes: Vec<Strike>,
    /// What came before them, by their ids: of many strikes some are drawn.
    pub came_before: BTreeMap<String, CameBefore>,
}

impl Input {
    /// Of all these strikes.
    pub fn of(rig: Rig, world: World, strikes: Vec<Strike>) -> Self {
        Self {
            rig,
            world,
            came_before: came_before(&strikes),
            strikes,
        }
    }

    /// Of those of all these strikes that a diagnosis looks at.
    pub fn sampled(diagnose: &Diagnose, rig: Rig, world: World, all: &[Strike]) -> Self {
        let mut came_before = came_before(all);
        let strikes = diagnose.sample(all);
        let drawn: BTreeSet<&String> = strikes.iter().map(|strike| &strike.id).collect();
        came_before.retain(|id, _| drawn.contains(id));
        Self {
            rig,
            world,
            strikes,
            came_before,
        }
    }
}
