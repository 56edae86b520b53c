//! The embedded rig: what `carom demo` and `strike --robot sim` strike in place of hardware.
//!
//! Its physics is its own, sharing no code with the MuJoCo world or its effect library, so that finding a hidden effect in
//! its logs is no inverse crime: a planar rigid body (or a rolling ball), dry friction integrated over the base, an impulse
//! with restitution and friction from a tip of infinite mass, a camera with noise, jitter and dropped frames.
//!
//! ```text
//! Truth (rig, friction, scatter, Hidden effects, Noise)
//!   command → launch scatter → delivered (effects) → impact (effects) → slide or roll (effects) → camera (effects) → samples
//! ```
//!
//! `truth.json` is a [`Truth`]: `rig` is the rig as it is, `noise` (only where there is any) lists kinds of noise like `hidden` lists
//! effects, and a strike has `friction`, its factor on friction, where that scatters.
//!
//! - [`Sim`] strikes one command after another, as a robot would.
//! - [`demo::write`] writes a folder of logs with the truth beside them.
//! - [`film::with_camera`] gives a demo's rig a camera: its logs then have pictures in place of centroids.
//! - [`Hide::parse`] reads `--hide`: effects, and kinds of noise.

mod air_table;
mod body;
mod choice;
mod declare;
pub mod demo;
mod disturbance;
mod effects;
mod error;
pub mod film;
mod hidden;
mod hide;
mod impact;
mod motion;
mod noise;
mod plan;
mod random;
mod roll;
mod sim;
mod slide;
mod strike;
mod surface;
mod truth;

pub use air_table::AirTable;
pub use choice::{NotSim, SimChoice};
pub use declare::ParameterSpec;
pub use effects::Effect;
pub use error::RigSimError;
pub use hidden::Hidden;
pub use hide::Hide;
pub use logs::write::{RecordingWriter, Samples, Stamped, StateSample};
pub use noise::{Noise, NoiseKind};
pub use plan::{PlannedStrike, parse_plan};
pub use random::StrikeIndex;
pub use sim::{Recording, Sim};
pub use strike::StrikeOutcome;
pub use truth::{CameraTruth, FenceTruth, Scatter, StrikeTruth, Truth};
