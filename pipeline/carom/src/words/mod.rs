//! Findings in words, once for terminal, report and JSON.

mod check;

pub use check::{say, severity};
