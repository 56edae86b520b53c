//! A smooth map of what the arm delivers beside the world: plain data, evaluated without a library.
//!
//! Two Gaussian processes over commanded speed and angle, one for the logarithm of the factor on the delivered speed, one for
//! what is added to the delivered angle. Each is a Bayesian linear model in [`FEATURES`] features: a constant and a slope for
//! each input, and eigenfunctions of the Laplacian on a box about the commands learnt from, which approximate a squared-exponential
//! kernel (Solin and Särkkä 2020, "Hilbert space methods for reduced-rank Gaussian process regression"). Beyond the box the
//! smooth part is zero and its uncertainty that of the prior: far from every strike the map says nothing but its slopes.

use std::f64::consts::{FRAC_PI_2, TAU};

use serde::{Deserialize, Serialize};
use values::Command;
use world::Delivery;

/// Eigenfunctions along each input.
pub const WAVES: usize = 8;
/// Features: a constant, two slopes, and the eigenfunctions.
pub const FEATURES: usize = LINEAR + WAVES * WAVES;
/// Of them, the constant and the slopes.
pub const LINEAR: usize = 3;
/// Half the side of the box, in half widths of the commands learnt from.
pub const BOX: f64 = 1.75;
/// No map changes a speed by more than this factor, or an angle by more than this, in rad: whatever its weights say.
const MOST: (f64, f64) = (4.0, 1.0);
/// Below this half width (m/s, rad) commands are all the same.
const LEAST_HALF_WIDTH: f64 = 1e-6;
/// No number of a map that strikes taught is greater; sums of them stay finite.
const GREATEST: f64 = 1e6;

/// The map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct LaunchMap {
    parts: Parts,
}

/// All numbers of a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    /// Middle of the commands learnt from: m/s, rad.
    pub centre: [f64; 2],
    /// Half of their range: m/s, rad.
    pub half_width: [f64; 2],
    /// Logarithm of the factor on the delivered speed.
    pub speed: SmoothMap,
    /// What is added to the delivered angle, in rad.
    pub angle: SmoothMap,
}

/// One quantity: a Gaussian over the weights of the features.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SmoothMap {
    /// Mean of each weight.
    pub weights: Vec<f64>,
    /// Covariance of the weights, row by row.
    pub covariance: Vec<f64>,
    /// Variance of each weight before any strike.
    pub prior: Vec<f64>,
    /// Variance from strike to strike.
    pub scatter: f64,
}

/// What is delivered beside the world at one command, and how sure that is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaunchOffset {
    /// Logarithm of the factor on the speed.
    pub speed: f64,
    /// Added to the angle, in rad.
    pub angle: f64,
    /// Standard deviations of the two for one more strike.
    pub deviation: [f64; 2],
}

impl LaunchOffset {
    /// Mean distance between predicted and actual stop that its deviations make, as a share of the path's length: distance goes as speed
    /// squared, bearing as angle, and the mean of a round normal distribution's distance is √(π/2) deviations.
    pub fn expected_miss(&self) -> f64 {
        let [speed, angle] = self.deviation;
        (0.5 * FRAC_PI_2 * ((2.0 * speed).powi(2) + angle * angle)).sqrt()
    }
}

/// Why numbers are no map. Its text completes "failed to …".
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("make a launch map: `{name}` {why}; train again")]
pub struct LaunchMapError {
    /// What is wrong.
    pub name: &'static str,
    /// What it must be.
    pub why: &'static str,
}

impl LaunchMap {
    /// The map of these numbers; refuses other lengths than [`FEATURES`] demands, numbers that are not finite, and variances below
    /// zero.
    pub fn new(parts: Parts) -> Result<Self, LaunchMapError> {
        let wrong = |name, why| Err(LaunchMapError { name, why });
        if !parts.centre.iter().all(|value| value.is_finite()) {
            return wrong("centre", "is not finite");
        }
        let is_wide = |width: &f64| *width >= LEAST_HALF_WIDTH && width.is_finite();
        if !parts.half_width.iter().all(is_wide) {
            return wrong("half_width", "must be finite and above zero");
        }
        for map in [&parts.speed, &parts.angle] {
            map.check()?;
        }
        Ok(Self { parts })
    }

    /// Its numbers.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// What has to be sent beside what the arm delivers for this command: speed in m/s and angle in rad.
    pub fn added(&self, command: Command) -> [f64; 2] {
        let offset = self.offset(command);
        [command.speed * (1.0 - offset.speed.exp()), -offset.angle]
    }

    /// What is delivered beside the world for this command.
    pub fn offset(&self, command: Command) -> LaunchOffset {
        let Parts {
            centre, half_width, ..
        } = self.parts;
        let within = |value: f64, i: usize| {
            value.clamp(centre[i] - half_width[i], centre[i] + half_width[i])
        };
        let nearest = Command {
            speed: within(command.speed, 0),
            angle: within(command.angle, 1),
        };
        let at = features(centre, half_width, command);
        let nearest = features(centre, half_width, nearest);
        let (speed, by_speed) = self.parts.speed.at(&at, &nearest);
        let (angle, by_angle) = self.parts.angle.at(&at, &nearest);
        let most = MOST.0.ln();
        LaunchOffset {
            speed: speed.clamp(-most, most),
            angle: angle.clamp(-MOST.1, MOST.1),
            deviation: [by_speed, by_angle],
        }
    }

