//! The programs' errors as exceptions, with the same texts.

use std::fmt::Display;

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;

create_exception!(
    carom,
    CaromError,
    PyException,
    "What was not done; the text is the programs'."
);
create_exception!(
    carom,
    InvalidInput,
    CaromError,
    "What was given cannot be worked with."
);
create_exception!(
    carom,
    Refused,
    CaromError,
    "A gate or a safety limit said no."
);
create_exception!(carom, Busy, CaromError, "Another run works in the folder.");
create_exception!(carom, Failed, CaromError, "The work itself failed.");

/// The Python exception with the text that the program prints.
pub fn of_carom(error: carom::Error) -> PyErr {
    let text = format!("failed to {error}");
    match error {
        carom::Error::Input(_) => InvalidInput::new_err(text),
        carom::Error::Busy(_) => Busy::new_err(text),
        carom::Error::Refused(_) => Refused::new_err(text),
        carom::Error::Failed(_) => Failed::new_err(text),
    }
}

/// What was given cannot be worked with; the crates' texts complete "failed to …".
pub fn invalid(error: impl Display) -> PyErr {
    InvalidInput::new_err(format!("failed to {error}"))
}

pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("CaromError", py.get_type::<CaromError>())?;
    module.add("InvalidInput", py.get_type::<InvalidInput>())?;
    module.add("Refused", py.get_type::<Refused>())?;
    module.add("Busy", py.get_type::<Busy>())?;
    module.add("Failed", py.get_type::<Failed>())
}
