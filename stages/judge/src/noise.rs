//! What repeats of the same command would scatter by: the least stop error that any model can show.
//!
//! How far repeats stop from one another is the diagnosis' to say, which measures it (from repeats where there are any, else from
//! neighbours); how that spreads over strikes and directions follows from the world. Without a diagnosis, the scatter that was identified
//! says how far, too.

use serde::{Deserialize, Serialize};
use values::{Command, Point};
use world::{Scatter, Worker};

use crate::HeldOut;
use crate::held_out::last_place;

/// How repeats differ and how well the camera sees them; standard deviations, as identified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    /// Standard deviation of the launch speed, relative, and of friction as the speed that moves a stop as far.
    pub speed: f64,
    /// Standard deviation of the launch angle, in rad.
    pub angle: f64,
    /// Standard deviation of a coordinate of a measured rest position, in m.
    pub position: f64,
    /// Root mean square distance of repeats from their middle over all strikes, in m, where it was measured.
    pub measured: Option<f64>,
    /// What stops differ by between sessions beside what models know of them: root mean square in m.
    pub sessions: f64,
}

impl Noise {
    /// The noise by a world's scatter, whose camera noise is that of one centroid; a rest position is the mean of `rest_frames` centroids. An object
    /// slides as far as the square of its speed over friction says: 1 % of friction moves a stop as half a per cent of speed does.
    pub fn of(scatter: &Scatter, rest_frames: f64) -> Self {
        Self {
            speed: scatter.speed.hypot(0.5 * scatter.friction),
            angle: scatter.angle,
            position: scatter.camera / rest_frames.max(1.0).sqrt(),
            measured: None,
            sessions: 0.0,
        }
    }

    /// By how much greater than these errors (m), of strikes in `sessions` sessions, are those in a session that taught a model nothing: what it learnt
    /// is the mean of these, which each draws to itself. Of a session's own part (1 − 1/S) of the variance is left there, of a new one's (1 + 1/S).
    pub(crate) fn in_a_new_session(&self, errors: &[Option<f64>], sessions: usize) -> f64 {
        let known: Vec<f64> = errors.iter().copied().flatten().collect();
        let square = known.iter().map(|e| e * e).sum::<f64>() / known.len().max(1) as f64;
        let more = 2.0 * self.sessions.powi(2) / sessions.max(1) as f64;
        (1.0 + more / square.max(f64::MIN_POSITIVE)).sqrt()
    }

    /// Distances between prediction and measurement, in m, that a perfect model would show over many repeats of these strikes.
    pub(crate) fn distances(&self, strikes: &[&Slopes]) -> Vec<f64> {
        let each = strikes.iter().flat_map(|slopes| slopes.distances(self));
        let mut distances: Vec<f64> = each.collect();
        let squares: f64 = distances.iter().map(|distance| distance * distance).sum();
        let expected = (squares / distances.len().max(1) as f64).sqrt();
        if let Some(measured) = self.measured.filter(|_| expected > 0.0) {
            distances
                .iter_mut()
                .for_each(|distance| *distance *= measured / expected);
        }
        distances
    }
}

/// Differences for the stop's derivatives, relative in speed and in rad: smaller ones read the contact's noise.
const DIFFERENCE: f64 = 0.03;
/// Points in radius and direction at which the scatter's distribution is sampled.
const RADII: usize = 32;
const DIRECTIONS: usize = 12;

/// Where a strike's stop moves to as its launch changes, in m: by relative speed, and by angle in rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slopes {
    by_speed: Point,
    by_angle: Point,
}

impl Slopes {
    /// The slopes of a strike; none where the world cannot simulate it.
    pub(crate) fn of(worker: &mut Worker<'_>, strike: &HeldOut) -> Option<Self> {
        let mut stop = |speed: f64, angle: f64| {
            let command = Command::new(
                strike.command.speed * (1.0 + speed),
                strike.command.angle + angle,
            );
            last_place(worker, strike, command).ok()
        };
        Some(Self {
            by_speed: (stop(DIFFERENCE, 0.0)? - stop(-DIFFERENCE, 0.0)?) * (0.5 / DIFFERENCE),
            by_angle: (stop(0.0, DIFFERENCE)? - stop(0.0, -DIFFERENCE)?) * (0.5 / DIFFERENCE),
        })
    }

