//! What the columns of a table are.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow::datatypes::{DataType, Field, Schema};

/// Version of all tables' layout; raised when a column changes its name, place, type, unit or meaning.
pub const SCHEMA_VERSION: u32 = 2;

/// Key of the file's metadata under which the version stands.
pub(crate) const VERSION_KEY: &str = "carom.schema";

/// Rows that are held in memory, and make a row group, at a time.
pub(crate) const GROUP_ROWS: usize = 1 << 16;

/// A table: its file, `NAME.parquet`, and its columns, in order.
pub(crate) struct Table<const N: usize> {
    pub name: &'static str,
    pub columns: [Column; N],
}

pub(crate) struct Column {
    name: &'static str,
    kind: Kind,
    /// Unit; empty where it has none.
    unit: &'static str,
    /// Whether a row may lack it.
    nullable: bool,
}

#[derive(Clone, Copy)]
pub(crate) enum Kind {
    Real,
    Count,
    Text,
}

pub(crate) const fn real(name: &'static str, unit: &'static str) -> Column {
    Column {
        name,
        kind: Kind::Real,
        unit,
        nullable: false,
    }
}

pub(crate) const fn count(name: &'static str) -> Column {
    Column {
        name,
        kind: Kind::Count,
        unit: "",
        nullable: false,
    }
}

pub(crate) const fn text(name: &'static str) -> Column {
    Column {
        name,
        kind: Kind::Text,
        unit: "",
        nullable: false,
    }
}

impl<const N: usize> Table<N> {
    pub fn path(&self, dir: &Path) -> PathBuf {
        dir.join(format!("{}.parquet", self.name))
    }

    pub fn schema(&self) -> Schema {
        Schema::new(self.columns.iter().map(Column::field).collect::<Vec<_>>())
    }

    pub fn shared_schema(&self) -> Arc<Schema> {
        Arc::new(self.schema())
    }
}

impl Column {
    /// This column, of which rows may lack a value.
    pub const fn or_null(self) -> Self {
        Self {
            nullable: true,
            ..self
        }
    }

    pub fn name(&self) -> &'static str {
        self.name
    }

    pub fn kind(&self) -> Kind {
        self.kind
    }

    fn field(&self) -> Field {
        let data_type = match self.kind {
            Kind::Real => DataType::Float64,
            Kind::Count => DataType::UInt32,
            Kind::Text => DataType::Utf8,
        };
        let unit = (!self.unit.is_empty()).then(|| ("unit".to_string(), self.unit.to_string()));
        Field::new(self.name, data_type, self.nullable)
            .with_metadata(unit.into_iter().collect::<HashMap<_, _>>())
    }
}
