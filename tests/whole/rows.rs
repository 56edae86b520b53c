//! A row that cannot be computed has its status, and the others are computed.

use judge::{Model, Path, Solve};
use stage::{ItemStage, Progress};
use values::{Command, Conditions, Point, Rig, Shape};
use world::SolveStatus::{Diverged, Solved, Unreachable};
use world::{AddedEffect, World};

/// A dome on whose side nothing comes to rest: MuJoCo's simulations of those rows diverge.
#[test]
fn a_path_on_which_nothing_rests_is_a_row_and_the_others_are_solved() {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal().with("friction", 0.25);
    let parameters = [("curvature", -0.3), ("center_x", 0.25), ("center_y", 0.0)];
    let dome = AddedEffect::fixed("table_bowl", &parameters);
    world.effects.push(dome);
    // Near its middle, beyond all reach, and on its side.
    let paths = [(0.25, 0.15), (0.25, 80.0), (1.25, 0.15), (0.25, 0.2)].map(|(x, length)| Path {
        strike_id: x.to_string(),
        initial: Point::new(x, 0.0),
        target: Point::new(x + length, 0.01),
        command: Command::new(0.7, 0.0),
        conditions: Conditions::default(),
    });
    let items: Vec<&Path> = paths.iter().collect();
    let solutions = Solve::default()
        .run_items(&Model::of_world(&rig, &world), &items, &Progress::hidden())
        .expect("a row each");
    let statuses: Vec<_> = solutions.iter().map(|row| row.solution.status).collect();
    assert_eq!(
        statuses,
        [Solved, Unreachable, Diverged, Solved],
        "{solutions:?}"
    );
    assert!(solutions[2].solution.miss.is_infinite());
}
