//! From a command to a plan: for strikes that gather data, whose stops are only predicted.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use store::{Artifact, Model};
use values::{Command, Conditions, Point, Rig};
use world::{Simulator, World, WorldError};

use crate::limits::{self, BrokenLimit, refuse_if};
use crate::plan::{Details, GOOD_FOR};
use crate::{Plan, PlannerError, Reason, Refusal, clearance, motion};

/// The name that stands for the version in plans that no version made.
const NO_VERSION: &str = "none";

/// Plans strikes by their command, in a world that predicts where the object stops.
pub struct CommandPlanner {
    version: String,
    model: Model,
    rig: Arc<Rig>,
    simulator: Simulator,
    good_for: Duration,
    clock: fn() -> SystemTime,
}

impl CommandPlanner {
    /// Plans in the nominal world, before anything is measured.
    pub fn nominal(rig: &Rig) -> Result<Self, PlannerError> {
        Self::in_world(NO_VERSION, Model::Nominal, rig, &World::nominal())
    }

    /// Plans in the world of a version's best model, within the limits of a robot's own rig file, which must pass [`crate::identity::check`].
    pub fn published(artifact: &Artifact, rig: &Rig) -> Result<Self, PlannerError> {
        let best = artifact.manifest.provenance.default_model;
        // The world predicts the stop; a residual corrects commands for targets.
        let world = artifact
            .model(best)
            .map_or_else(World::nominal, |(world, _)| world);
        Self::in_world(&artifact.version, best, rig, &world)
    }

    fn in_world(
        version: &str,
        model: Model,
        rig: &Rig,
        world: &World,
    ) -> Result<Self, PlannerError> {
        let failed = |source: WorldError| PlannerError::World {
            version: version.into(),
            source,
        };
        Ok(Self {
            version: version.into(),
            model,
            rig: Arc::new(rig.clone()),
            simulator: Simulator::new(rig, world).map_err(failed)?,
            good_for: GOOD_FOR,
            clock: SystemTime::now,
        })
    }

    /// This planner, its plans executable for `good_for` after they are made; 5 s unless given.
    pub fn good_for(self, good_for: Duration) -> Self {
        Self { good_for, ..self }
    }

    /// This planner, its strikes stamped by `clock` in place of this computer's clock.
    pub fn by_clock(self, clock: fn() -> SystemTime) -> Self {
        Self { clock, ..self }
    }

    /// The rig that it plans for.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Where the object is foreseen to stop that is struck at `from` (m); none where it is not struck or does not rest.
    pub fn foreseen(&self, from: Point, command: Command) -> Option<Point> {
        let conditions = Conditions::default();
        let object = motion::object(&self.simulator, from, command, &conditions);
        object.ok().map(|object| object.stop)
    }

    /// The strike of an object at rest at `from` (m) with this command, or why it is not made. The object must stay on the table
    /// even if it slides `farther` times as far as it is foreseen to. A box is taken to stand with its faces along the table's axes.
    pub fn plan(&self, from: Point, command: Command, farther: f64) -> Result<Plan, Refusal> {
        self.plan_turned(from, command, farther, 0.0)
    }

    /// The strike, by this command, of an object at rest at `from` (m) that is seen turned by `yaw` (rad) from the table's axes, or why it is not
    /// made. A box is struck as it stands, and refused where it is turned too far. The object must stay on the table even if it slides `farther`
    /// times as far as it is foreseen to.
    pub fn plan_turned(
        &self,
        from: Point,
        command: Command,
        farther: f64,
        yaw: f64,
    ) -> Result<Plan, Refusal> {
        limits::turn(&self.rig, yaw)
            .and_then(|turn| self.try_plan(from, command, farther, turn))
            .map_err(|(refused, detail)| Refusal {
                from: Some(from),
                to: None,
                refused,
                detail,
            })
    }

    fn try_plan(
        &self,
        from: Point,
        command: Command,
        farther: f64,
        turn: Option<f64>,
    ) -> Result<Plan, BrokenLimit> {
        let rig = &self.rig;
        limits::point(rig, "from", from)?;
        limits::command(rig, command, command)?;
        let conditions = Conditions {
            yaw: turn,
            ..Conditions::default()
        };
        let stroke = motion::stroke(rig, &self.simulator, from, command, &conditions)?;
        let object = motion::object(&self.simulator, from, command, &conditions)?;
        let path = object.stop - from;
        let farthest = from + path * farther.max(1.0);
        limits::points(rig, from, object.stop)
            .and_then(|()| limits::point(rig, "to", farthest))
            .and_then(|()| clearance::object(rig, from, farthest))
            .map_err(|(reason, detail)| {
                let text = format!(
                    "struck with {:.3} m/s at {:.3} rad it is foreseen to slide {:.3} m, and may slide {farther:.2} times as far: {detail}",
                    command.speed,
                    command.angle,
                    path.norm()
                );
                (reason, text)
            })?;
        limits::second_push(&stroke, &object, limits::sizes(rig).0)?;
        refuse_if(path.norm() == 0.0, Reason::Unreachable, || {
            "the object is foreseen not to move".into()
        })?;
        let maker = (self.version.clone(), self.model);
        let details = Details {
            yaw: turn,
            ..Details::unaided(maker, (from, object.stop), command, &stroke, rig)
        };
        let plan = Plan::new(details, stroke, rig.clone(), self.good_for);
        Ok(plan.by_clock(self.clock))
    }
}
