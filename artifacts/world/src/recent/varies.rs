//! How much a table varies: from strike to strike, within a session and between sessions; estimated from a version's own strikes.

use serde::{Deserialize, Serialize};

use super::linear::{Matrix, Rows, Vector, distance_squared, log_density, matrix, rows, variances};
use crate::{Observation, Shift, World};

/// Standard deviations of a jump of ln friction, ln gain and heading (rad): another surface, tip or mounting.
pub(super) const JUMP: [f64; 3] = [0.12, 0.06, 0.03];
/// Prior standard deviations from session to session where nothing jumps, and the number of sessions' worth of evidence that they count for. With
/// one, of six sessions that differ as much a test for changes at 0.03 % fired in 0.16 %; with four in 0.01 %.
const STEADY: [f64; 3] = [0.004, 0.002, 0.0015];
const STEADY_SESSIONS: f64 = 4.0;
/// Chance that something jumps between two sessions where one only was seen; k sessions show it k times less, down to the least.
const JUMP_CHANCE: [f64; 2] = [0.20, 0.06];
/// Chance that a session in which nothing jumps does not differ at all from the one before, where one only was seen; k sessions show it k times
/// less, for what they differ by is then known. On a linear table this costs one that is as it was 0.01 × the scatter of repeats after any
/// number of strikes (0.02 with a half); one that differs as above is followed to 0.06 with either.
const SAME_CHANCE: f64 = 0.8;
/// Weight of the world's own scatter as a prior, in strikes.
const PRIOR_STRIKES: f64 = 3.0;
/// Least scatter of ln launch speed, ln distance and bearing (rad): no camera and no arm repeats better.
const LEAST_SCATTER: [f64; 3] = [2e-3, 2e-3, 1e-3];
/// Squared distance beyond which a strike's weight falls: of χ² with three degrees of freedom one in a hundred is greater.
const OUTLYING: f64 = 11.0;
/// Passes of estimating scatter and sessions by turns.
const PASSES: usize = 6;
/// Steps of wander from strike to strike that are tried, of ln friction, ln gain and heading (rad): each √2 times the one before.
const WANDERS: [f64; 12] = [
    0.0, 0.001, 0.0014, 0.002, 0.0028, 0.004, 0.0057, 0.008, 0.0113, 0.016, 0.0226, 0.032,
];
/// Prior chance that a strike is bad (mislabelled, bumped, not free), so that it says nothing of the table, and the number of strikes that the prior
/// counts for.
const BAD: f64 = 0.02;
const BAD_STRIKES: f64 = 50.0;
/// Share of bad strikes above which nothing is learnt from them.
const MOST_BAD: f64 = 0.5;
/// Standard deviations of what a bad strike shows: so wide that one which a usual jump explains is hardly taken for bad.
const BAD_SHOWN: [f64; 3] = [0.3, 0.5, 0.3];
/// Gain in log-likelihood (nats) from which a wander is claimed.
const CLAIMED: f64 = 3.0;
/// Fewer strikes than these in a row show no wander.
const LEAST_IN_A_ROW: usize = 12;
/// Gain in log-likelihood (nats) from which a table is said to have changed between two strikes, wherever it is looked for: chance reaches it in less
/// than one in ten thousand rows of a hundred strikes.
const CLAIMED_STEP: f64 = 16.0;
/// Least number of strikes on each side of a change.
const LEAST_BESIDE: usize = 5;
/// Fewer strikes than these show no session's own value.
const LEAST_IN_A_SESSION: usize = 3;

