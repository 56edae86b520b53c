//! Models whose errors are known.

use stage::{Progress, Stage};
use store::network::{LAYERS, Layer, Network, SIZES};
use store::{Networks, ResidualModel};
use values::{Command, Conditions, Point, Rig, Shape, Split, Strike, Track};
use world::{AddedEffect, Estimate, Simulator, SolveSettings, SolveStatus, World};

use crate::{Candidate, Evaluate, Evaluation, Input, Noise, PredictionStatus, predict};

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
        t_start: 0.0,
        initial,
        stop,
        command,
        track: Track::default(),
        split,
        conditions: Conditions::default(),
        delivered: None,
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
            let command = Command {
                speed: sim.speed + d_speed,
                angle: sim.angle + d_angle,
            };
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
        let world = World::nominal(&rig);
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

fn evaluate(threads: usize, stage: Evaluate) -> Evaluation {
    let rig = Rig::demo(Shape::Cylinder);
    let world = World::nominal(&rig);
    let candidates = vec![
        Candidate {
            name: "nominal".into(),
            world: world.clone().with("friction", 0.25),
            residual: None,
        },
        Candidate {
            name: "sysid".into(),
            world: world.clone(),
            residual: None,
        },
        Candidate {
            name: "sysid_residual".into(),
            world: world.clone(),
            residual: Some(ResidualModel::Networks(residual())),
        },
    ];
    let strikes = planned(&rig, &world);
    let noise = Noise {
        speed: 0.01,
        angle: 0.005,
        position: 0.0002,
    };
    let input = Input {
        rig,
        strikes,
        candidates,
        noise,
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("threads");
    pool.install(|| stage.run(&input, &Progress::hidden()))
        .expect("sound input")
}

#[test]
fn the_better_model_has_the_smaller_error_on_held_out_strikes() {
    let evaluation = evaluate(1, Evaluate::default());
    let error = |model: &str| evaluation.models[model];
    assert_eq!(error("sysid").n, 4);
    assert_eq!(evaluation.predictions.len(), 3 * 4);
    assert!(error("nominal").mean > error("sysid").mean);
    assert!(error("sysid").mean > 20.0 * error("sysid_residual").mean);
    assert_eq!(evaluate(1, Evaluate { split: None }).models["sysid"].n, 12);
}

#[test]
fn the_noise_floor_is_what_the_scatter_of_the_launch_makes() {
    let evaluation = evaluate(1, Evaluate::default());
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
    let one = evaluate(1, Evaluate { split: None });
    assert_eq!(text(&one), text(&evaluate(2, Evaluate { split: None })));
    let read: Evaluation = serde_json::from_str(&text(&one)).expect("own text");
    assert_eq!(read.predictions.len(), one.predictions.len());
    assert_eq!(read.models["sysid_residual"].n, 12);
    let json: serde_json::Value = serde_json::from_str(&text(&one)).expect("own text");
    assert!(json["sysid_residual"]["p95"].is_number() && json["noise_floor"]["mean"].is_number());
}

#[test]
fn a_session_that_is_held_out_is_predicted_with_the_mean_of_the_others() {
    let rig = Rig::demo(Shape::Cylinder);
    let mut world = World::nominal(&rig);
    world.effects.push(AddedEffect {
        name: "friction_by_session".into(),
        parameters: [("a", 0.2), ("b", -0.2), ("c", 0.0)]
            .map(|(name, value)| (name.to_string(), Estimate::fixed(value)))
            .into(),
    });
    let simulator = Simulator::new(&rig, &world).expect("a world");
    let (initial, command) = (
        Point::new(0.3, 0.0),
        Command {
            speed: 0.8,
            angle: 0.1,
        },
    );
    let strikes: Vec<Strike> = ["a", "b", "c"]
        .into_iter()
        .zip(0..)
        .map(|(session, index)| {
            let conditions = Conditions {
                session: session.into(),
                order: 0.0,
                yaw: None,
                moving: None,
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
    let input = Input {
        rig,
        strikes,
        candidates: vec![Candidate {
            name: "effect".into(),
            world,
            residual: None,
        }],
        noise: Noise::default(),
    };
    let evaluation = Evaluate::default()
        .run(&input, &Progress::hidden())
        .expect("judges");
    assert!(evaluation.models["effect"].mean < 1e-9);
    let new = evaluation.new_sessions.expect("three sessions");
    assert_eq!(new.sessions, 3);
    // Distance goes as one over friction: 0.9, 1.1 and 1 times the mean's, in place of 1.2, 0.8 and 1.
    let expected = [(mean / 0.9 - high).abs(), (low - mean / 1.1).abs(), 0.0];
    let expected = expected.iter().sum::<f64>() / 3.0;
    let found = new.models["effect"].mean;
    assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    // Of one session alone there is nothing to hold out.
    let one = Input {
        strikes: input.strikes[..1].to_vec(),
        ..input
    };
    let evaluation = Evaluate::default()
        .run(&one, &Progress::hidden())
        .expect("judges");
    assert_eq!(evaluation.new_sessions, None);
}
