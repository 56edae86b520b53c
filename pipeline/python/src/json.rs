//! What the programs print as JSON, as Python's own values.

use pyo3::prelude::*;
use serde::Serialize;

use crate::error::Failed;

/// Dictionaries, lists, numbers and text.
pub fn to_python<T: Serialize>(py: Python<'_>, value: &T) -> PyResult<Py<PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| Failed::new_err(error.to_string()))?;
    let loaded = py.import("json")?.call_method1("loads", (text,))?;
    Ok(loaded.unbind())
}
