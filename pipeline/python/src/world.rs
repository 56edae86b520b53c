//! A world, forwards and backwards.

use std::path::PathBuf;

use ::world::{PARAMETERS, Simulated, Simulator, SolveSettings, effects};
use pyo3::prelude::*;
use rayon::prelude::*;
use serde_json::{Value, json};
use store::Store;
use values::{Command, Conditions, Point, Rig};

use crate::arrays::{from_numpy, to_numpy};
use crate::error::{InvalidInput, invalid};
use crate::json;

/// A world, compiled for its rig.
#[pyclass(frozen, module = "carom")]
pub struct World {
    rig: Rig,
    world: ::world::World,
    simulator: Simulator,
}

/// A simulated strike.
#[pyclass(frozen, module = "carom")]
pub struct Strike(Simulated);

impl World {
    pub fn new(rig: Rig, world: ::world::World) -> PyResult<Self> {
        let simulator = Simulator::new(&rig, &world).map_err(invalid)?;
        Ok(Self {
            rig,
            world,
            simulator,
        })
    }

    /// The world that an artifact is struck with.
    pub fn of(artifact: &store::Artifact) -> PyResult<Self> {
        let used = artifact.effect.as_ref().unwrap_or(&artifact.sysid);
        Self::new(artifact.rig.clone(), used.world.clone())
    }

    fn start(&self, (x, y): (f64, f64)) -> PyResult<Point> {
        let start = Point::new(x, y);
        match self.rig.table.contains(start) {
            true => Ok(start),
            false => Err(InvalidInput::new_err(format!(
                "failed to strike from ({x}, {y}): it is off the table of the rig file"
            ))),
        }
    }
}

/// A command, or why it is none.
fn command(speed: f64, angle: f64) -> PyResult<Command> {
    match speed.is_finite() && speed > 0.0 && angle.is_finite() {
        true => Ok(Command { speed, angle }),
        false => Err(InvalidInput::new_err(
            "failed to read speed and angle: give a speed above 0 m/s and an angle in rad",
        )),
    }
}

#[pymethods]
impl World {
    #[staticmethod]
    #[pyo3(signature = (path, rig = None, version = None))]
    fn load(
        py: Python<'_>,
        path: PathBuf,
        rig: Option<PathBuf>,
        version: Option<String>,
    ) -> PyResult<Self> {
        py.detach(|| {
            if path.is_dir() {
                let artifact = Store::open(&path).load(version.as_deref());
                return Self::of(&artifact.map_err(invalid)?);
            }
            let Some(rig) = rig else {
                return Err(InvalidInput::new_err(format!(
                    "failed to load {}: a world file needs its rig file, `rig=`; a run's folder has both",
                    path.display()
                )));
            };
            let rig = Rig::load(&rig).map_err(invalid)?;
            Self::new(rig, ::world::World::load(&path).map_err(invalid)?)
        })
    }

    #[pyo3(signature = (start, speed, angle, session = "", order = 0.0))]
    fn simulate(
        &self,
        py: Python<'_>,
        start: (f64, f64),
        speed: f64,
        angle: f64,
        session: &str,
        order: f64,
    ) -> PyResult<Strike> {
        let (start, command) = (self.start(start)?, command(speed, angle)?);
        let conditions = Conditions {
            session: session.to_owned(),
            order,
            ..Conditions::default()
        };
        let simulated = py.detach(|| self.simulator.worker().strike(start, command, &conditions));
        simulated.map(Strike).map_err(invalid)
    }

    fn stops<'py>(
        &self,
        py: Python<'py>,
        starts: &Bound<'py, PyAny>,
        speeds: &Bound<'py, PyAny>,
        angles: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let starts = from_numpy(starts, Some(2), "starts")?;
        let speeds = from_numpy(speeds, None, "speeds")?;
        let angles = from_numpy(angles, None, "angles")?;
        let (starts, _) = starts.as_chunks::<2>();
        if starts.len() != speeds.len() || speeds.len() != angles.len() {
            return Err(InvalidInput::new_err(format!(
                "failed to strike from {} starts at {} speeds and {} angles: give as many of each",
                starts.len(),
                speeds.len(),
                angles.len()
            )));
        }
        let strikes = starts.iter().zip(speeds.iter().zip(&angles));
        let strikes: Vec<(Point, Command)> = strikes
            .map(|(&[x, y], (speed, angle))| Ok((self.start((x, y))?, command(*speed, *angle)?)))
            .collect::<PyResult<_>>()?;
        let conditions = Conditions::default();
        let stops: Vec<f64> = py.detach(|| {
            let stops: Vec<[f64; 2]> = strikes
                .par_iter()
                .map_init(
                    || self.simulator.worker(),
                    |worker, (start, command)| {
                        let simulated = worker.strike(*start, *command, &conditions);
                        simulated.map_or([f64::NAN; 2], |strike| [strike.stop.x, strike.stop.y])
                    },
                )
                .collect();
            stops.into_flattened()
        });
        to_numpy(py, &stops)?.call_method1("reshape", (strikes.len(), 2))
    }

    fn solve(&self, py: Python<'_>, start: (f64, f64), target: (f64, f64)) -> PyResult<Py<PyAny>> {
        let start = self.start(start)?;
        let target = Point::new(target.0, target.1);
        if !target.is_finite() {
            return Err(InvalidInput::new_err(
                "failed to read the target: give x and y in m",
            ));
        }
        let solution = py.detach(|| {
            self.simulator.worker().solve(
                start,
                target,
                &Conditions::default(),
                &SolveSettings::default(),
                None,
            )
        });
        let said = json!({
            "speed": solution.command.speed,
            "angle": solution.command.angle,
            "miss": Some(solution.miss).filter(|miss| miss.is_finite()),
            "evaluations": solution.evaluations,
            "status": solution.status.name(),
        });
        json::to_python(py, &said)
    }

    fn mjcf(&self) -> PyResult<String> {
        ::world::mjcf(&self.rig, &self.world).map_err(invalid)
    }

    #[getter]
    fn parameters(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let all = PARAMETERS.iter().map(|spec| {
            let known = self.world.parameters.get(spec.name);
            let said = json!({
                "value": known.map_or(spec.nominal, |known| known.value),
                "low": known.and_then(|known| known.low),
                "high": known.and_then(|known| known.high),
                "unit": spec.unit,
            });
            (spec.name.to_owned(), said)
        });
        json::to_python(py, &Value::Object(all.collect()))
    }

    #[getter]
    fn effects(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let all = self.world.effects.iter().map(|effect| {
            let spec = effects::effect(&effect.name).map_err(invalid)?;
            let parameters = effect.parameters.iter().map(|(name, estimate)| {
                let unit = spec.parameter(name).map_or("", |parameter| parameter.unit);
                let said = json!({
                    "value": estimate.value, "low": estimate.low, "high": estimate.high, "unit": unit,
                });
                (name.clone(), said)
            });
            Ok((effect.name.clone(), Value::Object(parameters.collect())))
        });
        let all: serde_json::Map<String, Value> = all.collect::<PyResult<_>>()?;
        json::to_python(py, &Value::Object(all))
    }
}

#[pymethods]
impl Strike {
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_numpy(py, &self.0.track.t)
    }

    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_numpy(py, &self.0.track.x)
    }

    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_numpy(py, &self.0.track.y)
    }

    #[getter]
    fn stop(&self) -> (f64, f64) {
        (self.0.stop.x, self.0.stop.y)
    }

    #[getter]
    fn rest_time(&self) -> f64 {
        self.0.rest_time
    }
}
