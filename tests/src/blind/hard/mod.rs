//! The hard benchmark: noise, forms and phenomena that the library was not written for.
//!
//! Each set is drawn at random from its seed: zero to three kinds of noise, a phenomenon in any form, a rig file that may be
//! wrong, a cylinder or a box, 40 to 160 strikes in one to four sessions. What it hides was written from physics alone, without
//! a look into the diagnosis or its effects.

mod answers;
mod cases;
mod noise;
mod outcome;
mod page;
mod rows;
mod thresholds;

pub use answers::said;
pub use cases::{Drawn, HardCase, HardKind, hard_cases};
pub use outcome::{HardOutcome, diagnosed_hard, run_hard};
pub use page::hard_page;
pub use thresholds::{VariedSet, run_varied, thresholds_page};
