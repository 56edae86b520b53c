//! Strikes with clock and resting place integrated out beforehand: their scatter is not estimated, so they need not be carried through every
//! iteration.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, Vector3};

use super::{
    components::{ESTIMATED, FRICTION, NUISANCES, VarianceComponents},
    products::Products,
};
use crate::wander::{PATHS, Path};

/// Places of clock and resting place.
const OUT: [usize; 3] = [2, 3, 4];
/// Place of friction among the nuisances that stay.
pub(super) const OWN_FRICTION: usize = 2;
const _: () = assert!(ESTIMATED[OWN_FRICTION] == FRICTION);

/// One strike's clock and resting place, integrated out.
pub(super) struct Out {
    /// (GᵀG + σ²P⁻¹)⁻¹ of theirs.
    inverse: Matrix3<f64>,
    /// GᵀG, between theirs (rows) and what stays.
    between: Matrix3<f64>,
}

/// All strikes, at one ratio of the camera's noise to clocks and resting places.
pub(super) struct Reduced<'s> {
    strikes: &'s [Products],
    /// Columns of β, then the residual.
    pub(super) columns: usize,
    pub(super) out: Vec<Out>,
    /// Each strike's GᵀG of speed, angle and friction.
    pub(super) own: Vec<Matrix3<f64>>,
    /// Each strike's Gᵀ·[X r], column by column.
    cross: Vec<Vector3<f64>>,
    /// [X r]ᵀ·[X r], over all strikes.
    pub(super) pooled: DMatrix<f64>,
    /// Number of measured coordinates, over all strikes.
    pub(super) rows: f64,
    /// The part of ln |Σ| that does not depend on the estimated components.
    log_determinant: f64,
}

impl<'s> Reduced<'s> {
    /// Integrates clock and resting place out of strikes with `p` common columns and the residual.
    pub(super) fn new(strikes: &'s [Products], p: usize, components: &VarianceComponents) -> Self {
        let columns = p + 1;
        let ratios = OUT.map(|k| {
            let square = components.nuisance[k].powi(2).max(1e-18);
            components.camera * components.camera / square
        });
        let shrunk_by: f64 = ratios.iter().map(|ratio| ratio.ln()).sum();
        let mut reduced = Self {
            strikes,
            columns,
            out: Vec::with_capacity(strikes.len()),
            own: Vec::with_capacity(strikes.len()),
            cross: Vec::with_capacity(strikes.len() * columns),
            pooled: DMatrix::zeros(columns, columns),
            rows: 0.0,
            log_determinant: 0.0,
        };
        for strike in strikes {
            let part = |rows: [usize; 3], columns: [usize; 3]| {
                Matrix3::from_fn(|i, j| strike.gg[(rows[i], columns[j])])
            };
            let precision = part(OUT, OUT) + Matrix3::from_diagonal(&Vector3::from(ratios));
            let (inverse, log_determinant) = inverted(&precision);
            let between = part(OUT, ESTIMATED);
            let taken = inverse * between;
            let mut own = part(ESTIMATED, ESTIMATED) - between.tr_mul(&taken);
            own.fill_lower_triangle_with_upper_triangle();
            let mut seen = Vec::with_capacity(columns);
            for column in strike.gx.column_iter() {
                let of = |places: [usize; 3]| Vector3::from(places.map(|k| column[k]));
                seen.push(of(OUT));
                reduced.cross.push(of(ESTIMATED) - taken.tr_mul(&of(OUT)));
            }
            for j in 0..columns {
                let shrunk = inverse * seen[j];
                for (i, other) in seen[..=j].iter().enumerate() {
                    reduced.pooled[(i, j)] += strike.xx[(i, j)] - other.dot(&shrunk);
                }
            }
            reduced.rows += strike.rows;
            reduced.log_determinant += strike.log_determinant + log_determinant - shrunk_by;
            reduced.own.push(own);
            reduced.out.push(Out { inverse, between });
        }
        reduced.pooled.fill_lower_triangle_with_upper_triangle();
        reduced
    }

