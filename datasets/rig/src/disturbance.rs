//! What noise does in one strike: drawn once for each, from a stream of random numbers of its own.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use values::Point;

use crate::StrikeIndex;
use crate::noise::Levels;
use crate::random::{Purpose, random};

/// From when to when most objects slide, in s from the start of a recording: where lost frames matter.
const SLIDING: (f64, f64) = (0.6, 1.6);

#[derive(Clone, Debug)]
pub(crate) struct Disturbance {
    levels: Levels,
    random: ChaCha8Rng,
    pub friction: f64,
    /// How the object was put down, in rad.
    pub yaw: f64,
    /// Factors on the launch's normal deviates of speed and angle, which give them heavy tails.
    pub launch: [f64; 2],
    /// Factor on the camera's noise.
    camera: f64,
    /// Direction of the mount's vibration (its amplitude, in m) and its phase, in rad.
    mount: (Point, f64),
    /// From when to when frames are lost, in s.
    burst: (f64, f64),
    /// Correlated camera noise of the last frame, in standard deviations.
    last: Option<Point>,
}

impl Disturbance {
    pub(crate) fn new(levels: Levels, seed: u64, index: StrikeIndex) -> Self {
        let mut random = random(seed, Purpose::Noise, index.order);
        let mut friction = 1.0;
        if levels.friction_wander > 0.0 {
            friction *= (levels.friction_wander * walked(seed, index.order)).exp();
        }
        if levels.friction_scatter > 0.0 {
            friction *= (levels.friction_scatter * normal(&mut random)).exp();
        }
        let mut launch = [1.0; 2];
        if levels.launch_tails {
            launch = [tail(&mut random), tail(&mut random)];
        }
        let mut camera = 1.0;
        if levels.camera_spread > 0.0 {
            camera = (levels.camera_spread * normal(&mut random)).exp();
        }
        let mut mount = (Point::default(), 0.0);
        if levels.mount_amplitude > 0.0 {
            let turn = |random: &mut ChaCha8Rng| std::f64::consts::TAU * random.random::<f64>();
            mount = (
                Point::polar(levels.mount_amplitude, turn(&mut random)),
                turn(&mut random),
            );
        }
        let mut yaw = 0.0;
        if levels.yaw_scatter > 0.0 {
            yaw = levels.yaw_scatter * normal(&mut random);
        }
        if levels.other_change != 0.0 && random.random::<f64>() < levels.other_share {
            friction *= 1.0 + levels.other_change;
        }
        let mut burst = (0.0, 0.0);
        if levels.burst_share > 0.0 && random.random::<f64>() < levels.burst_share {
            let from = SLIDING.0 + (SLIDING.1 - SLIDING.0) * random.random::<f64>();
            burst = (from, from + levels.burst_longest * random.random::<f64>());
        }
        Self {
            levels,
            random,
            friction,
            yaw,
            launch,
            camera,
            mount,
            burst,
            last: None,
        }
    }

    /// Camera noise of the next frame (in m) from independent deviates and the standard deviation in m; a stray frame's is far off.
    pub(crate) fn frame(&mut self, white: Point, sd: f64, time: f64) -> Point {
        let mut deviate = white;
        if self.levels.camera_tails {
            deviate = Point::new(
                white.x * tail(&mut self.random),
                white.y * tail(&mut self.random),
            );
        }
        let rho = self.levels.camera_correlation;
        if rho > 0.0 {
            // The first frame has the stationary distribution, too.
            deviate = match self.last {
                None => deviate,
                Some(last) => last * rho + deviate * (1.0 - rho * rho).sqrt(),
            };
            self.last = Some(deviate);
        }
        let mut noise = deviate * sd;
        if self.camera != 1.0 {
            noise = noise * self.camera;
        }
        if self.levels.mount_amplitude > 0.0 {
            let phase = std::f64::consts::TAU * self.levels.mount_frequency * time + self.mount.1;
            noise = noise + self.mount.0 * phase.sin();
        }
        if self.levels.stray_share > 0.0 && self.random.random::<f64>() < self.levels.stray_share {
            let distance = self.levels.stray_distance * self.random.random::<f64>();
            let bearing = std::f64::consts::TAU * self.random.random::<f64>();
            noise = noise + Point::polar(distance, bearing);
        }
        noise
    }

    /// Error of the yaw in the next frame, in rad: a tracker's own, of half a degree.
    pub(crate) fn yaw_error(&mut self) -> f64 {
        const TRACKER: f64 = 0.009;
        TRACKER * normal(&mut self.random)
    }

    /// How late the next frame's stamp is, in s; negative where it is early.
    pub(crate) fn stamp_error(&mut self) -> f64 {
        let mut error = 0.0;
        if self.levels.stamp_delay > 0.0 {
            // Of [0, 1) the logarithm of 1 − u is finite.
            error -= self.levels.stamp_delay * (1.0 - self.random.random::<f64>()).ln();
        }
        if self.levels.stamp_jitter > 0.0 {
            error += self.levels.stamp_jitter * normal(&mut self.random);
        }
        error
    }

    /// Whether a frame is lost in which the object is seen here (m).
    pub(crate) fn loses(&self, seen: Point, time: f64) -> bool {
        (self.burst.0..self.burst.1).contains(&time) || self.levels.view_narrowness * seen.x > 1.0
    }

    /// How much later than the frame's first row an object is exposed that is seen here (m), in s.
    pub(crate) fn readout(&self, seen: Point) -> f64 {
        self.levels.readout.dot(seen)
    }

