//! The strikes that a model learns from, and how candidates compare on them.

use store::{ResidualModel, TrainingExtent};
use values::{Command, Interval, LaunchResidual, Split};

use crate::candidate::{Candidate, Score};
use crate::error::TrainError;
use crate::example::Example;
use crate::groups::{by_name, folds, settings};
use crate::launch_map::Launch;
use crate::miss::{Miss, mean, quantile};

/// Parts in which whole sessions are held out, at the most.
const SESSION_FOLDS: usize = 5;
/// Fewer strikes of a session do not judge.
pub(crate) const LEAST_OF_SESSION: usize = 5;
/// Standard errors by which a difference must exceed zero. Of 40 sets of 10 strikes in which nothing is missing two let a map pass in 1,
/// one in 3 (with medians of 0.1 in the map's priors); where the arm is off by 20 % both find it alike.
const SURE: f64 = 2.0;

/// The strikes that show a launch, with their groups.
pub(crate) struct LearningSet<'a> {
    pub(crate) rows: Vec<(&'a Example, LaunchResidual)>,
    pub(crate) groups: Vec<usize>,
    /// Whether maps learn from strikes that were pushed a second time, too. All strikes judge.
    pub(crate) learns_pushed: bool,
}

impl<'a> LearningSet<'a> {
    pub(crate) fn of(examples: &'a [Example]) -> Result<Self, TrainError> {
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
            learns_pushed: true,
        })
    }

    pub(crate) fn none(&self) -> Vec<Miss> {
        let rows = self.rows.iter();
        rows.map(|(_, launch)| Miss::of_launch(launch, [0.0; 2]))
            .collect()
    }

    /// Sessions held out in at most as many parts as networks; strikes of sessions with few of them have none. None where there are
    /// not two sessions that judge.
    pub(crate) fn sessions(&self) -> Option<Vec<Option<usize>>> {
        let names: Vec<&str> = self
            .rows
            .iter()
            .map(|(row, _)| row.session.as_str())
            .collect();
        let groups = by_name(&names);
        let mut sizes = vec![0; groups.len()];
        groups.iter().for_each(|group| sizes[*group] += 1);
        let folds = folds(&groups, SESSION_FOLDS, 0);
        let parts: Vec<Option<usize>> = (0..groups.len())
            .map(|i| (sizes[groups[i]] >= LEAST_OF_SESSION).then_some(folds[i]))
            .collect();
        let mut used: Vec<usize> = parts.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        (used.len() > 1).then_some(parts)
    }

    /// Mean distance in m, of these strikes.
    pub(crate) fn mean_of(&self, misses: &[Miss], strikes: &[usize]) -> Option<f64> {
        mean(
            strikes
                .iter()
                .map(|&i| self.rows[i].0.distance * misses[i].share()),
        )
    }

    pub(crate) fn score(&self, candidate: &Candidate) -> Score {
        Score {
            kind: candidate.kind,
            by_setting: self.mean_of(&candidate.misses, &self.all()).unwrap_or(0.0),
            by_session: None,
            strikes: self.rows.len(),
        }
    }

    pub(crate) fn distances(&self, candidate: &Candidate) -> Vec<(String, f64)> {
        let rows = self.rows.iter().zip(&candidate.misses);
        rows.map(|((row, _), miss)| (row.strike_id.clone(), row.distance * miss.share()))
            .collect()
    }

    pub(crate) fn all(&self) -> Vec<usize> {
        (0..self.rows.len()).collect()
    }

    pub(crate) fn is_better(&self, first: &Candidate, second: &Candidate) -> bool {
        self.is_less(&first.misses, &second.misses, &self.all())
    }

    /// Whether the first are less than the second on these strikes, beyond [`SURE`] standard errors of the mean difference.
    pub(crate) fn is_less(&self, first: &[Miss], second: &[Miss], strikes: &[usize]) -> bool {
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

    fn is_learnt_from(&self, i: usize) -> bool {
        self.learns_pushed || self.rows[i].0.is_free
    }

    pub(crate) fn launches(&self, takes: impl Fn(usize) -> bool) -> Vec<Launch> {
        let learns = |i: usize| self.is_learnt_from(i) && takes(i);
        let rows = self.rows.iter().enumerate().filter(|(i, _)| learns(*i));
        rows.map(|(_, (example, residual))| Launch {
            command: example.command,
            residual: *residual,
        })
        .collect()
    }

    pub(crate) fn explained(&self, best: &Candidate) -> Option<TrainingExtent> {
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
                    let simulated = Command::new(residual.speed_sim, residual.angle_sim);
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
        let none = self.none();
        let learnt = (0..none.len()).filter(|i| self.is_learnt_from(*i));
        let displacement = learnt.map(|i| none[i].share()).fold(0.0, f64::max);
        Some(TrainingExtent {
            strikes: self.rows.len(),
            d_speed: range(0)?,
            d_angle: range(1)?,
            displacement,
            miss,
            miss_p95: quantile(shares, 0.95)?,
            calibration: expected.map_or(1.0, |expected| miss / expected),
        })
    }
}
