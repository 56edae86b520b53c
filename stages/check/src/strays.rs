//! Objects that leave quite elsewhere than the others of their log do: no strikes, though each follows a command.
//!
//! A command that was given up, or that came while the object was carried, is followed by what a hand does; after a clock was set, or where
//! some commands are another robot's, every motion is another strike's. Headings of one log agree to far less than this.

use crate::finding::Finding;
use crate::pairs::Pair;
use crate::statistics::{middle, wrapped};

/// So far beside the others of the log (rad) is no strike: a box's gain and an arm's scatter together take it half as far.
const ASTRAY: f64 = 0.7;
/// So many, and this part of all, are told; this part makes a model meaningless.
const FEWEST: usize = 4;
const TOLD: f64 = 0.08;
const MANY: f64 = 0.2;

/// Strays of one log.
pub(crate) fn findings(pairs: &[Pair], log: &str) -> Option<Finding> {
    let turns: Vec<f64> = pairs
        .iter()
        .map(|pair| wrapped(pair.heading() - pair.command.angle))
        .collect();
    let (usual, _) = middle(&turns)?;
    let is_astray = |turn: &f64| wrapped(turn - usual).abs() > ASTRAY;
    let rises: Vec<f64> = pairs
        .iter()
        .zip(&turns)
        .filter(|(_, turn)| is_astray(turn))
        .map(|(pair, _)| pair.command.rise)
        .collect();
    let share = rises.len() as f64 / pairs.len() as f64;
    (rises.len() >= FEWEST && share > TOLD).then(|| Finding::Strays {
        log: log.into(),
        strays: rises.len(),
        strikes: pairs.len(),
        from: rises[0] - pairs[0].command.rise,
        until: rises[rises.len() - 1] - pairs[0].command.rise,
        certain: share > MANY,
    })
}
