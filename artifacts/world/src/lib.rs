//! The MuJoCo world that predicts strikes: one strike forwards ([`Worker::strike`]) and backwards ([`Worker::solve`]).
//!
//! A [`World`] is plain data (`world.toml`): parameters with 95 % intervals, launch scatter, and the effects added to it.
//! A [`Simulator`] is a world compiled for one rig, shared between threads; each thread strikes with a [`Worker`] of its own.
//! Where thousands of worlds or commands must be tried, the slide is integrated without contacts ([`planar`]), from MuJoCo's
//! impact ([`launch`]).
//! Nothing here depends on logs, tables, files of a run, or the artifact store.

mod base;
pub mod effects;
mod engine;
mod error;
mod impact;
pub mod launch;
mod parameter;
pub mod planar;
mod profile;
mod recent;
mod record;
mod releases;
mod scene;
mod search;
mod shift;
mod simulator;
mod solution;
mod solve;
mod tip_motion;
mod touch;
mod worker;
mod world;

pub use base::Base;
pub use effects::AddedEffect;
pub use engine::mujoco_version;
pub use error::WorldError;
pub use impact::{AsCommanded, Delivery, Impact, contact_solref};
pub use parameter::{Estimate, PARAMETERS, ParameterSpec, parameter};
pub use profile::Profile;
pub use recent::{
    BetweenSessions, Filter, MeanSquare, Observation, Observer, Session, TableChanged, Varies,
};
pub use record::Simulated;
pub use releases::Release;
pub use scene::mjcf;
pub use shift::Shift;
pub use simulator::{Simulator, Steps};
pub use solution::{Solution, SolveSettings, SolveStatus};
pub use worker::Worker;
pub use world::{Scatter, World};

/// Acceleration by weight, in m/s²: standard gravity. Decelerations give friction to a few parts in ten thousand, so a rounded value
/// would show.
pub const GRAVITY: f64 = 9.806_65;
