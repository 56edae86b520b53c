//! The hard benchmark: noise, forms and phenomena that the library was not written for.
//!
//! Each set is drawn at random from its seed: a design of 25 to 400 strikes, zero to three kinds of noise, a phenomenon in any form, a rig
//! file that may be wrong, a cylinder or a box, one to four sessions. What it hides, and what is right to say of it, was written from physics
//! alone, without a look into the diagnosis or its effects.

mod answers;
mod cases;
mod design;
mod kind;
mod noise;
mod outcome;
mod page;
mod rows;

pub use answers::{right, said};
pub use cases::{Drawn, HardCase, hard_cases};
pub use design::Design;
pub use kind::HardKind;
pub use outcome::{HardOutcome, diagnosed_hard, run_hard};
pub use page::hard_page;
