//! A box that does not stand straight when it is struck.

use values::{Command, Conditions, Point, Rig, Shape};
use world::{
    AddedEffect, Impact, Simulator, SolveSettings, SolveStatus, World, effects,
    launch::launches_about,
    planar::{Deviation, Planar, StrikeInput},
};

const START: Point = Point { x: 0.3, y: 0.05 };

/// Yaws in degrees, and offsets of the tip's line in m, all of which meet the struck face.
const YAWS: [f64; 5] = [-15.0, -6.0, 0.0, 4.0, 15.0];
const OFFSETS: [f64; 3] = [-0.006, 0.0, 0.008];

fn turned(yaw: f64) -> Conditions {
    Conditions {
        yaw: Some(yaw.to_radians()),
        ..Conditions::default()
    }
}

/// A world whose tip is led so far to the left of the object's centre.
fn world(offset: f64) -> World {
    let mut world = World::nominal()
        .with("friction", 0.22)
        .with("restitution", 0.5)
        .with("tip_friction", 0.7);
    world.effects.push(AddedEffect::fixed(
        "off_centre_contact",
        &[("offset", offset)],
    ));
    world
}

/// Velocity (of the tip's speed) and spin (rad/m) after an impact by Newton's restitution and Coulomb's friction, of a box that
/// stands straight, and where it is met: on its face towards −x.
fn rigid(rig: &Rig, angle: f64, offset: f64, restitution: f64, friction: f64) -> (Point, f64) {
    let [x, y] = rig.object.solid.half_sides().expect("a box");
    let gyration = (x * x + y * y) / 3.0;
    let met = offset / angle.cos() - (x + rig.striker.radius) * angle.tan();
    assert!(met.abs() < y, "the tip passes the face");
    let lever = (-met, -x);
    let (knn, knt, ktt) = (
        1.0 + lever.0 * lever.0 / gyration,
        lever.0 * lever.1 / gyration,
        1.0 + lever.1 * lever.1 / gyration,
    );
    let (normal, along) = ((1.0 + restitution) * angle.cos(), angle.sin());
    let determinant = knn * ktt - knt * knt;
    let mut pushed = (normal * ktt - along * knt) / determinant;
    let mut dragged = (along * knn - normal * knt) / determinant;
    if dragged.abs() > friction * pushed {
        let slope = friction.copysign(dragged);
        pushed = normal / (knn + slope * knt);
        dragged = slope * pushed;
    }
    let spin = (lever.0 * pushed + lever.1 * dragged) / gyration;
    (Point::new(pushed, dragged), spin)
}

#[test]
fn it_leaves_the_tip_as_from_a_rigid_impact_on_its_face() {
    let rig = Rig::demo(Shape::Box);
    let angle: f64 = 0.1;
    for offset in OFFSETS {
        // A table that brakes little while the impact lasts.
        let world = world(offset).with("friction", 0.02);
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let effects = effects_of(&rig, &world);
        let mut worker = simulator.worker();
        for yaw in YAWS {
            let command = Command { speed: 0.7, angle };
            let impact = Impact::of(&effects, 0.5, command, &turned(yaw));
            let release = worker.release(impact).expect("parts");
            // The release is given along the tip's motion, the formula along the box's edges.
            let onto_face = angle - yaw.to_radians();
            let (velocity, spin) = rigid(&rig, onto_face, offset, 0.5, 0.7);
            let velocity = velocity.rotated(-onto_face) * command.speed;
            let case = format!("{yaw}°, {offset} m");
            let faster = release.velocity.norm() / velocity.norm() - 1.0;
            assert!(faster.abs() < 4e-3, "{case}: speed {faster}");
            let aside = release.velocity.bearing() - velocity.bearing();
            assert!(aside.abs() < 1e-3, "{case}: bearing {aside}");
            let spun = release.spin - spin * command.speed;
            assert!(
                spun.abs() < 0.03 * (spin.abs() + 1.0),
                "{case}: spin {spun}"
            );
        }
    }
}

#[test]
fn a_box_that_stands_straight_leaves_the_tip_as_from_a_rigid_blow() {
    let rig = Rig::demo(Shape::Box);
    for (friction, speed, bearing) in [(0.7, 2e-3, 3e-4), (0.2, 1e-2, 3e-3)] {
        // A table that brakes little while the impact lasts.
        let world = World::nominal()
            .with("tip_friction", friction)
            .with("friction", 0.02);
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let mut worker = simulator.worker();
        for degrees in [-25, -8, 0, 5, 18, 25] {
            let angle = f64::from(degrees).to_radians();
            let command = Command { speed: 0.6, angle };
            let impact = Impact::of(&[], 0.5, command, &Conditions::default());
            let release = worker.release(impact).expect("parts");
            let (velocity, spin) = rigid(&rig, angle, 0.0, 0.5, friction);
            let case = format!("μ {friction}, {degrees}°");
            let off = release.velocity.norm() / (0.6 * velocity.norm()) - 1.0;
            assert!(off.abs() < speed, "{case}: speed {off}");
            let turned = release.velocity.bearing() - velocity.rotated(-angle).bearing();
            assert!(turned.abs() < bearing, "{case}: {turned}");
            let most = 0.025 * spin.abs() + 1e-6;
            assert!((release.spin / 0.6 - spin).abs() < most, "{case}: {spin}");
        }
    }
}

