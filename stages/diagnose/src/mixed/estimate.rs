//! Expectation and maximisation.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::{
    components::{
        ESTIMATED, FRICTION, GREATEST, LEAST, NEGLIGIBLE, NUISANCES, Small, VarianceComponents,
    },
    marginal::{PooledProducts, Prior, Sums},
    products::Products,
};
use crate::wander::{PATHS, Path};

/// What the strikes say.
#[derive(Clone, Debug)]
pub(crate) struct Estimated {
    /// Change of the common parameters.
    pub(crate) beta: DVector<f64>,
    /// Inverse covariance of β, the prior's apart.
    pub(crate) information: DMatrix<f64>,
    pub(crate) components: VarianceComponents,
    /// Logarithm of the marginal likelihood at no change.
    pub(crate) likelihood_here: f64,
    /// The same at β, if all is as linear as its columns.
    pub(crate) likelihood_there: f64,
    /// Each strike's nuisances, its share of the wander in its friction.
    pub(crate) nuisances: Vec<SVector<f64, NUISANCES>>,
    /// γ: the wander's path.
    pub(crate) wander: Path,
    /// Root mean square of how far it moved the strikes' friction, relative.
    pub(crate) wandered: f64,
}

/// Iterations of expectation and maximisation at the most, and the change of a standard deviation at which it ends.
const ITERATIONS: usize = 60;
const SETTLED: f64 = 2e-3;

/// β, the components and each strike's nuisances, from where `components` stands. `None` where β is not determined.
pub(crate) fn estimate(
    strikes: &[Products],
    prior: &Prior,
    start: &VarianceComponents,
) -> Option<Estimated> {
    estimate_within(strikes, prior, start, ITERATIONS)
}

/// The same, with so many iterations at the most.
pub(crate) fn estimate_within(
    strikes: &[Products],
    prior: &Prior,
    start: &VarianceComponents,
    iterations: usize,
) -> Option<Estimated> {
    let p = prior.precision.len();
    let pooled = PooledProducts::new(strikes, p);
    let mut components = *start;
    for iteration in 0..iterations {
        let sums = Sums::new(strikes, &pooled, &components);
        let before = components.wander;
        let wander = sums.likeliest_wander(&components, prior);
        components.wander = wander;
        let marginal = sums.marginal(wander)?;
        let beta = marginal.beta(prior)?;
        let gamma = marginal.path(&beta);
        let nuisances: Vec<_> = strikes
            .iter()
            .zip(&sums.posteriors)
            .map(|(strike, posterior)| {
                let wandered = strike.path.dot(&gamma);
                let mut left = strike.gg.fixed_columns::<1>(FRICTION) * -wandered;
                for k in 0..NUISANCES {
                    left[k] += strike.gx[(k, p)]
                        - (0..p).map(|i| strike.gx[(k, i)] * beta[i]).sum::<f64>();
                }
                posterior * left
            })
            .collect();
        let guess = CurrentEstimate {
            beta: &beta,
            gamma: &gamma,
            spread: &marginal.spread,
            nuisances: &nuisances,
        };
        let next = maximise(strikes, &pooled, &components, &sums.posteriors, &guess);
        let change = ESTIMATED
            .into_iter()
            .map(|i| {
                let (old, new) = (components.nuisance[i], next.nuisance[i]);
                (new - old).abs() / old.max(NEGLIGIBLE)
            })
            .fold((next.camera / components.camera).ln().abs(), f64::max)
            .max((wander - before).abs() / before.max(NEGLIGIBLE));
        if change < SETTLED || iteration + 1 == iterations {
            let moved = strikes.iter().map(|strike| strike.path.dot(&gamma).powi(2));
            let wandered = (moved.sum::<f64>() / strikes.len().max(1) as f64).sqrt();
            let nuisances = nuisances.into_iter().zip(strikes).map(|(mut b, strike)| {
                b[FRICTION] += strike.path.dot(&gamma);
                b
            });
            return Some(Estimated {
                likelihood_here: marginal.likelihood(&DVector::zeros(p)),
                likelihood_there: marginal.likelihood(&beta),
                nuisances: nuisances.collect(),
                beta,
                information: marginal.information,
                components,
                wander: gamma,
                wandered,
            });
        }
        components = next;
    }
    None
}

/// All that is guessed at some components.
struct CurrentEstimate<'g> {
    beta: &'g DVector<f64>,
    gamma: &'g Path,
    /// Covariance of γ.
    spread: &'g SMatrix<f64, PATHS, PATHS>,
    /// Of each strike, the wander apart.
    nuisances: &'g [SVector<f64, NUISANCES>],
}

fn maximise(
    strikes: &[Products],
    pooled: &PooledProducts,
    components: &VarianceComponents,
    posteriors: &[Small],
    guess: &CurrentEstimate<'_>,
) -> VarianceComponents {
    let n = strikes.len() as f64;
    let p = guess.beta.len();
    let variance = components.camera * components.camera;
    let full = DVector::from_iterator(p + 1, guess.beta.iter().map(|b| -b).chain([1.0]));
    let (mut squares, mut sum) = ([0.0; NUISANCES], full.dot(&(&pooled.xx * &full)));
    for ((strike, b), posterior) in strikes.iter().zip(guess.nuisances).zip(posteriors) {
        // What is not known of the wander moves the strike's own nuisances the other way.
        let column = strike.gg.fixed_columns::<1>(FRICTION).into_owned();
        let moved = posterior * column;
        let unknown = strike.path.dot(&(guess.spread * strike.path));
        for i in ESTIMATED {
            squares[i] +=
                b[i] * b[i] + variance * posterior[(i, i)] + unknown * moved[i] * moved[i];
        }
        let mut all = *b;
        all[FRICTION] += strike.path.dot(guess.gamma);
        let cross = (&strike.gx * &full).fixed_rows::<NUISANCES>(0).dot(&all);
        let explained = all.dot(&(strike.gg * all));
        let away = column[FRICTION] - 2.0 * moved.dot(&column) + moved.dot(&(strike.gg * moved));
        sum +=
            explained - 2.0 * cross + variance * (posterior * strike.gg).trace() + unknown * away;
    }
    let mut next = *components;
    // The common launch, angle and friction were fitted to the same strikes.
    for i in ESTIMATED {
        next.nuisance[i] = (squares[i] / (n - 1.0).max(1.0))
            .sqrt()
            .clamp(LEAST, GREATEST);
    }
    next.camera = (sum / (pooled.rows - p as f64).max(1.0)).max(1e-14).sqrt();
    for i in [3, 4] {
        next.nuisance[i] = next.camera * next.resting;
    }
    next
}
