//! `report.html`: one page that holds all it shows.

mod diagnosis;
mod figure_8;
mod figures;
mod looks;
mod models;
mod page;
mod plot;
mod stops;

use std::path::Path;

use crate::Error;
use crate::inputs::Inputs;
use crate::nightly::Night;
use crate::results::Results;
use crate::trial::Trial;

/// Where a run keeps its report.
pub const FILE: &str = "report.html";

/// What a version was made from and holds, for a person: name and hash.
#[derive(Clone, Debug, Default)]
pub struct Provenance {
    /// Version; none where nothing is published.
    pub version: Option<String>,
    /// The version in use, where that is not what is shown.
    pub in_use: Option<String>,
    /// Programs and their versions, seeds.
    pub made_by: Vec<(String, String)>,
    /// Files and their hashes.
    pub hashes: Vec<(String, String)>,
}

/// All that the page shows.
pub struct Shown<'a> {
    /// Rig, logs and seed.
    pub inputs: &'a Inputs,
    /// What the pipeline gave: of steps that were not gone nothing is shown.
    pub results: &'a Results,
    /// The latest trial, where one was made.
    pub trial: Option<&'a Trial>,
    /// What the last night decided, where there was one.
    pub night: Option<&'a Night>,
    /// What was published.
    pub provenance: &'a Provenance,
}

/// Writes the page into the run's folder.
pub fn write(shown: &Shown<'_>, dir: &Path) -> Result<(), Error> {
    let page = page::page(shown).map_err(Error::failed)?;
    Ok(durable::write_bytes(&dir.join(FILE), page.as_bytes())?)
}

#[cfg(test)]
mod testing;
#[cfg(test)]
pub use testing::found_tilt;
