//! Launch scatter and camera noise, estimated along with the parameters (EM), and the weight that they give to each
//! strike's evidence.
//!
//! A strike's residual is r = G·b + ε: b the scatter of its launch (speed, angle) and of its friction, the error of its clock
//! and of its resting place, ε the camera's noise. With b ~ N(0, P), Σ⁻¹ = (I − G·C·Gᵀ)/σ², C = (GᵀG + σ²P⁻¹)⁻¹. What is off in
//! every strike alike is no scatter: the fit takes the mean angle and clock out of r, and restitution the mean speed.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use world::Scatter;

use crate::notes::{Note, Scattering};

/// Speed, angle, clock, resting x, resting y, friction.
pub(crate) const NUISANCES: usize = 6;
/// Places of the nuisances whose scatter is estimated, and of those that are a robot's or a table's, each with its name.
const ESTIMATED: [usize; 4] = [SPEED, ANGLE, CLOCK, FRICTION];
const BOUNDED: [(usize, Scattering); 3] = [
    (SPEED, Scattering::Speed),
    (ANGLE, Scattering::Angle),
    (FRICTION, Scattering::Friction),
];
/// Places of a strike's own launch, clock and friction among the nuisances.
pub(crate) const SPEED: usize = 0;
pub(crate) const ANGLE: usize = 1;
pub(crate) const CLOCK: usize = 2;
pub(crate) const FRICTION: usize = 5;
/// The greatest scatter that a robot and a table have, relative and in rad: what differs more from strike to strike is no
/// scatter but something that is missing.
const GREATEST: f64 = 0.12;
/// Scatter that shows in no track, relative and in rad: changes below it are no changes.
const NEGLIGIBLE: f64 = 1e-3;

/// Places of launch and clock among the nuisances: unknown for a slide that no strike began.
const LAUNCH: [usize; 3] = [SPEED, ANGLE, CLOCK];
/// Prior standard deviation of an unknown nuisance.
const UNKNOWN: f64 = 10.0;

type Square = SMatrix<f64, NUISANCES, NUISANCES>;
/// One strike's deviations: relative speed, angle (rad), clock (s), resting x and y (m), relative friction.
pub(crate) type Nuisances = SVector<f64, NUISANCES>;

/// Most steps of expectation and maximisation, and the relative change of a standard deviation at which they end; the next
/// iteration of the fit takes them up where they were left.
const MOST_STEPS: u32 = 100;
const STEADY: f64 = 1e-4;

/// Standard deviations of a strike's nuisances and of the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarianceComponents {
    /// Relative speed, angle (rad), clock (s), resting x and y (m), relative friction.
    pub(crate) nuisance: [f64; NUISANCES],
    /// Standard deviation of a centroid's coordinate, in m.
    pub(crate) camera: f64,
}

impl VarianceComponents {
    /// Where estimation starts: 1 % of speed, 0.5°, half a frame, and a resting place averaged over ten frames.
    pub(crate) fn initial(camera_noise: f64, frame: f64) -> Self {
        let rest = camera_noise / 10f64.sqrt();
        Self {
            nuisance: [0.01, 0.5f64.to_radians(), 0.5 * frame, rest, rest, 0.01],
            camera: camera_noise,
        }
    }

    /// The components that apply to a strike, or to a slide that no strike began.
    fn of(&self, is_unstruck: bool) -> Self {
        let mut own = *self;
        if is_unstruck {
            for place in LAUNCH {
                own.nuisance[place] = UNKNOWN;
            }
        }
        own
    }

    /// The scatter as `world.toml` holds it.
    pub(crate) fn scatter(&self) -> Scatter {
        Scatter {
            speed: self.nuisance[SPEED],
            angle: self.nuisance[ANGLE],
            camera: self.camera,
            friction: self.nuisance[FRICTION],
            ..Scatter::default()
        }
    }

    /// Each scatter that is as great as is allowed for.
    pub(crate) fn at_bounds(&self) -> impl Iterator<Item = Note> {
        let at_bound = BOUNDED.into_iter();
        let at_bound = at_bound.filter(|(place, _)| self.is_at_bound(*place));
        at_bound.map(|(_, of)| Note::ScatterAtBound {
            of,
            bound: GREATEST,
        })
    }

    /// Whether a nuisance scatters by as much as is allowed for.
    fn is_at_bound(&self, place: usize) -> bool {
        self.nuisance[place] > 0.999 * GREATEST
    }

    /// Whether launches do.
    pub(crate) fn are_launches_at_bound(&self) -> bool {
        [SPEED, ANGLE]
            .into_iter()
            .any(|place| self.is_at_bound(place))
    }

    /// Largest relative change of a standard deviation.
    fn change(&self, next: &Self) -> f64 {
        ESTIMATED
            .into_iter()
            .map(|i| {
                let (old, new) = (self.nuisance[i], next.nuisance[i]);
                // A clock is in seconds, and never negligible.
                let least = if i == CLOCK { 0.0 } else { NEGLIGIBLE };
                (new - old).abs() / old.max(least)
            })
            .fold((next.camera / self.camera - 1.0).abs(), f64::max)
    }
}

