//! From a target to a plan: solve, add the residual, check every limit.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use store::{Artifact, Model, TrainedRegion, TrainingExtent};
use values::{Command, Conditions, Interval, Point, Rig, StopErrors, Strike};
use world::{Filter, Observer, Shift, Simulator, Varies};

use crate::correction::{Correction, solved};
use crate::limits::{self, BrokenLimit};
use crate::plan::{Adapted, Details, GOOD_FOR};
use crate::recent::{Acting, Recent};
use crate::{Plan, PlannerError, Reason, Refusal, clearance, motion};

/// The name, in refusals, of a start that was chosen here.
const CHOSEN_START: &str = "the start in the middle of the trained paths (no --from was given)";

/// Greatest move of a stop by the residual, in units of the 95th percentile of the world's own misses on held-out strikes: one in twenty strikes
/// needs more than once that, and none of a thousand draws from a normal distribution twice.
const MOST_SHIFT: f64 = 2.0;
/// Greatest share of the path by which the residual may move a stop where nobody measured what the world alone misses by.
const UNKNOWN_SHIFT: f64 = 0.1;

/// Root mean square over mean of the distance from the middle of a round normal distribution, √(4/π).
const ROOT_OF_MEAN: f64 = std::f64::consts::FRAC_2_SQRT_PI;

/// One model of an artifact, ready to plan. Shared between threads.
pub struct Planner {
    version: String,
    model: Model,
    rig: Arc<Rig>,
    simulator: Simulator,
    residual: Option<Correction>,
    /// The model on its table and on tables a step beside it, for derivatives by the table's shift.
    beside: Observer,
    table: Filter,
    /// Whether strikes of the session that is planned for have shown the table.
    is_seen: bool,
    /// The extent of what the residual's training explains; none where the version does not state it.
    explained: Option<TrainingExtent>,
    region: TrainedRegion,
    /// Stop errors of the model on held-out strikes.
    metrics: Option<StopErrors>,
    /// Stop errors of the world without the residual on held-out strikes; none for a model without one.
    unaided: Option<StopErrors>,
    /// The conditions that it plans for: a session that is not known, after all strikes that the version knows.
    conditions: Conditions,
    good_for: Duration,
}

impl Planner {
    /// The planner of one of the artifact's models, within the limits of the artifact's rig. Errors if the artifact does
    /// not hold the model, or its world does not compile.
    pub fn new(artifact: &Artifact, model: Model) -> Result<Self, PlannerError> {
        Self::within(artifact, model, &artifact.rig)
    }

    /// The planner of one of the artifact's models, within the limits of a robot's own rig file, which must pass [`crate::identity::check`]. Errors
    /// if the artifact does not hold the model, or its world does not compile.
    pub fn within(artifact: &Artifact, model: Model, rig: &Rig) -> Result<Self, PlannerError> {
        let version = &artifact.version;
        let (world, residual) = artifact
            .model(model)
            .ok_or_else(|| no_model(artifact, model))?;
        let in_world = |source| PlannerError::World {
            version: version.clone(),
            source,
        };
        let simulator = Simulator::new(rig, &world).map_err(in_world)?;
        let provenance = &artifact.manifest.provenance;
        let metrics = &provenance.metrics;
        let unaided = match model {
            Model::SysidResidual => metrics.get(&Model::Sysid),
            Model::EffectResidual => metrics.get(&Model::Effect),
            Model::Nominal | Model::Sysid | Model::Effect => None,
        };
        let varies = provenance.varies.get(&model);
        let varies = varies.map_or_else(|| Varies::assumed(&world), Clone::clone);
        let residual = Correction::in_world(&simulator, residual);
        Ok(Self {
            version: version.clone(),
            model,
            rig: Arc::new(rig.clone()),
            beside: beside(&simulator, residual.as_ref()),
            table: Filter::as_usual(&varies),
            is_seen: false,
            simulator,
            residual,
            explained: provenance.explained.get(&model).copied(),
            region: provenance.trained_region,
            metrics: metrics.get(&model).copied(),
            unaided: unaided.copied(),
            conditions: Conditions {
                order: artifact.next_order(),
                ..Conditions::default()
            },
            good_for: GOOD_FOR,
        })
    }

    /// This planner, for a session that the version knows. Errors where it does not know it.
    pub fn in_session(mut self, artifact: &Artifact, session: &str) -> Result<Self, PlannerError> {
        let effects = artifact.effect.as_ref();
        let known = effects.map_or_else(BTreeSet::new, |effect| effect.world.known_sessions());
        if !known.contains(session) {
            return Err(PlannerError::NoSession {
                session: session.into(),
                version: self.version,
                known: known.into_iter().collect::<Vec<_>>().join(", "),
            });
        }
        self.conditions.session = session.into();
        self.table = Filter::new(self.table.varies());
        Ok(self)
    }

    /// The table before any recent strike, to be passed to [`Planner::follow`].
    pub fn recent(&self) -> Recent {
        Recent::new(self.table.varies())
    }

