//! The table followed from strike to strike: a mixture of Kalman filters.
//!
//! Each hypothesis is a history: whether a session began on the table of before, on one that differs as sessions do, or with a jump of friction,
//! gain or heading; which strike was bad, whether the table jumped in between. Hypotheses stay apart, so that a bad first strike is recognised
//! by those after it.

use nalgebra::{Cholesky, Const};
use serde::{Deserialize, Serialize};

use super::linear::{Matrix, Rows, Vector, distance_squared, log_density, matrix, rows, variances};
use super::varies::{JUMP, Varies};
use crate::{Observation, Shift};

/// Most hypotheses that are kept.
const MOST: usize = 32;
/// What a session's beginning may change beside the usual: which of friction, gain and heading jump, and the share of all jumps
/// that are such.
const JUMPS: [([bool; 3], f64); 7] = [
    ([true, false, false], 0.30),
    ([false, true, false], 0.15),
    ([false, false, true], 0.15),
    ([true, true, true], 0.25),
    ([true, true, false], 0.05),
    ([true, false, true], 0.05),
    ([false, true, true], 0.05),
];
/// Chance that the table jumps between two strikes of a session.
const JUMP_NOW: f64 = 0.004;
/// Squared distance from the version's own table beyond which a shift is not believed: of χ² with three degrees of freedom one in a thousand is
/// greater.
const BELIEF: f64 = 16.27;
/// Least number of strikes that say that a table has changed: a single one may be bad.
const LEAST_STRIKES: usize = 2;
/// Least number of bad strikes and jumps, by the hypotheses' mean, from which they are reported as too many, and the probability of as many by chance
/// below which they are.
const LEAST_ODD: f64 = 3.0;
const ODD_BY_CHANCE: f64 = 1e-4;
/// Probability below which it is no chance that every strike of a session is bad.
const ALL_ODD_BY_CHANCE: f64 = 1e-3;

/// The belief about a table's present shift: a mixture of Kalman filters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    varies: Varies,
    hypotheses: Vec<Hypothesis>,
    /// The hypotheses before the session's first strike, had nothing jumped.
    as_it_was: Vec<Hypothesis>,
    strikes: usize,
    /// Strikes since the session began.
    in_session: usize,
}

/// One history of the table, with the shift's mean and covariance under it. The weights of all hypotheses sum to one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Hypothesis {
    log_weight: f64,
    mean: [f64; 3],
    covariance: Rows,
    /// Strikes that count as bad in this history, or before which the table jumped.
    odd: usize,
    /// Strikes of the session that do not count as bad in this history.
    good: usize,
}

/// The table is farther from the version's own than the version believes possible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableChanged {
    /// Estimated shift of the table.
    pub shift: Shift,
    /// Number of recent strikes that the estimate stands on.
    pub strikes: usize,
    /// Number of strikes that fit neither the strikes before nor the table's usual steps; none where these are not too many.
    pub odd: Option<usize>,
}

impl Filter {
    /// The belief before any recent strike, on the version's own table.
    pub fn new(varies: &Varies) -> Self {
        let hypotheses = vec![Hypothesis {
            log_weight: 0.0,
            mean: [0.0; 3],
            covariance: varies.certainty,
            odd: 0,
            good: 0,
        }];
        Self {
            as_it_was: hypotheses.clone(),
            hypotheses,
            varies: varies.clone(),
            strikes: 0,
            in_session: 0,
        }
    }

    /// The belief before the first strike of a new session in which nothing jumped.
    pub fn as_usual(varies: &Varies) -> Self {
        let mut filter = Self::new(varies);
        filter.begin_session();
        filter.if_as_it_was()
    }

    /// The belief about the session if nothing jumped and sessions differ as they were seen to; for use while no strike of it shows the table. One
    /// session shows no difference.
    pub fn if_as_it_was(&self) -> Self {
        Self {
            hypotheses: self.as_it_was.clone(),
            ..self.clone()
        }
    }

    /// Whether strikes of the session show the table: one that is bad shows nothing.
    pub fn is_shown(&self) -> bool {
        let good = self.hypotheses.iter().map(|h| h.weight() * h.good as f64);
        good.sum::<f64>() >= 0.5
    }

    /// The version's statistics of how a table varies.
    pub fn varies(&self) -> &Varies {
        &self.varies
    }

    /// Number of strikes followed.
    pub fn strikes(&self) -> usize {
        self.strikes
    }