/// How a table varies, as a version's own strikes show it beside one of its models. Vectors are in the order ln friction, ln gain,
/// heading (rad); what a strike shows in the order ln launch speed, ln distance, bearing (rad).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Varies {
    /// Number of strikes that this was estimated from; 0 for what is assumed of every table.
    pub strikes: usize,
    /// Covariance of what strikes show on an unchanged table: row by row.
    pub scatter: Rows,
    /// Excess of the launch speed (ln) over the model's, though strikes stop where the model says.
    pub launch_bias: f64,
    /// Chance that a strike is bad: what it shows says nothing of the table.
    #[serde(default = "usually_bad")]
    pub bad: f64,
    /// Standard deviations of the table's own step from strike to strike; 0 where none was found.
    pub wander: [f64; 3],
    /// Covariance of the model's own error, from the strikes that it learnt from: row by row.
    pub certainty: Rows,
    /// Differences from session to session.
    pub between: BetweenSessions,
}

/// How sessions differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BetweenSessions {
    /// Number of sessions that this was estimated from.
    pub sessions: usize,
    /// Standard deviations of ln friction, ln gain and heading (rad) between sessions.
    pub deviations: [f64; 3],
    /// Chance that friction, gain or heading jumps beyond these deviations between two sessions.
    pub jump_chance: f64,
}

impl BetweenSessions {
    /// Standard deviations of the next session about the mean of those seen.
    pub fn next(&self) -> [f64; 3] {
        let factor = (1.0 + 1.0 / self.sessions.max(1) as f64).sqrt();
        self.deviations.map(|sd| sd * factor)
    }

    /// Degrees of freedom of [`Self::deviations`].
    pub fn freedom(&self) -> f64 {
        STEADY_SESSIONS + self.sessions.max(1) as f64 - 1.0
    }

    /// Chance that the next session does not differ at all, where nothing jumps.
    pub(super) fn same_chance(&self) -> f64 {
        SAME_CHANCE / self.sessions.max(1) as f64
    }
}

/// A mean square and its degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanSquare {
    /// Mean square in units of the version's scatter: one where strikes scatter alike.
    pub mean_square: f64,
    /// Degrees of freedom of the mean square.
    pub freedom: f64,
}

/// A session's strikes in order of time: each one's number among all that were made, and what it showed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Session(pub Vec<(f64, Observation)>);

impl Varies {
    /// Assumed for a world's table where no strike says: the world's own scatter, and its effects' differences by session.
    pub fn assumed(world: &World) -> Self {
        let population = |effect: &str| world.sessions.get(effect);
        let of_effect = |effect: &str, steady: f64| {
            population(effect).map_or(steady, |population| population.scatter.max(steady))
        };
        let sessions = world.sessions.values().map(|p| p.sessions).max();
        let sessions = sessions.unwrap_or(1).max(1) as usize;
        Self {
            strikes: 0,
            scatter: rows(&assumed_scatter(world)),
            launch_bias: 0.0,
            bad: BAD,
            wander: [0.0; 3],
            certainty: rows(&variances(STEADY)),
            between: BetweenSessions {
                sessions,
                deviations: [
                    of_effect("friction_by_session", STEADY[0]),
                    STEADY[1],
                    of_effect("striker_angle_by_session", STEADY[2]),
                ],
                jump_chance: jump_chance(sessions),
            },
        }
    }

    /// Estimated from a version's own strikes, beside a model that knows none of their sessions.
    pub fn of(world: &World, sessions: &[Session]) -> Self {
        let assumed = Self::assumed(world);
        let all = || sessions.iter().flat_map(|session| &session.0);
        let strikes = all().count();
        if strikes < LEAST_IN_A_SESSION {
            return assumed;
        }
        let slower = all().map(|(_, seen)| seen.away[0] - 0.5 * seen.away[1]);
        let launch_bias = values::median(slower.collect());
        let mut varies = Self {
            strikes,
            launch_bias: launch_bias.unwrap_or(0.0),
            ..assumed
        };
        let prior = assumed_scatter(world);
        let mut scatter = prior;
        let mut own = Vec::new();
        for _ in 0..PASSES {
            own = varies.own_values(sessions, &scatter);
            scatter = varies.scatter_about(sessions, &own, &scatter, &prior);
        }
        varies.between = between(&own);
        varies.scatter = rows(&symmetric(&scatter));
        varies.bad = varies.share_of_bad(sessions, &own);
        varies.find_wander(sessions, &prior);
        varies.certainty = rows(&symmetric(&varies.own_certainty(&own, sessions)));
        varies
    }

