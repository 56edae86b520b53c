//! The inverse for every strike: which command the world would give for the path that the object took (paper,
//! algorithm 1, section 3.4).
//!
//! Each item is solved from the same first guess, whatever was solved before it, so that threads, order and what the cache
//! holds change no bit. A path that the world cannot reach is a row with its status, not a failure.

use serde::{Deserialize, Serialize};
use stage::{ItemStage, Progress};
use values::{Conditions, Point, Rig, Strike};
use world::{Simulator, Solution, SolveSettings, World, WorldError};

/// The stage and its settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Solve {
    /// When a solve ends.
    pub settings: SolveSettings,
}

/// What every path is solved in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shared {
    /// The set-up.
    pub rig: Rig,
    /// The identified world.
    pub world: World,
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
    /// When and in which session.
    pub conditions: Conditions,
}

impl From<&Strike> for Path {
    fn from(strike: &Strike) -> Self {
        Self {
            strike_id: strike.id.clone(),
            initial: strike.initial,
            target: strike.stop,
            conditions: strike.conditions.clone(),
        }
    }
}

/// Why nothing was solved. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum SolveError {
    /// The world does not compile for the rig.
    #[error("solve in the identified world: {0}")]
    World(#[from] WorldError),
}

impl ItemStage for Solve {
    const NAME: &'static str = "solve";
    const VERSION: u32 = 6;
    type Shared = Shared;
    type Item = Path;
    type Output = Solution;
    type Error = SolveError;

    fn run_items(
        &self,
        shared: &Shared,
        items: &[&Path],
        progress: &Progress,
    ) -> Result<Vec<Solution>, SolveError> {
        let simulator = Simulator::new(&shared.rig, &shared.world)?;
        Ok(simulator.map(items, |worker, path| {
            let solution = worker.solve(
                path.initial,
                path.target,
                &path.conditions,
                &self.settings,
                None,
            );
            progress.inc(1);
            solution
        }))
    }
}

#[cfg(test)]
mod tests {
    use rayon::ThreadPoolBuilder;
    use values::Shape;
    use world::SolveStatus;

    use super::*;

    fn shared() -> Shared {
        let rig = Rig::demo(Shape::Cylinder);
        let world = World::nominal(&rig).with("friction", 0.25);
        Shared { rig, world }
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
                    conditions: Conditions::default(),
                }
            })
            .collect()
    }

    fn solve(paths: &[Path], threads: usize) -> Vec<Solution> {
        let items: Vec<&Path> = paths.iter().collect();
        ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool")
            .install(|| Solve::default().run_items(&shared(), &items, &Progress::hidden()))
            .expect("solves")
    }

    #[test]
    fn every_reachable_path_is_solved_within_a_millimetre_in_about_one_simulation() {
        let solutions = solve(&paths(60), 2);
        let evaluations: u32 = solutions.iter().map(|s| s.evaluations).sum();
        assert!(
            solutions
                .iter()
                .all(|s| s.status == SolveStatus::Solved && s.miss < 1e-3)
        );
        assert!(f64::from(evaluations) / 60.0 <= 1.05, "{evaluations}");
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
            .items(&Solve::default(), &shared(), &paths[..10])
            .expect("solves");
        drop(first);
        let second = stage::Run::open(dir.path(), options).expect("a run");
        let all = second
            .items(&Solve::default(), &shared(), &paths)
            .expect("solves");
        assert_eq!(&all[..10], &ten[..]);
        let summary = second.summary();
        assert_eq!(
            (summary.stages[0].computed, summary.stages[0].reused),
            (2, 10)
        );
    }
}