fn effects_of(rig: &Rig, world: &World) -> Vec<Box<dyn effects::Effect>> {
    let build = |added| effects::build(added, rig).expect("an effect of the library");
    world.effects.iter().map(build).collect()
}

#[test]
fn planar_form_follows_mujoco() {
    let rig = Rig::demo(Shape::Box);
    let times: Vec<f64> = (1..60).map(|i| f64::from(i) / rig.camera.rate).collect();
    for offset in OFFSETS {
        let world = world(offset);
        let effects = effects_of(&rig, &world);
        let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
        let simulator = Simulator::new(&rig, &world).expect("valid");
        let mut worker = simulator.worker();
        for (i, yaw) in (0..).zip(YAWS) {
            let command = Command::new(0.5 + 0.1 * f64::from(i), 0.1 - 0.05 * f64::from(i));
            let conditions = turned(yaw);
            let case = format!("{yaw}°, {offset} m");
            let impact = Impact::of(&effects, 0.5, command, &conditions);
            let launch = launches_about(&rig, &world, &[impact]).expect("valid")[0].expect("parts");
            let input = StrikeInput {
                initial: START,
                command,
                conditions: &conditions,
                times: &times,
                to_rest: true,
            };
            let of_planar = planar.release(&input, &launch);
            let of_mujoco = worker.release(impact).expect("parts");
            let velocity = of_mujoco.velocity.rotated(command.angle);
            assert!(of_planar.velocity.distance(velocity) < 1e-3, "{case}");
            assert!((of_planar.spin - of_mujoco.spin).abs() < 1e-2, "{case}");
            let frames = planar.strike(&input, &launch, &Deviation::default());
            let frames = frames.expect("rests");
            let simulated = worker.strike(START, command, &conditions).expect("rests");
            let apart = frames.stop.distance(simulated.stop);
            assert!(apart < 4e-4, "{case}: {apart} m");
            for (t, at) in times.iter().zip(&frames.at) {
                let apart = at.distance(simulated.at(*t));
                assert!(apart < 4e-4, "{case}: {apart} m at {t} s");
            }
        }
    }
}

#[test]
fn a_turned_box_on_a_turned_table_moves_as_a_straight_one() {
    let rig = Rig::demo(Shape::Box);
    let simulator = Simulator::new(&rig, &world(0.003)).expect("valid");
    let mut worker = simulator.worker();
    let mut path = |angle: f64, yaw: f64| {
        let command = Command { speed: 0.8, angle };
        let struck = worker.strike(START, command, &turned(yaw));
        struck.expect("rests").stop - START
    };
    let straight = path(0.15, 0.0);
    for yaw in [-170.0, -12.0, 9.0, 60.0] {
        let by = f64::to_radians(yaw);
        let apart = path(0.15 + by, yaw).distance(straight.rotated(by));
        assert!(apart < 5e-5, "{yaw}°: {apart} m");
    }
    // The same command at a box that is turned leads elsewhere.
    let apart = path(0.15, 15.0).distance(straight);
    assert!(apart > 0.005, "{apart} m");
}

#[test]
fn a_round_object_does_not_care() {
    let rig = Rig::demo(Shape::Cylinder);
    let simulator = Simulator::new(&rig, &world(0.003)).expect("valid");
    let command = Command::new(0.8, 0.15);
    let mut worker = simulator.worker();
    let straight = worker.strike(START, command, &Conditions::default());
    let turned = worker.strike(START, command, &turned(33.0));
    assert_eq!(turned.expect("rests"), straight.expect("rests"));
}

#[test]
fn a_strike_is_solved_for_the_yaw_that_the_box_has() {
    let rig = Rig::demo(Shape::Box);
    let simulator = Simulator::new(&rig, &world(0.0)).expect("valid");
    let mut worker = simulator.worker();
    let target = START + Point::polar(0.25, 0.1);
    let settings = SolveSettings::default();
    for yaw in [-12.0, 5.0, 12.0] {
        let conditions = turned(yaw);
        let solution = worker.solve(START, target, &conditions, &settings, None);
        assert_eq!(solution.status, SolveStatus::Solved, "{yaw}°");
        let struck = worker.strike(START, solution.command, &conditions);
        assert!(
            struck.expect("rests").stop.distance(target) < 1e-3,
            "{yaw}°"
        );
        let straight = worker.solve(START, target, &Conditions::default(), &settings, None);
        let missed = worker.strike(START, straight.command, &conditions);
        let missed = missed.expect("rests").stop.distance(target);
        assert!(missed > 0.002, "{yaw}°: {missed} m");
    }
}

#[test]
fn a_turned_camera_sees_the_box_turned() {
    let rig = Rig::demo(Shape::Box);
    let by: f64 = 0.05;
    let mut turned_camera = World::nominal();
    turned_camera
        .effects
        .push(AddedEffect::fixed("camera_rotation", &[("angle", by)]));
    let effects = effects_of(&rig, &turned_camera);
    let command = Command::new(0.8, 0.0);
    let impact = Impact::of(&effects, 0.5, command, &turned(10.0));
    assert!((impact.yaw - (10f64.to_radians() - by)).abs() < 1e-12);
    // A box whose yaw was not tracked stands straight on the table, whatever the camera.
    let untracked = Impact::of(&effects, 0.5, command, &Conditions::default());
    assert_eq!(untracked.yaw, 0.0);
}
