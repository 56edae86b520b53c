//! Rows to Parquet, a row group at a time.

use std::path::Path;
use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Builder, RecordBatch, StringBuilder, UInt32Builder};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

use crate::TableError;
use crate::layout::{GROUP_ROWS, Kind, SCHEMA_VERSION, Table, VERSION_KEY};

/// One value of a row.
pub(crate) enum Cell<'a> {
    Real(f64),
    Count(u32),
    Text(&'a str),
}

/// Writes a table into a folder, whole or not at all.
pub(crate) fn write<'a, const N: usize>(
    dir: &Path,
    table: &Table<N>,
    rows: impl Iterator<Item = [Cell<'a>; N]>,
) -> Result<(), TableError> {
    let path = table.path(dir);
    durable::create_dir(dir)?;
    durable::write(&path, |file| {
        let encode = |source| TableError::Encode {
            path: path.clone(),
            source,
        };
        let properties = properties().map_err(encode)?;
        let mut writer =
            ArrowWriter::try_new(file, table.shared_schema(), Some(properties)).map_err(encode)?;
        let mut rows = rows.peekable();
        while rows.peek().is_some() {
            let batch = batch(table, rows.by_ref().take(GROUP_ROWS)).map_err(encode)?;
            writer.write(&batch).map_err(encode)?;
            writer.flush().map_err(encode)?;
        }
        writer.close().map_err(encode)?;
        Ok(())
    })
}

/// Nothing in them depends on the machine, the clock, or the version of the writer.
fn properties() -> Result<WriterProperties, ParquetError> {
    let version = KeyValue::new(VERSION_KEY.to_string(), SCHEMA_VERSION.to_string());
    Ok(WriterProperties::builder()
        .set_created_by("carom".into())
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_key_value_metadata(Some(vec![version]))
        .build())
}

enum Builder {
    Real(Float64Builder),
    Count(UInt32Builder),
    Text(StringBuilder),
}

impl Builder {
    fn new(kind: Kind) -> Self {
        match kind {
            Kind::Real => Self::Real(Float64Builder::new()),
            Kind::Count => Self::Count(UInt32Builder::new()),
            Kind::Text => Self::Text(StringBuilder::new()),
        }
    }

    fn push(&mut self, cell: &Cell<'_>) {
        match (self, cell) {
            (Self::Real(column), Cell::Real(value)) => column.append_value(*value),
            (Self::Count(column), Cell::Count(value)) => column.append_value(*value),
            (Self::Text(column), Cell::Text(value)) => column.append_value(value),
            // Leaves the column short, which the batch refuses.
            _ => {}
        }
    }

    fn finish(self) -> ArrayRef {
        match self {
            Self::Real(mut column) => Arc::new(column.finish()),
            Self::Count(mut column) => Arc::new(column.finish()),
            Self::Text(mut column) => Arc::new(column.finish()),
        }
    }
}

fn batch<'a, const N: usize>(
    table: &Table<N>,
    rows: impl Iterator<Item = [Cell<'a>; N]>,
) -> Result<RecordBatch, ParquetError> {
    let mut builders = table
        .columns
        .each_ref()
        .map(|column| Builder::new(column.kind()));
    for row in rows {
        for (builder, cell) in builders.iter_mut().zip(&row) {
            builder.push(cell);
        }
    }
    let columns = builders.map(Builder::finish).to_vec();
    Ok(RecordBatch::try_new(table.shared_schema(), columns)?)
}
