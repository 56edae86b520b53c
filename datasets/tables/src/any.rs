//! Any table row by row, whatever its columns: for programs that ask questions of them.

use std::path::Path;

use arrow::array::AsArray;
use arrow::array::types::{Float64Type, UInt32Type};

use crate::TableError;
use crate::layout::{Kind, Table};
use crate::read::{Batch, read};
use crate::solutions::{RESIDUALS, SOLUTIONS};
use crate::strikes::{REJECTS, SLIDES, STRIKES, TRACKS};

/// One cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// The row lacks it.
    Nothing,
    /// A number, in the column's unit.
    Real(f64),
    /// A count or an index.
    Count(u32),
    /// Text.
    Text(&'a str),
}

/// What is told of a folder's tables.
pub trait Reader {
    /// Why it goes no further.
    type Error: From<TableError>;
    /// A table begins: its name, and its columns in order.
    fn table(&mut self, name: &str, columns: &[&str]) -> Result<(), Self::Error>;
    /// A row of the table that began last.
    fn row(&mut self, cells: &[Value<'_>]) -> Result<(), Self::Error>;
}

/// Reads every table that the folder has; those that it lacks are passed over.
pub fn read_all<R: Reader>(dir: &Path, reader: &mut R) -> Result<(), R::Error> {
    read_table(dir, &STRIKES, reader)?;
    read_table(dir, &TRACKS, reader)?;
    read_table(dir, &REJECTS, reader)?;
    read_table(dir, &SLIDES, reader)?;
    read_table(dir, &SOLUTIONS, reader)?;
    read_table(dir, &RESIDUALS, reader)
}

fn read_table<R: Reader, const N: usize>(
    dir: &Path,
    table: &Table<N>,
    reader: &mut R,
) -> Result<(), R::Error> {
    let batches = match read(dir, table) {
        Err(TableError::Missing { .. }) => return Ok(()),
        batches => batches?,
    };
    let columns = table.columns.each_ref();
    reader.table(table.name, &columns.map(|column| column.name()))?;
    for batch in batches {
        let batch = batch?;
        for row in batch.rows() {
            let cells = columns.map(|column| cell(&batch, column.name(), column.kind(), row));
            reader.row(&cells)?;
        }
    }
    Ok(())
}

fn cell<'b>(batch: &'b Batch, column: &str, kind: Kind, row: usize) -> Value<'b> {
    let column = batch.column(column);
    if column.is_null(row) {
        return Value::Nothing;
    }
    match kind {
        Kind::Real => Value::Real(column.as_primitive::<Float64Type>().value(row)),
        Kind::Count => Value::Count(column.as_primitive::<UInt32Type>().value(row)),
        Kind::Text => Value::Text(column.as_string::<i32>().value(row)),
    }
}