    /// A place as it is reported, in m.
    pub(crate) fn reported(&self, at: Point) -> Point {
        let step = self.levels.place_step;
        Point::new(on_grid(at.x, step), on_grid(at.y, step))
    }

    /// A stamp as it is reported, in s.
    pub(crate) fn reported_stamp(&self, stamp: f64) -> f64 {
        on_grid(stamp, self.levels.stamp_step)
    }

    /// Whether stamps have errors beside the camera's own jitter.
    pub(crate) fn has_stamp_errors(&self) -> bool {
        self.levels.stamp_delay > 0.0
            || self.levels.stamp_jitter > 0.0
            || self.levels.stamp_step > 0.0
    }
}

/// The nearest multiple of a step; the value itself at a step of 0.
fn on_grid(value: f64, step: f64) -> f64 {
    if step > 0.0 {
        (value / step).round() * step
    } else {
        value
    }
}

fn normal(random: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(random)
}

/// Factor that makes of a normal deviate one of the t distribution with three degrees of freedom and variance 1: with χ² of
/// three degrees of freedom, √(3/χ²) has a t deviate's variance of 3.
fn tail(random: &mut ChaCha8Rng) -> f64 {
    let square: f64 = (0..3).map(|_| normal(random).powi(2)).sum();
    1.0 / square.max(1e-6).sqrt()
}

/// The random walk of unit steps after this many strikes: each strike's step is drawn from its own stream.
fn walked(seed: u64, order: usize) -> f64 {
    (1..=order)
        .map(|step| normal(&mut random(seed, Purpose::Walk, step)))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Noise, NoiseKind};

    fn levels(flags: &[(&str, &str, f64)]) -> Levels {
        let kinds = flags.iter().map(|(name, parameter, value)| {
            let mut kind = NoiseKind::named(name).expect("a known kind");
            assert!(kind.set(parameter, *value), "{name} has no {parameter}");
            kind
        });
        Noise(kinds.collect()).levels()
    }

    fn at(order: usize) -> StrikeIndex {
        StrikeIndex { session: 0, order }
    }

    fn sd(values: &[f64]) -> f64 {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    }

    #[test]
    fn friction_scatters_and_wanders_as_given() {
        let scatter = levels(&[("friction_scatter", "sd", 0.03)]);
        let logs: Vec<f64> = (0..4000)
            .map(|order| Disturbance::new(scatter, 7, at(order)).friction.ln())
            .collect();
        assert!((sd(&logs) / 0.03 - 1.0).abs() < 0.05, "{}", sd(&logs));
        let wander = levels(&[("friction_wander", "step", 0.01)]);
        let after: Vec<f64> = (0..400)
            .map(|seed| Disturbance::new(wander, seed, at(100)).friction.ln())
            .collect();
        assert!((sd(&after) / 0.1 - 1.0).abs() < 0.15, "{}", sd(&after));
        let (one, next) = (
            Disturbance::new(wander, 3, at(50)),
            Disturbance::new(wander, 3, at(51)),
        );
        assert!((one.friction / next.friction).ln().abs() < 0.05);
    }

    #[test]
    fn correlated_noise_has_its_autocorrelation_and_the_same_size() {
        let mut noise = Disturbance::new(levels(&[("camera_correlation", "rho", 0.8)]), 1, at(0));
        let mut white = random(5, Purpose::Camera, 0);
        let frames: Vec<f64> = (0..40_000)
            .map(|k| {
                let deviates = Point::new(normal(&mut white), normal(&mut white));
                noise.frame(deviates, 0.001, f64::from(k) / 60.0).x
            })
            .collect();
        let products: f64 = frames.windows(2).map(|w| w[0] * w[1]).sum();
        let squares: f64 = frames.iter().map(|x| x * x).sum();
        assert!((products / squares - 0.8).abs() < 0.02);
        assert!((sd(&frames) / 0.001 - 1.0).abs() < 0.05);
    }

    #[test]
    fn heavy_tails_have_unit_variance_and_more_beyond_four_standard_deviations() {
        let mut stream = random(2, Purpose::Camera, 0);
        let deviates: Vec<f64> = (0..200_000)
            .map(|_| normal(&mut stream) * tail(&mut stream))
            .collect();
        let far = deviates.iter().filter(|d| d.abs() > 4.0).count() as f64 / 200_000.0;
        // P(|t₃| > 4·√3) = 0.0062; of a normal deviate 0.00006.
        assert!((far / 0.0062 - 1.0).abs() < 0.15, "{far}");
        assert!((sd(&deviates) - 1.0).abs() < 0.2);
    }

    #[test]
    fn stamps_are_late_by_their_mean() {
        let mut noise = Disturbance::new(levels(&[("late_stamps", "mean", 0.003)]), 1, at(0));
        let errors: Vec<f64> = (0..20_000).map(|_| noise.stamp_error()).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!((mean / 0.003 - 1.0).abs() < 0.05 && errors.iter().all(|e| *e >= 0.0));
    }

    #[test]
    fn without_noise_nothing_is_changed() {
        let mut none = Disturbance::new(Levels::default(), 1, at(9));
        assert_eq!((none.friction, none.launch), (1.0, [1.0; 2]));
        let white = Point::new(0.3, -1.2);
        assert_eq!(none.frame(white, 0.0007, 0.4), white * 0.0007);
        assert!(!none.has_stamp_errors());
    }
}
