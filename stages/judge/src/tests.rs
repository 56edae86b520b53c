//! Models whose errors are known.

use stage::{Options, Run};
use store::network::{LAYERS, Layer, Network, SIZES};
use store::{Networks, ResidualModel};
use values::{Command, Conditions, Point, Rig, Shape, Split, Strike};
use world::{AddedEffect, Simulator, SolveSettings, SolveStatus, World};

use crate::{Candidate, Evaluation, HeldOut, Model, Noise, PredictionStatus, evaluate, predict};

/// Δv = 0.02 + 0.10·v_sim, Δθ = −0.05 + 0.15·path_x: large beside real residuals.
fn residual() -> Networks {
    let mut layers: Vec<Layer> = (0..LAYERS)
        .map(|i| Layer {
            weight: vec![0.0; SIZES[i] * SIZES[i + 1]],
            bias: vec![0.0; SIZES[i + 1]],
        })
        .collect();
    // Unit 0 carries v_sim, unit 1 path_x; both are positive, so that ReLU passes them.
    layers[0].weight[2] = 1.0;
    layers[0].weight[SIZES[0]] = 1.0;
    for index in 1..LAYERS {
        layers[index].weight[0] = 1.0;
        layers[index].weight[SIZES[index] + 1] = 1.0;
    }
    layers[3].weight[0] = 0.10;
    layers[3].weight[SIZES[3] + 1] = 0.15;
    layers[3].bias = vec![0.02, -0.05];
    let network = Network::new(layers).expect("shapes are right");
    Networks::new(vec![network]).expect("one")
}

fn strike(index: u32, command: Command, initial: Point, stop: Point, split: Split) -> Strike {
    Strike {
        id: format!("strike{index}"),
        log: "a.mcap".into(),
        index,
        split,
        ..Strike::bare(command, initial, stop)
    }
}

/// Strikes that the world with the residual plans, and that stop where they are meant to. Bearings stay where the tip
/// does not slip along a box's face.
fn planned(rig: &Rig, world: &World) -> Vec<Strike> {
    let simulator = Simulator::new(rig, world).expect("a world");
    let mut worker = simulator.worker();
    let network = residual();
    (0..12)
        .map(|index| {
            let initial = Point::new(0.30, 0.02 * f64::from(index) - 0.1);
            let path = Point::polar(
                0.10 + 0.03 * f64::from(index),
                0.06 * f64::from(index) - 0.3,
            );
            let solution = worker.solve(
                initial,
                initial + path,
                &Conditions::default(),
                &SolveSettings::default(),
                None,
            );
            assert_eq!(solution.status, SolveStatus::Solved);
            let sim = solution.command;
            let [d_speed, d_angle] = network.predict([path.x, path.y, sim.speed, sim.angle]);
            let command = Command::new(sim.speed + d_speed, sim.angle + d_angle);
            let split = if index % 3 == 0 {
                Split::Test
            } else {
                Split::Train
            };
            strike(index as u32, command, initial, initial + path, split)
        })
        .collect()
}

#[test]
fn predicting_a_planned_command_gives_the_path_it_was_planned_for() {
    for shape in [Shape::Cylinder, Shape::Box] {
        let rig = Rig::demo(shape);
        let world = World::nominal();
        let strikes = planned(&rig, &world);
        let simulator = Simulator::new(&rig, &world).expect("a world");
        let mut worker = simulator.worker();
        for strike in &strikes {
            let predicted = predict(&mut worker, Some(&residual()), &strike.into());
            assert_eq!(
                predicted.status,
                PredictionStatus::Converged,
                "{}",
                strike.id
            );
            let miss = predicted.stop.expect("a stop").distance(strike.stop);
            assert!(miss < 1e-3, "{}: {miss} m", strike.id);
            assert!(
                predicted.evaluations <= 4,
                "{}: {} simulations",
                strike.id,
                predicted.evaluations
            );
        }
    }
}

fn run() -> (tempfile::TempDir, Run) {
    let dir = tempfile::tempdir().expect("folder");
    let options = Options {
        is_quiet: true,
        ..Options::default()
    };
    let run = Run::open(dir.path(), options).expect("free");
    (dir, run)
}

