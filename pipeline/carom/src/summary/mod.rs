//! Results as text for a person.

mod check;
mod details;
pub mod diagnosis;
mod overview;
mod shared;
mod table;

pub use check::{candidate, findings, findings_json, measured};
pub use details::{details, rolled_back};
pub use overview::overview;
pub use shared::{examples, reasons};
pub use table::{evaluation_table, misses_table, trial};
