//! What is added to a world: nothing, a launch map, or the paper's networks, whichever predicts held-out commands best.
//!
//! Each candidate is judged by the stops that it predicts for commands that it did not learn from, strikes with commands that are
//! alike held out together. The plainer candidate stays unless the other is better by more than two standard errors
//! of the difference; a launch map must do no harm to whole sessions held out, either. Strikes of [`values::Split::Test`] take no part.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};
use store::{ResidualModel, TrainingExtent};

use crate::candidate::{Candidate, Kind, Score};
use crate::error::TrainError;
use crate::example::Example;
use crate::fit::{Epoch, Trained};
use crate::learning_set::{LEAST_OF_SESSION, LearningSet};
use crate::miss;
use crate::settings::Settings;

/// Chooses what is added to a world, and learns it. With too few strikes, nothing is.
pub fn learn(
    examples: &[Example],
    settings: &Settings,
    on_epoch: &(dyn Fn(&Epoch) + Sync),
) -> Result<Learned, TrainError> {
    let mut strikes = LearningSet::of(examples)?;
    let none = strikes.none();
    let mut best = Candidate {
        kind: Kind::None,
        model: None,
        misses: none.clone(),
        expected: Vec::new(),
        is_within: Vec::new(),
    };
    let mut scores = vec![strikes.score(&best)];
    if let Some(map) = strikes.launch_map(settings.seed) {
        let mut score = strikes.score(&map);
        let mut harms_sessions = false;
        if let Some(others) = strikes
            .sessions()
            .and_then(|sessions| strikes.held_out_maps(&sessions, None))
        {
            // Beyond the commands learnt from, the executor asks no map.
            let is_within: Vec<usize> = (0..others.is_within.len())
                .filter(|i| others.is_within[*i])
                .collect();
            if is_within.len() >= LEAST_OF_SESSION {
                scores[0].by_session = strikes.mean_of(&none, &is_within);
                score.by_session = strikes.mean_of(&others.misses, &is_within);
                harms_sessions = strikes.is_less(&none, &others.misses, &is_within);
            }
        }
        if strikes.is_better(&map, &best) && !harms_sessions {
            best = map;
        }
        scores.push(score);
    }
    let networked = match settings.networks {
        true => strikes.networks(&best, settings, on_epoch)?,
        false => None,
    };
    let training = networked.map(|networked| {
        scores.push(networked.score);
        let networks = networked.candidate;
        if let Some(networks) = networks.filter(|networks| strikes.is_better(networks, &best)) {
            best = networks;
        }
        networked.first
    });
    Ok(Learned {
        kind: best.kind,
        explained: strikes.explained(&best),
        misses: strikes.distances(&best),
        model: best.model,
        scores,
        training,
        strikes: strikes.rows.len(),
    })
}

/// What was learnt on top of a world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Learned {
    /// What is added.
    pub kind: Kind,
    /// The model; none where nothing is added.
    pub model: Option<ResidualModel>,
    /// Every candidate that was tried.
    pub scores: Vec<Score>,
    /// Distance in m between measured and predicted stop of each strike learnt from, by what is added: predicted by a model that
    /// learnt from other commands.
    pub misses: Vec<(String, f64)>,
    /// What the training explains; none where nothing is added.
    pub explained: Option<TrainingExtent>,
    /// The first network's training; none where no network was tried.
    pub training: Option<Trained>,
    /// Number of strikes learnt from.
    pub strikes: usize,
}

/// Strikes at which a curve is drawn.
const SIZES: [usize; 7] = [10, 20, 35, 50, 100, 200, 500];
/// Numbers of the earliest strikes to learn from for a curve: 10 to 500, those that exceed `count` cut to it, once.
pub fn curve_sizes(count: usize) -> Vec<usize> {
    let mut sizes = SIZES.map(|size| size.min(count)).to_vec();
    sizes.dedup();
    sizes
}

/// The place of the one with the least mean distance between measured and predicted stop, over the strikes that all of them predict;
/// the first of equals, none of none. No strike that judges a version takes part.
pub fn best(learned: &[&Learned]) -> Option<usize> {
    let ids = |learned: &'_ Learned| -> HashSet<String> {
        learned.misses.iter().map(|(id, _)| id.clone()).collect()
    };
    let common = learned
        .iter()
        .map(|learned| ids(learned))
        .reduce(|all, more| all.intersection(&more).cloned().collect())?;
    let mean = |learned: &Learned| {
        let misses = learned.misses.iter().filter(|(id, _)| common.contains(id));
        miss::mean(misses.map(|(_, miss)| *miss)).unwrap_or(f64::INFINITY)
    };
    let means = learned.iter().map(|learned| mean(learned)).enumerate();
    means
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(place, _)| place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_ends_at_all_rows() {
        assert_eq!(curve_sizes(900), [10, 20, 35, 50, 100, 200, 500]);
        assert_eq!(curve_sizes(120), [10, 20, 35, 50, 100, 120]);
        assert_eq!(curve_sizes(8), [8]);
    }
}