    /// Root mean square scatter of stops on an unchanged table, as a share of the path's length.
    pub fn stop_scatter(&self) -> f64 {
        (self.scatter[1][1] + self.scatter[2][2]).sqrt()
    }

    /// Checks that every number is finite and every covariance is one; else why not.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self) -> Result<(), String> {
        for (name, covariance) in [("scatter", self.scatter), ("certainty", self.certainty)] {
            let covariance = matrix(covariance);
            let is_symmetric = covariance == covariance.transpose();
            if !is_symmetric || covariance.cholesky().is_none() {
                return Err(format!("{name} is no covariance"));
            }
        }
        let deviations = self.wander.iter().chain(&self.between.deviations);
        let chance = self.between.jump_chance;
        if deviations.clone().all(|sd| (0.0..=1.0).contains(sd))
            && (0.0..1.0).contains(&chance)
            && (0.0..=MOST_BAD).contains(&self.bad)
            && self.launch_bias.is_finite()
        {
            Ok(())
        } else {
            Err("standard deviations must lie in [0, 1], and a chance below 1".into())
        }
    }

    /// The shift of the table that one strike alone shows; none where it does not determine all directions.
    pub fn shown_by(&self, seen: &Observation) -> Option<[f64; 3]> {
        let away = self.unbiased(seen.away_at(&Vector::zeros()));
        let shift: [f64; 3] = (matrix(seen.slopes).try_inverse()? * away).into();
        Some(shift)
    }

    /// The shift at which a session's strikes are likeliest, and its covariance; bad strikes weigh less. None of fewer than three strikes.
    pub fn fit(&self, session: &Session) -> Option<(Shift, [[f64; 3]; 3])> {
        let own = self.own_values(std::slice::from_ref(session), &matrix(self.scatter));
        let (shift, covariance) = own.into_iter().next()??;
        let shift: [f64; 3] = shift.into();
        Some((shift.into(), rows(&symmetric(&covariance))))
    }

    /// The place of the first strike on another table, where one change among the strikes explains them far better than none. A table that
    /// wanders changes all along.
    pub fn step(&self, session: &Session) -> Option<usize> {
        if self.wander != [0.0; 3] {
            return None;
        }
        let strikes = &session.0;
        let squares = |part: &[(f64, Observation)]| {
            let scatter = self.scatter_of(&Session(part.to_vec()))?;
            Some(scatter.mean_square * scatter.freedom)
        };
        let whole = squares(strikes)?;
        let last = strikes.len().saturating_sub(LEAST_BESIDE);
        let parts = (LEAST_BESIDE..=last).filter_map(|place| {
            let (before, after) = strikes.split_at(place);
            Some((place, squares(before)? + squares(after)?))
        });
        let (place, least) = parts.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (0.5 * (whole - least) > CLAIMED_STEP).then_some(place)
    }

    /// Scatter of a session's strikes about their own shift, in units of the version's scatter. A bad strike counts for no more than one that is just
    /// outlying: many are needed to make a session look bad.
    pub fn scatter_of(&self, session: &Session) -> Option<MeanSquare> {
        let (shift, _) = self.fit(session)?;
        let own = Vector::from(shift.values());
        let scatter = matrix(self.scatter);
        let seen = session.0.iter();
        let squares =
            seen.map(|(_, seen)| distance_squared(&self.left(seen, &own), &scatter).min(OUTLYING));
        let freedom = 3.0 * (session.0.len() as f64 - 1.0);
        Some(MeanSquare {
            mean_square: squares.sum::<f64>() / freedom,
            freedom,
        })
    }

    /// These statistics after the model's own values were moved to where strikes since a change have them; `certainty`: covariance of the moved
    /// values.
    pub fn moved(&self, certainty: [[f64; 3]; 3]) -> Self {
        Self {
            certainty,
            ..self.clone()
        }
    }

    /// Variances of the table's walk over so many strikes.
    pub(super) fn wander_after(&self, strikes: f64) -> Matrix {
        variances(self.wander) * strikes.max(0.0)
    }

    /// Logarithm of the likelihood of a bad strike, its chance included.
    pub(super) fn log_bad(&self, away: &Vector) -> f64 {
        self.bad.ln() + log_density(away, &variances(BAD_SHOWN))
    }

    /// An innovation with the launch bias taken off.
    pub(super) fn unbiased(&self, away: Vector) -> Vector {
        away - Vector::new(self.launch_bias, 0.0, 0.0)
    }

    /// Each session's own shift and its covariance, bad strikes weighed down.
    fn own_values(&self, sessions: &[Session], scatter: &Matrix) -> Vec<Option<(Vector, Matrix)>> {
        let one = |session: &Session| -> Option<(Vector, Matrix)> {
            let scatter_inverse = scatter.try_inverse()?;
            let prior = variances(JUMP).try_inverse()?;
            let mut own = Vector::zeros();
            let mut covariance = Matrix::zeros();
            for _ in 0..PASSES {
                let (mut information, mut score) = (prior, Vector::zeros());
                for (_, seen) in &session.0 {
                    let slopes = matrix(seen.slopes);
                    let away = self.unbiased(seen.away_at(&Vector::zeros()));
                    let left = away - slopes * own;
                    let weight = weight(&left, scatter);
                    information += slopes.transpose() * scatter_inverse * slopes * weight;
                    score += slopes.transpose() * scatter_inverse * away * weight;
                }
                covariance = information.try_inverse()?;
                own = covariance * score;
            }
            Some((own, covariance))
        };
        let is_enough = |session: &&Session| session.0.len() >= LEAST_IN_A_SESSION;
        let found = |session: &Session| Some(session).filter(is_enough).and_then(one);
        sessions.iter().map(found).collect()
    }

    /// Covariance of what strikes show about their session's own value.
    fn scatter_about(
        &self,
        sessions: &[Session],
        own: &[Option<(Vector, Matrix)>],
        scatter: &Matrix,
        prior: &Matrix,
    ) -> Matrix {
        let (mut sum, mut count) = (prior * PRIOR_STRIKES, PRIOR_STRIKES);
        for (session, own) in sessions.iter().zip(own) {
            let Some((own, _)) = own else { continue };
            for (_, seen) in &session.0 {
                let left = self.left(seen, own);
                let weight = weight(&left, scatter);
                sum += left * left.transpose() * weight;
                count += weight;
            }
            // A session's own value takes one strike's worth of freedom.
            count -= 1.0;
        }
        at_least(sum / count.max(PRIOR_STRIKES))
    }

    /// The share of bad strikes: their expected number, beside what is believed of any table.
    fn share_of_bad(&self, sessions: &[Session], own: &[Option<(Vector, Matrix)>]) -> f64 {
        let (mut bad, mut strikes) = (BAD * BAD_STRIKES, BAD_STRIKES);
        let scatter = matrix(self.scatter);
        for (session, own) in sessions.iter().zip(own) {
            let Some((own, _)) = own else { continue };
            for (_, seen) in &session.0 {
                let left = self.left(seen, own);
                let good = (1.0 - self.bad).ln() + log_density(&left, &scatter);
                bad += 1.0 / (1.0 + (good - self.log_bad(&left)).exp());
                strikes += 1.0;
            }
        }
        (bad / strikes).min(MOST_BAD)
    }

    fn left(&self, seen: &Observation, own: &Vector) -> Vector {
        self.unbiased(seen.away_at(&Vector::zeros())) - matrix(seen.slopes) * own
    }

    /// Estimates the wander, if it makes the strikes likelier beyond chance; the scatter is then what neighbours differ by beyond one step of it.
    fn find_wander(&mut self, sessions: &[Session], prior: &Matrix) {
        let longest = sessions.iter().map(|session| session.0.len()).max();
        if longest.unwrap_or(0) < LEAST_IN_A_ROW {
            return;
        }
        let still = self.likelihood(sessions);
        let neighbours = self.neighbours(sessions, prior);
        let with = |wander: [f64; 3]| Self {
            scatter: rows(&symmetric(&without_step(&neighbours, wander, sessions))),
            wander,
            ..self.clone()
        };
        let mut walking = with([0.0; 3]);
        let mut best = walking.likelihood(sessions);
        // Each direction by turns, twice: they do not trade much.
        for direction in [0, 1, 2, 0, 1, 2] {
            for step in WANDERS {
                let mut wander = walking.wander;
                wander[direction] = step;
                let tried = with(wander);
                let likelihood = tried.likelihood(sessions);
                if likelihood > best {
                    (walking, best) = (tried, likelihood);
                }
            }
        }
        if walking.wander != [0.0; 3] && best > still + CLAIMED {
            *self = walking;
        }
    }

    /// Half the covariance of neighbours' differences.
    fn neighbours(&self, sessions: &[Session], prior: &Matrix) -> Matrix {
        let differences: Vec<Vector> = sessions
            .iter()
            .flat_map(|session| session.0.windows(2))
            .map(|pair| {
                let [a, b] = [0, 1].map(|i| self.left(&pair[i].1, &Vector::zeros()));
                b - a
            })
            .collect();
        let mut scatter = matrix(self.scatter);
        for _ in 0..PASSES {
            let (mut sum, mut count) = (prior * PRIOR_STRIKES, PRIOR_STRIKES);
            for difference in &differences {
                let weight = weight(difference, &(scatter * 2.0));
                sum += difference * difference.transpose() * (0.5 * weight);
                count += weight;
            }
            scatter = at_least(sum / count);
        }
        scatter
    }

    /// Logarithm of the sessions' likelihood, each begun anywhere; a bad strike counts for no more than one that is just outlying.
    fn likelihood(&self, sessions: &[Session]) -> f64 {
        let scatter = matrix(self.scatter);
        let mut sum = 0.0;
        for session in sessions {
            let (mut mean, mut covariance) = (Vector::zeros(), variances(JUMP));
            let mut before = session.0.first().map_or(0.0, |(order, _)| *order);
            for (order, seen) in &session.0 {
                covariance += self.wander_after(order - before);
                before = *order;
                let slopes = matrix(seen.slopes);
                let left = self.left(seen, &mean);
                let innovation = slopes * covariance * slopes.transpose() + scatter;
                let far = distance_squared(&left, &innovation);
                sum += log_density(&left, &innovation) + 0.5 * (far - far.min(OUTLYING));
                if far < OUTLYING
                    && let Some(inverse) = innovation.try_inverse()
                {
                    let gain = covariance * slopes.transpose() * inverse;
                    mean += gain * left;
                    covariance -= gain * slopes * covariance;
                }
            }
        }
        sum
    }

    /// Covariance of the model's own values from all strikes together, with the variance that the table may have walked by meanwhile.
    fn own_certainty(&self, own: &[Option<(Vector, Matrix)>], sessions: &[Session]) -> Matrix {
        let informations = own
            .iter()
            .flatten()
            .filter_map(|(_, covariance)| covariance.try_inverse());
        let information = informations.fold(Matrix::zeros(), |sum, one| sum + one);
        let certainty = information.try_inverse().unwrap_or(variances(JUMP));
        let longest = sessions.iter().map(|session| session.0.len()).max();
        certainty + self.wander_after(longest.unwrap_or(0) as f64 / 3.0)
    }
}

