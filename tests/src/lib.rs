//! What proves the whole: the hidden-effect benchmark ([`blind`]), the real strikes of a KUKA arm ([`kuka`]), tables that change ([`living`]), what
//! a fence hides ([`fenced`]), fuzzing ([`fuzz`]) and a hundred nights with faults ([`soak`]); the integration tests are in `whole/`.

#![expect(missing_docs, reason = "its own tests alone use it")]

pub mod blind;
pub mod fenced;
pub mod fuzz;
pub mod kuka;
pub mod living;
pub mod soak;

use carom::{Cli, Output, execute};
use clap::Parser;

/// Runs a `carom` command line, of words without blanks, quietly; the error says which.
pub fn carom(line: &str) -> anyhow::Result<Output> {
    let words = ["carom", "--quiet"]
        .into_iter()
        .chain(line.split_whitespace());
    let cli = Cli::try_parse_from(words)?;
    execute(&cli).map_err(|error| anyhow::anyhow!("failed to {error}").context(line.to_owned()))
}
