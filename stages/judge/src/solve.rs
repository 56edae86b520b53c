//! The inverse for every strike: which command the world would give for the path that the object took (paper,
//! algorithm 1, section 3.4), and which launch that is beside what the arm delivered.
//!
//! Each item is solved from the same first guess, whatever was solved before it, so that threads, order and what the cache
//! holds change no bit. A path that the world cannot reach is a row with its status, not a failure.
//!
//! A launch map learns from launches. Targets from where strikes stop carry what the slide does otherwise, too: on the real strikes a map
//! of them predicts held-out stops better than one of speeds seen right after the impact.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use stage::{ItemStage, Progress};
use values::{Command, Conditions, LaunchResidual, Point, Strike, wrap_angle};
use world::{AsCommanded, Scatter, Simulator, Solution, SolveSettings, SolveStatus};

use crate::{JudgeError, Model};

/// The stage and its settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Solve {
    /// When a solve ends.
    pub settings: SolveSettings,
}

/// One path to solve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Path {
    /// The strike that took it.
    pub strike_id: String,
    /// Where the object rested, in m.
    pub initial: Point,
    /// Where it came to rest, in m.
    pub target: Point,
    /// What was commanded.
    pub command: Command,
    /// When and in which session.
    pub conditions: Conditions,
}

/// What a path needs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solved {
    /// The command that the world needs for the path.
    pub solution: Solution,
    /// The launch that it needs beside the one that the world's effects make of the command that was sent. None where no launch leads
    /// along it, or as near to its end as repeats of a strike stop to one another.
    pub launch: Option<LaunchResidual>,
}

impl From<&Strike> for Path {
    fn from(strike: &Strike) -> Self {
        Self {
            strike_id: strike.id.clone(),
            initial: strike.initial,
            target: strike.stop,
            command: strike.command,
            conditions: strike.conditions.clone(),
        }
    }
}

impl ItemStage for Solve {
    const NAME: &'static str = "solve";
    const VERSION: u32 = 8;
    /// The model; only its world alone is used.
    type Shared = Model;
    type Item = Path;
    type Output = Solved;
    type Error = JudgeError;

    fn run_items(
        &self,
        model: &Model,
        paths: &[&Path],
        progress: &Progress,
    ) -> Result<Vec<Solved>, JudgeError> {
        let world = Simulator::new(&model.rig, &model.world)?;
        let solutions = self.solve(&world, paths, || progress.inc(1));
        let is_solved = |solution: &Solution| solution.status == SolveStatus::Solved;
        let beyond: Vec<&Path> = paths
            .iter()
            .zip(&solutions)
            .filter(|(_, solution)| !is_solved(solution))
            .map(|(path, _)| *path)
            .collect();
        // What no command leads to through the world's arm, such as one whose speed has a cap, a launch may.
        let as_told = match beyond[..] {
            [] => None,
            _ => {
                Some(Simulator::new(&model.rig, &model.world)?.with_delivery(Arc::new(AsCommanded)))
            }
        };
        let mut launches = as_told.iter().flat_map(|as_told| {
            let needed = self.solve(as_told, &beyond, || {});
            needed.into_iter().zip(&beyond).map(|(needed, path)| {
                let is_near =
                    is_solved(&needed) || needed.miss <= repeats(&model.world.scatter, path);
                is_near.then(|| as_told.delivered(needed.command, path.initial, &path.conditions))
            })
        });
        Ok(paths
            .iter()
            .zip(solutions)
            .map(|(path, solution)| {
                let deliver = |command| world.delivered(command, path.initial, &path.conditions);
                let launch = if is_solved(&solution) {
                    Some(deliver(solution.command))
                } else {
                    launches.next().flatten()
                };
                let launch = launch.and_then(|needed| beside(needed, deliver(path.command)));
                Solved { solution, launch }
            })
            .collect())
    }
}

impl Solve {
    fn solve(
        &self,
        simulator: &Simulator,
        paths: &[&Path],
        on_solved: impl Fn() + Sync,
    ) -> Vec<Solution> {
        simulator.map(paths, |worker, path| {
            let (from, to) = (path.initial, path.target);
            let solution = worker.solve(from, to, &path.conditions, &self.settings, None);
            on_solved();
            solution
        })
    }
}

/// Root mean square distance of repeats' stops from one another, in m: distance goes as speed squared, bearing as angle. A path that bends a little
/// further than the world's tip holds a box is as good as reached: without its strike a map would learn nothing of the commands that led there.
fn repeats(scatter: &Scatter, path: &Path) -> f64 {
    (2.0 * scatter.speed).hypot(scatter.angle) * path.initial.distance(path.target)
}

/// A launch beside another; none beside one that does not move.
fn beside(needed: Command, delivered: Command) -> Option<LaunchResidual> {
    (delivered.speed > 0.0).then(|| LaunchResidual {
        speed: (needed.speed / delivered.speed).ln(),
        angle: wrap_angle(needed.angle - delivered.angle),
    })
}

#[cfg(test)]
mod tests {
    use rayon::ThreadPoolBuilder;
    use values::{Rig, Shape};
    use world::{AddedEffect, World};

    use super::*;

    fn model() -> Model {
        let rig = Rig::demo(Shape::Cylinder);
        let world = World::nominal().with("friction", 0.25);
        Model::of_world(&rig, &world)
    }

    /// Paths of 5 to 50 cm in all directions before the robot.
    fn paths(count: u32) -> Vec<Path> {
        (0..count)
            .map(|i| {
                let share = f64::from(i) / f64::from(count);
                let initial = Point::new(0.25, 0.1 * share);
                let bearing = 0.8 * (12.0 * share).sin();
                Path {
                    strike_id: i.to_string(),
                    initial,
                    target: initial + Point::polar(0.05 + 0.45 * share, bearing),
                    command: command(0.7, bearing),
                    conditions: Conditions::default(),
                }
            })
            .collect()
    }