/// One strike: residual, its derivatives by the nuisances, and C.
pub(crate) struct Evidence<'a> {
    pub(crate) residual: DVector<f64>,
    nuisances: &'a DMatrix<f64>,
    /// GᵀG, Gᵀr and rᵀr: all that the scatter needs of the track.
    gram: Square,
    projected: Nuisances,
    square: f64,
    posterior: Square,
    camera: f64,
    /// Whether it is a slide that no strike began.
    is_unstruck: bool,
}

impl<'a> Evidence<'a> {
    /// `nuisances`: one column for each, a row for each coordinate of the residual. `is_unstruck`: no strike began the slide.
    pub(crate) fn new(
        is_unstruck: bool,
        residual: DVector<f64>,
        nuisances: &'a DMatrix<f64>,
        components: &VarianceComponents,
    ) -> Self {
        let gram = nuisances.tr_mul(nuisances);
        let projected = nuisances.tr_mul(&residual);
        let mut evidence = Self {
            square: residual.norm_squared(),
            residual,
            nuisances,
            gram: Square::from_fn(|i, j| gram[(i, j)]),
            projected: Nuisances::from_fn(|i, _| projected[i]),
            posterior: Square::zeros(),
            camera: components.camera,
            is_unstruck,
        };
        evidence.reweigh(components);
        evidence
    }

    /// Weighs the strike by other variance components.
    fn reweigh(&mut self, components: &VarianceComponents) {
        let variance = components.camera * components.camera;
        let mut precision = self.gram;
        for (i, sd) in components.of(self.is_unstruck).nuisance.iter().enumerate() {
            precision[(i, i)] += variance / (sd * sd).max(1e-18);
        }
        self.posterior = precision
            .cholesky()
            .map_or_else(Square::zeros, |c| c.inverse());
        self.camera = components.camera;
    }

    /// Σ⁻¹·m for a matrix of as many rows as the residual.
    pub(crate) fn weigh(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        let projected = self.nuisances.tr_mul(m);
        let posterior = DMatrix::from_fn(NUISANCES, NUISANCES, |i, j| self.posterior[(i, j)]);
        (m - self.nuisances * (posterior * projected)) / (self.camera * self.camera)
    }

    /// rᵀ·Σ⁻¹·r.
    pub(crate) fn distance(&self) -> f64 {
        (self.square - self.projected.dot(&self.nuisance())) / (self.camera * self.camera)
    }

    /// Best linear prediction of the nuisances.
    pub(crate) fn nuisance(&self) -> Nuisances {
        self.posterior * self.projected
    }

    /// Sum of squares that the best guess leaves, in m².
    fn unexplained(&self, guess: &Nuisances) -> f64 {
        (self.square - 2.0 * guess.dot(&self.projected) + guess.dot(&(self.gram * guess))).max(0.0)
    }
}

/// The scatter under which these residuals are most likely; each strike counts by its weight. `fitted` parameters were
/// fitted to the same strikes, mean speed, angle and clock among them.
pub(crate) fn estimate_components(
    components: &VarianceComponents,
    strikes: &mut [Evidence<'_>],
    weights: &[f64],
    fitted: usize,
) -> VarianceComponents {
    let mut components = *components;
    for _ in 0..MOST_STEPS {
        let next = update(&components, strikes, weights, fitted);
        let is_steady = components.change(&next) < STEADY;
        components = next;
        for evidence in &mut *strikes {
            evidence.reweigh(&components);
        }
        if is_steady {
            break;
        }
    }
    components
}

/// One step of expectation and maximisation. The resting place keeps its prior: a constant shift is all but invisible.
fn update(
    components: &VarianceComponents,
    strikes: &[Evidence<'_>],
    weights: &[f64],
    fitted: usize,
) -> VarianceComponents {
    let variance = components.camera * components.camera;
    let mut next = *components;
    let (mut squares, mut count, mut launched) = ([0.0; NUISANCES], -1.0, -1.0);
    let (mut sum, mut freedom) = (0.0, -(fitted as f64));
    for (evidence, weight) in strikes.iter().zip(weights) {
        let guess = evidence.nuisance();
        let own = components.of(evidence.is_unstruck);
        for (i, square) in squares.iter_mut().enumerate() {
            if evidence.is_unstruck && LAUNCH.contains(&i) {
                continue;
            }
            *square += weight * (guess[i].powi(2) + variance * evidence.posterior[(i, i)]);
        }
        count += weight;
        if !evidence.is_unstruck {
            launched += weight;
        }
        sum += weight * evidence.unexplained(&guess);
        let shrunk: f64 = (0..NUISANCES)
            .map(|i| evidence.posterior[(i, i)] * variance / own.nuisance[i].powi(2).max(1e-18))
            .sum();
        freedom += weight * (evidence.residual.len() as f64 - (NUISANCES as f64 - shrunk));
    }
    for i in ESTIMATED {
        // A clock's error is in seconds.
        let most = if i == CLOCK { 1.0 } else { GREATEST };
        let count = if LAUNCH.contains(&i) { launched } else { count };
        if count > 0.0 {
            next.nuisance[i] = (squares[i] / count.max(1.0)).sqrt().clamp(1e-5, most);
        }
    }
    next.camera = (sum / freedom.max(1.0)).sqrt().max(1e-6);
    for i in [3, 4] {
        next.nuisance[i] = next.camera / 10f64.sqrt();
    }
    next
}
