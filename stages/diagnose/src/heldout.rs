//! Whether a set of effects predicts strikes that took no part in its fit: cross-validation by groups of strikes.
//!
//! Strikes of one command are one group. Each fifth of the groups is predicted by fits to the others, with and without the
//! effects: the difference in log-likelihood of whole tracks, launch, friction and noise integrated out.

use std::collections::BTreeMap;

use nalgebra::DVector;
use statrs::distribution::{ContinuousCDF, StudentsT};
use world::WorldError;

use crate::{
    fit::Fitted,
    linearisation::{Linearisation, Linearised},
    mixed::{FRICTION, posterior},
    model::CLOCK,
    strikes::{Nuisances, PreparedStrikes},
};

/// Parts into which the strikes are divided.
pub(crate) const FOLDS: usize = 5;
/// Iterations of each fit, which starts from the fit to all strikes.
const ITERATIONS: usize = 4;
/// Commands that differ by less than this (m/s and rad) are one.
const SAME: f64 = 1e-3;

/// The part of each strike: strikes of one command share it.
pub(crate) fn folds(prepared: &PreparedStrikes<'_>) -> Vec<usize> {
    let mut groups: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    prepared
        .strikes
        .iter()
        .map(|strike| {
            let key = |value: f64| (value / SAME).round() as i64;
            let next = groups.len();
            let group = (key(strike.command.speed), key(strike.command.angle));
            *groups.entry(group).or_insert(next) % FOLDS
        })
        .collect()
}

/// What a model gains over the world without effects on each strike, which neither was fitted to.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gains {
    /// Log-likelihood of the whole track.
    pub(crate) likelihood: Vec<f64>,
    /// By how much the square of the stop error falls, in m²; zero where either model predicts no stop.
    pub(crate) stop: Vec<f64>,
}

/// The gains of every strike.
pub(crate) fn gains(
    prepared: &PreparedStrikes<'_>,
    null: &Fitted,
    fitted: &Fitted,
) -> Result<Gains, WorldError> {
    let folds = folds(prepared);
    let mut gains = Gains {
        likelihood: vec![0.0; folds.len()],
        stop: vec![0.0; folds.len()],
    };
    for fold in 0..FOLDS {
        let learns: Vec<usize> = (0..folds.len()).filter(|i| folds[*i] != fold).collect();
        if learns.len() == folds.len() || learns.is_empty() {
            continue;
        }
        let (Some(with), Some(without)) = (
            predictive(prepared, fitted, &learns)?,
            predictive(prepared, null, &learns)?,
        ) else {
            continue;
        };
        for i in (0..folds.len()).filter(|i| folds[*i] == fold) {
            gains.likelihood[i] = with[i].0 - without[i].0;
            if let (Some(with), Some(without)) = (with[i].1, without[i].1) {
                gains.stop[i] = without - with;
            }
        }
    }
    Ok(gains)
}

/// What a model predicts of one strike: its log-likelihood, and the square of its stop error, if it predicts a stop.
type Predicted = (f64, Option<f64>);

/// Log-likelihood of every strike under a model that is fitted to some of them, and the square of its stop error in m². The stop is simulated from
/// the model's own launch, not linearised about the strike's: linearised, a launch that is twice too fast would miss by half of what it does.
fn predictive(
    prepared: &PreparedStrikes<'_>,
    from: &Fitted,
    learns: &[usize],
) -> Result<Option<Vec<Predicted>>, WorldError> {
    let part = prepared.only(learns);
    let Some(fitted) = part.refit(&from.only(learns), ITERATIONS)? else {
        return Ok(None);
    };
    let Some(raw) = Linearised::all(prepared, &fitted.model, &from.nuisances)? else {
        return Ok(None);
    };
    let all = Linearisation::new(prepared, raw.into());
    let components = &fitted.estimated.components;
    let precision = components.camera.powi(-2);
    let wander = &fitted.estimated.wander;
    let values = &fitted.model.values;
    let effects = fitted.model.effects(prepared.rig, values)?;
    let planar = prepared.planar(values, &effects);
    let miss = |i: usize| {
        if !prepared.judges(i) {
            return None;
        }
        let simulated = prepared.simulate(&planar, i, values[CLOCK], &Nuisances::zeros())?;
        Some(simulated.stop.distance(prepared.strikes[i].stop).powi(2))
    };
    let each = all.whitened.iter().zip(&all.products);
    Ok(Some(
        each.zip(&prepared.paths)
            .enumerate()
            .map(|(i, ((whitened, products), path))| {
                // The wander is known from the strikes before and after.
                let wandered = whitened.nuisances.column(FRICTION) * path.dot(wander);
                let r = &whitened.residual - wandered;
                let posterior = posterior(&whitened.nuisances, components);
                let seen: DVector<f64> = whitened.nuisances.tr_mul(&r);
                let square = precision * (r.norm_squared() - seen.dot(&(&posterior * &seen)));
                let likelihood = -0.5 * (square + products.log_determinant(components));
                (likelihood, miss(i))
            })
            .collect(),
    ))
}