    /// Strikes with their paths, GᵀG and Gᵀ·[X r].
    pub(super) fn each(
        &self,
    ) -> impl Iterator<Item = (&Path, &Matrix3<f64>, &[Vector3<f64>])> + Clone {
        self.strikes
            .iter()
            .zip(&self.own)
            .zip(self.cross.chunks_exact(self.columns))
            .map(|((strike, own), cross)| (&strike.path, own, cross))
    }

    /// All nuisances of each strike, given its speed, angle and friction at a β (`full` is −β, then 1).
    pub(super) fn whole(
        &self,
        own: &[Vector3<f64>],
        full: &DVector<f64>,
    ) -> Vec<SVector<f64, NUISANCES>> {
        let each = self.strikes.iter().zip(&self.out).zip(own);
        each.map(|((strike, out), own)| {
            let seen = &strike.gx * full;
            let left = Vector3::from(OUT.map(|k| seen[k])) - out.between * own;
            let beside = out.inverse * left;
            let mut all = SVector::zeros();
            for k in 0..3 {
                all[ESTIMATED[k]] = own[k];
                all[OUT[k]] = beside[k];
            }
            all
        })
        .collect()
    }
}

/// Inverse, and logarithm of the determinant, of a positive definite matrix; nothing of another.
fn inverted(matrix: &Matrix3<f64>) -> (Matrix3<f64>, f64) {
    let determinant = matrix.determinant();
    match matrix.try_inverse() {
        Some(inverse) if determinant > 0.0 => (inverse, determinant.ln()),
        _ => (Matrix3::zeros(), 0.0),
    }
}

/// Products over all strikes at some components, Σ without the wander.
pub(super) struct Sums {
    /// [X r]ᵀΣ⁻¹[X r].
    pub(super) all: DMatrix<f64>,
    pub(super) log_determinant: f64,
    /// Each strike's C of speed, angle and friction.
    pub(super) posteriors: Vec<Matrix3<f64>>,
    /// WᵀΣ⁻¹W and, column by column, WᵀΣ⁻¹[X r], with W the wander's columns.
    pub(super) own: SMatrix<f64, PATHS, PATHS>,
    pub(super) with: Vec<Path>,
}

impl Sums {
    pub(super) fn new(reduced: &Reduced<'_>, components: &VarianceComponents) -> Self {
        let variance = components.camera * components.camera;
        let precision = variance.recip();
        let ratios = ESTIMATED.map(|k| variance / components.nuisance[k].powi(2).max(1e-18));
        let shrunk_by: f64 = ratios.iter().map(|ratio| ratio.ln()).sum();
        let ratios = Matrix3::from_diagonal(&Vector3::from(ratios));
        let mut explained = DMatrix::zeros(reduced.columns, reduced.columns);
        let mut sums = Self {
            all: DMatrix::zeros(0, 0),
            log_determinant: reduced.log_determinant + reduced.rows * variance.ln(),
            posteriors: Vec::with_capacity(reduced.own.len()),
            own: SMatrix::zeros(),
            with: vec![Path::zeros(); reduced.columns],
        };
        for (path, own, cross) in reduced.each() {
            let (posterior, log_determinant) = inverted(&(own + ratios));
            sums.log_determinant += log_determinant - shrunk_by;
            let friction: Vector3<f64> = own.column(OWN_FRICTION).into();
            let shrunk = posterior * friction;
            let weight = (friction[OWN_FRICTION] - friction.dot(&shrunk)) * precision;
            sums.own.ger(weight, path, path, 1.0);
            for (j, column) in cross.iter().enumerate() {
                let known = posterior * column;
                for (i, other) in cross[..=j].iter().enumerate() {
                    explained[(i, j)] += other.dot(&known);
                }
                let left = (column[OWN_FRICTION] - shrunk.dot(column)) * precision;
                sums.with[j].axpy(left, path, 1.0);
            }
            sums.posteriors.push(posterior);
        }
        explained.fill_lower_triangle_with_upper_triangle();
        sums.all = (&reduced.pooled - explained) * precision;
        sums
    }
}
