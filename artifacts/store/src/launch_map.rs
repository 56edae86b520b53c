//! A smooth map of what the arm delivers beside the world: plain data, evaluated without a library.
//!
//! Two Gaussian processes over commanded speed and angle, one for the logarithm of the factor on the delivered speed, one for
//! what is added to the delivered angle. Each is a Bayesian linear model in [`FEATURES`] features: a constant and a slope for
//! each input, and eigenfunctions of the Laplacian on a box about the commands learnt from, which approximate a squared-exponential
//! kernel (Solin and Särkkä 2020, "Hilbert space methods for reduced-rank Gaussian process regression"). Beyond the box the
//! smooth part is zero and its uncertainty that of the prior: far from every strike the map says nothing but its slopes. Faster than
//! every strike it holds what was delivered at the fastest.

use std::f64::consts::{FRAC_PI_2, TAU};

use serde::{Deserialize, Serialize};
use values::Command;
use world::Delivery;

/// Eigenfunctions along each input.
pub const WAVES: usize = 8;
/// Features: a constant, two slopes, and the eigenfunctions.
pub const FEATURES: usize = LINEAR + WAVES * WAVES;
/// Number of features that are linear: the constant and the slopes.
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
        if parts.centre[0] + parts.half_width[0] <= 0.0 {
            return wrong("centre", "has no speed above zero");
        }
        for map in [&parts.speed, &parts.angle] {
            map.check()?;
        }
        Ok(Self { parts })
    }

    /// The numbers of the map.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// What has to be sent beside what the arm delivers for this command: speed in m/s and angle in rad.
    pub fn added(&self, command: Command) -> [f64; 2] {
        let offset = self.offset(command);
        [command.speed * (1.0 - offset.speed.exp()), -offset.angle]
    }

    /// The command, or the fastest one learnt from at its angle if it is faster.
    ///
    /// A map is learnt where the arm does not deliver the command. Nothing then says that it would deliver more than it was seen to: a
    /// drive's speed is bounded. This is assumed, not learnt; its deviation says so. Slower commands go on in proportion, to nothing at
    /// rest.
    pub fn held(&self, command: Command) -> Command {
        let fastest = self.parts.centre[0] + self.parts.half_width[0];
        Command {
            speed: command.speed.min(fastest),
            ..command
        }
    }

    /// What is delivered beside what the world's effects make of the command that is [`held`](Self::held). Beyond that the speed may be
    /// off by as much as proportion would add: the deviation counts it.
    pub fn offset(&self, command: Command) -> LaunchOffset {
        let Parts {
            centre, half_width, ..
        } = self.parts;
        let held = self.held(command);
        let beyond = (command.speed / held.speed).ln().max(0.0);
        let command = held;
        let within = |value: f64, i: usize| {
            value.clamp(centre[i] - half_width[i], centre[i] + half_width[i])
        };
        let nearest = Command::new(within(command.speed, 0), within(command.angle, 1));
        let at = features(centre, half_width, command);
        let nearest = features(centre, half_width, nearest);
        let (speed, by_speed) = self.parts.speed.at(&at, &nearest);
        let (angle, by_angle) = self.parts.angle.at(&at, &nearest);
        let most = MOST.0.ln();
        LaunchOffset {
            speed: speed.clamp(-most, most),
            angle: angle.clamp(-MOST.1, MOST.1),
            deviation: [by_speed.hypot(beyond), by_angle],
        }
    }

    /// By how many half widths a command lies outside the commands learnt from; zero among them.
    pub fn outside(&self, command: Command) -> f64 {
        let [speed, angle] = scaled(self.parts.centre, self.parts.half_width, command);
        (speed.abs().max(angle.abs()) - 1.0).max(0.0)
    }
}

impl Delivery for LaunchMap {
    fn deliver(&self, commanded: Command, by_effects: &dyn Fn(Command) -> Command) -> Command {
        let offset = self.offset(commanded);
        let by_effects = by_effects(self.held(commanded));
        Command::new(
            by_effects.speed * offset.speed.exp(),
            by_effects.angle + offset.angle,
        )
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
        let learnt: f64 = self
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
        (mean, (learnt.max(0.0) + faded + self.scatter).sqrt())
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
    let [first, second] = lengths.map(|length| {
        std::array::from_fn::<f64, WAVES, _>(|wave| {
            TAU.sqrt() * length * (-0.5 * (length * frequency(wave)).powi(2)).exp()
        })
    });
    let of = |first: f64| second.map(|second| amplitude * first * second);
    first.into_iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests;
