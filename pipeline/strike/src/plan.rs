//! What is to be done: a command, and the motion of the tip that strikes it.

use std::ops::Deref;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use logs::write::Lineage;
use serde::Serialize;
use store::Model;
use values::{Command, Point, Rig};
use world::{Filter, Shift};

use crate::about::program;
use crate::epoch::Epoch;
use crate::limits::{self, BrokenLimit, refuse_if};
use crate::stroke::Stroke;
use crate::{Reason, clearance};

/// Number of strikes below which their mean says little: at ten it is known to a fifth or so.
pub const FEW: usize = 10;
/// How long a plan may be executed after it was made, unless the planner says otherwise: later, the object may lie elsewhere.
pub(crate) const GOOD_FOR: Duration = Duration::from_secs(5);

/// One strike, planned and within every limit. Only a [`crate::Planner`] makes one, and nothing can change it: what is read of
/// it is its [`Details`]. Serialised it is the contract's plan.
#[derive(Clone, Debug, Serialize)]
#[serde(transparent)]
pub struct Plan {
    details: Details,
    #[serde(skip)]
    stroke: Stroke,
    #[serde(skip)]
    rig: Arc<Rig>,
    #[serde(skip)]
    made: Instant,
    #[serde(skip)]
    epoch: Epoch,
    #[serde(skip)]
    good_for: Duration,
}

/// The numbers of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Details {
    /// Version of the artifact that planned it, such as `v0003`.
    pub artifact: String,
    /// Model that planned it.
    pub model: Model,
    /// Where the object rests, in m.
    pub from: Point,
    /// How far a box is turned from one whose faces lie along the table's axes, in rad; not stated where it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw: Option<f64>,
    /// Where it shall come to rest, in m.
    pub to: Point,
    /// Displacement, in m.
    pub path: Point,
    /// Speed that the world alone would strike with, in m/s.
    pub speed_sim: f64,
    /// Angle that the world alone would strike at, in rad.
    pub angle_sim: f64,
    /// What the residual adds to the speed, in m/s; 0 for a model without one.
    pub d_speed: f64,
    /// What the residual adds to the angle, in rad; 0 for a model without one.
    pub d_angle: f64,
    /// Speed of the command, in m/s.
    pub speed: f64,
    /// Angle of the command, in rad.
    pub angle: f64,
    /// Tip's centre at rest before, in m.
    pub start: Point,
    /// Tip's centre when it has reached the striking speed, 10 mm before it strikes, in m.
    pub pre_strike: Point,
    /// Tip's centre when it touches the object, in m.
    pub strike: Point,
    /// Tip's centre at rest after, in m.
    pub stop: Point,
    /// Acceleration of the ramps, in m/s².
    pub acceleration: f64,
    /// Root mean square of the distance between target and stop to expect, in m. None where nothing is known of it.
    pub expected_miss: Option<f64>,
    /// Number of strikes that the expected miss was estimated from: below [`FEW`] the miss is hardly known.
    pub expected_miss_strikes: Option<usize>,
    /// Whether the expected miss holds only if the table is unchanged: no strike of this session was seen.
    pub if_as_before: bool,
    /// What recent strikes showed of the table; none where none was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adapted: Option<Adapted>,
}

/// The table as recent strikes show it, beside the version's own: values with their standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adapted {
    /// Number of strikes that showed the table.
    pub strikes: usize,
    /// The shift that is planned with: logarithms of factors on friction and launch speed, and an angle in rad.
    pub shift: Shift,
    /// Standard deviations of the three values of the shift.
    pub deviations: [f64; 3],
}

impl Adapted {
    /// The table that a filter believes in; none before any strike.
    pub(crate) fn of(table: &Filter) -> Option<Self> {
        (table.strikes() > 0).then(|| Self {
            strikes: table.strikes(),
            shift: table.mean(),
            deviations: table.deviations(),
        })
    }
}

