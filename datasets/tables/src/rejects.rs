//! `rejects.parquet`: a row for each strike that was seen and not kept.

use std::path::Path;

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error as NameError;
use values::{Reject, RejectReason};

use crate::TableError;
use crate::layout::{Table, count, real, text};
use crate::read::read;
use crate::write::{Cell, write};

pub(crate) const REJECTS: Table<5> = Table {
    name: "rejects",
    columns: [
        text("log"),
        count("index"),
        real("t_start", "s"),
        text("reason"),
        text("detail"),
    ],
};

/// Writes the table of these rejects, in their order.
pub fn write_rejects(dir: &Path, rejects: &[Reject]) -> Result<(), TableError> {
    let rows = rejects.iter().map(|reject| {
        [
            Cell::Text(&reject.log),
            Cell::Count(reject.index),
            Cell::Real(reject.t_start),
            Cell::Text(reject.reason.name()),
            Cell::Text(&reject.detail),
        ]
    });
    write(dir, &REJECTS, rows)
}

/// Reads the table, in the order written.
pub fn read_rejects(dir: &Path) -> Result<Vec<Reject>, TableError> {
    let mut rejects = Vec::new();
    for batch in read(dir, &REJECTS)? {
        let batch = batch?;
        for row in batch.rows() {
            let reason = batch.text("reason").value(row).into_deserializer();
            let reason = RejectReason::deserialize(reason)
                .map_err(|error: NameError| batch.wrong(row, error.to_string()))?;
            rejects.push(Reject {
                log: batch.text("log").value(row).to_string(),
                index: batch.count("index")[row],
                t_start: batch.real("t_start")[row],
                reason,
                detail: batch.text("detail").value(row).to_string(),
            });
        }
    }
    Ok(rejects)
}
