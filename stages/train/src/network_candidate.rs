//! Networks as a candidate: each learnt without one part, and is judged by it.

use rayon::prelude::*;
use residual::Residual;
use store::{Networks, ResidualModel};
use values::Split;

use crate::candidate::{Candidate, Kind};
use crate::error::TrainError;
use crate::fit::{Epoch, Trained, fit};
use crate::groups::folds;
use crate::learning_set::LearningSet;
use crate::miss::Miss;
use crate::settings::Settings;

/// With fewer strikes no network is tried: 11,042 weights learn nothing from them.
const LEAST_FOR_NETWORKS: usize = 50;
/// Networks, each of which learnt without one of as many parts.
const NETWORKS: usize = 5;
/// One in so many of a network's groups chooses when its training stops.
const VALIDATION: usize = 8;

impl LearningSet<'_> {
    /// Networks that each learnt without one part, and what each leaves of that; and the first one's training.
    pub(crate) fn networks(
        &self,
        settings: &Settings,
        on_epoch: &(dyn Fn(&Epoch) + Sync),
    ) -> Result<Option<(Candidate, Trained)>, TrainError> {
        if self
            .rows
            .iter()
            .filter(|(row, _)| row.residual.is_some())
            .count()
            < LEAST_FOR_NETWORKS
        {
            return Ok(None);
        }
        let parts = folds(&self.groups, NETWORKS, settings.seed);
        let stops = folds(&self.groups, VALIDATION, settings.seed.wrapping_add(1));
        let trained: Vec<Result<Trained, TrainError>> = (0..NETWORKS)
            .into_par_iter()
            .map(|part| {
                let split = |i: usize| match (parts[i] == part, stops[i] == part) {
                    (true, _) => Split::Test,
                    (_, true) => Split::Validation,
                    _ => Split::Train,
                };
                let rows = self.rows.iter().enumerate().filter_map(|(i, (row, _))| {
                    let residual = row.residual.clone()?;
                    Some(Residual {
                        split: split(i),
                        ..residual
                    })
                });
                let settings = Settings {
                    seed: settings.seed.wrapping_add(part as u64),
                    ..settings.clone()
                };
                fit(&rows.collect::<Vec<_>>(), &settings, &mut |epoch| {
                    on_epoch(epoch)
                })
            })
            .collect();
        let trained = match trained.into_iter().collect::<Result<Vec<Trained>, _>>() {
            Err(TrainError::TooFewRows { .. }) => return Ok(None),
            trained => trained?,
        };
        let answers: Vec<Option<Answer>> = self
            .rows
            .iter()
            .zip(&parts)
            .map(|((row, _), part)| Answer::of(row.residual.as_ref()?, &trained[*part]))
            .collect();
        let share = Answer::best_share(answers.iter().flatten());
        let misses = self
            .rows
            .iter()
            .zip(&answers)
            .map(|((row, launch), answer)| {
                let miss = answer.as_ref().and_then(|answer| {
                    Miss::of_command(row.command, row.residual.as_ref()?, answer.times(share))
                });
                miss.unwrap_or_else(|| Miss::of_launch(launch, [0.0; 2]))
            });
        let networks = trained.iter().map(|one| one.network.scaled(share));
        let model = networks
            .collect::<Result<Vec<_>, _>>()
            .ok()
            .and_then(|networks| Networks::new(networks).ok())
            .map(ResidualModel::Networks);
        let candidate = Candidate {
            kind: Kind::Networks,
            misses: misses.collect(),
            model,
            expected: Vec::new(),
            is_within: Vec::new(),
        };
        let first = trained.into_iter().next();
        Ok(first
            .filter(|_| candidate.model.is_some())
            .map(|first| (candidate, first)))
    }
}

/// A network's answer for a strike that it did not learn from, in the units of the stop that it moves: relative speed, and rad.
struct Answer {
    predicted: [f64; 2],
    wanted: [f64; 2],
    speed: f64,
}

impl Answer {
    fn of(row: &Residual, trained: &Trained) -> Option<Self> {
        let inputs = [row.path.x, row.path.y, row.speed_sim, row.angle_sim];
        let [d_speed, d_angle] = trained.network.predict(inputs);
        let speed = row.speed_sim + row.d_speed;
        (speed > 0.0).then(|| Self {
            predicted: [2.0 * d_speed / speed, d_angle],
            wanted: [2.0 * row.d_speed / speed, row.d_angle],
            speed,
        })
    }

    /// The answer, taken by this share: m/s, rad.
    fn times(&self, share: f64) -> [f64; 2] {
        [
            0.5 * self.predicted[0] * self.speed * share,
            self.predicted[1] * share,
        ]
    }

    /// The share of all answers that comes nearest to what was wanted: one where they are right, zero where they say nothing.
    fn best_share<'a>(answers: impl Iterator<Item = &'a Self>) -> f64 {
        let (mut right, mut size) = (0.0, 0.0);
        for answer in answers {
            for i in 0..2 {
                right += answer.predicted[i] * answer.wanted[i];
                size += answer.predicted[i].powi(2);
            }
        }
        if size > 0.0 {
            (right / size).clamp(0.0, 1.0)
        } else {
            0.0
        }
    }
}
