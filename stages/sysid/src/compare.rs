//! Simulated tracks beside measured ones.

use nalgebra::DVector;
use rayon::prelude::*;
use values::{Command, Rig, Strike};
use world::{Simulated, Simulator, World, WorldError};

/// The simulated strikes of one world, in the order of the strikes.
pub(crate) struct Batch {
    simulated: Vec<Simulated>,
}

/// A change of launch: factor on speed, and turn in rad.
#[derive(Clone, Copy)]
pub(crate) struct Launch {
    pub(crate) speed_factor: f64,
    pub(crate) turn: f64,
}

impl Batch {
    /// Simulates every strike as commanded.
    pub(crate) fn new(rig: &Rig, world: &World, strikes: &[&Strike]) -> Result<Self, WorldError> {
        Self::launched(
            rig,
            world,
            strikes,
            Launch {
                speed_factor: 1.0,
                turn: 0.0,
            },
        )
    }

    /// Simulates every strike with another launch.
    pub(crate) fn launched(
        rig: &Rig,
        world: &World,
        strikes: &[&Strike],
        launch: Launch,
    ) -> Result<Self, WorldError> {
        let simulator = Simulator::new(rig, world)?;
        let simulated = strikes
            .par_iter()
            .map_init(
                || simulator.worker(),
                |worker, strike| {
                    let command = Command {
                        speed: strike.command.speed * launch.speed_factor,
                        angle: strike.command.angle + launch.turn,
                    };
                    worker.strike(strike.initial, command, &strike.conditions)
                },
            )
            .collect::<Result<_, _>>()?;
        Ok(Self { simulated })
    }

    /// Simulated centroids at the measured times, shifted by `delay` s: all x, then all y, in m.
    pub(crate) fn track(&self, strike: usize, times: &[f64], delay: f64) -> DVector<f64> {
        let n = times.len();
        let mut track = DVector::zeros(2 * n);
        for (i, t) in times.iter().enumerate() {
            let point = self.simulated[strike].at(t + delay);
            track[i] = point.x;
            track[n + i] = point.y;
        }
        track
    }

    /// Root mean square of measured minus simulated coordinates, in m.
    pub(crate) fn rms(&self, strikes: &[&Strike]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (i, strike) in strikes.iter().enumerate() {
            let residual = measured(strike) - self.track(i, &strike.track.t, 0.0);
            sum += residual.norm_squared();
            count += residual.len();
        }
        (sum / count.max(1) as f64).sqrt()
    }
}

/// Measured centroids: all x, then all y, in m.
pub(crate) fn measured(strike: &Strike) -> DVector<f64> {
    DVector::from_iterator(
        2 * strike.track.len(),
        strike.track.x.iter().chain(&strike.track.y).copied(),
    )
}
