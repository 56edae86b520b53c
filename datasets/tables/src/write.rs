//! Rows to Parquet, a row group at a time.

use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Builder, RecordBatch, StringBuilder, UInt32Builder};
use durable::Output;
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{WriterProperties, WriterPropertiesBuilder};

use crate::TableError;
use crate::layout::{Column, GROUP_ROWS, Kind, SCHEMA_VERSION, Table, VERSION_KEY};

pub(crate) enum Cell<'a> {
    Real(f64),
    Count(u32),
    Text(&'a str),
    Null,
}

impl Cell<'_> {
    /// A number, or none.
    pub fn real_or_null(value: Option<f64>) -> Self {
        value.map_or(Self::Null, Self::Real)
    }
}

/// Writes a table into a folder, whole or not at all.
pub(crate) fn write<'a, const N: usize>(
    dir: &Path,
    table: &Table<N>,
    mut rows: impl Iterator<Item = [Cell<'a>; N]>,
) -> Result<(), TableError> {
    write_with(dir, table, |writer| {
        rows.try_for_each(|row| writer.push(&row))
    })
}

/// Writes a table into a folder, whole or not at all: `fill` gives its rows.
pub(crate) fn write_with<const N: usize, E: From<TableError> + From<durable::Error>>(
    dir: &Path,
    table: &Table<N>,
    fill: impl FnOnce(&mut Rows<'_, N>) -> Result<(), E>,
) -> Result<(), E> {
    durable::create_dir(dir)?;
    durable::write(&table.path(dir), |file| {
        let mut rows = Rows::new(table, table.path(dir), file)?;
        fill(&mut rows)?;
        Ok(rows.finish()?)
    })
}

/// A table being written; no more than one row group of it is held.
pub(crate) struct Rows<'a, const N: usize> {
    table: &'a Table<N>,
    path: PathBuf,
    writer: ArrowWriter<&'a mut BufWriter<Output>>,
    group: [Builder; N],
    /// Rows in `group`.
    held: usize,
}

impl<'a, const N: usize> Rows<'a, N> {
    fn new(
        table: &'a Table<N>,
        path: PathBuf,
        file: &'a mut BufWriter<Output>,
    ) -> Result<Self, TableError> {
        let schema = table.shared_schema();
        let writer = properties()
            .and_then(|properties| ArrowWriter::try_new(file, schema, Some(properties)));
        match writer {
            Ok(writer) => Ok(Self {
                table,
                path,
                writer,
                group: table.builders(),
                held: 0,
            }),
            Err(source) => Err(TableError::Encode { path, source }),
        }
    }

    pub fn push(&mut self, row: &[Cell<'_>; N]) -> Result<(), TableError> {
        for (column, cell) in self.group.iter_mut().zip(row) {
            column.push(cell);
        }
        self.held += 1;
        if self.held < GROUP_ROWS {
            return Ok(());
        }
        self.end_group()
    }

    fn end_group(&mut self) -> Result<(), TableError> {
        self.held = 0;
        let columns = self.group.iter_mut().map(Builder::finish).collect();
        RecordBatch::try_new(self.table.shared_schema(), columns)
            .map_err(ParquetError::from)
            .and_then(|batch| self.writer.write(&batch))
            .and_then(|()| self.writer.flush())
            .map_err(|source| self.failed(source))
    }

    fn finish(mut self) -> Result<(), TableError> {
        if self.held > 0 {
            self.end_group()?;
        }
        let Self { path, writer, .. } = self;
        match writer.close() {
            Ok(_) => Ok(()),
            Err(source) => Err(TableError::Encode { path, source }),
        }
    }

    fn failed(&self, source: ParquetError) -> TableError {
        TableError::Encode {
            path: self.path.clone(),
            source,
        }
    }
}

/// What all files share: nothing in it depends on the machine, the clock, or the version of the writer.
pub(crate) fn common() -> WriterPropertiesBuilder {
    WriterProperties::builder()
        .set_created_by("carom".into())
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
}

fn properties() -> Result<WriterProperties, ParquetError> {
    let version = KeyValue::new(VERSION_KEY.to_string(), SCHEMA_VERSION.to_string());
    Ok(common()
        .set_max_row_group_row_count(Some(GROUP_ROWS))
        .set_key_value_metadata(Some(vec![version]))
        .build())
}

impl<const N: usize> Table<N> {
    fn builders(&self) -> [Builder; N] {
        let column = |column: &Column| Builder::new(column.kind());
        self.columns.each_ref().map(column)
    }
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
            (Self::Real(column), Cell::Null) => column.append_null(),
            (Self::Count(column), Cell::Null) => column.append_null(),
            (Self::Text(column), Cell::Null) => column.append_null(),
            // Leaves the column short, which the batch refuses.
            _ => {}
        }
    }

    /// The column so far; the next one begins.
    fn finish(&mut self) -> ArrayRef {
        match self {
            Self::Real(column) => Arc::new(column.finish()),
            Self::Count(column) => Arc::new(column.finish()),
            Self::Text(column) => Arc::new(column.finish()),
        }
    }
}
