//! From a target to a plan: solve, add the residual, check every limit.

use store::{Artifact, Metrics, Model, Network, TrainedRegion};
use values::{Command, Conditions, Interval, Point, Rig};
use world::{Simulator, SolveSettings, SolveStatus};

use crate::limits::{self, Broken};
use crate::{Plan, PlannerError, Reason, Refusal};

/// How a start is named that was chosen here.
const CHOSEN_START: &str = "the start in the middle of the trained paths (no --from was given)";

/// How many times the 95th percentile of what the world alone missed by on held-out strikes the residual may move a stop: one in
/// twenty strikes needs more than once that, and none of a thousand draws from a normal distribution twice.
const MOST_SHIFT: f64 = 2.0;
/// Share of the path by which the residual may move a stop where nobody measured what the world alone misses by.
const UNKNOWN_SHIFT: f64 = 0.1;

/// One model of an artifact, ready to plan. Shared between threads.
pub struct Planner {
    version: String,
    model: Model,
    rig: Rig,
    simulator: Simulator,
    residual: Option<Network>,
    region: TrainedRegion,
    /// Of the model on held-out strikes.
    metrics: Option<Metrics>,
    /// Of the same world without the residual on held-out strikes; none for a model without one.
    unaided: Option<Metrics>,
    /// Strikes that the version knows: the order of the next one.
    order: f64,
}

impl Planner {
    /// The planner of one of the artifact's models, within the limits of the artifact's rig. Errors if the artifact does
    /// not hold the model, or its world does not compile.
    pub fn new(artifact: &Artifact, model: Model) -> Result<Self, PlannerError> {
        Self::within(artifact, model, &artifact.rig)
    }

    /// The same, within the limits of a robot's own rig file, which must pass [`crate::identity::check`].
    pub fn within(artifact: &Artifact, model: Model, rig: &Rig) -> Result<Self, PlannerError> {
        let version = &artifact.version;
        let (world, residual) = artifact
            .model(model)
            .ok_or_else(|| no_model(artifact, model))?;
        let simulator = Simulator::new(rig, &world).map_err(|source| PlannerError::World {
            version: version.clone(),
            source,
        })?;
        let metrics = &artifact.manifest.provenance.metrics;
        let unaided = match model {
            Model::SysidResidual => metrics.get(&Model::Sysid),
            Model::EffectResidual => metrics.get(&Model::Effect),
            Model::Nominal | Model::Sysid | Model::Effect => None,
        };
        Ok(Self {
            version: version.clone(),
            model,
            rig: rig.clone(),
            simulator,
            residual: residual.cloned(),
            region: artifact.manifest.provenance.trained_region,
            metrics: metrics.get(&model).copied(),
            unaided: unaided.copied(),
            order: artifact
                .manifest
                .provenance
                .strikes
                .map_or(0.0, |strikes| strikes.count as f64),
        })
    }

    /// The rig that it plans for.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Where an object lies whose path to `to` (m) is the middle of the trained paths, to a tenth of a millimetre: for a
    /// try without a camera. Refuses a target that no start would mend.
    pub fn usual_start(&self, to: Point) -> Result<Point, Refusal> {
        let middle = |interval: Interval| 0.5 * (interval.low + interval.high);
        let start = to - Point::polar(middle(self.region.distance), middle(self.region.bearing));
        let round = |coordinate: f64| (coordinate * 1e4).round() / 1e4;
        let start = Point::new(round(start.x), round(start.y));
        limits::point(&self.rig.table, "to", to)
            .and_then(|()| limits::trained_stop(&self.region, to))
            .and_then(|()| limits::point(&self.rig.table, CHOSEN_START, start))
            .map_err(|(refused, detail)| Refusal {
                from: None,
                to: Some(to),
                refused,
                detail,
            })?;
        Ok(start)
    }

    /// The strike that brings an object at rest at `from` to rest at `to` (m), or why it is not made: no value is ever
    /// moved into a limit. The same input gives the same plan, whatever was planned before.
    pub fn plan(&self, from: Point, to: Point) -> Result<Plan, Refusal> {
        self.try_plan(from, to)
            .map_err(|(refused, detail)| Refusal {
                from: Some(from),
                to: Some(to),
                refused,
                detail,
            })
    }