/// Half the covariance of neighbours' differences, less what the table's own step adds to it; no more than leaves a covariance.
fn without_step(neighbours: &Matrix, wander: [f64; 3], sessions: &[Session]) -> Matrix {
    let (mut sum, mut pairs) = (Matrix::zeros(), 0.0_f64);
    for pair in sessions.iter().flat_map(|session| session.0.windows(2)) {
        let slopes = matrix(pair[1].1.slopes);
        let gap = pair[1].0 - pair[0].0;
        sum += slopes * variances(wander) * slopes.transpose() * (0.5 * gap);
        pairs += 1.0;
    }
    let step = sum / pairs.max(1.0);
    let left = [1.0, 0.75, 0.5, 0.25].map(|share| neighbours - step * share);
    let is_covariance = |left: &&Matrix| {
        let least = variances(LEAST_SCATTER);
        (*left - least).cholesky().is_some()
    };
    *left.iter().find(is_covariance).unwrap_or(neighbours)
}

fn usually_bad() -> f64 {
    BAD
}

fn jump_chance(sessions: usize) -> f64 {
    let [of_one, least] = JUMP_CHANCE;
    (of_one / sessions.max(1) as f64).max(least)
}

/// Between sessions by Paule and Mandel's estimate (1982), direction by direction, beside what is believed of a steady table.
fn between(own: &[Option<(Vector, Matrix)>]) -> BetweenSessions {
    let known: Vec<&(Vector, Matrix)> = own.iter().flatten().collect();
    let sessions = known.len();
    let deviations = std::array::from_fn(|i| {
        let values: Vec<(f64, f64)> = known
            .iter()
            .map(|(own, covariance)| (own[i], covariance[(i, i)]))
            .collect();
        let freedom = sessions.saturating_sub(1) as f64;
        let variance = STEADY_SESSIONS * STEADY[i].powi(2) + freedom * paule_mandel(&values);
        (variance / (STEADY_SESSIONS + freedom)).sqrt()
    });
    BetweenSessions {
        sessions: sessions.max(1),
        deviations,
        jump_chance: jump_chance(sessions),
    }
}

