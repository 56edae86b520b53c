//! Carom's tables: the only code that reads or writes Arrow and Parquet.
//!
//! Six files in a run's folder, each with a fixed list of columns (`f64`, `u32`, UTF-8, none null), the unit in each
//! column's metadata, and the version of the layout in the file's. The same rows give the same bytes. Files are
//! written a row group at a time and are whole or absent; they are read back batch by batch. [`write_lerobot`] writes the same strikes as others
//! read them.

mod any;
mod error;
mod layout;
mod lerobot;
mod read;
mod solutions;
mod strikes;
mod write;

pub use any::{Reader, Value, read_all};
pub use error::TableError;
pub use layout::SCHEMA_VERSION;
pub use lerobot::{Episode, write_lerobot};
pub use solutions::{
    SolutionRow, read_residuals, read_solutions, write_residuals, write_solutions,
};
pub use strikes::{
    read_rejects, read_strikes, stream_strikes, strikes_as_arrow, tracks_as_arrow, write_rejects,
    write_slides, write_strikes,
};