    /// Follows recent strikes in the order of time, beside this planner's model.
    ///
    /// # Errors
    /// Where the table then is farther from the version's own than that believes possible.
    pub fn follow(
        &self,
        artifact: &Artifact,
        recent: &mut Recent,
        strikes: &[Strike],
    ) -> Result<(), PlannerError> {
        let (_, residual) = artifact
            .model(self.model)
            .ok_or_else(|| no_model(artifact, self.model))?;
        let usual = |simulator: &Simulator| simulator.shifted(Shift::default());
        let alone = usual(&self.simulator);
        let delivering = self.residual.as_ref().and_then(Correction::delivering);
        let model = Acting {
            delivering: &delivering.map_or_else(|| usual(&self.simulator), usual),
            alone: &alone,
            residual,
            order: artifact.next_order(),
        };
        recent
            .follow(&model, strikes)
            .map_err(|changed| PlannerError::TableChanged {
                version: self.version.clone(),
                strikes: changed.strikes,
                shown: match changed.odd {
                    Some(odd) => {
                        format!("{odd} that fit neither the others nor a table that moves")
                    }
                    None => changed.shift.to_string(),
                },
            })
    }

    /// This planner on the table as recent strikes show it. `is_today` says that the last of them is of the session to plan in; else a new session
    /// begins. Until a strike of the session shows the table (none yet, or all of them bad), it is taken to be as identified, within what sessions
    /// usually differ by.
    pub fn adapted(mut self, recent: &Recent, is_today: bool) -> Self {
        let mut recent = recent.clone();
        if !is_today {
            recent.begin_session();
        }
        let filter = recent.filter();
        self.is_seen = filter.is_shown();
        self.table = match self.is_seen {
            true => filter.clone(),
            false => filter.if_as_it_was(),
        };
        self.simulator = self.simulator.shifted(self.table.mean());
        self.residual = self
            .residual
            .map(|residual| residual.shifted(self.table.mean()));
        self.beside = beside(&self.simulator, self.residual.as_ref());
        self.conditions.order += recent.seen() as f64;
        self
    }

    /// This planner, its plans executable for `good_for` after they are made; 5 s unless given.
    pub fn good_for(self, good_for: Duration) -> Self {
        Self { good_for, ..self }
    }

    /// This planner, its plans executable for `by` longer.
    pub fn good_for_longer(self, by: Duration) -> Self {
        let good_for = self.good_for + by;
        self.good_for(good_for)
    }

    /// The rig that it plans for.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// The start of an object whose path to `to` (m) is as near to the middle of the trained paths as trained starts allow, to a tenth of a
    /// millimetre: for a try without a camera. Refuses a target that no start would mend.
    pub fn usual_start(&self, to: Point) -> Result<Point, Refusal> {
        /// Parts of the ranges of trained lengths and bearings that are tried, from their middles on.
        const PARTS: i32 = 20;
        let refuse = |(refused, detail)| Refusal {
            from: None,
            to: Some(to),
            refused,
            detail,
        };
        limits::point(&self.rig, "to", to)
            .and_then(|()| limits::trained_stop(&self.region, to))
            .map_err(refuse)?;
        let at = |interval: Interval, part: i32| {
            interval.low + (interval.high - interval.low) * f64::from(part) / f64::from(PARTS)
        };
        let round = |coordinate: f64| (coordinate * 1e4).round() / 1e4;
        let mut parts: Vec<(i32, i32)> = (0..=PARTS)
            .flat_map(|length| (0..=PARTS).map(move |bearing| (length, bearing)))
            .collect();
        let aside = |part: i32| (part - PARTS / 2).pow(2);
        parts.sort_by_key(|(length, bearing)| aside(*length) + aside(*bearing));
        let mut broken = None;
        for (length, bearing) in parts {
            let (length, bearing) = (
                at(self.region.distance, length),
                at(self.region.bearing, bearing),
            );
            let start = to - Point::polar(length, bearing);
            let start = Point::new(round(start.x), round(start.y));
            let checked = limits::point(&self.rig, CHOSEN_START, start)
                .and_then(|()| limits::trained(&self.region, start, to));
            match checked {
                Ok(()) => return Ok(start),
                Err(limit) => {
                    broken.get_or_insert(limit);
                }
            }
        }
        // What the middle one breaks.
        Err(refuse(
            broken.unwrap_or((Reason::Unreachable, String::new())),
        ))
    }

    /// The strike that brings an object at rest at `from` to rest at `to` (m), or why it is not made: no value is ever
    /// moved into a limit. The same input gives the same plan, whatever was planned before. A box is taken to stand with its faces
    /// along the table's axes.
    pub fn plan(&self, from: Point, to: Point) -> Result<Plan, Refusal> {
        self.plan_turned(from, to, 0.0)
    }

