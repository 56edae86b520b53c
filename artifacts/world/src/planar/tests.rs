use values::{Command, Conditions, Point, Rig, Shape, Strike, Track};

use super::*;
use crate::{
    AddedEffect, Simulator, World,
    effects::{Acts, Effect},
    launch::launches,
};

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
fn apart(shape: Shape, hidden: Option<&AddedEffect>) -> f64 {
    let rig = Rig::demo(shape);
    let world = World::nominal()
        .with("friction", 0.22)
        .with("restitution", 0.5);
    let mut with = world.clone();
    with.effects.extend(hidden.cloned());
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
        object.step_on();
    }
    object.ended().expect("rests")
}

const CASES: [&str; 5] = [
    "speed_weakening_friction: rise = 0.3, speed = 0.3",
    "anisotropic_friction: contrast = 0.1",
    "friction_patch: center_x = 0.5, change = 0.5, radius = 0.04",
    "table_bowl: curvature = 0.04, center_x = 0.4",
    "off_centre_contact: offset = 0.004",
];

/// Asks of strikes in worlds with each of these effects.
fn in_each(mut ask: impl FnMut(&Rig, &AddedEffect, &Planar<'_>, &Strike, &Launch)) {
    for shape in [Shape::Cylinder, Shape::Box] {
        let rig = Rig::demo(shape);
        let world = World::nominal().with("friction", 0.22);
        let strikes = strikes(&rig);
        let commanded = strikes.iter().map(Strike::commanded);
        let launches = launches(&rig, &world, commanded).expect("a valid world");
        for added in CASES.map(AddedEffect::listed) {
            let effects = [effects::build(&added, &rig).expect("an effect")];
            let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
            for (strike, launch) in strikes.iter().zip(&launches) {
                ask(
                    &rig,
                    &added,
                    &planar,
                    strike,
                    launch.as_ref().expect("parts"),
                );
            }
        }
    }
}

#[test]
fn its_steps_follow_the_slide() {
    let mut worst: f64 = 0.0;
    in_each(|_, _, planar, strike, launch| {
        let input = strike.into();
        let release = planar.release(&input, launch);
        let none = Deviation::default();
        let frames = planar.slide(&input, release, &none).expect("rests");
        let fine = finely(Sliding::new(planar, &input, release, &none));
        for (a, b) in frames.at.iter().zip(&fine.at) {
            worst = worst.max(a.distance(*b));
        }
    });
    assert!(worst < 2e-5, "{worst} m");
}

#[test]
fn a_response_is_what_differs_between_slides() {
    /// Change in m, for a unit, below which it is compared with this.
    const LEAST: f64 = 0.02;
    let mut worst: f64 = 0.0;
    in_each(|rig, added, planar, strike, launch| {
        let input: StrikeInput<'_> = strike.into();
        let release = planar.release(&input, launch);
        let none = Deviation::default();
        let response = planar
            .response(&input, release, &none, 0.025)
            .expect("rests");
        let n = input.times.len();
        let nothing = |_: &Node| Rate::default();
        let mut held = |answer: &dyn Fn(&mut [f64]), slid: &dyn Fn(f64) -> Option<Frames>| {
            let mut column = vec![0.0; 2 * n];
            answer(&mut column);
            let step = 2e-3;
            let (before, after) = (slid(-step).expect("rests"), slid(step).expect("rests"));
            let (mut off, mut all): (f64, f64) = (0.0, 0.0);
            for (k, (a, b)) in after.at.iter().zip(&before.at).enumerate() {
                let whole = (*a - *b) * (0.5 / step);
                off = off.max(whole.distance(Point::new(column[k], column[n + k])));
                all = all.max(whole.norm());
            }
            worst = worst.max(off / all.max(LEAST));
        };
        let slid = |deviation: Deviation| planar.strike(&input, launch, &deviation);
        held(
            &|column| response.answer(response.faster(), &nothing, column),
            &|speed| slid(Deviation { speed, ..none }),
        );
        held(
            &|column| response.answer(response.turned(), &nothing, column),
            &|angle| slid(Deviation { angle, ..none }),
        );
        held(
            &|column| response.answer(StartChange::default(), &Node::friction, column),
            &|friction| slid(Deviation { friction, ..none }),
        );
        // A little of another effect, by what it adds, or by the whole world with it.
        for (name, strength) in [
            ("table_tilt", "tilt_x"),
            ("friction_patch", "change"),
            ("path_curl", "part"),
            ("camera_distortion", "k1"),
            ("off_centre_contact", "offset"),
        ] {
            let size = if name == "off_centre_contact" {
                0.1
            } else {
                1.0
            };
            let little = |value: f64| {
                let added = AddedEffect::fixed(name, &[(strength, value * size)]);
                effects::build(&added, rig).expect("an effect")
            };
            let beside = |value: f64| {
                [
                    effects::build(added, rig).expect("an effect"),
                    little(value),
                ]
            };
            let world = |all: &[Box<dyn Effect>], ask: &mut dyn FnMut(&Planar<'_>)| {
                let base = [planar.friction, planar.restitution];
                ask(&Planar::of(base, planar.base, planar.gyration, all));
            };
            let slid = |value: f64| {
                let (all, mut found) = (beside(value), None);
                world(&all, &mut |other| {
                    found = other.strike(&input, launch, &none)
                });
                found
            };
            let step = 1e-3;
            let whole = |column: &mut [f64]| {
                let mut opposite = column.to_vec();
                for (step, column) in [(step, &mut *column), (-step, &mut opposite[..])] {
                    world(&beside(step), &mut |other| {
                        let release = other.release(&input, launch);
                        response.answer_of(other, &release, &none, column);
                    });
                }
                for (change, opposite) in column.iter_mut().zip(opposite) {
                    *change = (*change - opposite) / (2.0 * step);
                }
            };
            held(&whole, &slid);
            let effect = little(step);
            if matches!(effect.acts(), Acts::Slide | Acts::Strike) {
                let by_effect = |node: &Node| response.effect(node, effect.as_ref()) * step.recip();
                held(
                    &|column| response.answer(StartChange::default(), &by_effect, column),
                    &slid,
                );
            }
        }
    });
    assert!(worst < 5e-3, "{worst}");
}

#[test]
fn an_object_that_runs_away_down_a_saddle_is_not_followed_for_ever() {
    let rig = Rig::demo(Shape::Cylinder);
    let world = World::nominal().with("friction", 0.1);
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
        let world = World::nominal().with("friction", friction);
        let planar = Planar::new(&rig, &world, &[]).expect("known parameters");
        let strikes = strikes(&rig);
        let launch = launches(&rig, &World::nominal(), [strikes[3].commanded()]);
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
    let cases = [
        "viscous_drag: rate = 0.3",
        "quadratic_drag: coefficient = 0.2",
        "speed_weakening_friction: rise = 0.3, speed = 0.3",
        "anisotropic_friction: contrast = 0.1, direction = 0.5",
        "friction_patch: center_x = 0.5, change = 0.3, radius = 0.08",
        "friction_drift: rate = 0.2",
        "friction_by_session: monday.mcap = 0.1, tuesday.mcap = -0.1",
        "table_tilt: tilt_x = -0.004, tilt_y = 0.006",
        "table_bowl: curvature = 0.04, center_x = 0.4",
        "striker_speed_error: offset = -0.04, cap = 0.9",
        "striker_angle_bias: bias = 0.03",
        "speed_dependent_restitution: slope = 0.2",
        "off_centre_contact: offset = 0.002",
        "camera_rotation: angle = 0.02",
        "camera_distortion: k1 = 0.08",
        "striker_angle_error: gain = 0.3, bias = 0.02, slope = -0.05",
        "striker_angle_by_session: monday.mcap = 0.04, tuesday.mcap = 0.0",
        "restitution_drift: rate = -0.3",
        "friction_gradient: gradient_x = 0.5, gradient_y = -0.3",
        "friction_step: direction = 0.4, offset = 0.45, change = 0.3",
        "friction_map: node_6 = 0.2, node_9 = -0.2, low_x = 0.3",
        "camera_lean: lean_x = 0.06, lean_y = -0.03",
        "striker_speed_error: cap = 1.1, softness = 0.4",
        "friction_drift: rate = 1.0, saturation = 5.0",
    ]
    .map(AddedEffect::listed);
    let plain = apart(Shape::Cylinder, None);
    assert!(plain < 1e-4, "without effects: {plain} m");
    for added in &cases {
        let apart = apart(Shape::Cylinder, Some(added));
        assert!(apart < 4e-4, "{}: {apart} m", added.name);
    }
    // An effect without a case here, at the sizes that its file states.
    for spec in effects::EFFECTS {
        let has_case = cases.iter().any(|added| added.name == spec.name);
        if let (false, effects::Parameters::Listed(listed)) = (has_case, spec.parameters) {
            let usual = |p: &effects::EffectParameter| (p.name, (p.neutral + p.scale).min(p.high));
            let usual: Vec<(&str, f64)> = listed.iter().map(usual).collect();
            let added = AddedEffect::fixed(spec.name, &usual);
            let apart = apart(Shape::Cylinder, Some(&added));
            assert!(apart < 4e-4, "{}: {apart} m", spec.name);
        }
    }
    let turning = apart(Shape::Box, None);
    assert!(turning < 2e-4, "a box that turns: {turning} m");
}
