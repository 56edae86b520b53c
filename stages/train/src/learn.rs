//! What is added to a world: nothing, a launch map, or the paper's networks, whichever predicts held-out commands best.
//!
//! Each candidate is judged by the stops that it predicts for commands that it did not learn from, strikes with commands that are
//! alike held out together. The plainer candidate stays unless the other is better by more than two standard errors of the difference; a launch map must do no harm to whole sessions held out, either. Strikes of [`Split::Test`] take no part.

use rayon::prelude::*;
use residual::{LaunchResidual, Residual};
use serde::{Deserialize, Serialize};
use store::{Explained, LaunchMap, Networks, ResidualModel};
use values::{Command, Interval, Split};

use crate::groups::{by_name, folds, settings};
use crate::launch_map::{Launch, fit_launch_map};
use crate::miss::{Miss, mean, quantile};
use crate::{Epoch, Example, Settings, TrainError, Trained, fit};

/// With fewer strikes no map is tried, and with fewer no network: 11,042 weights learn nothing from them.
const LEAST_FOR_MAP: usize = 8;
const LEAST_FOR_NETWORKS: usize = 50;
/// Parts that are held out in turn to judge a launch map, and networks, each of which learnt without one of as many parts.
const MAP_FOLDS: usize = 10;
const NETWORKS: usize = 5;
/// One in so many of a network's groups chooses when its training stops.
const VALIDATION: usize = 8;
/// Standard errors by which a difference must exceed zero. Of 40 sets of 10 strikes in which nothing is missing two let a map pass in 1,
/// one in 3 (with medians of 0.1 in the map's priors); where the arm is off by 20 % both find it alike.
const SURE: f64 = 2.0;
/// Fewer strikes of a session do not judge.
const LEAST_OF_SESSION: usize = 5;

/// What may be added to a world, the plainest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Nothing.
    None,
    /// A smooth map of launches over commands.
    LaunchMap,
    /// The paper's networks.
    Networks,
}

impl Kind {
    /// Its name for a person.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::LaunchMap => "launch map",
            Self::Networks => "networks",
        }
    }
}

/// How well a candidate predicts stops of strikes that it did not learn from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// The candidate.
    pub kind: Kind,
    /// Mean distance in m, commands that are alike held out together.
    pub by_setting: f64,
    /// Mean distance in m, whole sessions held out together, over commands among those of the other sessions; none where it was not
    /// measured.
    pub by_session: Option<f64>,
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
    pub explained: Option<Explained>,
    /// Standard deviations of what is left of launches on held-out commands: relative speed, and angle in rad; robust.
    pub scatter: [f64; 2],
    /// The first network's training; none where no network was tried.
    pub training: Option<Trained>,
    /// Number of strikes learnt from.
    pub strikes: usize,
}

/// Chooses what is added to a world, and learns it. With too few strikes, nothing is.
pub fn learn(
    examples: &[Example],
    settings: &Settings,
    on_epoch: &(dyn Fn(&Epoch) + Sync),
) -> Result<Learned, TrainError> {
    let field = Field::of(examples)?;
    let none = field.none();
    let mut best = Candidate {
        kind: Kind::None,
        model: None,
        misses: none.clone(),
        expected: Vec::new(),
        asked: Vec::new(),
    };
    let mut scores = vec![field.score(&best)];
    if let Some(map) = field.launch_map(settings.seed) {
        let mut score = field.score(&map);
        let mut harms_sessions = false;
        if let Some(others) = field
            .sessions()
            .and_then(|sessions| field.held_out_maps(&sessions, None))
        {
            // Beyond the commands learnt from, the executor asks no map.
            let asked: Vec<usize> = (0..others.asked.len())
                .filter(|i| others.asked[*i])
                .collect();
            if asked.len() >= LEAST_OF_SESSION {
                scores[0].by_session = field.mean_of(&none, &asked);
                score.by_session = field.mean_of(&others.misses, &asked);
                harms_sessions = field.is_less(&none, &others.misses, &asked);
            }
        }
        if field.is_better(&map, &best) && !harms_sessions {
            best = map;
        }
        scores.push(score);
    }
    let mut training = None;
    if let Some((networks, first)) = field.networks(settings, on_epoch)? {
        scores.push(field.score(&networks));
        training = Some(first);
        if field.is_better(&networks, &best) {
            best = networks;
        }
    }
    Ok(Learned {
        kind: best.kind,
        explained: field.explained(&best),
        scatter: Miss::scatter(&best.misses),
        misses: field.distances(&best),
        model: best.model,
        scores,
        training,
        strikes: field.rows.len(),
    })
}