/// The gains, each limited to `typical` times their median size: what only a fifth of the strikes determines may go far wrong without it, and must
/// not decide over all.
pub(crate) fn limited(gains: &[f64], typical: f64) -> Vec<f64> {
    let mut sizes: Vec<f64> = gains.iter().map(|gain| gain.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = typical * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    gains.iter().map(|gain| gain.clamp(-most, most)).collect()
}

/// Sum of the gains, and its standard error over strikes.
pub(crate) fn total(gains: &[f64]) -> (f64, f64) {
    let n = gains.len().max(1) as f64;
    let sum: f64 = gains.iter().sum();
    let mean = sum / n;
    let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    (sum, (n * variance).sqrt())
}

/// One-sided level of the test: effects that predict tracks no better pass in one case of twenty.
const BY_CHANCE: f64 = 0.05;

/// Whether effects pay in stops of strikes that were `left_out` of fits in turn, by the fall of each strike's squared error: over all it must be
/// above zero. More would refuse what is real and smaller than stops scatter: whether an effect is real, tracks say with far more power.
pub(crate) fn pays(left_out: &[f64]) -> bool {
    left_out.iter().sum::<f64>() > 0.0
}

/// Whether the mean of the gains is above zero beyond chance; never of fewer than two.
pub(crate) fn is_beyond_chance(gains: &[f64]) -> bool {
    let (sum, error) = total(gains);
    quantile(gains.len(), 1.0 - BY_CHANCE).is_some_and(|t| sum > t * error)
}

/// Quantile of Student's t for the mean of so many; none of fewer than two.
pub(crate) fn quantile(count: usize, probability: f64) -> Option<f64> {
    let t = StudentsT::new(0.0, 1.0, count.checked_sub(1)? as f64).ok()?;
    Some(t.inverse_cdf(probability))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::Thresholds;

    /// `count` gains about a mean, in units of their scatter.
    fn gains(count: usize, mean: f64, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
        (0..count).map(|_| mean + normal(&mut random)).collect()
    }

    #[test]
    fn what_predicts_no_better_is_taken_for_better_in_one_case_of_twenty() {
        let cases = 2000;
        let passed = |mean: f64| {
            let each = (0..cases).filter(|seed| is_beyond_chance(&gains(60, mean, *seed)));
            each.count() as f64 / cases as f64
        };
        assert!((0.03..0.07).contains(&passed(0.0)), "{}", passed(0.0));
        assert!(passed(0.5) > 0.93, "{}", passed(0.5));
    }

    #[test]
    fn one_strike_that_goes_far_wrong_does_not_decide() {
        let mut each = gains(40, 2.0, 3);
        each[7] = -300.0;
        assert!(!is_beyond_chance(&each));
        let limited = |gains: &[f64]| limited(gains, Thresholds::default().typical_gains);
        assert!(is_beyond_chance(&limited(&each)));
        let mut none = gains(40, 0.0, 3);
        none[7] = 300.0;
        assert!(!is_beyond_chance(&limited(&none)));
    }

    #[test]
    fn what_moves_stops_farther_off_does_not_pay() {
        assert!(!pays(&[-1.0, 0.2, -0.1]));
        assert!(pays(&[1.0, -0.2, -0.1]));
        assert!(!pays(&[]));
    }
}
