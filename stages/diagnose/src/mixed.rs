//! The linear mixed model of strikes: what a strike's residual is evidence of when its launch scatters.
//!
//! r = X·β + G·b + ε for each strike: β common to all, b ~ N(0, P) its own launch, clock, resting place and friction, ε the
//! camera's noise, made independent beforehand ([`crate::noise`]). All that is needed of a strike are the products of its columns, a few dozen numbers in place of its frames.
//! Variances by expectation and maximisation (Laird and Ware 1982).

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::noise::{self, FrameNoise, Whitening};

/// Speed (logarithm), angle, clock, resting x, resting y, friction (logarithm).
pub(crate) const NUISANCES: usize = 6;
/// Places among them whose standard deviations are estimated.
pub(crate) const ESTIMATED: [usize; 3] = [SPEED, ANGLE, FRICTION];
/// Places of speed, angle and friction.
pub(crate) const SPEED: usize = 0;
pub(crate) const ANGLE: usize = 1;
pub(crate) const FRICTION: usize = 5;

type Small = SMatrix<f64, NUISANCES, NUISANCES>;

/// Standard deviations of a strike's nuisances and of the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarianceComponents {
    /// Relative speed, angle (rad), clock (s), resting x and y (m), relative friction.
    pub(crate) nuisance: [f64; NUISANCES],
    /// Of a centroid's coordinate, in m.
    pub(crate) camera: f64,
    /// Of a resting place, over the camera's.
    resting: f64,
}

/// A strike's clock is its own: first motion is seen later where the object is slow, the camera noisy or a frame lost, and a
/// prior that pulled clocks together would turn that into speeds that depend on speed. So it is all but free, in frames.
const CLOCK_FRAMES: f64 = 2.0;
/// Scatter of speed, angle and friction from which the estimate starts, and the greatest that a robot and a table have: what
/// differs more from strike to strike is no scatter but something that is missing, and must not be weighed down as if it were.
const START: f64 = 0.01;
pub(crate) const GREATEST: f64 = 0.12;
/// Scatter that shows in no track: changes below it are no changes.
const NEGLIGIBLE: f64 = 1e-3;
/// The least, which keeps it from zero.
const LEAST: f64 = 1e-5;

impl VarianceComponents {
    /// Before anything is estimated.
    pub(crate) fn initial(camera: f64, frame: f64) -> Self {
        let mut components = Self {
            nuisance: [START, START, CLOCK_FRAMES * frame, 0.0, 0.0, START],
            camera,
            resting: 0.0,
        };
        components.set_resting(FrameNoise::WHITE);
        components
    }

    /// The same under other noise of frames.
    pub(crate) fn under(mut self, noise: FrameNoise) -> Self {
        self.set_resting(noise);
        self
    }

    fn set_resting(&mut self, noise: FrameNoise) {
        self.resting = noise::resting(noise);
        let rest = self.camera * self.resting;
        (self.nuisance[3], self.nuisance[4]) = (rest, rest);
    }

    /// Whether a scatter is as great as a robot's or a table's can be.
    pub(crate) fn is_at_bound(&self, place: usize) -> bool {
        ESTIMATED.contains(&place) && self.nuisance[place] > 0.999 * GREATEST
    }
}

/// The products of one strike's columns: those of β, then the residual.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    /// Gᵀ·G.
    gg: Small,
    /// Gᵀ·[X r].
    gx: DMatrix<f64>,
    /// [X r]ᵀ·[X r].
    xx: DMatrix<f64>,
    rows: f64,
    /// ln |R| in units of σ².
    log_determinant: f64,
}

