use values::{Command, Conditions, Point, Rig, Shape, Strike, Track};

use super::*;
use crate::{AddedEffect, Simulator, World, launch::launches};

/// Strikes over the rig's speeds and angles, with frames to compare at.
fn strikes(rig: &Rig) -> Vec<Strike> {
    let times: Vec<f64> = (1..60).map(|i| f64::from(i) / rig.camera.rate).collect();
    (0..6)
        .map(|i| {
            let share = f64::from(i) / 5.0;
            let range = rig.robot.angle;
            let command = Command::new(
                0.45 + 0.5 * share,
                range.low + (range.high - range.low) * ((2.0 * share) % 1.0),
            );
            Strike {
                track: Track {
                    x: vec![0.0; times.len()],
                    y: vec![0.0; times.len()],
                    t: times.clone(),
                    yaw: None,
                    end: values::End::Rest,
                },
                split: values::Split::Train,
                conditions: Conditions {
                    session: "monday.mcap".into(),
                    order: 10.0 * f64::from(i),
                    ..Conditions::default()
                },
                ..Strike::bare(command, Point::new(0.3, 0.05), Point::default())
            }
        })
        .collect()
}

/// Greatest distance in m between the planar slide and MuJoCo's, over all frames and stops.
fn apart(shape: Shape, hidden: Option<(&str, &[(&str, f64)])>) -> f64 {
    let rig = Rig::demo(shape);
    let world = World::nominal(&rig)
        .with("friction", 0.22)
        .with("restitution", 0.5);
    let mut with = world.clone();
    with.effects
        .extend(hidden.map(|(name, parameters)| AddedEffect::fixed(name, parameters)));
    let effects: Vec<_> = with
        .effects
        .iter()
        .map(|added| effects::build(added, &rig).expect("an effect of the library"))
        .collect();
    let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
    let strikes = strikes(&rig);
    let launches =
        launches(&rig, &world, strikes.iter().map(Strike::commanded)).expect("a valid world");
    let simulator = Simulator::new(&rig, &with).expect("a valid world");
    let mut worker = simulator.worker();
    let mut worst: f64 = 0.0;
    for (strike, launch) in strikes.iter().zip(launches) {
        let frames = planar
            .strike(
                &strike.into(),
                &launch.expect("parts"),
                &Deviation::default(),
            )
            .expect("rests");
        let simulated = worker
            .strike(strike.initial, strike.command, &strike.conditions)
            .expect("rests");
        worst = worst.max(frames.stop.distance(simulated.stop));
        for (t, at) in strike.track.t.iter().zip(&frames.at) {
            worst = worst.max(at.distance(simulated.at(*t)));
        }
    }
    worst
}

/// A slide in steps a twentieth as long.
fn finely(mut object: Sliding<'_>) -> Frames {
    while object.phase == sliding::Phase::Slides {
        object.step *= 0.05;
        let middle = object.rate_after(&object.rate, 0.5);
        let again = object.rate_after(&middle, 0.5);
        let end = object.rate_after(&again, 1.0);
        object.go(&middle, &again, &end);
    }
    object.ended().expect("rests")
}

#[test]
fn its_steps_follow_the_slide_and_several_at_once_are_each_as_alone() {
    let cases: &[(&str, &[(&str, f64)])] = &[
        ("speed_weakening_friction", &[("rise", 0.3), ("speed", 0.3)]),
        ("anisotropic_friction", &[("contrast", 0.1)]),
        (
            "friction_patch",
            &[("center_x", 0.5), ("change", 0.5), ("radius", 0.04)],
        ),
        ("table_bowl", &[("curvature", 0.04), ("center_x", 0.4)]),
        ("off_centre_contact", &[("offset", 0.004)]),
    ];
    let mut worst: f64 = 0.0;
    for shape in [Shape::Cylinder, Shape::Box] {
        let rig = Rig::demo(shape);
        let world = World::nominal(&rig).with("friction", 0.22);
        let strikes = strikes(&rig);
        let commanded = strikes.iter().map(Strike::commanded);
        let launches = launches(&rig, &world, commanded).expect("a valid world");
        let launches: Vec<Launch> = launches.into_iter().flatten().collect();
        for (name, parameters) in cases {
            let effects =
                [effects::build(&AddedEffect::fixed(name, parameters), &rig).expect("an effect")];
            let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
            let jobs: Vec<Job<'_>> = (0..2 * ABREAST - 1)
                .map(|i| i % strikes.len())
                .map(|i| Job {
                    planar: &planar,
                    input: (&strikes[i]).into(),
                    launch: &launches[i],
                    deviation: Deviation::default(),
                })
                .collect();
            for (job, frames) in jobs.iter().zip(super::strikes(&jobs)) {
                let frames = frames.expect("rests");
                let alone = planar.strike(&job.input, job.launch, &job.deviation);
                assert_eq!(alone.expect("rests").at, frames.at, "{name}");
                let release = planar.release(&job.input, job.launch);
                let fine = finely(Sliding::new(&planar, &job.input, release, &job.deviation));
                for (a, b) in frames.at.iter().zip(&fine.at) {
                    worst = worst.max(a.distance(*b));
                }
            }
        }
    }
    assert!(worst < 2e-5, "{worst} m");
}