    fn try_plan(&self, from: Point, to: Point) -> Result<Plan, Broken> {
        limits::points(&self.rig.table, from, to)?;
        limits::trained(&self.region, from, to)?;
        let path = to - from;
        let simulated = self.solve(from, to)?;
        let [d_speed, d_angle] = self.residual(path, simulated);
        let command = Command {
            speed: simulated.speed + d_speed,
            angle: simulated.angle + d_angle,
        };
        limits::command(&self.rig, command, simulated)?;
        if self.residual.is_some() {
            let stop = self.simulated_stop(from, command)?;
            limits::residual(&self.rig, to, stop, self.farthest_shift(path))?;
        }
        let profile = self.simulator.profile(from, command).ok_or_else(|| {
            (
                Reason::Unreachable,
                format!(
                    "the tip passes beside the object at {:.4} rad; lay the object more in line with its target",
                    command.angle
                ),
            )
        })?;
        limits::reach(&self.rig.table, &profile)?;
        Ok(Plan {
            artifact: self.version.clone(),
            model: self.model,
            from,
            to,
            path,
            speed_sim: simulated.speed,
            angle_sim: simulated.angle,
            d_speed,
            d_angle,
            speed: command.speed,
            angle: command.angle,
            start: profile.start,
            pre_strike: profile.pre_strike,
            strike: profile.strike,
            stop: profile.stop,
            acceleration: self.rig.robot.acceleration,
            expected_miss: self.metrics.map(|metrics| metrics.mean),
            expected_miss_strikes: self.metrics.map(|metrics| metrics.n),
        })
    }

    /// Where the world's object comes to rest, in m, when it is struck with the final command.
    fn simulated_stop(&self, from: Point, command: Command) -> Result<Point, Broken> {
        let simulated = self
            .simulator
            .worker()
            .strike(from, command, &self.conditions());
        let simulated = simulated.map_err(|error| {
            (
                Reason::Diverged,
                format!(
                    "the final command, residual included, has no end: {error}; use another --model"
                ),
            )
        })?;
        Ok(simulated.stop)
    }

    /// How far (m) the residual may move the simulated stop from the target: it makes good what the world alone misses by.
    fn farthest_shift(&self, path: Point) -> f64 {
        self.unaided.map_or(UNKNOWN_SHIFT * path.norm(), |unaided| {
            MOST_SHIFT * unaided.p95
        })
    }

    /// A strike yet to be made belongs to no session, and comes after all that the version knows.
    fn conditions(&self) -> Conditions {
        Conditions {
            session: String::new(),
            order: self.order,
        }
    }

    /// The world's own command. The robot's limits are those of the final command, not of this one.
    fn solve(&self, from: Point, to: Point) -> Result<Command, Broken> {
        let settings = SolveSettings::default();
        let conditions = self.conditions();
        let solution = self
            .simulator
            .worker()
            .solve(from, to, &conditions, &settings, None);
        match solution.status {
            SolveStatus::Solved => Ok(solution.command),
            SolveStatus::Unreachable => Err((
                Reason::Unreachable,
                format!(
                    "after {} simulations the nearest strike, {:.4} m/s at {:.4} rad, stops {:.1} mm from `to`; \
                     choose another target, or lay the object elsewhere",
                    solution.evaluations,
                    solution.command.speed,
                    solution.command.angle,
                    solution.miss * 1e3
                ),
            )),
            SolveStatus::Diverged => Err((
                Reason::Diverged,
                format!(
                    "none of {} simulations came to rest; check the artifact's world, or use another --model",
                    solution.evaluations
                ),
            )),
        }
    }

    /// What the residual adds to the simulated command: speed in m/s and angle in rad.
    fn residual(&self, path: Point, simulated: Command) -> [f64; 2] {
        self.residual.as_ref().map_or([0.0, 0.0], |network| {
            network.predict([path.x, path.y, simulated.speed, simulated.angle])
        })
    }
}

fn no_model(artifact: &Artifact, model: Model) -> PlannerError {
    PlannerError::NoModel {
        model,
        version: artifact.version.clone(),
        has: artifact
            .models()
            .iter()
            .map(|model| model.name())
            .collect::<Vec<_>>()
            .join(", "),
    }
}
