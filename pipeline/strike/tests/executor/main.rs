//! The executor against a published artifact: what it plans, what it refuses, and that nothing is struck when it refuses.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod batches;
mod commands;
mod computer;
mod damage;
mod dependencies;
mod fixture;
mod own_rig;
mod plans;
mod refusals;
mod residuals;
mod sessions;
mod strikes;
mod trust;
mod turned;
