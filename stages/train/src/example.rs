//! What is learnt from: strikes, and what a world leaves of each.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};
use values::{Command, LaunchResidual, Residual, Split, Strike};

/// One strike to learn from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Example {
    /// The strike.
    pub strike_id: String,
    /// What was commanded.
    pub command: Command,
    /// The log that it comes from.
    pub session: String,
    /// Length of its path in m.
    pub distance: f64,
    /// The part that it plays.
    pub split: Split,
    /// Whether its object slid freely: the arm did not push it a second time.
    pub is_free: bool,
    /// What the arm delivered beside the world; none where no launch leads along its path.
    pub launch: Option<LaunchResidual>,
    /// What was commanded beside the world's command; none where the world's arm cannot reach its stop.
    pub residual: Option<Residual>,
}

/// The examples that strikes are, in one world: each with its launch, and the residuals of those that have one, found by the strike. One that was
/// pushed twice has a launch, the one that would have led as far, and no residual: no one command sends an object there.
pub fn examples<'a>(
    strikes: impl Iterator<Item = (&'a Strike, Option<LaunchResidual>)>,
    residuals: &[Residual],
) -> Vec<Example> {
    let by_strike: HashMap<&str, &Residual> = residuals
        .iter()
        .map(|row| (row.strike_id.as_str(), row))
        .collect();
    let example = |(strike, launch): (&Strike, Option<LaunchResidual>)| {
        let is_free = !strike.is_pushed_again();
        let residual = by_strike.get(strike.id.as_str()).filter(|_| is_free);
        Example {
            strike_id: strike.id.clone(),
            command: strike.command,
            session: strike.conditions.session.clone(),
            distance: strike.path().norm(),
            split: strike.split,
            is_free,
            launch,
            residual: residual.map(|row| (*row).clone()),
        }
    };
    strikes.map(example).collect()
}