#[test]
fn an_object_that_runs_away_down_a_saddle_is_not_followed_for_ever() {
    let rig = Rig::demo(Shape::Cylinder);
    let world = World::nominal(&rig).with("friction", 0.1);
    // Steps are as short as the patch is small, and ever shorter in time as the object goes faster.
    let saddle = [("curvature", -0.3), ("stretch", -0.5), ("center_x", 0.3)];
    let patch = [("center_x", 0.5), ("change", 0.5), ("radius", 0.04)];
    let effects =
        [("table_bowl", &saddle), ("friction_patch", &patch)].map(|(name, parameters)| {
            effects::build(&AddedEffect::fixed(name, parameters), &rig).expect("valid")
        });
    let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
    let strikes = strikes(&rig);
    let launch = launches(&rig, &world, [strikes[5].commanded()]).expect("a valid world");
    let launch = launch[0].expect("leaves the tip");
    let frames = planar.strike(&(&strikes[5]).into(), &launch, &Deviation::default());
    assert!(frames.is_none());
}

#[test]
fn a_strike_on_more_friction_of_its_own_is_one_in_a_world_of_more_friction() {
    let rig = Rig::demo(Shape::Cylinder);
    let stop = |friction: f64, deviation: Deviation| {
        let world = World::nominal(&rig).with("friction", friction);
        let planar = Planar::new(&rig, &world, &[]).expect("known parameters");
        let strikes = strikes(&rig);
        let launch = launches(&rig, &World::nominal(&rig), [strikes[3].commanded()]);
        let launch = launch.expect("a valid world")[0].expect("parts");
        let frames = planar.strike(&(&strikes[3]).into(), &launch, &deviation);
        frames.expect("rests").stop
    };
    let own = Deviation {
        friction: 1.1f64.ln(),
        ..Deviation::default()
    };
    let apart = stop(0.2, own).distance(stop(0.22, Deviation::default()));
    assert!(apart < 1e-9, "{apart} m");
    assert!(stop(0.2, own).distance(stop(0.2, Deviation::default())) > 0.01);
}

#[test]
fn it_follows_mujoco_whatever_the_effect() {
    let cases: &[(&str, &[(&str, f64)])] = &[
        ("viscous_drag", &[("rate", 0.3)]),
        ("quadratic_drag", &[("coefficient", 0.2)]),
        ("speed_weakening_friction", &[("rise", 0.3), ("speed", 0.3)]),
        (
            "anisotropic_friction",
            &[("contrast", 0.1), ("direction", 0.5)],
        ),
        (
            "friction_patch",
            &[("center_x", 0.5), ("change", 0.3), ("radius", 0.08)],
        ),
        ("friction_drift", &[("rate", 0.2)]),
        (
            "friction_by_session",
            &[("monday.mcap", 0.1), ("tuesday.mcap", -0.1)],
        ),
        ("table_tilt", &[("tilt_x", -0.004), ("tilt_y", 0.006)]),
        ("table_bowl", &[("curvature", 0.04), ("center_x", 0.4)]),
        ("striker_speed_error", &[("offset", -0.04), ("cap", 0.9)]),
        ("striker_angle_bias", &[("bias", 0.03)]),
        ("speed_dependent_restitution", &[("slope", 0.2)]),
        ("off_centre_contact", &[("offset", 0.002)]),
        ("camera_rotation", &[("angle", 0.02)]),
        ("camera_distortion", &[("k1", 0.08)]),
        (
            "striker_angle_error",
            &[("gain", 0.3), ("bias", 0.02), ("slope", -0.05)],
        ),
        (
            "striker_angle_by_session",
            &[("monday.mcap", 0.04), ("tuesday.mcap", 0.0)],
        ),
        ("restitution_drift", &[("rate", -0.3)]),
        (
            "friction_gradient",
            &[("gradient_x", 0.5), ("gradient_y", -0.3)],
        ),
        (
            "friction_step",
            &[("direction", 0.4), ("offset", 0.45), ("change", 0.3)],
        ),
        (
            "friction_map",
            &[("node_6", 0.2), ("node_9", -0.2), ("low_x", 0.3)],
        ),
        ("camera_lean", &[("lean_x", 0.06), ("lean_y", -0.03)]),
        ("striker_speed_error", &[("cap", 1.1), ("softness", 0.4)]),
        ("friction_drift", &[("rate", 1.0), ("saturation", 5.0)]),
    ];
    let plain = apart(Shape::Cylinder, None);
    assert!(plain < 1e-4, "without effects: {plain} m");
    for (name, parameters) in cases {
        let apart = apart(Shape::Cylinder, Some((name, parameters)));
        assert!(apart < 4e-4, "{name}: {apart} m");
    }
    // An effect without a case here, at the sizes that its file states.
    for spec in effects::EFFECTS {
        let has_case = cases.iter().any(|(name, _)| *name == spec.name);
        if let (false, effects::Parameters::Listed(listed)) = (has_case, spec.parameters) {
            let usual = |p: &effects::EffectParameter| (p.name, (p.neutral + p.scale).min(p.high));
            let usual: Vec<(&str, f64)> = listed.iter().map(usual).collect();
            let apart = apart(Shape::Cylinder, Some((spec.name, &usual)));
            assert!(apart < 4e-4, "{}: {apart} m", spec.name);
        }
    }
    let turning = apart(Shape::Box, None);
    assert!(turning < 2e-4, "a box that turns: {turning} m");
}
