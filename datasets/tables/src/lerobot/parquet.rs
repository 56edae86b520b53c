//! Columns to a Parquet file.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use arrow::array::{ArrayRef, RecordBatch};
use arrow::datatypes::{Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::errors::ParquetError;

use crate::TableError;
use crate::write::common;

/// A column of a table that is being written.
pub type Column = (Field, ArrayRef);

/// Writes a file, whole or not at all, with an entry of metadata.
pub fn write_columns(
    path: &Path,
    columns: Vec<Column>,
    metadata: Option<(&str, String)>,
) -> Result<(), TableError> {
    let (fields, arrays): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    let metadata = metadata.map(|(key, value)| (key.to_string(), value));
    let schema = Arc::new(Schema::new_with_metadata(
        fields,
        metadata.into_iter().collect::<HashMap<_, _>>(),
    ));
    if let Some(folder) = path.parent() {
        durable::create_dir(folder)?;
    }
    let encode = |source: ParquetError| TableError::Encode {
        path: path.to_path_buf(),
        source,
    };
    let batch = RecordBatch::try_new(schema.clone(), arrays)
        .map_err(ParquetError::from)
        .map_err(encode)?;
    let properties = common().build();
    durable::write(path, |file| {
        let mut writer = ArrowWriter::try_new(file, schema, Some(properties)).map_err(encode)?;
        writer.write(&batch).map_err(encode)?;
        writer.close().map(drop).map_err(encode)
    })
}