    /// The strike that brings an object at rest at `from`, seen turned by `yaw` (rad) from the table's axes, to rest at `to` (m), or why it is not
    /// made. A box is struck as it stands, and refused where it is turned too far.
    pub fn plan_turned(&self, from: Point, to: Point, yaw: f64) -> Result<Plan, Refusal> {
        limits::turn(&self.rig, yaw)
            .and_then(|turn| self.try_plan(from, to, turn))
            .map_err(|(refused, detail)| Refusal {
                from: Some(from),
                to: Some(to),
                refused,
                detail,
            })
    }

    fn try_plan(&self, from: Point, to: Point, turn: Option<f64>) -> Result<Plan, BrokenLimit> {
        limits::points(&self.rig, from, to)?;
        clearance::object(&self.rig, from, to)?;
        limits::trained(&self.region, from, to)?;
        let path = to - from;
        limits::trained_face(&self.region, path, turn)?;
        let conditions = &Conditions {
            yaw: turn,
            ..self.conditions.clone()
        };
        let (simulated, command) = self.commands(from, to, conditions)?;
        limits::command(&self.rig, command, simulated)?;
        let stroke = motion::stroke(&self.rig, &self.simulator, from, command, conditions)?;
        let mut object = motion::object(&self.simulator, from, command, conditions)?;
        if let Some(residual) = &self.residual {
            limits::shift(to, object.stop, self.farthest_shift(path))?;
            if let Some(explained) = &self.explained {
                residual.check_added(explained, simulated, command)?;
            }
            object = residual.moved(&self.rig.table, object, |world| {
                motion::object(world, from, command, conditions)
            })?;
        }
        limits::second_push(&stroke, &object, limits::sizes(&self.rig).0)?;
        let maker = (self.version.clone(), self.model);
        let details = Details {
            yaw: turn,
            speed_sim: simulated.speed,
            angle_sim: simulated.angle,
            d_speed: command.speed - simulated.speed,
            d_angle: command.angle - simulated.angle,
            expected_miss: self.expected_miss(from, path, (simulated, command), conditions),
            expected_miss_strikes: self.expected_miss_strikes(),
            if_as_before: !self.is_seen,
            adapted: Adapted::of(&self.table),
            ..Details::unaided(maker, (from, to), command, &stroke, &self.rig)
        };
        Ok(Plan::new(details, stroke, self.rig.clone(), self.good_for))
    }

    /// Greatest distance (m) that the residual may move the simulated stop from the target: it makes good what the world alone misses by, on the
    /// strikes that it learnt from or, where the version does not state it, on held-out ones.
    fn farthest_shift(&self, path: Point) -> f64 {
        if let Some(explained) = self.explained {
            return explained.displacement * path.norm();
        }
        self.unaided.map_or(UNKNOWN_SHIFT * path.norm(), |unaided| {
            MOST_SHIFT * unaided.p95
        })
    }

    /// The world's own command, and the one to send. The robot's limits are those of the latter.
    fn commands(
        &self,
        from: Point,
        to: Point,
        conditions: &Conditions,
    ) -> Result<(Command, Command), BrokenLimit> {
        match &self.residual {
            None => solved(&self.simulator, from, to, conditions).map(|command| (command, command)),
            Some(residual) => residual.commands(&self.simulator, from, to, conditions),
        }
    }

    /// Number of strikes that the expected miss was estimated from: those that show how strikes scatter beside the model, of a residual those that it
    /// learnt from; else those held out.
    fn expected_miss_strikes(&self) -> Option<usize> {
        let shown = self.table.varies().strikes;
        let learnt_from = self.explained.map(|explained| explained.strikes);
        Some(shown)
            .filter(|shown| *shown > 0)
            .or(learnt_from)
            .or(self.metrics.map(|metrics| metrics.n))
    }

    /// Root mean square (m) of the distance between stop and target to expect: what strikes scatter by beside the model, what is not
    /// known of the table, and what a launch map is not sure of at this command. They are independent, so their squares add.
    fn expected_miss(
        &self,
        from: Point,
        path: Point,
        (simulated, command): (Command, Command),
        conditions: &Conditions,
    ) -> Option<f64> {
        let acting = match &self.residual {
            Some(Correction::Networks(..)) => simulated,
            Some(Correction::Launch(..)) | None => command,
        };
        let slopes = self.beside.stop_slopes(from, acting, conditions)?;
        let by_table = self.table.share_by_shift(&slopes).sqrt() * path.norm();
        let of_residual = self.residual.as_ref().zip(self.explained.as_ref());
        let alone = if self.table.varies().strikes > 0 {
            let scatter = self.table.varies().stop_scatter();
            let unsure = self.residual.as_ref().map_or(0.0, |r| r.unsure(command));
            scatter.hypot(unsure) * path.norm()
        } else if let Some((residual, explained)) = of_residual {
            ROOT_OF_MEAN * residual.expected_miss(explained, command) * path.norm()
        } else {
            self.metrics.map(|metrics| metrics.mean.hypot(metrics.sd))?
        };
        Some(alone.hypot(by_table))
    }
}

/// The model that a stop depends on, on tables beside its own.
fn beside(alone: &Simulator, residual: Option<&Correction>) -> Observer {
    Observer::about(residual.and_then(Correction::delivering).unwrap_or(alone))
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
