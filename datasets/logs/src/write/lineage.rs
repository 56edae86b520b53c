//! Where a log comes from: MCAP metadata under the name `carom`, one record a strike.

use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::Path;

use mcap::Writer;
use mcap::records::{Metadata, Record};

use crate::LogError;

const NAME: &str = "carom";

/// What made a log: names and values as text, such as `version`, `manifest` (its hash), `model`, `target`, `plan` and `promised_miss` of a
/// planned strike. Which names there are is up to the program that writes.
pub type Lineage = BTreeMap<String, String>;

pub(super) fn write<W: Write + Seek>(
    mcap: &mut Writer<W>,
    lineage: &Lineage,
) -> Result<(), mcap::McapError> {
    let metadata = Metadata {
        name: NAME.into(),
        metadata: lineage.clone(),
    };
    mcap.write_metadata(&metadata)
}

/// The lineages that a log states, in its order; none of one that no carom program wrote.
///
/// # Errors
/// A file that cannot be read, or is no MCAP.
pub fn lineages(log: &Path) -> Result<Vec<Lineage>, LogError> {
    let name = log.display().to_string();
    let bytes = std::fs::read(log).map_err(|source| LogError::io(&name, source))?;
    let records = mcap::read::LinearReader::new(&bytes);
    let mut found = Vec::new();
    for record in records.map_err(|_| LogError::NotMcap { log: name })? {
        match record {
            Ok(Record::Metadata(metadata)) if metadata.name == NAME => {
                found.push(metadata.metadata);
            }
            Ok(_) => {}
            // Cut off or damaged: what came before counts.
            Err(_) => break,
        }
    }
    Ok(found)
}
