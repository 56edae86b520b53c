//! What a residual adds to a plan, and how far it may.

use store::network::{LAYERS, Layer, SIZES};
use store::{Artifact, Model, Network, TrainingExtent};
use strike::{Planner, Reason};
use values::{Command, Conditions, Point};
use world::Simulator;

use crate::fixture::{self, FROM, TO, plan, refusal};

#[test]
fn a_residual_makes_good_what_the_arm_delivers_otherwise_and_a_model_without_one_does_not() {
    let artifact = fixture::artifact();
    // An arm that delivers less than it is commanded, and turned: just what this residual has learnt to add.
    let [slower, turned] = fixture::SYSID_RESIDUAL;
    let simulator = Simulator::new(&artifact.rig, &artifact.sysid.world).unwrap();
    let miss = |model: Model| {
        let plan = plan(model);
        let delivered = Command::new(plan.speed - slower, plan.angle - turned);
        let mut worker = simulator.worker();
        let struck = worker.strike(FROM, delivered, &Conditions::default());
        struck.unwrap().stop.distance(TO)
    };
    assert!(miss(Model::SysidResidual) < 1e-3);
    assert!(miss(Model::Sysid) > 0.03);
}

/// A network that answers with `share` of one of its inputs, as speed and as angle.
fn reads(input: usize, share: f32) -> Network {
    let mut layers: Vec<Layer> = (0..LAYERS)
        .map(|layer| Layer {
            weight: vec![0.0; SIZES[layer] * SIZES[layer + 1]],
            bias: vec![0.0; SIZES[layer + 1]],
        })
        .collect();
    // The first unit carries the input, the second its negative: rectifiers pass one of the two.
    layers[0].weight[input] = 1.0;
    layers[0].weight[SIZES[0] + input] = -1.0;
    for layer in 1..LAYERS - 1 {
        layers[layer].weight[0] = 1.0;
        layers[layer].weight[SIZES[layer] + 1] = 1.0;
    }
    let width = SIZES[LAYERS - 1];
    for output in 0..SIZES[LAYERS] {
        layers[LAYERS - 1].weight[output * width] = share;
        layers[LAYERS - 1].weight[output * width + 1] = -share;
    }
    Network::new(layers).unwrap()
}

#[test]
fn a_residual_is_asked_about_the_path_and_the_simulated_command() {
    const SHARE: f64 = 1.0 / 64.0;
    let mut artifact = fixture::artifact();
    for (input, expected) in [
        (0, TO.x - FROM.x),
        (1, TO.y - FROM.y),
        (2, plan(Model::Sysid).speed),
        (3, plan(Model::Sysid).angle),
    ] {
        artifact.sysid.residual = Some(reads(input, SHARE as f32).into());
        let planner = Planner::new(&artifact, Model::SysidResidual).unwrap();
        let plan = planner.plan(FROM, TO).unwrap();
        for added in [plan.d_speed, plan.d_angle] {
            assert!((added - SHARE * expected).abs() < 1e-9, "{input}: {added}");
        }
    }
}

#[test]
fn a_residual_that_moves_the_stop_farther_than_it_was_trained_to_is_refused() {
    let mut artifact = fixture::artifact();
    // Within the arm's limits, and 0.1 m beyond the target.
    artifact.sysid.residual = Some(fixture::constant([0.2, 0.0]).into());
    let to = Point::new(0.48, 0.08);
    let refused = |artifact: &Artifact| refusal(artifact, Model::SysidResidual, FROM, to);
    let answer = refused(&artifact);
    assert_eq!(answer.refused, Reason::ResidualTooLarge, "{answer}");
    assert!(answer.detail.contains("mm from `to`"), "{answer}");
    artifact.sysid.residual = Some(fixture::constant([0.28, 0.5]).into());
    assert_eq!(refused(&artifact).refused, Reason::ResidualTooLarge);
    // Where nobody measured the world alone, a tenth of the path is the most.
    artifact.manifest.provenance.metrics.clear();
    artifact.sysid.residual = Some(fixture::constant(fixture::SYSID_RESIDUAL).into());
    assert_eq!(refused(&artifact).refused, Reason::ResidualTooLarge);
}

