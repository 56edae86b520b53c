//! What the page shows.

use super::provenance::Provenance;
use super::trend::VersionErrors;
use crate::inputs::Inputs;
use crate::nightly::Night;
use crate::results::Results;
use crate::trial::Trial;

/// All that the page shows.
pub struct ReportInput<'a> {
    /// Rig, logs and seed.
    pub inputs: &'a Inputs,
    /// What the pipeline gave: of steps that were not gone nothing is shown.
    pub results: &'a Results,
    /// The latest trial, where one was made.
    pub trial: Option<&'a Trial>,
    /// What the last night decided, where there was one.
    pub night: Option<&'a Night>,
    /// Versions of the folder, oldest first.
    pub versions: Vec<VersionErrors>,
    /// What was published.
    pub provenance: &'a Provenance,
}
