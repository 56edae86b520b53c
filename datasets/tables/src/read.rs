//! Parquet to batches of rows, after checking that the file is the table it should be.

use std::fs::File;
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use arrow::array::types::{Float64Type, UInt32Type};
use arrow::array::{Array, AsArray, RecordBatch, StringArray};
use arrow::datatypes::{Schema, SchemaRef};
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, RowGroupMetaData};

use crate::TableError;
use crate::layout::{GROUP_ROWS, SCHEMA_VERSION, Table, VERSION_KEY};

/// The batches of a table, one after the other.
pub(crate) struct Batches {
    path: PathBuf,
    reader: ParquetRecordBatchReader,
    /// What comes behind damage is nothing.
    is_damaged: bool,
    row: usize,
}

/// Some rows of a table.
pub(crate) struct Batch {
    path: PathBuf,
    first_row: usize,
    batch: RecordBatch,
}

pub(crate) fn read<const N: usize>(dir: &Path, table: &Table<N>) -> Result<Batches, TableError> {
    let path = table.path(dir);
    let damaged = |why: String| TableError::Damaged {
        path: path.clone(),
        why,
    };
    let file = File::open(&path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => TableError::Missing { path: path.clone() },
        _ => durable::Error::new("read", &path, error).into(),
    })?;
    let builder = foreseen(|| ParquetRecordBatchReaderBuilder::try_new(file))
        .map_err(|error| damaged(error.to_string()))?;
    // The library asserts what a damaged footer can break.
    let is_placed = |column: &ColumnChunkMetaData| {
        column.data_page_offset() >= 0
            && column.dictionary_page_offset().is_none_or(|at| at >= 0)
            && column.compressed_size() >= 0
    };
    let groups = builder.metadata().row_groups();
    if !groups
        .iter()
        .flat_map(RowGroupMetaData::columns)
        .all(is_placed)
    {
        return Err(damaged("a column lies before the file's beginning".into()));
    }
    let version = builder
        .metadata()
        .file_metadata()
        .key_value_metadata()
        .and_then(|pairs| pairs.iter().find(|pair| pair.key == VERSION_KEY))
        .and_then(|pair| pair.value.clone());
    let (found, expected) = (
        describe(version.as_deref().unwrap_or("none"), builder.schema()),
        describe(&SCHEMA_VERSION.to_string(), &table.schema()),
    );
    if found != expected {
        return Err(TableError::Layout {
            path,
            found,
            expected,
        });
    }
    let reader = foreseen(|| builder.with_batch_size(GROUP_ROWS).build())
        .map_err(|error| damaged(error.to_string()))?;
    Ok(Batches {
        path,
        reader,
        is_damaged: false,
        row: 0,
    })
}

pub(crate) fn read_whole<const N: usize>(
    dir: &Path,
    table: &Table<N>,
) -> Result<(SchemaRef, Vec<RecordBatch>), TableError> {
    let batches = read(dir, table)?.map(|batch| Ok::<_, TableError>(batch?.batch));
    Ok((table.shared_schema(), batches.collect::<Result<_, _>>()?))
}

/// What the library does not foresee of a damaged file is an error of that file, not of the program.
fn foreseen<T>(read: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    catch_unwind(AssertUnwindSafe(read))
        .unwrap_or_else(|_| Err(ParquetError::General("its reader gave up".into())))
}

fn describe(version: &str, schema: &Schema) -> String {
    let columns: Vec<_> = schema
        .fields()
        .iter()
        .map(|field| {
            let null = if field.is_nullable() { "?" } else { "" };
            let unit = field.metadata().get("unit").map_or("", String::as_str);
            format!("{}: {}{null} {unit}", field.name(), field.data_type())
                .trim_end()
                .to_string()
        })
        .collect();
    format!("columns [{}] of carom schema {version}", columns.join(", "))
}

impl Iterator for Batches {
    type Item = Result<Batch, TableError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_damaged {
            return None;
        }
        let batch = foreseen(|| self.reader.next().transpose().map_err(ParquetError::from));
        self.is_damaged = batch.is_err();
        Some(match batch.transpose()? {
            Ok(batch) => {
                let first_row = self.row;
                self.row += batch.num_rows();
                Ok(Batch {
                    path: self.path.clone(),
                    first_row,
                    batch,
                })
            }
            Err(error) => Err(TableError::Damaged {
                path: self.path.clone(),
                why: error.to_string(),
            }),
        })
    }
}

impl Batch {
    /// Rows of this batch.
    pub fn rows(&self) -> std::ops::Range<usize> {
        0..self.batch.num_rows()
    }

    /// A column of the layout that was checked.
    pub fn column(&self, name: &str) -> &dyn Array {
        self.batch[name].as_ref()
    }

    /// A column of numbers of the layout that was checked.
    pub fn real(&self, name: &str) -> &[f64] {
        self.batch[name].as_primitive::<Float64Type>().values()
    }

    /// A number of a column that rows may lack.
    pub fn real_or_null(&self, name: &str, row: usize) -> Option<f64> {
        let column = self.batch[name].as_primitive::<Float64Type>();
        column.is_valid(row).then(|| column.value(row))
    }

    /// A count of a column that rows may lack.
    pub fn count_or_null(&self, name: &str, row: usize) -> Option<u32> {
        let column = self.batch[name].as_primitive::<UInt32Type>();
        column.is_valid(row).then(|| column.value(row))
    }

    /// A column of counts of the layout that was checked.
    pub fn count(&self, name: &str) -> &[u32] {
        self.batch[name].as_primitive::<UInt32Type>().values()
    }

    /// A column of text of the layout that was checked.
    pub fn text(&self, name: &str) -> &StringArray {
        self.batch[name].as_string()
    }

    /// The error of a row of this batch.
    pub fn wrong(&self, row: usize, why: String) -> TableError {
        TableError::Row {
            path: self.path.clone(),
            row: self.first_row + row,
            why,
        }
    }
}