    /// By how many half widths a command lies outside the commands learnt from; zero among them.
    pub fn outside(&self, command: Command) -> f64 {
        let [speed, angle] = scaled(self.parts.centre, self.parts.half_width, command);
        (speed.abs().max(angle.abs()) - 1.0).max(0.0)
    }
}

impl Delivery for LaunchMap {
    fn deliver(&self, commanded: Command, by_effects: Command) -> Command {
        let offset = self.offset(commanded);
        Command {
            speed: by_effects.speed * offset.speed.exp(),
            angle: by_effects.angle + offset.angle,
        }
    }
}

impl SmoothMap {
    fn check(&self) -> Result<(), LaunchMapError> {
        let wrong = |name, why| Err(LaunchMapError { name, why });
        let lengths = [
            (self.weights.len(), FEATURES),
            (self.covariance.len(), FEATURES * FEATURES),
            (self.prior.len(), FEATURES),
        ];
        if lengths.iter().any(|(found, expected)| found != expected) {
            return wrong("weights", "are not as many as there are features");
        }
        let mut numbers = self.weights.iter().chain(&self.covariance);
        if !numbers.all(|value| value.abs() <= GREATEST) {
            return wrong("weights", "are not all finite and of a sensible size");
        }
        let is_variance = |value: &f64| (0.0..=GREATEST).contains(value);
        let variances = self.prior.iter().chain([&self.scatter]);
        if variances.into_iter().all(is_variance) {
            Ok(())
        } else {
            wrong("variances", "must be finite and not below zero")
        }
    }

    /// Mean, and standard deviation for one more strike, by the features of a command and of the nearest one among those learnt from.
    fn at(&self, features: &[f64; FEATURES], nearest: &[f64; FEATURES]) -> (f64, f64) {
        let dot = |row: &[f64]| row.iter().zip(features).map(|(a, b)| a * b).sum::<f64>();
        let mean = dot(&self.weights);
        let told: f64 = self
            .covariance
            .chunks_exact(FEATURES)
            .zip(features)
            .map(|(row, feature)| feature * dot(row))
            .sum();
        let prior = |features: &[f64; FEATURES]| -> f64 {
            (LINEAR..FEATURES)
                .map(|i| self.prior[i] * features[i] * features[i])
                .sum()
        };
        // Beyond the commands learnt from the features fade, and with them what they say of the smooth part's uncertainty: as much as
        // they lose from the nearest of those commands on is added.
        let faded = (prior(nearest) - prior(features)).max(0.0);
        (mean, (told.max(0.0) + faded + self.scatter).sqrt())
    }
}

impl TryFrom<Parts> for LaunchMap {
    type Error = LaunchMapError;
    fn try_from(parts: Parts) -> Result<Self, LaunchMapError> {
        Self::new(parts)
    }
}

impl From<LaunchMap> for Parts {
    fn from(map: LaunchMap) -> Self {
        map.parts
    }
}

/// A command in half widths of the commands learnt from, about their middle.
fn scaled(centre: [f64; 2], half_width: [f64; 2], command: Command) -> [f64; 2] {
    [
        (command.speed - centre[0]) / half_width[0],
        (command.angle - centre[1]) / half_width[1],
    ]
}

/// The features of a command: a constant, the two inputs in half widths, and the eigenfunctions, the second input's running
/// fastest.
pub fn features(centre: [f64; 2], half_width: [f64; 2], command: Command) -> [f64; FEATURES] {
    let at = scaled(centre, half_width, command);
    let mut features = [0.0; FEATURES];
    [features[0], features[1], features[2]] = [1.0, at[0], at[1]];
    if at.iter().all(|x| x.abs() < BOX) {
        let waves = at.map(|x| {
            let phase = FRAC_PI_2 * (x / BOX + 1.0);
            std::array::from_fn::<f64, WAVES, _>(|wave| ((wave + 1) as f64 * phase).sin())
        });
        for (i, first) in waves[0].iter().enumerate() {
            for (j, second) in waves[1].iter().enumerate() {
                // 1/√BOX for each input makes them orthonormal.
                features[LINEAR + i * WAVES + j] = first * second / BOX;
            }
        }
    }
    features
}

