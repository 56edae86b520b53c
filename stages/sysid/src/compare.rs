//! Simulated tracks beside measured ones.

use nalgebra::DVector;
use rayon::prelude::*;
use values::{Command, Rig, Strike};
use world::{Simulated, Simulator, World, WorldError};

/// The simulated strikes of one world, in the order of the strikes.
pub(crate) struct Batch {
    simulated: Vec<Simulated>,
    launch: Launch,
}

/// How every launch differs from its command: factor on speed, turn in rad, and how late its clock starts in s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Launch {
    pub(crate) speed_factor: f64,
    pub(crate) turn: f64,
    pub(crate) delay: f64,
}

impl Launch {
    /// As commanded.
    pub(crate) const EXACT: Self = Self {
        speed_factor: 1.0,
        turn: 0.0,
        delay: 0.0,
    };
}

impl Batch {
    /// Simulates every strike as commanded.
    pub(crate) fn new(rig: &Rig, world: &World, strikes: &[&Strike]) -> Result<Self, WorldError> {
        Self::launched(rig, world, strikes, Launch::EXACT)
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
        Ok(Self { simulated, launch })
    }

    /// How every strike was launched.
    pub(crate) fn launch(&self) -> Launch {
        self.launch
    }

    /// Simulated centroids at the measured times, `later` s beyond the launch's delay: all x, then all y, in m.
    pub(crate) fn track(&self, strike: usize, times: &[f64], later: f64) -> DVector<f64> {
        let n = times.len();
        let mut track = DVector::zeros(2 * n);
        for (i, t) in times.iter().enumerate() {
            let point = self.simulated[strike].at(t + self.launch.delay + later);
            track[i] = point.x;
            track[n + i] = point.y;
        }
        track
    }

    /// Measured minus simulated coordinates of one strike, in m.
    pub(crate) fn residual(&self, index: usize, strike: &Strike) -> DVector<f64> {
        measured(strike) - self.track(index, &strike.track.t, 0.0)
    }

    /// Root mean square of measured minus simulated coordinates, in m.
    pub(crate) fn rms(&self, strikes: &[&Strike]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (i, strike) in strikes.iter().enumerate() {
            let residual = self.residual(i, strike);
            sum += residual.norm_squared();
            count += residual.len();
        }
        (sum / count.max(1) as f64).sqrt()
    }
}

/// Measured centroids: all x, then all y, in m.
fn measured(strike: &Strike) -> DVector<f64> {
    DVector::from_iterator(
        2 * strike.track.len(),
        strike.track.x.iter().chain(&strike.track.y).copied(),
    )
}
