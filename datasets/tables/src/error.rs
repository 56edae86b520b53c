//! What can go wrong with a table.

use std::path::PathBuf;

use parquet::errors::ParquetError;

/// Why a table was not written or read. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file could not be written.
    #[error(transparent)]
    Io(#[from] durable::Error),
    /// The rows could not be encoded.
    #[error("encode {}: {source}", path.display())]
    Encode {
        /// The table.
        path: PathBuf,
        /// What Parquet's writer said.
        source: ParquetError,
    },
    /// There is no such file.
    #[error("find {}: run `carom ingest` or `carom run` into that folder first", path.display())]
    Missing {
        /// The table.
        path: PathBuf,
    },
    /// The file is damaged or no Parquet file.
    #[error("read {}: {why}; run again to write it anew", path.display())]
    Damaged {
        /// The table.
        path: PathBuf,
        /// What the reader said.
        why: String,
    },
    /// The file is another table, or of another version of carom.
    #[error("read {}: it holds {found}, where {expected} must be; run again to write it anew", path.display())]
    Layout {
        /// The table.
        path: PathBuf,
        /// What the file holds.
        found: String,
        /// What it must hold.
        expected: String,
    },
    /// A row makes no sense.
    #[error("read {} at row {row}: {why}; run again to write it anew", path.display())]
    Row {
        /// The table.
        path: PathBuf,
        /// Row, from 0.
        row: usize,
        /// What is wrong with it.
        why: String,
    },
}
