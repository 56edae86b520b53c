//! A table that changes, in the closed loop: rigs drawn at random, versions computed by `carom run`, plans by the executor's library.
//!
//! The embedded rig strikes; it shares no code with the world that plans. Peers plan with the same version and see the same strikes.

mod drawn;
pub mod nights;
mod outcome;
pub mod page;
mod table;

use std::path::Path;

pub use drawn::Case;
pub use outcome::{Method, Outcome, RECENT};

/// Every outcome of one rig.
///
/// # Errors
/// What failed, for a person.
pub fn measure(number: u64, scratch: &Path) -> anyhow::Result<Vec<Outcome>> {
    table::measure(&drawn::LivingRig::draw(number)?, scratch)
}
