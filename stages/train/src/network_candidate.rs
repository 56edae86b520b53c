//! Networks as a candidate: each learnt without one part, and is judged by it. Where the first one loses beyond chance, the others are not
//! trained.

use rayon::prelude::*;
use store::{Networks, ResidualModel};
use values::{Residual, Split};

use crate::candidate::{Candidate, Kind, Score};
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
    /// Networks that each learnt without one part, and what each leaves of that; and the first one's training. Where the first leaves
    /// more of its part than `best` does, beyond chance, it is the only one.
    pub(crate) fn networks(
        &self,
        best: &Candidate,
        settings: &Settings,
        on_epoch: &(dyn Fn(&Epoch) + Sync),
    ) -> Result<Option<Networked>, TrainError> {
        let has_residual = |i: &usize| self.rows[*i].0.residual.is_some();
        if self.all().iter().filter(|i| has_residual(i)).count() < LEAST_FOR_NETWORKS {
            return Ok(None);
        }
        let parts = folds(&self.groups, NETWORKS, settings.seed);
        let stops = folds(&self.groups, VALIDATION, settings.seed.wrapping_add(1));
        let train = |part: usize| {
            let rows = self.rows.iter().enumerate().filter_map(|(i, (row, _))| {
                let split = match (parts[i] == part, stops[i] == part) {
                    (true, _) => Split::Test,
                    (_, true) => Split::Validation,
                    _ => Split::Train,
                };
                let residual = row.residual.clone()?;
                Some(Residual { split, ..residual })
            });
            let settings = Settings {
                seed: settings.seed.wrapping_add(part as u64),
                ..settings.clone()
            };
            fit(&rows.collect::<Vec<_>>(), &settings, &mut |epoch| {
                on_epoch(epoch)
            })
        };
        let first = match train(0) {
            Err(TrainError::TooFewRows { .. }) => return Ok(None),
            first => first?,
        };
        let judged: Vec<usize> = self.all().into_iter().filter(|i| parts[*i] == 0).collect();
        let (misses, _) = self.of_networks(std::slice::from_ref(&first), &parts);
        if self.is_less(&best.misses, &misses, &judged) {
            return Ok(Some(Networked {
                score: Score {
                    kind: Kind::Networks,
                    by_setting: self.mean_of(&misses, &judged).unwrap_or(0.0),
                    by_session: None,
                    strikes: judged.len(),
                },
                candidate: None,
                first,
            }));
        }
        let others = (1..NETWORKS).into_par_iter().map(train);
        let others = match others.collect::<Result<Vec<Trained>, _>>() {
            Err(TrainError::TooFewRows { .. }) => return Ok(None),
            others => others?,
        };
        let mut trained = vec![first];
        trained.extend(others);
        let (misses, share) = self.of_networks(&trained, &parts);
        let networks = trained.iter().map(|one| one.network.scaled(share));
        let networks = networks.collect::<Result<Vec<_>, _>>().ok();
        let Some(networks) = networks.and_then(|networks| Networks::new(networks).ok()) else {
            return Ok(None);
        };
        let candidate = Candidate {
            kind: Kind::Networks,
            misses,
            model: Some(ResidualModel::Networks(networks)),
            expected: Vec::new(),
            is_within: Vec::new(),
        };
        Ok(Some(Networked {
            score: self.score(&candidate),
            candidate: Some(candidate),
            first: trained.swap_remove(0),
        }))
    }

    /// What each network leaves of its own part, all taken by the share that comes nearest to what was wanted; and that share. Strikes of
    /// parts that have no network are missed as without any.
    fn of_networks(&self, trained: &[Trained], parts: &[usize]) -> (Vec<Miss>, f64) {
        let rows = self.rows.iter().zip(parts);
        let answers: Vec<Option<Answer>> = rows
            .map(|((row, _), part)| Answer::of(row.residual.as_ref()?, trained.get(*part)?))
            .collect();
        let share = Answer::best_share(answers.iter().flatten());
        let rows = self.rows.iter().zip(&answers);
        let misses = rows.map(|((row, launch), answer)| {
            let miss = answer.as_ref().and_then(|answer| {
                Miss::of_command(row.command, row.residual.as_ref()?, answer.times(share))
            });
            miss.unwrap_or_else(|| Miss::of_launch(launch, [0.0; 2]))
        });
        (misses.collect(), share)
    }
}

pub(crate) struct Networked {
    pub(crate) score: Score,
    /// All of them; none where the first was worse than what there is.
    pub(crate) candidate: Option<Candidate>,
    /// The first one's training.
    pub(crate) first: Trained,
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