    fn command(speed: f64, angle: f64) -> Command {
        Command { speed, angle }
    }

    fn solve(paths: &[Path], threads: usize) -> Vec<Solution> {
        let items: Vec<&Path> = paths.iter().collect();
        ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool")
            .install(|| Solve::default().run_items(&model(), &items, &Progress::hidden()))
            .expect("solves")
            .into_iter()
            .map(|solved| solved.solution)
            .collect()
    }

    #[test]
    fn the_number_of_threads_and_the_order_change_no_bit() {
        let mut paths = paths(24);
        let one = solve(&paths, 1);
        assert_eq!(one, solve(&paths, 2));
        paths.reverse();
        let mut reversed = solve(&paths, 2);
        reversed.reverse();
        assert_eq!(one, reversed);
    }

    #[test]
    fn an_unreachable_path_is_a_row_with_its_status() {
        let mut paths = paths(2);
        paths[1].target = Point::new(80.0, 0.0);
        let solutions = solve(&paths, 1);
        assert_eq!(solutions[0].status, SolveStatus::Solved);
        assert_eq!(solutions[1].status, SolveStatus::Unreachable);
        assert!(solutions[1].miss > 1.0);
    }

    #[test]
    fn in_a_run_only_paths_that_are_new_are_solved() {
        let dir = tempfile::tempdir().expect("folder");
        let options = stage::Options {
            engine: "test".into(),
            is_quiet: true,
        };
        let paths = paths(12);
        let first = stage::Run::open(dir.path(), options.clone()).expect("a run");
        let ten = first
            .items(&Solve::default(), &model(), &paths[..10])
            .expect("solves");
        drop(first);
        let second = stage::Run::open(dir.path(), options).expect("a run");
        let all = second
            .items(&Solve::default(), &model(), &paths)
            .expect("solves");
        assert_eq!(&all[..10], &ten[..]);
        let summary = second.summary();
        assert_eq!(
            (summary.stages[0].computed, summary.stages[0].reused),
            (2, 10)
        );
    }

    /// A strike of the world without effects, whose arm delivers `delivered` when commanded `command`.
    fn struck(command: Command, delivered: Command) -> Path {
        let rig = Rig::demo(Shape::Cylinder);
        let simulator = Simulator::new(&rig, &World::nominal()).expect("valid");
        let (initial, conditions) = (Point::new(0.3, 0.0), Conditions::default());
        let stop = simulator
            .worker()
            .strike(initial, delivered, &conditions)
            .expect("rests")
            .stop;
        Path {
            strike_id: String::new(),
            initial,
            target: stop,
            command,
            conditions,
        }
    }

    fn launch(rig: &Rig, world: &World, strike: &Path) -> Option<LaunchResidual> {
        let model = Model::of_world(rig, world);
        let answer = Solve::default().run_items(&model, &[strike], &Progress::hidden());
        answer.expect("valid")[0].launch
    }

    fn residual_of(world: World, strike: &Path) -> LaunchResidual {
        let rig = Rig::demo(Shape::Cylinder);
        launch(&rig, &world, strike).expect("within reach")
    }

    #[test]
    fn it_is_what_the_arm_delivered_beside_the_command() {
        let strike = struck(command(0.7, 0.1), command(0.7 * 0.9, 0.13));
        let world = World::nominal();
        let residual = residual_of(world, &strike);
        assert!((residual.speed - 0.9f64.ln()).abs() < 2e-3, "{residual:?}");
        assert!((residual.angle - 0.03).abs() < 2e-3, "{residual:?}");
    }

    #[test]
    fn a_strike_a_little_beyond_every_launch_is_the_nearest_one_if_repeats_scatter_so() {
        let rig = Rig::demo(Shape::Box);
        let mut world = World::nominal().with("tip_friction", 0.3);
        let initial = Point::new(0.3, 0.0);
        // A tip of that friction sends a box 0.29 rad aside at the most.
        let item = |bearing: f64| Path {
            strike_id: String::new(),
            initial,
            target: initial + Point::polar(0.3, bearing),
            command: command(0.8, bearing),
            conditions: Conditions::default(),
        };
        let residual_of = |world: &World, strike: &Path| launch(&rig, world, strike);
        assert!(residual_of(&world, &item(0.2)).is_some());
        (world.scatter.speed, world.scatter.angle) = (0.02, 0.01);
        assert_eq!(residual_of(&world, &item(0.37)), None);
        world.scatter.speed = 0.06;
        let strike = item(0.37);
        let nearest = residual_of(&world, &strike).expect("as near as repeats");
        let launch = Command::new(
            strike.command.speed * nearest.speed.exp(),
            strike.command.angle + nearest.angle,
        );
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let simulated = simulator
            .worker()
            .strike(initial, launch, &strike.conditions)
            .expect("rests");
        let miss = simulated.stop.distance(strike.target);
        assert!(miss > 1e-3 && miss < 0.3 * 0.12f64.hypot(0.01), "{miss}");
        assert_eq!(residual_of(&world, &item(0.6)), None);
    }

    #[test]
    fn what_an_effect_explains_is_no_residual_even_beyond_a_cap() {
        let mut world = World::nominal();
        world
            .effects
            .push(AddedEffect::fixed("striker_speed_error", &[("cap", 0.6)]));
        // The arm delivers a little more than the cap: no command reaches that path through it, and it has a residual all the same.
        let strike = struck(command(0.9, 0.1), command(0.63, 0.1));
        let residual = residual_of(world, &strike);
        assert!((residual.speed - 1.05f64.ln()).abs() < 2e-3, "{residual:?}");
    }
}
