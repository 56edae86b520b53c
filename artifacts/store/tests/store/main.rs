//! What the store promises: whole versions, refusals that name the damage, and a way back.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod damage;
mod fixture;
mod publishing;
mod remote;
mod signing;
mod versions;
