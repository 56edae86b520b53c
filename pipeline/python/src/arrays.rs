//! Numbers to and from numpy, through its own functions: one copy each way.

use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};

use crate::error::InvalidInput;

/// A one-dimensional array that owns its numbers and may be written to.
pub fn to_numpy<'py>(py: Python<'py>, values: &[f64]) -> PyResult<Bound<'py, PyAny>> {
    let bytes: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_ne_bytes())
        .collect();
    let bytes = PyByteArray::new(py, &bytes);
    py.import("numpy")?
        .call_method1("frombuffer", (bytes, "f8"))
}

/// The numbers of an array, or of anything that numpy makes one of, row after row; `columns` is none for one dimension. `what` is
/// what an error calls it.
pub fn from_numpy(
    array: &Bound<'_, PyAny>,
    columns: Option<usize>,
    what: &str,
) -> PyResult<Vec<f64>> {
    let numpy = array.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (array, "f8"))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let is_right = match columns {
        None => shape.len() == 1,
        Some(columns) => shape.len() == 2 && shape[1] == columns,
    };
    if !is_right {
        let wanted = columns.map_or("n".to_owned(), |columns| format!("n × {columns}"));
        return Err(InvalidInput::new_err(format!(
            "failed to read {what}: give an array of {wanted} numbers, not one of shape {shape:?}"
        )));
    }
    let bytes = array.call_method0("tobytes")?;
    let bytes = bytes.cast::<PyBytes>()?.as_bytes();
    let (numbers, _) = bytes.as_chunks::<8>();
    Ok(numbers
        .iter()
        .map(|number| f64::from_ne_bytes(*number))
        .collect())
}
