//! The embedded rig as a robot: its own physics, hidden effects, scatter and camera.

use std::path::Path;

use rig::{Sim, Truth};
use values::Rig;

use super::{Robot, RobotError, StrikeRecord};
use crate::{Plan, identity};

/// Seed of a rig that no `truth.json` describes.
const SEED: u64 = 0;

/// Which embedded rig is struck.
#[derive(Clone, Copy, Debug)]
pub enum TruthSource<'a> {
    /// The demo's mixture of hidden effects.
    Demo,
    /// The one that this `truth.json` describes.
    File(&'a Path),
}

/// `--robot sim`: the embedded rig.
#[derive(Clone, Debug)]
pub struct SimRobot {
    sim: Sim,
    planned_for: Rig,
}

impl SimRobot {
    /// The embedded rig, after as many strikes as its truth lists and `struck` more: the next strike has a scatter, a
    /// wear and stamps of its own. It strikes in this session of the demo, which its log names, or in the one after all that the
    /// truth lists. `rig` is the rig that plans are made for. Errors where the truth cannot be read, or lists no such session.
    pub fn open(
        rig: &Rig,
        source: TruthSource<'_>,
        struck: usize,
        session: Option<&str>,
    ) -> Result<Self, RobotError> {
        let failed = |why: String| RobotError::Connection {
            robot: "sim".into(),
            why,
        };
        let of_rig = |error: rig::RigSimError| failed(error.to_string());
        let truth = match source {
            TruthSource::Demo => Truth::demo(rig, SEED),
            TruthSource::File(path) => Truth::load(path).map_err(of_rig)?,
        };
        let before = truth.strikes.len();
        let sessions = truth.strikes.last().map_or(0, |last| last.session + 1);
        let session = match session {
            None => sessions,
            Some(name) => rig::demo::session_number(name)
                .filter(|number| *number < sessions)
                .ok_or_else(|| {
                    failed(format!(
                        "its truth lists no session `{name}`, only {sessions} that `carom demo` logged"
                    ))
                })?,
        };
        let sim = Sim::from(truth).map_err(of_rig)?;
        Ok(Self {
            sim: sim.after(before + struck).in_session(session),
            planned_for: rig.clone(),
        })
    }
}

impl Robot for SimRobot {
    fn name(&self) -> String {
        "sim".into()
    }

    fn check(&mut self, _: &Plan) -> Result<(), RobotError> {
        identity::allows(&self.planned_for, &self.sim.truth().rig).map_err(|difference| {
            RobotError::NotReady {
                robot: self.name(),
                why: difference.to_string(),
            }
        })
    }

    fn strike(&mut self, plan: &Plan) -> Result<Option<StrikeRecord>, RobotError> {
        let recording = match plan.yaw {
            Some(yaw) => self.sim.strike_turned(plan.from, yaw, plan.command()),
            None => self.sim.strike(plan.from, plan.command()),
        };
        Ok(Some(StrikeRecord {
            stop: Some(recording.stop),
            samples: recording.samples,
            delivered_speed: None,
            warning: None,
        }))
    }

    fn abort(&mut self) -> Result<(), RobotError> {
        Ok(())
    }
}
