//! What a world makes of strikes: backwards, which command and which launch each path needs ([`Solve`], [`residuals`]); forwards, by how much
//! models miss stops that they had no part in ([`evaluate()`]).
//!
//! A [`Model`] is a rig, a world on it and what is added to the world's command; every stage here works in one. Nothing here fits or chooses.

mod error;
mod evaluate;
mod held_out;
mod inverse;
mod items;
mod misses;
mod model;
mod noise;
mod residuals;
mod solve;

pub use error::JudgeError;
pub use evaluate::{
    Evaluation, NewSessions, Prediction, evaluate, stop_errors, unseen_stop_errors,
};
pub use held_out::{HeldOut, Predicted, PredictionStatus};
pub use inverse::predict;
pub use items::{Observe, Predict, Repeat};
pub use misses::{Misses, misses};
pub use model::{Candidate, Model};
pub use noise::{Noise, Slopes};
pub use residuals::{ExcludedStrike, ResidualTable, residuals};
pub use solve::{Path, Solve, Solved};

#[cfg(test)]
mod tests;