    /// Distances between prediction and measurement, in m, that a perfect model would show over many repeats of the strike:
    /// evenly weighted points of the scatter's distribution.
    fn distances(&self, noise: &Noise) -> Vec<f64> {
        let scatter = Ellipse::of(&[
            self.by_speed * noise.speed,
            self.by_angle * noise.angle,
            // Where it rested before and after is measured with the same error each.
            Point::new(noise.position * std::f64::consts::SQRT_2, 0.0),
            Point::new(0.0, noise.position * std::f64::consts::SQRT_2),
        ]);
        scatter.distances()
    }
}

/// A normal distribution in the plane, as the lower factor of its covariance.
struct Ellipse {
    xx: f64,
    yx: f64,
    yy: f64,
}

impl Ellipse {
    /// The sum of independent scatters along these vectors, each of that length's standard deviation.
    fn of(scatters: &[Point]) -> Self {
        let sum = |term: fn(&Point) -> f64| scatters.iter().map(term).sum::<f64>();
        let (xx, xy, yy) = (sum(|v| v.x * v.x), sum(|v| v.x * v.y), sum(|v| v.y * v.y));
        let x = xx.sqrt();
        let yx = if x > 0.0 { xy / x } else { 0.0 };
        Self {
            xx: x,
            yx,
            yy: (yy - yx * yx).max(0.0).sqrt(),
        }
    }

    /// Distances in m from the centre of points of equal weight: middles of rings and sectors of equal probability.
    fn distances(&self) -> Vec<f64> {
        let radius = |ring: usize| (-2.0 * (1.0 - (ring as f64 + 0.5) / RADII as f64).ln()).sqrt();
        let bearing =
            |sector: usize| std::f64::consts::TAU * (sector as f64 + 0.5) / DIRECTIONS as f64;
        (0..RADII)
            .flat_map(|ring| {
                (0..DIRECTIONS).map(move |sector| Point::polar(radius(ring), bearing(sector)))
            })
            .map(|z| Point::new(self.xx * z.x, self.yx * z.x + self.yy * z.y).norm())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(values: &[f64]) -> f64 {
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn friction_that_scatters_counts_as_half_as_much_speed() {
        let scatter = Scatter {
            speed: 0.003,
            angle: 0.005,
            camera: 0.001,
            friction: 0.008,
            camera_correlation: 0.0,
            stamp_jitter: 0.0,
        };
        assert!((Noise::of(&scatter, 4.0).speed - 0.005).abs() < 1e-12);
    }

    #[test]
    fn what_was_measured_is_the_root_mean_square_of_the_floor() {
        let slopes = [0.3, 0.6].map(|length| Slopes {
            by_speed: Point::new(2.0 * length, 0.0),
            by_angle: Point::new(0.0, length),
        });
        let noise = Noise {
            speed: 0.01,
            angle: 0.01,
            position: 0.0,
            measured: Some(0.004),
            sessions: 0.0,
        };
        let squares: Vec<f64> = noise
            .distances(&[&slopes[0], &slopes[1]])
            .iter()
            .map(|distance| distance * distance)
            .collect();
        assert!((mean(&squares).sqrt() - 0.004).abs() < 1e-12);
    }

    #[test]
    fn round_scatter_follows_the_rayleigh_distribution() {
        let distances = Ellipse::of(&[Point::new(0.002, 0.0), Point::new(0.0, 0.002)]).distances();
        let squares: Vec<f64> = distances.iter().map(|d| d * d).collect();
        assert!(
            (mean(&distances) / (0.002 * (std::f64::consts::PI / 2.0).sqrt()) - 1.0).abs() < 0.01
        );
        assert!((mean(&squares).sqrt() / (0.002 * 2f64.sqrt()) - 1.0).abs() < 0.02);
    }

    #[test]
    fn scatter_along_a_line_follows_the_half_normal_distribution() {
        let distances = Ellipse::of(&[Point::new(0.003, 0.004)]).distances();
        let expected = 0.005 * (2.0 / std::f64::consts::PI).sqrt();
        assert!(
            (mean(&distances) / expected - 1.0).abs() < 0.02,
            "{}",
            mean(&distances)
        );
    }
}