impl Products {
    /// `g`: a column for each nuisance; `x`: the columns of β, then the residual; rows are coordinates of frames, whitened.
    pub(crate) fn new(g: &DMatrix<f64>, x: &DMatrix<f64>, whitening: &Whitening) -> Self {
        let gram = g.tr_mul(g);
        Self {
            gg: Small::from_fn(|i, j| gram[(i, j)]),
            gx: g.tr_mul(x),
            xx: square(x),
            rows: whitening.rows,
            log_determinant: whitening.log_determinant,
        }
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

    /// Adds the upper half of [X r]ᵀ·Σ⁻¹·[X r].
    fn weigh(&self, posterior: &Small, components: &VarianceComponents, all: &mut DMatrix<f64>) {
        let precision = (components.camera * components.camera).recip();
        for j in 0..self.gx.ncols() {
            let shrunk = posterior * self.gx.fixed_view::<NUISANCES, 1>(0, j);
            for i in 0..=j {
                let taken = self.gx.fixed_view::<NUISANCES, 1>(0, i).dot(&shrunk);
                all[(i, j)] += (self.xx[(i, j)] - taken) * precision;
            }
        }
    }
}

/// xᵀ·x, each pair of columns once.
fn square(x: &DMatrix<f64>) -> DMatrix<f64> {
    let mut square = DMatrix::zeros(x.ncols(), x.ncols());
    for i in 0..x.ncols() {
        for j in 0..=i {
            let dot = x.column(i).dot(&x.column(j));
            square[(i, j)] = dot;
            square[(j, i)] = dot;
        }
    }
    square
}

/// A Gaussian on β, to keep what the data do not tell near where it was.
#[derive(Clone, Debug)]
pub(crate) struct Prior {
    /// Precision of each.
    pub(crate) precision: DVector<f64>,
    /// Mean less the value about which the model is linear.
    pub(crate) away: DVector<f64>,
}

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
    /// Each strike's nuisances.
    pub(crate) nuisances: Vec<SVector<f64, NUISANCES>>,
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
    let mut components = *start;
    for iteration in 0..iterations {
        let (information, score, square, log_determinant, posteriors) =
            sums(strikes, &components, p);
        let mut penalised = information.clone();
        let mut pull = score.clone();
        for i in 0..p {
            penalised[(i, i)] += prior.precision[i];
            pull[i] += prior.precision[i] * prior.away[i];
        }
        let beta = if p == 0 {
            DVector::zeros(0)
        } else {
            penalised.cholesky()?.solve(&pull)
        };
        let nuisances: Vec<_> = strikes
            .iter()
            .zip(&posteriors)
            .map(|(strike, posterior)| {
                let mut left = SVector::<f64, NUISANCES>::zeros();
                for k in 0..NUISANCES {
                    left[k] = strike.gx[(k, p)]
                        - (0..p).map(|i| strike.gx[(k, i)] * beta[i]).sum::<f64>();
                }
                posterior * left
            })
            .collect();
        let next = maximise(strikes, &components, &posteriors, &nuisances, &beta);
        let change = ESTIMATED
            .into_iter()
            .map(|i| {
                let (old, new) = (components.nuisance[i], next.nuisance[i]);
                (new - old).abs() / old.max(NEGLIGIBLE)
            })
            .fold((next.camera / components.camera).ln().abs(), f64::max);
        if change < SETTLED || iteration + 1 == iterations {
            let there = square - 2.0 * beta.dot(&score) + beta.dot(&(&information * &beta));
            return Some(Estimated {
                likelihood_here: -0.5 * (log_determinant + square),
                likelihood_there: -0.5 * (log_determinant + there),
                beta,
                information,
                components,
                nuisances,
            });
        }
        components = next;
    }
    None
}

type Sums = (DMatrix<f64>, DVector<f64>, f64, f64, Vec<Small>);

/// XᵀΣ⁻¹X, XᵀΣ⁻¹r, rᵀΣ⁻¹r, ln det Σ over all strikes, and each strike's C.
fn sums(strikes: &[Products], components: &VarianceComponents, p: usize) -> Sums {
    let mut all = DMatrix::zeros(p + 1, p + 1);
    let mut log_determinant = 0.0;
    let mut posteriors = Vec::with_capacity(strikes.len());
    for strike in strikes {
        let (posterior, determinant) = strike.posterior(components);
        strike.weigh(&posterior, components, &mut all);
        log_determinant += determinant;
        posteriors.push(posterior);
    }
    all.fill_lower_triangle_with_upper_triangle();
    (
        all.view((0, 0), (p, p)).into_owned(),
        DVector::from_iterator(p, (0..p).map(|i| all[(i, p)])),
        all[(p, p)],
        log_determinant,
        posteriors,
    )
}

fn maximise(
    strikes: &[Products],
    components: &VarianceComponents,
    posteriors: &[Small],
    nuisances: &[SVector<f64, NUISANCES>],
    beta: &DVector<f64>,
) -> VarianceComponents {
    let n = strikes.len() as f64;
    let p = beta.len();
    let variance = components.camera * components.camera;
    let mut next = *components;
    // The common launch, angle and friction were fitted to the same strikes.
    for i in ESTIMATED {
        let sum: f64 = nuisances
            .iter()
            .zip(posteriors)
            .map(|(b, posterior)| b[i] * b[i] + variance * posterior[(i, i)])
            .sum();
        next.nuisance[i] = (sum / (n - 1.0).max(1.0)).sqrt().clamp(LEAST, GREATEST);
    }
    let full = DVector::from_iterator(p + 1, beta.iter().map(|b| -b).chain([1.0]));
    let (mut sum, mut rows) = (0.0, 0.0);
    for ((strike, b), posterior) in strikes.iter().zip(nuisances).zip(posteriors) {
        let residual = full.dot(&(&strike.xx * &full));
        let cross = (&strike.gx * &full).fixed_rows::<NUISANCES>(0).dot(b);
        let explained = b.dot(&(strike.gg * b));
        sum += residual - 2.0 * cross + explained + variance * (posterior * strike.gg).trace();
        rows += strike.rows;
    }
    next.camera = (sum / (rows - p as f64).max(1.0)).max(1e-14).sqrt();
    for i in [3, 4] {
        next.nuisance[i] = next.camera * next.resting;
    }
    next
}

/// C of a strike whose nuisances have these columns, whitened.
pub(crate) fn posterior(g: &DMatrix<f64>, components: &VarianceComponents) -> DMatrix<f64> {
    let gram = g.tr_mul(g);
    let products = Products {
        gg: Small::from_fn(|i, j| gram[(i, j)]),
        gx: DMatrix::zeros(0, 0),
        xx: DMatrix::zeros(0, 0),
        rows: 0.0,
        log_determinant: 0.0,
    };
    let (small, _) = products.posterior(components);
    DMatrix::from_fn(NUISANCES, NUISANCES, |i, j| small[(i, j)])
}
