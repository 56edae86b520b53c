//! All that a fit needs of a strike: the products of its columns.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::components::{FRICTION, NUISANCES, Small, VarianceComponents};
use crate::{noise::Whitening, wander::Path};

/// The products of one strike's columns: those of β, then the residual.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    /// Gᵀ·G.
    pub(super) gg: Small,
    /// Gᵀ·[X r].
    pub(super) gx: DMatrix<f64>,
    /// [X r]ᵀ·[X r].
    pub(super) xx: DMatrix<f64>,
    pub(super) rows: f64,
    /// How far each path of the wander moves this strike's friction.
    pub(super) path: Path,
    /// ln |R| in units of σ².
    pub(super) log_determinant: f64,
}

impl Products {
    /// `g`: a column for each nuisance; `x`: those of β; rows are coordinates of frames, whitened.
    pub(crate) fn new(
        g: &DMatrix<f64>,
        x: &DMatrix<f64>,
        residual: &DVector<f64>,
        whitening: &Whitening,
        path: &Path,
    ) -> Self {
        let mut products = Self {
            gg: Small::zeros(),
            gx: DMatrix::zeros(NUISANCES, 0),
            xx: DMatrix::zeros(0, 0),
            rows: whitening.rows,
            path: *path,
            log_determinant: whitening.log_determinant,
        };
        for j in 0..NUISANCES {
            for i in 0..=j {
                products.gg[(i, j)] = g.column(i).dot(&g.column(j));
                products.gg[(j, i)] = products.gg[(i, j)];
            }
        }
        let columns: Vec<_> = x.column_iter().collect();
        products.extended([g, &x.columns(0, 0).into_owned()], &columns, residual)
    }

    /// These products with other columns and another residual after the columns of β that are kept.
    fn extended(
        &self,
        [g, kept]: [&DMatrix<f64>; 2],
        columns: &[DVectorView<'_, f64>],
        residual: &DVector<f64>,
    ) -> Self {
        let (own, count) = (kept.ncols(), kept.ncols() + columns.len() + 1);
        let mut more = self.clone();
        more.gx.resize_horizontally_mut(count, 0.0);
        more.xx.resize_mut(count, count, 0.0);
        let residual = residual.column(0);
        let of = |j: usize| match j {
            _ if j < own => kept.column(j),
            _ if j + 1 < count => columns[j - own],
            _ => residual,
        };
        for j in own..count {
            let column = of(j);
            for i in 0..NUISANCES {
                more.gx[(i, j)] = g.column(i).dot(&column);
            }
            for i in 0..=j {
                let dot = of(i).dot(&column);
                more.xx[(i, j)] = dot;
                more.xx[(j, i)] = dot;
            }
        }
        more
    }

    /// These products with more columns of β and another residual; the strike's own columns `g` and `x` are as they were.
    pub(crate) fn beside(
        &self,
        g: &DMatrix<f64>,
        x: &DMatrix<f64>,
        columns: &[DVectorView<'_, f64>],
        residual: &DVector<f64>,
    ) -> Self {
        self.extended([g, x], columns, residual)
    }

    /// These products with `count` more columns of zeros.
    pub(crate) fn beside_nothing(&self, count: usize) -> Self {
        let place = self.gx.ncols() - 1;
        let mut more = self.clone();
        more.gx = more.gx.insert_columns(place, count, 0.0);
        more.xx = more
            .xx
            .insert_columns(place, count, 0.0)
            .insert_rows(place, count, 0.0);
        more
    }

    /// C = (GᵀG + σ²P⁻¹)⁻¹, and the logarithm of Σ's determinant.
    fn posterior(&self, components: &VarianceComponents) -> (Small, f64) {
        let variance = components.camera * components.camera;
        let mut precision = self.gg;
        let mut log_determinant = self.log_determinant + self.rows * variance.ln();
        for (i, sd) in components.nuisance.iter().enumerate() {
            let square = (sd * sd).max(1e-18);
            precision[(i, i)] += variance / square;
            log_determinant += (square / variance).ln();
        }
        match precision.cholesky() {
            Some(factor) => {
                let root: f64 = factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
                (factor.inverse(), log_determinant + 2.0 * root)
            }
            None => (Small::zeros(), log_determinant),
        }
    }

    /// Logarithm of Σ's determinant.
    pub(crate) fn log_determinant(&self, components: &VarianceComponents) -> f64 {
        self.posterior(components).1
    }

    /// gᵀ·Σ⁻¹·[X r] and gᵀ·Σ⁻¹·g, with g the column of the strike's friction.
    fn friction(&self, posterior: &Small, components: &VarianceComponents) -> (DVector<f64>, f64) {
        let precision = (components.camera * components.camera).recip();
        let own = self.gg.fixed_columns::<1>(FRICTION).into_owned();
        let shrunk = posterior * own;
        let with = DVector::from_fn(self.gx.ncols(), |j, _| {
            let column = self.gx.fixed_view::<NUISANCES, 1>(0, j);
            (column[FRICTION] - shrunk.dot(&column)) * precision
        });
        (with, (own[FRICTION] - own.dot(&shrunk)) * precision)
    }

    /// XᵀΣ⁻¹X and XᵀΣ⁻¹(r − X·β − g·w), with w what is known of the strike's friction beside its own.
    pub(crate) fn scores(
        &self,
        components: &VarianceComponents,
        beta: &DVector<f64>,
        gamma: &Path,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let p = beta.len();
        let (posterior, _) = self.posterior(components);
        let mut all = &self.xx * (components.camera * components.camera).recip();
        self.subtract_explained(&posterior, components, &mut all);
        all.fill_lower_triangle_with_upper_triangle();
        let (friction, _) = self.friction(&posterior, components);
        let information = all.view((0, 0), (p, p)).into_owned();
        let score = all.view((0, p), (p, 1)).column(0)
            - &information * beta
            - friction.rows(0, p) * self.path.dot(gamma);
        (information, score)
    }

    /// Subtracts from the upper half of `all` what the nuisances explain of [X r]ᵀ·[X r]/σ², which leaves [X r]ᵀ·Σ⁻¹·[X r].
    fn subtract_explained(
        &self,
        posterior: &Small,
        components: &VarianceComponents,
        all: &mut DMatrix<f64>,
    ) {
        let precision = (components.camera * components.camera).recip();
        for j in 0..self.gx.ncols() {
            let shrunk = posterior * self.gx.fixed_view::<NUISANCES, 1>(0, j) * precision;
            for i in 0..=j {
                all[(i, j)] -= self.gx.fixed_view::<NUISANCES, 1>(0, i).dot(&shrunk);
            }
        }
    }
}

/// C of a strike whose nuisances have these columns, whitened.
pub(crate) fn posterior(g: &DMatrix<f64>, components: &VarianceComponents) -> DMatrix<f64> {
    let gram = g.tr_mul(g);
    let products = Products {
        gg: Small::from_fn(|i, j| gram[(i, j)]),
        gx: DMatrix::zeros(0, 0),
        xx: DMatrix::zeros(0, 0),
        rows: 0.0,
        path: Path::zeros(),
        log_determinant: 0.0,
    };
    let (small, _) = products.posterior(components);
    DMatrix::from_fn(NUISANCES, NUISANCES, |i, j| small[(i, j)])
}
