//! carom as a Python package: each function calls what the programs call. Numpy arrays in and out, tables as Arrow.
#![cfg(feature = "extension")]

mod arrays;
mod command;
mod error;
mod json;
mod table;
mod version;
mod world;

use pyo3::prelude::*;

#[pymodule]
fn _carom(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(command::run, module)?)?;
    module.add_function(wrap_pyfunction!(command::command, module)?)?;
    module.add_function(wrap_pyfunction!(command::main, module)?)?;
    module.add_function(wrap_pyfunction!(command::about, module)?)?;
    module.add_class::<world::World>()?;
    module.add_class::<world::Strike>()?;
    module.add_class::<version::Version>()?;
    module.add_class::<table::Table>()?;
    error::add(module)
}
