//! What a solve is asked, and what it answers.

use serde::{Deserialize, Serialize};
use values::{Command, Interval};

/// Tolerances within which a solve counts as solved; a target that is further off with the command at a bound is out of reach.
pub(crate) const SOLVED: f64 = 2.0;

/// Settings of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveSettings {
    /// Miss in m at which a solve ends; one that comes within twice that is solved too.
    pub tolerance: f64,
    /// Speeds in m/s that may be tried.
    pub speed: Interval,
    /// Corrections by scaling and Broyden steps before NLopt takes over.
    pub corrections: u32,
    /// Simulations that NLopt may use; 0 leaves it out.
    pub fallback: u32,
}

impl Default for SolveSettings {
    /// Tolerance 0.5 mm; speeds 0.05–4 m/s; 12 corrections; 25 simulations.
    fn default() -> Self {
        Self {
            tolerance: 0.5e-3,
            speed: Interval::new(0.05, 4.0),
            corrections: 12,
            fallback: 25,
        }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolveStatus {
    /// The miss is within twice the tolerance: less than a millimetre by default.
    Solved,
    /// No command within the speeds allowed, on a face of a box, reaches the target; the nearest found is given.
    Unreachable,
    /// No simulation of this row came to a finite rest.
    Diverged,
}

impl SolveStatus {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Unreachable => "unreachable",
            Self::Diverged => "diverged",
        }
    }
}

/// What a solve found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// Speed in m/s and angle in rad.
    pub command: Command,
    /// Distance in m between target and simulated stop; infinite where nothing came to rest.
    pub miss: f64,
    /// MuJoCo's simulations of a whole strike; trials in planar form are not counted.
    pub evaluations: u32,
    /// How it ended.
    pub status: SolveStatus,
}