/// The variance τ² at which Σ (x − mean)²/(v + τ²) is its expectation n − 1, of values and their own variances; 0 for one value.
fn paule_mandel(values: &[(f64, f64)]) -> f64 {
    let excess = |between: f64| {
        let weights: Vec<f64> = values.iter().map(|(_, v)| 1.0 / (v + between)).collect();
        let sum: f64 = weights.iter().sum();
        let mean: f64 = values
            .iter()
            .zip(&weights)
            .map(|((x, _), w)| x * w)
            .sum::<f64>()
            / sum;
        let squares: f64 = values
            .iter()
            .zip(&weights)
            .map(|((x, _), w)| (x - mean).powi(2) * w)
            .sum();
        squares - (values.len() as f64 - 1.0)
    };
    if values.len() < 2 || excess(0.0) <= 0.0 {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

fn weight(left: &Vector, scatter: &Matrix) -> f64 {
    (OUTLYING / distance_squared(left, scatter).max(1e-12)).min(1.0)
}

/// The covariance made exactly symmetric.
fn symmetric(covariance: &Matrix) -> Matrix {
    (covariance + covariance.transpose()) * 0.5
}

/// A covariance whose variances are at least those that any camera and arm leave.
fn at_least(mut scatter: Matrix) -> Matrix {
    for (i, least) in LEAST_SCATTER.iter().enumerate() {
        scatter[(i, i)] = scatter[(i, i)].max(least * least);
    }
    scatter
}

/// Scatter of what strikes show, from the world's scatter of launches and friction: v² enters the distance, and friction divides it.
fn assumed_scatter(world: &World) -> Matrix {
    let scatter = &world.scatter;
    let speed = scatter.speed.powi(2);
    let mut assumed = Matrix::zeros();
    assumed[(0, 0)] = speed;
    assumed[(0, 1)] = 2.0 * speed;
    assumed[(1, 0)] = 2.0 * speed;
    assumed[(1, 1)] = 4.0 * speed + scatter.friction.powi(2);
    assumed[(2, 2)] = scatter.angle.powi(2);
    // A launch is read from a track, less surely than a stop.
    assumed + variances(LEAST_SCATTER.map(|sd| 3.0 * sd))
}
