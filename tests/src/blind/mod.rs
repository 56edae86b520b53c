//! The hidden-effect benchmark: strikes in which an effect is hidden, and whether the diagnosis names it.
//!
//! The embedded rig makes the strikes, with its own physics and, where it can, another functional form of the effect than the
//! library's. The diagnosis sees logs and a rig file; only the grading sees the truth.

mod cases;
mod chosen;
mod compare;
mod grade;
mod hide;
mod outcome;
mod page;
mod peers;

pub use cases::{Case, Kind, cases, slice};
pub use chosen::{Pair, Struck, starts, struck};
pub use grade::{Tally, is_right, tally};
pub use outcome::{Outcome, diagnosed, run};
pub use page::page;
pub use peers::{Peers, is_for_peers, peers};