/// Three models on strikes, with so many threads.
fn evaluated(threads: usize, judges: impl Fn(&Strike) -> bool) -> Evaluation {
    let rig = Rig::demo(Shape::Cylinder);
    let world = World::nominal();
    let candidate = |name: &str, world: &World, residual: Option<Networks>| Candidate {
        name: name.into(),
        model: Model {
            residual: residual.map(ResidualModel::Networks),
            ..Model::of_world(&rig, world)
        },
    };
    let candidates = [
        candidate("nominal", &world.clone().with("friction", 0.25), None),
        candidate("sysid", &world, None),
        candidate("sysid_residual", &world, Some(residual())),
    ];
    let strikes = planned(&rig, &world);
    let strikes: Vec<HeldOut> = strikes
        .iter()
        .filter(|strike| judges(strike))
        .map(HeldOut::from)
        .collect();
    let noise = Noise {
        speed: 0.01,
        angle: 0.005,
        position: 0.0002,
        measured: None,
        sessions: 0.0,
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    let (_dir, run) = run();
    pool.install(|| evaluate(&run, &candidates, &strikes, &noise))
        .expect("sound input")
}

fn is_test(strike: &Strike) -> bool {
    strike.split == Split::Test
}

#[test]
fn the_better_model_has_the_smaller_error_on_held_out_strikes() {
    let evaluation = evaluated(1, is_test);
    let error = |model: &str| evaluation.models[model];
    assert_eq!(error("sysid").n, 4);
    assert_eq!(evaluation.predictions.len(), 3 * 4);
    assert!(error("nominal").mean > error("sysid").mean);
    assert!(error("sysid").mean > 20.0 * error("sysid_residual").mean);
    assert_eq!(evaluated(1, |_| true).models["sysid"].n, 12);
}

#[test]
fn the_noise_floor_is_what_the_scatter_of_the_launch_makes() {
    let evaluation = evaluated(1, is_test);
    let floor = evaluation.noise_floor.expect("strikes");
    assert_eq!((floor.n, floor.failed), (4, 0));
    // Distance goes as speed squared: 1 % of speed is 2 % of the mean path of about 0.24 m, half-normally
    // distributed; angle and camera add a little.
    assert!((0.003..0.006).contains(&floor.mean), "{floor:?}");
    assert!(
        floor.median < floor.mean && floor.mean < floor.p95,
        "{floor:?}"
    );
}

#[test]
fn the_same_bytes_with_one_thread_and_with_two() {
    let text = |evaluation: &Evaluation| serde_json::to_string(evaluation).expect("plain data");
    let one = evaluated(1, |_| true);
    assert_eq!(text(&one), text(&evaluated(2, |_| true)));
    let read: Evaluation = serde_json::from_str(&text(&one)).expect("own text");
    assert_eq!(read.predictions.len(), one.predictions.len());
    assert_eq!(read.models["sysid_residual"].n, 12);
    let json: serde_json::Value = serde_json::from_str(&text(&one)).expect("own text");
    assert!(json["sysid_residual"]["p95"].is_number() && json["noise_floor"]["mean"].is_number());
}

#[test]
fn a_session_that_is_held_out_is_predicted_with_the_mean_of_the_others() {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal();
    world.effects.push(AddedEffect::fixed(
        "friction_by_session",
        &[("a", 0.2), ("b", -0.2), ("c", 0.0)],
    ));
    let simulator = Simulator::new(&rig, &world).expect("a world");
    let (initial, command) = (Point::new(0.3, 0.0), Command::new(0.8, 0.1));
    let strikes: Vec<Strike> = ["a", "b", "c"]
        .into_iter()
        .zip(0..)
        .map(|(session, index)| {
            let conditions = Conditions {
                session: session.into(),
                ..Conditions::default()
            };
            let struck = simulator.worker().strike(initial, command, &conditions);
            let stop = struck.expect("rests").stop;
            Strike {
                conditions,
                ..strike(index, command, initial, stop, Split::Test)
            }
        })
        .collect();
    let distance = |index: usize| strikes[index].stop.distance(initial);
    let [high, low, mean] = [distance(0), distance(1), distance(2)];
    let candidates = [Candidate {
        name: "effect".into(),
        model: Model::of_world(&rig, &world),
    }];
    let held_out: Vec<HeldOut> = strikes.iter().map(HeldOut::from).collect();
    let (_dir, run) = run();
    let evaluation = evaluate(&run, &candidates, &held_out, &Noise::default()).expect("judges");
    assert!(evaluation.models["effect"].mean < 1e-9);
    let new = evaluation.new_sessions.expect("three sessions");
    assert_eq!(new.sessions, 3);
    // Distance goes as one over friction: 0.9, 1.1 and 1 times the mean's, in place of 1.2, 0.8 and 1.
    let expected = [(mean / 0.9 - high).abs(), (low - mean / 1.1).abs(), 0.0];
    let expected = expected.iter().sum::<f64>() / 3.0;
    let found = new.models["effect"].mean;
    assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    // A model that has learnt the mean of all misses by less in them than in a new one: by √((1 + ⅓)/(1 − ⅓)) where that is all that it misses by.
    let mut together = candidates.clone();
    together[0].model.world = World::nominal().with("friction", 0.3);
    let known = evaluate(&run, &together, &held_out, &Noise::default()).expect("judges");
    let known = known.new_sessions.expect("three sessions").models["effect"];
    let noise = Noise {
        sessions: (1.5f64).sqrt() * known.mean.hypot(known.sd * (2.0f64 / 3.0).sqrt()),
        ..Noise::default()
    };
    let new = evaluate(&run, &together, &held_out, &noise).expect("judges");
    let new = new.new_sessions.expect("three sessions").models["effect"];
    let times = new.mean / known.mean;
    assert!((times - 2f64.sqrt()).abs() < 1e-9, "{times}");
    // Of one session alone there is nothing to hold out.
    let one = evaluate(&run, &candidates, &held_out[..1], &Noise::default()).expect("judges");
    assert_eq!(one.new_sessions, None);
}