/// The strikes that tell a launch, with their groups.
struct Field<'a> {
    rows: Vec<(&'a Example, LaunchResidual)>,
    groups: Vec<usize>,
}

/// A candidate, and what it leaves of each strike that it did not learn from.
struct Candidate {
    kind: Kind,
    model: Option<ResidualModel>,
    misses: Vec<Miss>,
    /// The share of the path that it expected to leave; of a map alone.
    expected: Vec<f64>,
    /// Whether a map that learnt from other parts was asked of a command among those that it learnt from.
    asked: Vec<bool>,
}

impl<'a> Field<'a> {
    fn of(examples: &'a [Example]) -> Result<Self, TrainError> {
        let learns = examples
            .iter()
            .filter(|example| example.split != Split::Test);
        let mut rows = Vec::new();
        for example in learns {
            let Some(launch) = example.launch else {
                continue;
            };
            let Command { speed, angle } = example.command;
            let numbers = [launch.speed, launch.angle, speed, angle, example.distance];
            if !(numbers.iter().all(|number| number.is_finite()) && speed > 0.0) {
                return Err(TrainError::NotFinite {
                    strike_id: example.strike_id.clone(),
                });
            }
            rows.push((example, launch));
        }
        let commands: Vec<Command> = rows.iter().map(|(example, _)| example.command).collect();
        Ok(Self {
            groups: settings(&commands),
            rows,
        })
    }

    fn none(&self) -> Vec<Miss> {
        let rows = self.rows.iter();
        rows.map(|(_, launch)| Miss::of_launch(launch, [0.0; 2]))
            .collect()
    }

    /// Sessions held out in at most as many parts as networks; strikes of sessions with few of them have none. None where there are
    /// not two sessions that judge.
    fn sessions(&self) -> Option<Vec<Option<usize>>> {
        let names: Vec<&str> = self
            .rows
            .iter()
            .map(|(row, _)| row.session.as_str())
            .collect();
        let groups = by_name(&names);
        let size = |group: usize| groups.iter().filter(|other| **other == group).count();
        let folds = folds(&groups, NETWORKS, 0);
        let parts: Vec<Option<usize>> = (0..groups.len())
            .map(|i| (size(groups[i]) >= LEAST_OF_SESSION).then_some(folds[i]))
            .collect();
        let mut told: Vec<usize> = parts.iter().flatten().copied().collect();
        told.sort_unstable();
        told.dedup();
        (told.len() > 1).then_some(parts)
    }

    fn launches(&self, takes: impl Fn(usize) -> bool) -> Vec<Launch> {
        let rows = self.rows.iter().enumerate().filter(|(i, _)| takes(*i));
        rows.map(|(_, (example, residual))| Launch {
            command: example.command,
            residual: *residual,
        })
        .collect()
    }

    fn launch_map(&self, seed: u64) -> Option<Candidate> {
        if self.rows.len() < LEAST_FOR_MAP {
            return None;
        }
        let fitted = fit_launch_map(&self.launches(|_| true), None)?;
        let parts: Vec<Option<usize>> = folds(&self.groups, MAP_FOLDS, seed)
            .into_iter()
            .map(Some)
            .collect();
        let held_out = self.held_out_maps(&parts, Some(fitted.hyper))?;
        Some(Candidate {
            model: Some(fitted.map.into()),
            ..held_out
        })
    }

