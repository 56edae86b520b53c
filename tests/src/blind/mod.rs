//! The hidden-effect benchmark: strikes in which an effect is hidden, and whether the diagnosis names it.
//!
//! The embedded rig makes the strikes, with its own physics and, where it can, another functional form of the effect than the
//! library's. The diagnosis sees logs and a rig file; only the grading sees the truth.

mod cases;
mod chosen;
mod coverage;
mod form;
mod grade;
mod hard;
mod hide;
mod judged;
mod outcome;
mod page;
mod peers;
mod resume;
mod set;
mod size;

pub use cases::{Case, Kind, cases, slice};
pub use chosen::{Pair, Separation, separate, starts};
pub use grade::is_right;
pub use hard::{
    Design, Drawn, HardCase, HardKind, HardOutcome, diagnosed_hard, hard_cases, hard_page, run_hard,
};
pub use judged::{Figure, Judged, Proportion};
pub use outcome::{Outcome, diagnosed, run};
pub use page::page;
pub use peers::{Peers, is_for_peers, peers};
pub use resume::{beside, lines, resumed};
pub use set::{Answer, DiagnosedSet};
