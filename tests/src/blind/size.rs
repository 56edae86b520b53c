//! How large an effect is: the shift of the stops that it makes, in units of what repeats scatter by.

use nalgebra::{DMatrix, DVector};
use rig::{Effect, Hidden, StrikeIndex, Truth};
use values::{Command, Point};

/// Share of the larger singular value below which two directions are one.
const ALIKE: f64 = 1e-3;
/// Bisections of the strength: to less than a thousandth of the range.
const BISECTIONS: usize = 14;
/// Standard deviation of a stop by independent camera noise, in standard deviations of a frame.
const STOP_BY_CAMERA: f64 = 0.6;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shift {
    Whole,
    /// What is left of it when friction and one factor of launch are fitted to the stops: the gap that identification leaves.
    Unabsorbed,
}

/// Strikes by which sizes are measured, and where they stop with nothing hidden.
pub(super) struct Probes {
    truth: Truth,
    strikes: Vec<(Point, Command, StrikeIndex)>,
    stops: Vec<Point>,
    /// Orthonormal basis of the shifts that friction and one factor of launch make.
    absorbed: DMatrix<f64>,
}

impl Probes {
    /// Probes from these strikes: start, command, and number; `None` where the rig cannot strike.
    pub(super) fn new(truth: &Truth, strikes: Vec<(Point, Command, StrikeIndex)>) -> Option<Self> {
        let mut probes = Self {
            truth: truth.clone(),
            stops: stops(truth, &strikes)?,
            strikes,
            absorbed: DMatrix::zeros(0, 0),
        };
        let by = |change: fn(&mut Truth)| {
            let mut other = truth.clone();
            change(&mut other);
            Some(flat(&stops(&other, &probes.strikes)?) - flat(&probes.stops))
        };
        let slopes = DMatrix::from_columns(&[
            by(|truth| truth.friction *= 1.01)?,
            by(|truth| truth.restitution += 0.01)?,
        ]);
        // Both may move the stops alike: then they are one direction.
        let svd = slopes.svd(true, false);
        let largest = svd.singular_values.max();
        let kept: Vec<usize> = (0..svd.singular_values.len())
            .filter(|i| svd.singular_values[*i] > ALIKE * largest)
            .collect();
        probes.absorbed = svd.u?.select_columns(&kept);
        Some(probes)
    }

    /// What repeats scatter by at rest, in m: by launch, friction and camera.
    pub(super) fn floor(&self, strikes: usize) -> Option<f64> {
        let truth = &self.truth;
        let moved = |speed: f64, angle: f64| {
            let moved: Vec<_> = self
                .strikes
                .iter()
                .map(|(initial, command, when)| {
                    let command =
                        Command::new(command.speed * (1.0 + speed), command.angle + angle);
                    (*initial, command, *when)
                })
                .collect();
            Some(rms(&(flat(&stops(truth, &moved)?) - flat(&self.stops))))
        };
        let friction = truth.noise.friction_sd(strikes);
        let by_friction = if friction > 0.0 {
            let mut other = truth.clone();
            other.friction *= 1.0 + friction;
            rms(&(flat(&stops(&other, &self.strikes)?) - flat(&self.stops)))
        } else {
            0.0
        };
        // Noise that lasts from frame to frame is not averaged out at rest.
        let rho = truth.noise.camera_correlation();
        let lasting = ((1.0 + rho) / (1.0 - rho)).sqrt() * STOP_BY_CAMERA;
        Some(
            moved(truth.scatter.speed, 0.0)?
                .hypot(moved(0.0, truth.scatter.angle)?)
                .hypot(by_friction)
                .hypot(lasting.clamp(STOP_BY_CAMERA, 1.0) * truth.rig.camera.noise),
        )
    }

    /// Root mean square shift of the stops by an effect, in m; infinite where the rig cannot strike with it.
    fn shift(&self, effect: Effect, which: Shift) -> f64 {
        let mut with = self.truth.clone();
        with.hidden = Hidden(vec![effect]);
        let Some(stops) = stops(&with, &self.strikes) else {
            return f64::INFINITY;
        };
        let mut moved = flat(&stops) - flat(&self.stops);
        if which == Shift::Unabsorbed {
            moved -= &self.absorbed * self.absorbed.tr_mul(&moved);
        }
        rms(&moved)
    }

    /// The effect as strong as shifts the stops by this much, in m; `None` where that takes more than `strongest` times its
    /// default strength.
    pub(super) fn scaled(
        &self,
        effect: &Effect,
        shift: f64,
        which: Shift,
        strongest: f64,
    ) -> Option<Effect> {
        let (mut low, mut high) = (0.0, strongest);
        if self.shift(effect.scaled(high), which) < shift {
            return None;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.shift(effect.scaled(middle), which) < shift {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(effect.scaled(high))
    }
}

fn stops(truth: &Truth, strikes: &[(Point, Command, StrikeIndex)]) -> Option<Vec<Point>> {
    strikes
        .iter()
        .map(|(initial, command, when)| truth.expected_stop(*initial, *command, *when).ok())
        .collect()
}

fn flat(points: &[Point]) -> DVector<f64> {
    DVector::from_iterator(2 * points.len(), points.iter().flat_map(|p| [p.x, p.y]))
}

/// Root mean square length of points one after another.
fn rms(points: &DVector<f64>) -> f64 {
    (points.norm_squared() / (points.len() / 2).max(1) as f64).sqrt()
}
