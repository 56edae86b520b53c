//! The truth of a rig: what no stage may read, and every benchmark compares with.

use std::path::Path;

use serde::{Deserialize, Serialize};
use values::{Command, Point, Rig, Shape};

use crate::{Hidden, Noise, RigSimError, StrikeIndex};

/// A rig as it really is; `truth.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// The rig as it is: sizes, table, camera, robot. The rig file says the same, unless noise makes it wrong ([`Truth::rig_file`]).
    pub rig: Rig,
    /// Seed of everything random.
    pub seed: u64,
    /// Coefficient of friction between object and table.
    pub friction: f64,
    /// Coefficient of rolling resistance, for a ball.
    pub rolling: f64,
    /// Coefficient of restitution between tip and object.
    pub restitution: f64,
    /// Coefficient of friction between tip and object.
    pub tip_friction: f64,
    /// How much one launch differs from the next.
    pub scatter: Scatter,
    /// What is wrong with the camera besides noise.
    pub camera: CameraTruth,
    /// What is hidden.
    pub hidden: Hidden,
    /// Where objects bounce on the table; not in the file where there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fences: Vec<FenceTruth>,
    /// Noise beside launch scatter and independent camera noise; not in the file where there is none.
    #[serde(default, skip_serializing_if = "Noise::is_none")]
    pub noise: Noise,
    /// What was struck; empty for a robot that has not struck yet.
    #[serde(default)]
    pub strikes: Vec<StrikeTruth>,
}

/// A straight fence: an object turns back where its edge meets it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FenceTruth {
    /// The fence's one end, in m.
    pub from: Point,
    /// The fence's other end, in m.
    pub to: Point,
    /// Speed away from it over speed towards it.
    pub restitution: f64,
}

impl FenceTruth {
    /// The velocity after the fence, of a body with an edge at `reach` (m) from its centre that moves towards it and touches.
    pub(crate) fn turned_back(&self, at: Point, velocity: Point, reach: f64) -> Option<Point> {
        let along = self.to - self.from;
        let share = ((at - self.from).dot(along) / along.dot(along)).clamp(0.0, 1.0);
        let away = at - (self.from + along * share);
        let towards = away * (-1.0 / away.norm().max(1e-12));
        let speed = velocity.dot(towards);
        (away.norm() < reach && speed > 0.0)
            .then(|| velocity - towards * ((1.0 + self.restitution) * speed))
    }
}

/// Launch scatter: standard deviations from strike to strike.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// Standard deviation of the delivered speed, relative.
    pub speed: f64,
    /// Standard deviation of the delivered angle, in rad.
    pub angle: f64,
}

/// The camera's faults; rate and noise are the rig file's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraTruth {
    /// Standard deviation of the time between frames, in s.
    pub jitter: f64,
    /// Share of frames that are lost.
    pub dropped: f64,
}

/// One strike as it really was, on the table and without noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StrikeTruth {
    /// Number of its session, from 0.
    pub session: usize,
    /// Number of strikes before it.
    pub order: usize,
    /// Initial position, in m.
    pub initial: Point,
    /// What was commanded.
    pub command: Command,
    /// What the arm delivered, scatter included.
    pub delivered: Command,
    /// Stamp of the impact, in ns.
    #[serde(rename = "blow")]
    pub impact: u64,
    /// Seconds from the impact to rest.
    pub rest_time: f64,
    /// Where it came to rest, in m.
    pub stop: Point,
    /// Factor on friction in this strike; not in the file where friction does not scatter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// How the object was turned before it, in rad; not in the file where every object lies straight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw: Option<f64>,
}

impl StrikeTruth {
    /// Which strike it is.
    pub fn index(&self) -> StrikeIndex {
        StrikeIndex {
            session: self.session,
            order: self.order,
        }
    }
}

impl Truth {
    /// The demo's truth for a rig: its hidden mixture, a dry plastic-on-wood contact, and a good arm's scatter.
    ///
    /// Launch scatter and the camera's faults are those of a small arm with a software-triggered camera; together with the
    /// noise of the rig file they scatter repeats of one command by a few millimetres.
    pub fn demo(rig: &Rig, seed: u64) -> Self {
        Self {
            rig: rig.clone(),
            seed,
            friction: 0.18,
            rolling: 0.10,
            restitution: 0.50,
            // A rubber-faced tip: it sticks to a box over all the demo's angles, so that they all lead somewhere else.
            tip_friction: 0.70,
            scatter: Scatter {
                speed: 0.006,
                angle: 0.3f64.to_radians(),
            },
            camera: CameraTruth {
                jitter: 0.0008,
                dropped: 0.01,
            },
            hidden: Hidden::demo(),
            fences: Vec::new(),
            noise: Noise::none(),
            strikes: Vec::new(),
        }
    }

    /// The demo's rig for a shape. A box is struck within ±0.35 rad: beyond 0.55 the tip slips or meets an edge, and a model
    /// that must undo the hidden angles needs the rest.
    pub fn demo_rig(shape: Shape) -> Rig {
        let mut rig = Rig::demo(shape);
        if shape == Shape::Box {
            rig.robot.angle = [-0.35, 0.35].into();
        }
        rig
    }

    /// Reads `truth.json`.
    pub fn load(path: &Path) -> Result<Self, RigSimError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|source| RigSimError::File {
            doing: "read",
            path: file.clone(),
            source,
        })?;
        serde_json::from_str(&text).map_err(|error| RigSimError::Parse {
            what: format!("truth {file}"),
            why: error.to_string(),
        })
    }

    /// The text of `truth.json`.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a truth is plain data")
    }

    /// This truth before it struck.
    pub(crate) fn without_strikes(&self) -> Self {
        Self {
            rig: self.rig.clone(),
            hidden: self.hidden.clone(),
            fences: self.fences.clone(),
            noise: self.noise.clone(),
            strikes: Vec::new(),
            ..*self
        }
    }

    /// Where the camera sees a point of the table, without noise, in m.
    pub fn see(&self, at: Point, index: StrikeIndex) -> Point {
        self.hidden.see(at, self.rig.camera.centre, index)
    }

    /// How the camera sees an object turned that is turned by `yaw` at a point of the table, without noise, in rad.
    pub fn see_yaw(&self, at: Point, yaw: f64, index: StrikeIndex) -> f64 {
        /// Between the two points of the object that are compared, in m.
        const AHEAD: f64 = 1e-3;
        let ahead = self.see(at + Point::polar(AHEAD, yaw), index) - self.see(at, index);
        yaw + ahead.rotated(-yaw).bearing()
    }

    /// The rig file that a user has: [`Truth::rig`] with what noise makes wrong in it.
    pub fn rig_file(&self) -> Rig {
        self.noise.rig_file(&self.rig)
    }
}
