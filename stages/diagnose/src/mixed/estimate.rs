//! Expectation and maximisation.

use nalgebra::{DMatrix, DVector, SVector, Vector3};

use super::{
    components::{ESTIMATED, GREATEST, LEAST, NEGLIGIBLE, NUISANCES, VarianceComponents},
    marginal::{Marginal, Prior, likeliest},
    products::Products,
    reduced::{OWN_FRICTION, Reduced, Sums},
};
use crate::wander::Path;

/// What the strikes determine: common values, variance components and each strike's nuisances.
#[derive(Clone, Debug)]
pub(crate) struct Estimated {
    /// β: change of the common parameters from where the strikes were linearised.
    pub(crate) beta: DVector<f64>,
    /// Inverse covariance of β by the data alone, without its prior.
    pub(crate) information: DMatrix<f64>,
    pub(crate) components: VarianceComponents,
    /// Logarithm of the marginal likelihood at no change.
    pub(crate) likelihood_here: f64,
    /// Logarithm of the marginal likelihood after the change β, if tracks are linear in it.
    pub(crate) likelihood_there: f64,
    /// Each strike's nuisances, its share of the wander in its friction.
    pub(crate) nuisances: Vec<SVector<f64, NUISANCES>>,
    /// γ: the wander's path.
    pub(crate) wander: Path,
    /// Root mean square change of the strikes' friction by the wander, relative.
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

/// β, the variance components and each strike's nuisances, after at most `iterations` of expectation and maximisation. `None` where β is not
/// determined.
pub(crate) fn estimate_within(
    strikes: &[Products],
    prior: &Prior,
    start: &VarianceComponents,
    iterations: usize,
) -> Option<Estimated> {
    let p = prior.precision.len();
    let reduced = Reduced::new(strikes, p, start);
    let mut components = *start;
    for iteration in 0..iterations {
        let sums = Sums::new(&reduced, &components);
        let before = components.wander;
        let (wander, marginal) = likeliest(&sums, &components, prior)?;
        components.wander = wander;
        let full = DVector::from_iterator(p + 1, marginal.beta.iter().map(|b| -b).chain([1.0]));
        let gamma = marginal.path();
        let guess = Guess::new(&reduced, &sums, &full, &gamma);
        let next = guess.maximise(&reduced, &components, &sums, &marginal, &full);
        let change = ESTIMATED
            .into_iter()
            .map(|i| {
                let (old, new) = (components.nuisance[i], next.nuisance[i]);
                (new - old).abs() / old.max(NEGLIGIBLE)
            })
            .fold((next.camera / components.camera).ln().abs(), f64::max)
            .max((wander - before).abs() / before.max(NEGLIGIBLE));
        if change < SETTLED || iteration + 1 == iterations {
            let square: f64 = guess.wandered.iter().map(|moved| moved * moved).sum();
            let own: Vec<Vector3<f64>> = guess.whole().collect();
            return Some(Estimated {
                likelihood_here: marginal.likelihood_at(&DVector::zeros(p)),
                likelihood_there: marginal.likelihood,
                nuisances: reduced.whole(&own, &full),
                information: marginal.information(),
                beta: marginal.beta,
                components,
                wander: gamma,
                wandered: (square / strikes.len().max(1) as f64).sqrt(),
            });
        }
        components = next;
    }
    None
}

/// Best guess of each strike's speed, angle and friction, given the variance components.
struct Guess {
    /// Change of each strike's friction by the wander, relative.
    wandered: Vec<f64>,
    /// Gᵀ·(r − X·β).
    seen: Vec<Vector3<f64>>,
    /// Each strike's own speed, angle and friction, without the wander.
    own: Vec<Vector3<f64>>,
}

impl Guess {
    fn new(reduced: &Reduced<'_>, sums: &Sums, full: &DVector<f64>, gamma: &Path) -> Self {
        let mut guess = Self {
            wandered: Vec::with_capacity(sums.posteriors.len()),
            seen: Vec::with_capacity(sums.posteriors.len()),
            own: Vec::with_capacity(sums.posteriors.len()),
        };
        for ((path, gram, cross), posterior) in reduced.each().zip(&sums.posteriors) {
            let wandered = path.dot(gamma);
            let mut seen = Vector3::zeros();
            for (column, factor) in cross.iter().zip(full) {
                seen.axpy(*factor, column, 1.0);
            }
            guess
                .own
                .push(posterior * (seen - gram.column(OWN_FRICTION) * wandered));
            guess.wandered.push(wandered);
            guess.seen.push(seen);
        }
        guess
    }

    /// Each strike's speed, angle and friction, the wander included in the friction.
    fn whole(&self) -> impl Iterator<Item = Vector3<f64>> {
        self.own.iter().zip(&self.wandered).map(|(own, wandered)| {
            let mut whole = *own;
            whole[OWN_FRICTION] += wandered;
            whole
        })
    }

    fn maximise(
        &self,
        reduced: &Reduced<'_>,
        components: &VarianceComponents,
        sums: &Sums,
        marginal: &Marginal,
        full: &DVector<f64>,
    ) -> VarianceComponents {
        let n = self.own.len() as f64;
        let p = marginal.beta.len();
        let variance = components.camera * components.camera;
        let spread = marginal.spread();
        let (mut squares, mut sum) = ([0.0; 3], full.dot(&(&reduced.pooled * full)));
        let each = reduced.each().zip(&sums.posteriors);
        for (((path, gram, _), posterior), (i, all)) in each.zip(self.whole().enumerate()) {
            // What is not known of the wander moves the strike's own nuisances the other way.
            let column: Vector3<f64> = gram.column(OWN_FRICTION).into();
            let moved = posterior * column;
            let unknown = path.dot(&(spread * path));
            for k in 0..3 {
                squares[k] += self.own[i][k].powi(2)
                    + variance * posterior[(k, k)]
                    + unknown * moved[k] * moved[k];
            }
            let explained = all.dot(&(gram * all)) - 2.0 * self.seen[i].dot(&all);
            let away = column[OWN_FRICTION] - 2.0 * moved.dot(&column) + moved.dot(&(gram * moved));
            sum += explained + variance * (posterior * gram).trace() + unknown * away;
        }
        let mut next = *components;
        // The common launch, angle and friction were fitted to the same strikes.
        for (k, i) in ESTIMATED.into_iter().enumerate() {
            next.nuisance[i] = (squares[k] / (n - 1.0).max(1.0))
                .sqrt()
                .clamp(LEAST, GREATEST);
        }
        next.camera = (sum / (reduced.rows - p as f64).max(1.0)).max(1e-14).sqrt();
        for i in [3, 4] {
            next.nuisance[i] = next.camera * next.resting;
        }
        next
    }
}
