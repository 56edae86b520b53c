//! Adaptation to a table that changes: what recent strikes say of its friction, its launch and its heading, beside the version's own.
//!
//! [`Observer`] compares a strike with a model; [`Varies`] holds how much a table varies, and [`Filter`] follows it.

mod filter;
mod linear;
mod observer;
#[cfg(test)]
mod tests;
mod varies;

pub use filter::{Filter, TableChanged};
pub use observer::{Observation, Observer};
pub use varies::{BetweenSessions, MeanSquare, Session, Varies};