/// Variance of each eigenfunction's weight, in the features' order, under a squared-exponential kernel of this variance and these
/// lengths (half widths): the kernel's spectral density.
pub fn spectrum(amplitude: f64, lengths: [f64; 2]) -> Vec<f64> {
    let frequency = |wave: usize| (wave + 1) as f64 * FRAC_PI_2 / BOX;
    let density = |length: f64, wave: usize| {
        TAU.sqrt() * length * (-0.5 * (length * frequency(wave)).powi(2)).exp()
    };
    (0..WAVES)
        .flat_map(|i| (0..WAVES).map(move |j| (i, j)))
        .map(|(i, j)| amplitude * density(lengths[0], i) * density(lengths[1], j))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CENTRE: [f64; 2] = [1.0, 0.0];
    const HALF_WIDTH: [f64; 2] = [0.5, 0.4];

    fn command(x: f64, y: f64) -> Command {
        Command {
            speed: CENTRE[0] + HALF_WIDTH[0] * x,
            angle: CENTRE[1] + HALF_WIDTH[1] * y,
        }
    }

    /// Nothing learnt: the prior alone.
    fn blank(amplitude: f64) -> Parts {
        let mut prior = vec![0.0; LINEAR];
        prior.extend(spectrum(amplitude, [1.0, 0.8]));
        let mut covariance = vec![0.0; FEATURES * FEATURES];
        for i in 0..FEATURES {
            covariance[i * FEATURES + i] = prior[i];
        }
        let map = SmoothMap {
            weights: vec![0.0; FEATURES],
            covariance,
            prior,
            scatter: 0.0,
        };
        Parts {
            centre: CENTRE,
            half_width: HALF_WIDTH,
            speed: map.clone(),
            angle: map,
        }
    }

    #[test]
    fn features_make_a_squared_exponential_kernel() {
        let spectrum = spectrum(0.04, [1.0, 0.8]);
        let kernel = |a: [f64; 2], b: [f64; 2]| -> f64 {
            let at = |x: [f64; 2]| features(CENTRE, HALF_WIDTH, command(x[0], x[1]));
            let (a, b) = (at(a), at(b));
            (0..WAVES * WAVES)
                .map(|i| spectrum[i] * a[LINEAR + i] * b[LINEAR + i])
                .sum()
        };
        for (a, b) in [
            ([0.0, 0.0], [0.0, 0.0]),
            ([0.2, -0.3], [-0.4, 0.1]),
            ([0.5, 0.5], [-0.3, 0.2]),
        ] {
            let far = ((a[0] - b[0]) / 1.0f64).powi(2) + ((a[1] - b[1]) / 0.8f64).powi(2);
            let exact = 0.04 * (-0.5 * far).exp();
            assert!((kernel(a, b) - exact).abs() < 0.04 * 0.06, "{a:?} {b:?}");
        }
    }

    #[test]
    fn far_from_every_strike_it_adds_nothing_and_is_as_unsure_as_before_any() {
        let mut parts = blank(0.04);
        parts.speed.weights[LINEAR + 1] = 0.3;
        let map = LaunchMap::new(parts).expect("a map");
        assert!(map.offset(command(0.1, 0.1)).speed.abs() > 1e-3);
        for far in [command(1.8, 0.0), command(0.0, -9.0), command(40.0, 40.0)] {
            let offset = map.offset(far);
            assert_eq!(offset.speed, 0.0);
            let edge = map.offset(command(
                ((far.speed - CENTRE[0]) / HALF_WIDTH[0]).clamp(-1.0, 1.0),
                ((far.angle - CENTRE[1]) / HALF_WIDTH[1]).clamp(-1.0, 1.0),
            ));
            // Nothing was learnt at that edge either: the deviation there is the prior's.
            let apart = offset.deviation[0] - edge.deviation[0];
            assert!(
                apart.abs() < 1e-9 && edge.deviation[0] > 0.05,
                "{offset:?} {edge:?}"
            );
            assert!(map.outside(far) > 0.7);
        }
        assert_eq!(map.outside(command(1.0, -1.0)), 0.0);
    }

    #[test]
    fn whatever_its_weights_it_is_bounded() {
        let mut parts = blank(0.04);
        parts.speed.weights[0] = 1e6;
        parts.angle.weights[1] = -1e6;
        let map = LaunchMap::new(parts).expect("finite");
        let delivered = map.deliver(command(0.5, 0.0), command(0.0, 0.0));
        assert!(delivered.speed <= 4.0 * 1.0 + 1e-9 && delivered.angle >= -1.0);
    }

    #[test]
    fn numbers_that_are_no_map_are_refused() {
        type Spoil = fn(&mut Parts);
        let spoils: [Spoil; 6] = [
            |parts| parts.centre[0] = f64::NAN,
            |parts| parts.half_width[1] = 0.0,
            |parts| parts.speed.weights[3] = f64::INFINITY,
            |parts| {
                parts.angle.covariance.pop();
            },
            |parts| parts.angle.scatter = -1.0,
            |parts| parts.speed.prior[0] = f64::NAN,
        ];
        for (index, spoil) in spoils.iter().enumerate() {
            let mut parts = blank(0.01);
            spoil(&mut parts);
            assert!(LaunchMap::new(parts).is_err(), "{index}");
        }
    }
}
