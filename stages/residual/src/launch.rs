//! What the arm delivered beside the world, strike by strike: what a launch map learns from.
//!
//! The solve answers with the launch that a strike's path needs when the arm delivers its commands. Beside it is what the
//! world's effects make of the command that was sent. Targets from where strikes stop carry what the slide does otherwise, too: on
//! the real strikes a map of them predicts held-out stops better than one of speeds seen right after the impact.

use serde::{Deserialize, Serialize};
use stage::{ItemStage, Progress};
use values::{Command, Conditions, Point, Rig, Strike};
use world::{AsCommanded, Simulator, SolveSettings, SolveStatus, World, WorldError};

use crate::wrap;

/// The stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Launches {}

/// What every strike is seen from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shared {
    /// The set-up.
    pub rig: Rig,
    /// The world.
    pub world: World,
}

/// The part of a strike that shows its launch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LaunchItem {
    /// Where the object rested, in m.
    pub initial: Point,
    /// Where it came to rest, in m.
    pub stop: Point,
    /// What was commanded.
    pub command: Command,
    /// When and in which session.
    pub conditions: Conditions,
}

impl From<&Strike> for LaunchItem {
    fn from(strike: &Strike) -> Self {
        Self {
            initial: strike.initial,
            stop: strike.stop,
            command: strike.command,
            conditions: strike.conditions.clone(),
        }
    }
}

/// What a strike's path needs beside what the world says is delivered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaunchResidual {
    /// Logarithm of the factor on the speed.
    pub speed: f64,
    /// Added to the angle, in rad, in (−π, π].
    pub angle: f64,
}

impl ItemStage for Launches {
    const NAME: &'static str = "launches";
    const VERSION: u32 = 3;
    type Shared = Shared;
    type Item = LaunchItem;
    /// None where no launch leads along the path, or as near to its end as repeats of a strike stop to one another.
    type Output = Option<LaunchResidual>;
    type Error = WorldError;

    fn run_items(
        &self,
        shared: &Shared,
        strikes: &[&LaunchItem],
        progress: &Progress,
    ) -> Result<Vec<Self::Output>, WorldError> {
        let world = Simulator::new(&shared.rig, &shared.world)?;
        let as_told = Simulator::new(&shared.rig, &shared.world)?
            .with_delivery(std::sync::Arc::new(AsCommanded));
        // Distance goes as speed squared, bearing as angle.
        let scatter = &shared.world.scatter;
        let repeats = (2.0 * scatter.speed).hypot(scatter.angle);
        Ok(as_told.map(strikes, |worker, strike| {
            let needed = worker.solve(
                strike.initial,
                strike.stop,
                &strike.conditions,
                &SolveSettings::default(),
                None,
            );
            let delivered = world.delivered(strike.command, strike.initial, &strike.conditions);
            progress.inc(1);
            // A path that bends a little further than the world's tip holds a box: without its strike a map would learn nothing of
            // the commands that led there. The nearest launch is all that it could deliver.
            let distance = strike.initial.distance(strike.stop);
            let is_near = needed.miss <= repeats * distance;
            let is_told =
                (needed.status == SolveStatus::Solved || is_near) && delivered.speed > 0.0;
            is_told.then(|| LaunchResidual {
                speed: (needed.command.speed / delivered.speed).ln(),
                angle: wrap(needed.command.angle - delivered.angle),
            })
        }))
    }
}

#[cfg(test)]
mod tests {
    use values::Shape;
    use world::{AddedEffect, Estimate};

    use super::*;

    /// A strike of the world without effects, whose arm delivers `delivered` when commanded `command`.
    fn struck(command: Command, delivered: Command) -> LaunchItem {
        let rig = Rig::demo(Shape::Cylinder);
        let simulator = Simulator::new(&rig, &World::nominal(&rig)).expect("valid");
        let (initial, conditions) = (Point::new(0.3, 0.0), Conditions::default());
        let stop = simulator
            .worker()
            .strike(initial, delivered, &conditions)
            .expect("rests")
            .stop;
        LaunchItem {
            initial,
            stop,
            command,
            conditions,
        }
    }

    fn residual_of(world: World, strike: &LaunchItem) -> LaunchResidual {
        let rig = Rig::demo(Shape::Cylinder);
        let answer = Launches {}
            .run_items(&Shared { rig, world }, &[strike], &Progress::hidden())
            .expect("valid");
        answer[0].expect("within reach")
    }

    fn command(speed: f64, angle: f64) -> Command {
        Command { speed, angle }
    }

    #[test]
    fn it_is_what_the_arm_delivered_beside_the_command() {
        let strike = struck(command(0.7, 0.1), command(0.7 * 0.9, 0.13));
        let world = World::nominal(&Rig::demo(Shape::Cylinder));
        let residual = residual_of(world, &strike);
        assert!((residual.speed - 0.9f64.ln()).abs() < 2e-3, "{residual:?}");
        assert!((residual.angle - 0.03).abs() < 2e-3, "{residual:?}");
    }

    #[test]
    fn a_strike_a_little_beyond_every_launch_is_the_nearest_one_if_repeats_scatter_so() {
        let rig = Rig::demo(Shape::Box);
        let mut world = World::nominal(&rig).with("tip_friction", 0.3);
        let initial = Point::new(0.3, 0.0);
        // A tip of that friction sends a box 0.29 rad aside at the most.
        let item = |bearing: f64| LaunchItem {
            initial,
            stop: initial + Point::polar(0.3, bearing),
            command: command(0.8, bearing),
            conditions: Conditions::default(),
        };
        let residual_of = |world: &World, strike: &LaunchItem| {
            let shared = Shared {
                rig: rig.clone(),
                world: world.clone(),
            };
            let answer = Launches {}.run_items(&shared, &[strike], &Progress::hidden());
            answer.expect("valid")[0]
        };
        assert!(residual_of(&world, &item(0.2)).is_some());
        (world.scatter.speed, world.scatter.angle) = (0.02, 0.01);
        assert_eq!(residual_of(&world, &item(0.37)), None);
        world.scatter.speed = 0.06;
        let strike = item(0.37);
        let nearest = residual_of(&world, &strike).expect("as near as repeats");
        let launch = Command {
            speed: strike.command.speed * nearest.speed.exp(),
            angle: strike.command.angle + nearest.angle,
        };
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let simulated = simulator
            .worker()
            .strike(initial, launch, &strike.conditions)
            .expect("rests");
        let miss = simulated.stop.distance(strike.stop);
        assert!(miss > 1e-3 && miss < 0.3 * 0.12f64.hypot(0.01), "{miss}");
        assert_eq!(residual_of(&world, &item(0.6)), None);
    }

    #[test]
    fn what_an_effect_explains_is_no_residual_even_beyond_a_cap() {
        let mut world = World::nominal(&Rig::demo(Shape::Cylinder));
        world.effects.push(AddedEffect {
            name: "striker_speed_error".into(),
            parameters: [("cap".to_string(), Estimate::fixed(0.6))].into(),
        });
        // The arm delivers a little more than the cap: no command reaches that path through it, and it has a residual all the same.
        let strike = struck(command(0.9, 0.1), command(0.63, 0.1));
        let residual = residual_of(world, &strike);
        assert!((residual.speed - 1.05f64.ln()).abs() < 2e-3, "{residual:?}");
    }
}
