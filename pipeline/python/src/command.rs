//! Command lines: what the programs do, in this process.

use std::ffi::OsString;
use std::path::PathBuf;

use carom::{Cli, Outcome};
use clap::Parser;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error::{InvalidInput, of_carom};
use crate::json;

/// Runs a command line and gives what `--json` prints, with `outcome` where that is an object.
pub fn execute(py: Python<'_>, words: Vec<OsString>) -> PyResult<Py<PyAny>> {
    let cli =
        Cli::try_parse_from(words).map_err(|error| InvalidInput::new_err(error.to_string()))?;
    let output = py.detach(|| carom::execute(&cli)).map_err(of_carom)?;
    let mut value = output.json;
    if let Value::Object(map) = &mut value {
        let outcome = match output.outcome {
            Outcome::Done => "done",
            Outcome::Rejected => "rejected",
            Outcome::Refused => "refused",
            Outcome::Failed | Outcome::BadInput => "failed",
            Outcome::Busy => "busy",
        };
        map.insert("outcome".into(), json!(outcome));
    }
    json::to_python(py, &value)
}

/// One path, or several.
#[derive(FromPyObject)]
pub enum Paths {
    One(PathBuf),
    Many(Vec<PathBuf>),
}

#[pyfunction]
#[pyo3(signature = (logs, rig, out, *, seed = 0, without_effects = false, key = None, quiet = true))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn run(
    py: Python<'_>,
    logs: Paths,
    rig: PathBuf,
    out: PathBuf,
    seed: u64,
    without_effects: bool,
    key: Option<PathBuf>,
    quiet: bool,
) -> PyResult<Py<PyAny>> {
    let logs = match logs {
        Paths::One(path) => vec![path],
        Paths::Many(paths) => paths,
    };
    let mut words: Vec<OsString> = vec!["carom".into(), "run".into()];
    words.extend(["--rig".into(), rig.into(), "--out".into(), out.into()]);
    words.extend(["--seed".into(), seed.to_string().into()]);
    if without_effects {
        words.push("--without-effects".into());
    }
    if quiet {
        words.push("--quiet".into());
    }
    if let Some(key) = key {
        words.extend(["--key".into(), key.into()]);
    }
    // Behind these dashes everything is a path.
    words.push("--".into());
    words.extend(logs.into_iter().map(OsString::from));
    execute(py, words)
}

#[pyfunction]
pub fn command(py: Python<'_>, arguments: Vec<OsString>) -> PyResult<Py<PyAny>> {
    let words = ["carom".into(), "--quiet".into()]
        .into_iter()
        .chain(arguments);
    execute(py, words.collect())
}

/// The program itself, with its name as the first word; gives its exit code.
#[pyfunction]
pub fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| carom::program(arguments, COMMIT))
}

#[pyfunction]
pub fn about() -> String {
    strike::built_from(COMMIT);
    carom::about()
}

/// The commit that this was built from.
const COMMIT: Option<&str> = option_env!("CAROM_COMMIT");
