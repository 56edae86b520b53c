//! The embedded rig: what `carom demo` and `strike --robot sim` strike in place of hardware.
//!
//! Its physics is its own, sharing no code with the MuJoCo world or its effect library, so that finding a hidden effect in
//! its logs is no inverse crime: a planar rigid body (or a rolling ball), dry friction integrated over the base, an impulse
//! with restitution and friction from a tip of infinite mass, a camera with noise, jitter and dropped frames.
//!
//! ```text
//! Truth (rig, friction, scatter, Hidden effects)
//!   command → launch scatter → delivered (effects) → impact (effects) → slide or roll (effects) → camera (effects) → samples
//! ```
//!
//! - [`Sim`] strikes one command after another, as a robot would.
//! - [`demo::write`] writes a folder of logs with the truth beside them.
//! - [`Hidden::parse`] reads `--hide`.

mod body;
mod camera;
mod choice;
pub mod demo;
mod effects;
mod error;
mod hidden;
mod impact;
mod motion;
mod plan;
mod roll;
mod shot;
mod sim;
mod slide;
mod striker;
mod surface;
mod truth;

pub use choice::{NotSim, SimChoice};
pub use effects::{Effect, ParameterSpec};
pub use error::RigSimError;
pub use hidden::Hidden;
pub use logs::write::{RecordingWriter, Samples, Stamped, StateSample};
pub use plan::{PlannedStrike, parse_plan};
pub use shot::{Shot, When};
pub use sim::{Recording, Sim};
pub use truth::{CameraTruth, Scatter, StrikeTruth, Truth};