    /// Begins a session: a new day, object or set-up, of which nothing is seen yet.
    pub fn begin_session(&mut self) {
        let between = &self.varies.between;
        let usual = variances(between.next());
        let (same, stays) = (between.same_chance(), 1.0 - between.jump_chance);
        let [same, differs] = [stays * same, stays * (1.0 - same)].map(f64::ln);
        for hypothesis in &mut self.hypotheses {
            hypothesis.good = 0;
        }
        self.as_it_was.clone_from(&self.hypotheses);
        if between.sessions > 1 {
            for hypothesis in &mut self.as_it_was {
                *hypothesis = hypothesis.spread(0.0, &usual);
            }
        }
        let mut begun = Vec::with_capacity((2 + JUMPS.len()) * self.hypotheses.len());
        for hypothesis in &self.hypotheses {
            begun.push(hypothesis.spread(same, &Matrix::zeros()));
            begun.push(hypothesis.spread(differs, &usual));
            for (jumps, share) in JUMPS {
                let jump = std::array::from_fn(|i| if jumps[i] { JUMP[i] } else { 0.0 });
                let chance = (between.jump_chance * share).ln();
                begun.push(hypothesis.spread(chance, &(usual + variances(jump))));
            }
        }
        self.hypotheses = begun;
        self.in_session = 0;
    }

    /// The belief after one more strike, `gap` strikes after the one before.
    pub fn after(&self, observation: &Observation, gap: f64) -> Self {
        let wander = self.varies.wander_after(gap);
        let scatter = matrix(self.varies.scatter);
        let slopes = matrix(observation.slopes);
        let is_good = (1.0 - self.varies.bad - JUMP_NOW).ln();
        let mut next = Vec::with_capacity(3 * self.hypotheses.len());
        for hypothesis in &self.hypotheses {
            let away = |mean: &Vector| self.varies.unbiased(observation.away_at(mean));
            let walked = hypothesis.spread(0.0, &wander);
            let jumped = walked.spread(JUMP_NOW.ln(), &variances(JUMP)).one_odd();
            let is_bad = self.varies.log_bad(&away(&walked.vector()));
            next.push(walked.spread(is_bad, &Matrix::zeros()).one_odd());
            for prior in [walked.spread(is_good, &Matrix::zeros()), jumped] {
                next.extend(prior.updated(&away(&prior.vector()), &slopes, &scatter));
            }
        }
        Self {
            varies: self.varies.clone(),
            hypotheses: heaviest(next),
            as_it_was: self.as_it_was.clone(),
            strikes: self.strikes + 1,
            in_session: self.in_session + 1,
        }
    }

    /// The weighted mean shift of the hypotheses that the version believes possible: what to plan with. A strike that only an impossible table
    /// explains counts as bad until another says the same, which [`Filter::check`] then tells.
    pub fn mean(&self) -> Shift {
        shift(&mean_of(&self.believed()))
    }

    /// Standard deviations of friction (ln), gain (ln) and heading (rad) about the mean.
    pub fn deviations(&self) -> [f64; 3] {
        let covariance = self.covariance();
        std::array::from_fn(|i| covariance[(i, i)].max(0.0).sqrt())
    }

    /// Mean square of the next strike's expected miss from not knowing the table better, as a share of its path's length; `stop_slopes`: by what ln
    /// distance and bearing change with the shift ([`crate::Observer::stop_slopes`]).
    pub fn share_by_shift(&self, stop_slopes: &[[f64; 3]; 2]) -> f64 {
        let covariance = self.covariance() + self.varies.wander_after(1.0);
        let by_shift = stop_slopes.iter().map(|slopes| {
            let slopes = Vector::from(*slopes);
            slopes.dot(&(covariance * slopes))
        });
        by_shift.sum::<f64>().max(0.0)
    }

    /// Checks whether the table is farther from the version's own than that believes possible, or more strikes than it believes possible fit nothing.
    ///
    /// # Errors
    /// Where it is.
    pub fn check(&self) -> Result<(), TableChanged> {
        let mean = mean_of(&self.weighted(|_| true));
        let away = distance_squared(&mean, &self.belief());
        let chance = self.varies.bad + JUMP_NOW;
        let odd: f64 = self
            .hypotheses
            .iter()
            .map(|h| h.weight() * h.odd as f64)
            .sum();
        let expected = chance * self.strikes as f64;
        let all_odd = !self.is_shown() && chance.powi(self.in_session as i32) < ALL_ODD_BY_CHANCE;
        let is_odd = all_odd || (odd >= LEAST_ODD && by_chance(odd, expected) < ODD_BY_CHANCE);
        if is_odd || (self.strikes >= LEAST_STRIKES && away > BELIEF) {
            return Err(TableChanged {
                shift: shift(&mean),
                strikes: self.strikes,
                odd: is_odd.then_some(odd.round() as usize),
            });
        }
        Ok(())
    }

