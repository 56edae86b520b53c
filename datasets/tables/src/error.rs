//! What can go wrong with a table.

use std::path::PathBuf;

use parquet::errors::ParquetError;

/// Why a table was not written or read. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum TableError {
    #[error(transparent)]
    Io(#[from] durable::Error),
    #[error("encode {}: {source}", path.display())]
    Encode { path: PathBuf, source: ParquetError },
    #[error("find {}: run `carom ingest` or `carom run` into that folder first", path.display())]
    Missing { path: PathBuf },
    #[error("read {}: {why}; run again to write it anew", path.display())]
    Damaged { path: PathBuf, why: String },
    #[error("read {}: it holds {found}, where {expected} must be; run again to write it anew", path.display())]
    Layout {
        path: PathBuf,
        found: String,
        expected: String,
    },
    #[error("read {} at row {row}: {why}; run again to write it anew", path.display())]
    Row {
        path: PathBuf,
        row: usize,
        why: String,
    },
}