/// What sysid's residual learnt: it adds about [`fixture::SYSID_RESIDUAL`], and moves a stop by this share of its path at most.
fn explained(artifact: &mut Artifact, displacement: f64) {
    let [d_speed, d_angle] = fixture::SYSID_RESIDUAL;
    let about = |value: f64, by: f64| [value - by, value + by].into();
    let explained = TrainingExtent {
        strikes: 80,
        d_speed: about(d_speed, 0.02),
        d_angle: about(d_angle, 0.02),
        displacement,
        miss: 0.02,
        miss_p95: 0.05,
        calibration: 1.0,
    };
    let known = &mut artifact.manifest.provenance.explained;
    known.insert(Model::SysidResidual, explained);
}

#[test]
fn forged_weights_are_refused_by_what_the_residuals_training_explains() {
    let mut artifact = fixture::artifact();
    let to = Point::new(0.48, 0.08);
    let plan = |artifact: &Artifact| {
        let planner = Planner::new(artifact, Model::SysidResidual).unwrap();
        planner.plan(FROM, to)
    };
    // The world's held-out misses, doubled, allow 80 mm; the training says how much of this path it is.
    for (displacement, is_planned) in [(0.4, true), (0.05, false)] {
        explained(&mut artifact, displacement);
        let answer = plan(&artifact);
        if let Ok(plan) = &answer {
            // What to expect is what its training missed by, on as many strikes.
            let miss = plan.expected_miss.expect("known");
            let learnt = 0.02 * to.distance(FROM) * (4.0 / std::f64::consts::PI).sqrt();
            assert!(miss > learnt && miss < 1.2 * learnt, "{miss} {learnt}");
            assert_eq!(plan.expected_miss_strikes, Some(80));
        }
        assert_eq!(answer.is_ok(), is_planned, "{displacement}: {answer:?}");
        if let Err(refusal) = answer {
            let most = 1e3 * displacement * to.distance(FROM);
            assert_eq!(refusal.refused, Reason::ResidualTooLarge);
            assert!(
                refusal.detail.contains(&format!("the {most:.1} mm")),
                "{refusal}"
            );
        }
    }
    // Weights as they were forged before: within the arm's limits, and the object would leave the table.
    for (forged, displacement, said) in [
        ([0.28, 0.5], 0.4, "mm from `to`"),
        // However far the arm's strikes may stop from where the world says, the residual adds what it learnt.
        ([0.28, 0.5], 9.0, "adds +0.2800 m/s"),
        ([0.0625, 0.5], 9.0, "adds +0.5000 rad"),
        ([0.28, -0.03125], 9.0, "adds +0.2800 m/s"),
    ] {
        explained(&mut artifact, displacement);
        artifact.sysid.residual = Some(fixture::constant(forged).into());
        let refusal = plan(&artifact).expect_err("refused");
        assert_eq!(refusal.refused, Reason::ResidualTooLarge, "{refusal}");
        assert!(refusal.detail.contains(said), "{refusal}");
    }
}

#[test]
fn a_residual_that_moves_the_stop_off_the_table_is_refused() {
    let mut artifact = fixture::artifact();
    artifact.sysid.residual = Some(fixture::constant([0.0, 0.2]).into());
    let planner = Planner::new(&artifact, Model::SysidResidual).unwrap();
    let from = Point::new(0.3, 0.35);
    assert!(planner.plan(from, Point::new(0.6, 0.5)).is_ok());
    let answer = refusal(
        &artifact,
        Model::SysidResidual,
        from,
        Point::new(0.6, 0.548),
    );
    assert_eq!(answer.refused, Reason::ResidualTooLarge, "{answer}");
    assert!(answer.detail.contains("off the table"), "{answer}");
}