    /// Covariance of the shifts that the version believes possible, about its own table.
    fn belief(&self) -> Matrix {
        matrix(self.varies.certainty) + variances(self.varies.between.next()) + variances(JUMP)
    }

    /// The hypotheses whose shift is believed possible, with their weights; all, where none is.
    fn believed(&self) -> Vec<(&Hypothesis, f64)> {
        let belief = self.belief();
        let within = self.weighted(|h| distance_squared(&h.vector(), &belief) <= BELIEF);
        if within.is_empty() {
            self.weighted(|_| true)
        } else {
            within
        }
    }

    /// The hypotheses for which `is_one` holds, their weights scaled to sum to one.
    fn weighted(&self, is_one: impl Fn(&Hypothesis) -> bool) -> Vec<(&Hypothesis, f64)> {
        let chosen = self.hypotheses.iter().filter(|h| is_one(h));
        let mut chosen: Vec<(&Hypothesis, f64)> = chosen.map(|h| (h, h.weight())).collect();
        let sum: f64 = chosen.iter().map(|(_, weight)| weight).sum();
        for (_, weight) in &mut chosen {
            *weight /= sum;
        }
        chosen
    }

    /// Covariance of the shift over the hypotheses believed possible, within and between them.
    fn covariance(&self) -> Matrix {
        let believed = self.believed();
        let mean = mean_of(&believed);
        let spread = believed.iter().map(|(hypothesis, weight)| {
            let away = hypothesis.vector() - mean;
            (matrix(hypothesis.covariance) + away * away.transpose()) * *weight
        });
        spread.fold(Matrix::zeros(), |sum, one| sum + one)
    }
}

fn mean_of(weighted: &[(&Hypothesis, f64)]) -> Vector {
    let each = weighted.iter().map(|(h, weight)| h.vector() * *weight);
    each.fold(Vector::zeros(), |sum, mean| sum + mean)
}

fn shift(values: &Vector) -> Shift {
    let values: [f64; 3] = (*values).into();
    values.into()
}

impl Hypothesis {
    fn weight(&self) -> f64 {
        self.log_weight.exp()
    }

    fn vector(&self) -> Vector {
        Vector::from(self.mean)
    }

    /// This hypothesis with its logarithm of weight raised by `log_chance` and its covariance by `by`.
    fn spread(&self, log_chance: f64, by: &Matrix) -> Self {
        Self {
            log_weight: self.log_weight + log_chance,
            mean: self.mean,
            covariance: rows(&(matrix(self.covariance) + by)),
            odd: self.odd,
            good: self.good,
        }
    }

    fn one_odd(self) -> Self {
        Self {
            odd: self.odd + 1,
            ..self
        }
    }

    /// This hypothesis after a Kalman update; none where the numbers do not allow one.
    fn updated(&self, away: &Vector, slopes: &Matrix, scatter: &Matrix) -> Option<Self> {
        let covariance = matrix(self.covariance);
        let innovation = slopes * covariance * slopes.transpose() + scatter;
        let cholesky: Cholesky<f64, Const<3>> = innovation.cholesky()?;
        let gain = cholesky.solve(&(slopes * covariance)).transpose();
        // Joseph's form stays symmetric and positive.
        let left = Matrix::identity() - gain * slopes;
        let after = left * covariance * left.transpose() + gain * scatter * gain.transpose();
        let mean = self.vector() + gain * away;
        Some(Self {
            log_weight: self.log_weight + log_density(away, &innovation),
            mean: mean.into(),
            covariance: rows(&after),
            odd: self.odd,
            good: self.good + 1,
        })
    }
}

/// Probability of `count` events or more (its whole part counts) where `expected` are expected (Poisson).
fn by_chance(count: f64, expected: f64) -> f64 {
    let mut chance = (-expected).exp();
    let mut fewer = 0.0;
    for events in 0..count as usize {
        fewer += chance;
        chance *= expected / (events + 1) as f64;
    }
    1.0 - fewer
}

/// The heaviest hypotheses, whose weights sum to one again.
fn heaviest(mut all: Vec<Hypothesis>) -> Vec<Hypothesis> {
    all.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
    all.truncate(MOST);
    let greatest = all.first().map_or(0.0, |first| first.log_weight);
    let sum: f64 = all.iter().map(|h| (h.log_weight - greatest).exp()).sum();
    for hypothesis in &mut all {
        hypothesis.log_weight -= greatest + sum.ln();
    }
    all
}
