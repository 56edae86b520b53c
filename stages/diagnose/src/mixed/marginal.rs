//! What all strikes say of the common values, with the wander of friction integrated out.

use nalgebra::{Cholesky, Const, DMatrix, DVector, SMatrix};

use super::{
    components::{LEAST, VarianceComponents},
    reduced::Sums,
};
use crate::wander::{PATHS, Path};

/// A Gaussian on β, to keep what the data do not determine near its start.
#[derive(Clone, Debug)]
pub(crate) struct Prior {
    /// Precision of each.
    pub(crate) precision: DVector<f64>,
    /// Mean less the value about which the model is linear.
    pub(crate) away: DVector<f64>,
}

/// Products over all strikes, the wander integrated out, and the best β.
pub(super) struct Marginal {
    /// [X r]ᵀΣ⁻¹[X r].
    all: DMatrix<f64>,
    log_determinant: f64,
    /// Cholesky factor L of the wander's precision at a known β, and L⁻¹·WᵀΣ⁻¹[X r], column by column.
    factor: Cholesky<f64, Const<PATHS>>,
    seen: Vec<Path>,
    pub(super) beta: DVector<f64>,
    /// Logarithm of the likelihood at β.
    pub(super) likelihood: f64,
}

/// Factors of the wander's standard deviation that are tried at each iteration: expectation and maximisation would creep.
const WANDERS: [f64; 5] = [0.5, 0.8, 1.0, 1.25, 2.0];

/// The standard deviation of the wander, near to the present one, at which the likelihood is greatest.
pub(super) fn likeliest(
    sums: &Sums,
    from: &VarianceComponents,
    prior: &Prior,
) -> Option<(f64, Marginal)> {
    let mut tried = WANDERS.map(|factor| (from.wander * factor).clamp(LEAST, from.greatest_wander));
    tried.sort_by(f64::total_cmp);
    let mut best: Option<(f64, Marginal)> = None;
    for (i, wander) in tried.iter().enumerate() {
        if i > 0 && tried[i - 1] == *wander {
            continue;
        }
        let Some(marginal) = Marginal::new(sums, *wander, prior) else {
            continue;
        };
        if best
            .as_ref()
            .is_none_or(|(_, best)| marginal.likelihood >= best.likelihood)
        {
            best = Some((*wander, marginal));
        }
    }
    best
}

impl Marginal {
    /// `None` where β is not determined.
    pub(super) fn new(sums: &Sums, wander: f64, prior: &Prior) -> Option<Self> {
        let p = prior.precision.len();
        let variance = wander * wander;
        let mut precision = sums.own;
        for k in 0..PATHS {
            precision[(k, k)] += variance.recip();
        }
        let factor = precision.cholesky()?;
        let root: f64 = factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
        let mut seen = sums.with.clone();
        let mut all = sums.all.clone();
        for j in 0..=p {
            factor.l_dirty().solve_lower_triangular_mut(&mut seen[j]);
            for i in 0..=j {
                all[(i, j)] -= seen[i].dot(&seen[j]);
                all[(j, i)] = all[(i, j)];
            }
        }
        let mut marginal = Self {
            all,
            log_determinant: sums.log_determinant + 2.0 * root + PATHS as f64 * variance.ln(),
            factor,
            seen,
            beta: DVector::zeros(p),
            likelihood: 0.0,
        };
        if p > 0 {
            let mut penalised = marginal.information();
            let mut pull = marginal.all.view((0, p), (p, 1)).column(0).into_owned();
            for i in 0..p {
                penalised[(i, i)] += prior.precision[i];
                pull[i] += prior.precision[i] * prior.away[i];
            }
            penalised.cholesky()?.solve_mut(&mut pull);
            marginal.beta = pull;
        }
        marginal.likelihood = marginal.likelihood_at(&marginal.beta);
        Some(marginal)
    }

    /// XᵀΣ⁻¹X.
    pub(super) fn information(&self) -> DMatrix<f64> {
        let p = self.beta.len();
        self.all.view((0, 0), (p, p)).into_owned()
    }

    /// Logarithm of the likelihood.
    pub(super) fn likelihood_at(&self, beta: &DVector<f64>) -> f64 {
        let p = beta.len();
        let mut left = self.all[(p, p)];
        for j in 0..p {
            let along: f64 = (0..p).map(|i| self.all[(i, j)] * beta[i]).sum();
            left += beta[j] * (along - 2.0 * self.all[(j, p)]);
        }
        -0.5 * (self.log_determinant + left)
    }

    /// γ at the best β.
    pub(super) fn path(&self) -> Path {
        let p = self.beta.len();
        let mut seen = self.seen[p];
        for (column, beta) in self.seen.iter().zip(&self.beta) {
            seen.axpy(-beta, column, 1.0);
        }
        self.factor
            .l_dirty()
            .tr_solve_lower_triangular_mut(&mut seen);
        seen
    }

    /// Covariance of γ at a known β.
    pub(super) fn spread(&self) -> SMatrix<f64, PATHS, PATHS> {
        self.factor.inverse()
    }
}