impl Plan {
    /// Where a strike of this plan comes from, for its log: the program, the version and model that planned it, the target, the plan itself
    /// and the miss that it promises (m), and the robot's name.
    pub fn lineage(&self, robot: &str) -> Lineage {
        let promised = self.expected_miss.map(|miss| miss.to_string());
        [
            ("program", program()),
            ("version", self.artifact.clone()),
            ("model", self.model.name().into()),
            ("target", format!("[{}, {}]", self.to.x, self.to.y)),
            ("plan", serde_json::to_string(self).unwrap_or_default()),
            ("promised_miss", promised.unwrap_or_default()),
            ("robot", robot.into()),
        ]
        .map(|(name, value)| (name.to_owned(), value))
        .into()
    }
}

impl Details {
    /// The details of a command that nothing is added to, and of which nothing is known from held-out strikes.
    pub(crate) fn unaided(
        (artifact, model): (String, Model),
        (from, to): (Point, Point),
        command: Command,
        stroke: &Stroke,
        rig: &Rig,
    ) -> Self {
        Self {
            artifact,
            model,
            from,
            yaw: None,
            to,
            path: to - from,
            speed_sim: command.speed,
            angle_sim: command.angle,
            d_speed: 0.0,
            d_angle: 0.0,
            speed: command.speed,
            angle: command.angle,
            start: stroke.start,
            pre_strike: stroke.pre_strike,
            strike: stroke.strike,
            stop: stroke.stop,
            acceleration: rig.robot.acceleration,
            expected_miss: None,
            expected_miss_strikes: None,
            if_as_before: true,
            adapted: None,
        }
    }
}

impl Deref for Plan {
    type Target = Details;

    fn deref(&self) -> &Details {
        &self.details
    }
}

/// Plans are equal where they make the same strike, whenever they were made.
impl PartialEq for Plan {
    fn eq(&self, other: &Self) -> bool {
        self.details == other.details
    }
}

impl Plan {
    pub(crate) fn new(details: Details, stroke: Stroke, rig: Arc<Rig>, good_for: Duration) -> Self {
        Self {
            details,
            stroke,
            rig,
            made: Instant::now(),
            epoch: Epoch::now(),
            good_for,
        }
    }

    /// This plan, its strike stamped by `clock` in place of this computer's clock.
    pub(crate) fn by_clock(self, clock: fn() -> SystemTime) -> Self {
        let epoch = Epoch::by(clock);
        Self { epoch, ..self }
    }

    /// The command that the robot is sent.
    pub fn command(&self) -> Command {
        Command::new(self.speed, self.angle)
    }

    /// The motion of the tip with its times.
    pub fn stroke(&self) -> &Stroke {
        &self.stroke
    }

    /// The clocks that all that is recorded of the strike is stamped by.
    pub(crate) fn epoch(&self) -> Epoch {
        self.epoch
    }

    /// The rig that it was planned for.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Checks whether the plan still holds: it is no older than it is good for, and command and path are within the limits of its rig.
    pub(crate) fn check_again(&self) -> Result<(), BrokenLimit> {
        let age = self.made.elapsed();
        refuse_if(age > self.good_for, Reason::PlanExpired, || {
            format!(
                "the plan is {:.1} s old, good for {:.1} s: the object may lie elsewhere; plan again",
                age.as_secs_f64(),
                self.good_for.as_secs_f64()
            )
        })?;
        if let Some(set) = self.epoch.was_set() {
            return Err((Reason::PlanExpired, format!("{set}; plan again")));
        }
        let simulated = Command::new(self.speed_sim, self.angle_sim);
        limits::command(&self.rig, self.command(), simulated)?;
        limits::points(&self.rig, self.from, self.to)?;
        clearance::object(&self.rig, self.from, self.to)?;
        clearance::path(&self.rig, &[("start", self.start), ("stop", self.stop)])
    }

    /// Whether the tip may go to the start of the strike from where it is (m), and this is the whole way at travel height.
    pub fn check_approach(&self, from: Point) -> Result<(), String> {
        let way = [("present place", from), ("start", self.start)];
        clearance::path(&self.rig, &way)
            .map_err(|(reason, detail)| format!("{}: {detail}", reason.name()))
    }
}
