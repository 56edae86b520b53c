//! The drivers of arms against the emulated controllers.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../../../../pipeline/strike/tests/executor/fixture.rs"]
#[expect(dead_code, reason = "the executor's own tests use the rest")]
mod fixture;

mod bench;
mod bytes;
mod clear;
mod faults;
mod gather;
mod live;
mod run_up;
mod strikes;
