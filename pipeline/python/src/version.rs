//! A published version.

use std::ffi::OsString;
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;

use pyo3::prelude::*;
use serde_json::Value;
use store::{Artifact, Model, Store};
use strike::Planner;
use values::Point;

use crate::command::execute;
use crate::error::{Refused, invalid};
use crate::json;
use crate::table::Table;
use crate::world::World;

/// A version, and the folder that it is in.
#[pyclass(frozen, module = "carom")]
pub struct Version {
    folder: PathBuf,
    artifact: Artifact,
    planner: Planner,
}

#[pymethods]
impl Version {
    #[staticmethod]
    #[pyo3(signature = (folder, version = None))]
    fn load(py: Python<'_>, folder: PathBuf, version: Option<String>) -> PyResult<Self> {
        py.detach(|| {
            let artifact = Store::open(&folder).load(version.as_deref());
            let artifact = artifact.map_err(invalid)?;
            let model = artifact.manifest.provenance.default_model;
            let planner = Planner::new(&artifact, model).map_err(invalid)?;
            Ok(Self {
                folder,
                artifact,
                planner,
            })
        })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.artifact.version
    }

    #[getter]
    fn model(&self) -> &'static str {
        self.artifact.manifest.provenance.default_model.name()
    }

    #[getter]
    fn manifest(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        json::to_python(py, &self.artifact.manifest)
    }

    #[getter]
    fn diagnosis(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let path = self.folder.join("diagnosis.json");
        let text = match fs::read(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(py.None()),
            read => read,
        };
        let at = |error: String| invalid(format!("read {}: {error}", path.display()));
        let text = text.map_err(|error| at(error.to_string()))?;
        let value: Value = serde_json::from_slice(&text).map_err(|error| at(error.to_string()))?;
        json::to_python(py, &value)
    }

    fn world(&self, py: Python<'_>) -> PyResult<World> {
        py.detach(|| World::of(&self.artifact))
    }

    fn predict(
        &self,
        py: Python<'_>,
        start: (f64, f64),
        speed: f64,
        angle: f64,
    ) -> PyResult<Py<PyAny>> {
        let mut words: Vec<OsString> = ["carom", "predict", "--quiet"].map(OsString::from).into();
        words.extend(["--artifacts".into(), self.folder.clone().into()]);
        words.extend(["--version".into(), self.artifact.version.clone().into()]);
        words.push("--from".into());
        words.extend([start.0, start.1].map(|at| at.to_string().into()));
        words.extend(["--speed".into(), speed.to_string().into()]);
        words.extend(["--angle".into(), angle.to_string().into()]);
        execute(py, words)
    }

    #[pyo3(signature = (start, target, model = None))]
    fn plan(
        &self,
        py: Python<'_>,
        start: (f64, f64),
        target: (f64, f64),
        model: Option<&str>,
    ) -> PyResult<Py<PyAny>> {
        let [start, target] = [start, target].map(|(x, y)| Point::new(x, y));
        let model: Option<Model> = model.map(str::parse).transpose().map_err(invalid)?;
        let plan = py.detach(|| match model {
            None => Ok(self.planner.plan(start, target)),
            Some(model) => {
                Planner::new(&self.artifact, model).map(|other| other.plan(start, target))
            }
        });
        let plan = plan.map_err(invalid)?;
        let plan = plan.map_err(|refusal| Refused::new_err(refusal.to_string()))?;
        json::to_python(py, &plan)
    }

    fn strikes(&self, py: Python<'_>) -> PyResult<Table> {
        py.detach(|| tables::strikes_as_arrow(&self.folder))
            .map(Table::new)
            .map_err(invalid)
    }

    fn tracks(&self, py: Python<'_>) -> PyResult<Table> {
        py.detach(|| tables::tracks_as_arrow(&self.folder))
            .map(Table::new)
            .map_err(invalid)
    }
}
