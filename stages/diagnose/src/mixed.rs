//! The linear mixed model of strikes: what a strike's residual is evidence of when its launch scatters.
//!
//! r = X·β + G·b + ε for each strike: β common to all, b ~ N(0, P) its own launch, clock, resting place and friction, ε the camera's noise, made
//! independent beforehand ([`crate::noise`]). Friction also wanders over the order of strikes ([`crate::wander`]): γ ~ N(0, σ_w²) is common to all
//! strikes, acts as friction of φᵀγ and is integrated out as b is. All that is needed of a strike are the products of its columns, a few dozen
//! numbers in place of its frames. Clock and resting place, whose scatter is not estimated, are integrated out beforehand. Variances by expectation and maximisation (Laird and Ware 1982).

use nalgebra::{
    Cholesky, Const, DMatrix, DVector, DVectorView, Matrix3, SMatrix, SVector, Vector3,
};

use crate::noise::{self, FrameNoise, Whitening};
use crate::wander::{PATHS, Path};

/// Speed (logarithm), angle, clock, resting x, resting y, friction (logarithm).
pub(crate) const NUISANCES: usize = 6;
/// Places among them whose standard deviations are estimated.
pub(crate) const ESTIMATED: [usize; 3] = [SPEED, ANGLE, FRICTION];
/// Places of speed, angle and friction.
pub(crate) const SPEED: usize = 0;
pub(crate) const ANGLE: usize = 1;
pub(crate) const FRICTION: usize = 5;

pub(super) type Small = SMatrix<f64, NUISANCES, NUISANCES>;

/// Standard deviations of a strike's nuisances and of the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarianceComponents {
    /// Relative speed, angle (rad), clock (s), resting x and y (m), relative friction.
    pub(crate) nuisance: [f64; NUISANCES],
    /// Standard deviation of a centroid's coordinate, in m.
    pub(crate) camera: f64,
    /// Standard deviation of the wander of friction from the first strike to the last, relative.
    pub(crate) wander: f64,
    /// Upper bound of `wander`.
    pub(super) greatest_wander: f64,
    /// Standard deviation of a resting place over that of a centroid's coordinate.
    pub(super) resting: f64,
}

/// Prior standard deviation of a strike's clock, in frames: all but free. First motion is seen later where the object is slow, the camera noisy or a
/// frame lost, and a prior that pulled clocks together would turn that into speeds that depend on speed.
const CLOCK_FRAMES: f64 = 2.0;
/// Scatter of speed, angle and friction from which the estimate starts, and the greatest that a robot and a table have: what
/// differs more from strike to strike is no scatter but something that is missing, and must not be weighed down as if it were.
const START: f64 = 0.01;
pub(crate) const GREATEST: f64 = 0.12;
/// Scatter that shows in no track: changes below it are no changes.
pub(super) const NEGLIGIBLE: f64 = 1e-3;
/// Least standard deviation, which keeps variances from zero.
pub(super) const LEAST: f64 = 1e-5;

impl VarianceComponents {
    /// Where estimation starts: camera noise in m, time from frame to frame in s, upper bound of the wander (relative).
    pub(crate) fn initial(camera: f64, frame: f64, greatest_wander: f64) -> Self {
        let mut components = Self {
            nuisance: [START, START, CLOCK_FRAMES * frame, 0.0, 0.0, START],
            camera,
            wander: START.min(greatest_wander),
            greatest_wander,
            resting: 0.0,
        };
        components.set_resting(FrameNoise::WHITE);
        components
    }

    /// These components, the scatter of resting places set for this camera noise.
    pub(crate) fn under(mut self, noise: FrameNoise) -> Self {
        self.set_resting(noise);
        self
    }

    /// These components with this upper bound on the standard deviation of the wander (relative).
    pub(crate) fn with_greatest_wander(mut self, greatest_wander: f64) -> Self {
        self.greatest_wander = greatest_wander;
        self
    }

    fn set_resting(&mut self, noise: FrameNoise) {
        self.resting = noise::resting(noise);
        let rest = self.camera * self.resting;
        (self.nuisance[3], self.nuisance[4]) = (rest, rest);
    }

    /// Whether the standard deviation of this nuisance is at its upper bound.
    pub(crate) fn is_at_bound(&self, place: usize) -> bool {
        ESTIMATED.contains(&place) && self.nuisance[place] > 0.999 * GREATEST
    }
}

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
