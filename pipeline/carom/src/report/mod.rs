//! `report.html`: one page that holds all it shows; `fleet.html` of several rigs.

mod answer;
mod delivered;
mod diagnosis;
mod explorer;
mod figures;
mod fleet;
mod input;
mod maps;
mod markup;
mod models;
mod page;
mod plot;
mod provenance;
mod residual_plots;
mod stops;
#[cfg(test)]
mod testing;
mod trend;

use std::path::Path;

use store::Store;

use self::input::ReportInput;
use self::page::page;
use self::provenance::provenance;
use self::trend::versions;
use crate::inputs::Inputs;
use crate::results::Results;
use crate::{Error, nightly, trial};

pub use fleet::write_fleet;

#[cfg(test)]
pub use testing::found_tilt;

/// Where a run keeps its report.
pub const FILE: &str = "report.html";

/// The report of a run, with its latest trial and night, and the version that it published (else the latest) where there are any. Returns its path.
pub fn write(
    dir: &Path,
    inputs: &Inputs,
    results: &Results,
    version: Option<&str>,
) -> Result<String, Error> {
    let trial = trial::kept(dir);
    let provenance = provenance(dir, results, version)?.unwrap_or_default();
    let night = nightly::kept(dir).ok().flatten();
    let input = ReportInput {
        inputs,
        results,
        trial: trial.as_ref(),
        provenance: &provenance,
        night: night.as_ref(),
        versions: versions(&Store::open(dir)),
    };
    let page = page(&input).map_err(Error::failed)?;
    let path = dir.join(FILE);
    durable::write_bytes(&path, page.as_bytes())?;
    Ok(path.display().to_string())
}