    /// What maps leave that learnt from the other parts; strikes of no part always learn, and none is told of them.
    fn held_out_maps(
        &self,
        parts: &[Option<usize>],
        near: Option<[[f64; 5]; 2]>,
    ) -> Option<Candidate> {
        let most = parts.iter().flatten().max()? + 1;
        let maps: Vec<Option<LaunchMap>> = (0..most)
            .into_par_iter()
            .map(|part| {
                let launches = self.launches(|i| parts[i] != Some(part));
                if launches.is_empty() {
                    return None;
                }
                Some(fit_launch_map(&launches, near)?.map)
            })
            .collect();
        let told = self
            .rows
            .iter()
            .zip(parts)
            .map(|((example, launch), part)| {
                let map = part.and_then(|part| maps[part].as_ref());
                map.map_or((Miss::of_launch(launch, [0.0; 2]), (0.0, false)), |map| {
                    let offset = map.offset(example.command);
                    let miss = Miss::of_launch(launch, [offset.speed, offset.angle]);
                    let is_among = map.outside(example.command) <= 0.0;
                    (miss, (offset.expected_miss(), is_among))
                })
            });
        let (misses, told): (Vec<Miss>, Vec<(f64, bool)>) = told.unzip();
        let (expected, asked) = told.into_iter().unzip();
        Some(Candidate {
            kind: Kind::LaunchMap,
            model: None,
            misses,
            expected,
            asked,
        })
    }

    /// Networks that each learnt without one part, and what each leaves of that; and the first one's training.
    fn networks(
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
            asked: Vec::new(),
        };
        let first = trained.into_iter().next();
        Ok(first
            .filter(|_| candidate.model.is_some())
            .map(|first| (candidate, first)))
    }

    /// Mean distance in m, of these strikes.
    fn mean_of(&self, misses: &[Miss], strikes: &[usize]) -> Option<f64> {
        mean(
            strikes
                .iter()
                .map(|&i| self.rows[i].0.distance * misses[i].share()),
        )
    }

    fn score(&self, candidate: &Candidate) -> Score {
        Score {
            kind: candidate.kind,
            by_setting: self.mean_of(&candidate.misses, &self.all()).unwrap_or(0.0),
            by_session: None,
        }
    }

    fn distances(&self, candidate: &Candidate) -> Vec<(String, f64)> {
        let rows = self.rows.iter().zip(&candidate.misses);
        rows.map(|((row, _), miss)| (row.strike_id.clone(), row.distance * miss.share()))
            .collect()
    }

    fn all(&self) -> Vec<usize> {
        (0..self.rows.len()).collect()
    }

    fn is_better(&self, first: &Candidate, second: &Candidate) -> bool {
        self.is_less(&first.misses, &second.misses, &self.all())
    }

    /// Whether the first are less than the second on these strikes, beyond [`SURE`] standard errors of the mean difference.
    fn is_less(&self, first: &[Miss], second: &[Miss], strikes: &[usize]) -> bool {
        let gains: Vec<f64> = strikes
            .iter()
            .map(|&i| self.rows[i].0.distance * (second[i].share() - first[i].share()))
            .collect();
        let count = gains.len() as f64;
        let Some(gain) = mean(gains.iter().copied()).filter(|_| count > 1.0) else {
            return false;
        };
        let variance = gains.iter().map(|one| (one - gain).powi(2)).sum::<f64>() / (count - 1.0);
        gain > SURE * (variance / count).sqrt()
    }

    fn explained(&self, best: &Candidate) -> Option<Explained> {
        let model = best.model.as_ref()?;
        let added: Vec<[f64; 2]> = self
            .rows
            .iter()
            .filter_map(|(row, _)| match (model, &row.residual) {
                (ResidualModel::Launch(_), _) => {
                    // A launch map's answer depends on the command alone.
                    Some(model.added(Default::default(), row.command, row.command))
                }
                (ResidualModel::Networks(_), Some(residual)) => {
                    let simulated = Command {
                        speed: residual.speed_sim,
                        angle: residual.angle_sim,
                    };
                    Some(model.added(residual.path, simulated, row.command))
                }
                _ => None,
            })
            .collect();
        let range = |i: usize| {
            let values = added.iter().map(|added| added[i]);
            values
                .map(|value| Interval::from([value, value]))
                .reduce(|all, one| Interval::from([all.low.min(one.low), all.high.max(one.high)]))
        };
        let shares: Vec<f64> = best.misses.iter().map(Miss::share).collect();
        let miss = mean(shares.iter().copied())?;
        let expected = mean(best.expected.iter().copied()).filter(|expected| *expected > 0.0);
        Some(Explained {
            strikes: self.rows.len(),
            d_speed: range(0)?,
            d_angle: range(1)?,
            displacement: self.none().iter().map(Miss::share).fold(0.0, f64::max),
            miss,
            miss_p95: quantile(shares, 0.95)?,
            calibration: expected.map_or(1.0, |expected| miss / expected),
        })
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
