//! Adding an effect is one file: what is only listed is tried, fitted and named by diagnosis.

mod lopsided_arm;
mod turning_force;

use std::sync::LazyLock;

use diagnose::{Diagnose, Input, Verdict};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use stage::{Progress, Stage};
use values::{Command, Conditions, Delivered, Point, Rig, Shape, Split, Strike, Track};
use world::{AddedEffect, Estimate, Simulator, World, effects};

/// Lists both effects in this process; whether neither was known before.
static LISTED: LazyLock<bool> = LazyLock::new(|| {
    let more = [&turning_force::SPEC, &lopsided_arm::SPEC];
    more.iter().all(|spec| effects::effect(spec.name).is_err()) && effects::extend_library(&more)
});

/// Turning in 1/s that the strikes are made with: half a degree in a slide of half a second would be 0.02.
const RATE: f64 = 0.12;
/// Share of the speed for each rad.
const SLOPE: f64 = 0.25;
const STRIKES: usize = 60;
/// Scatter of launches: relative speed, and rad; camera noise in m.
const SCATTER: (f64, f64, f64) = (0.01, 0.005, 0.5e-3);

/// Strikes in this world, with the arm's logged state or without.
fn strikes(rig: &Rig, world: &World, log_state: bool) -> Vec<Strike> {
    let simulator = Simulator::new(rig, world).expect("a world with the effect");
    let acting = world.effects.iter().map(|added| effects::build(added, rig));
    let acting: Vec<_> = acting.collect::<Result<_, _>>().expect("listed");
    let mut worker = simulator.worker();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    (0..STRIKES)
        .map(|i| {
            let share = i as f64 / STRIKES as f64;
            let command = Command {
                speed: 0.5 + 0.5 * ((7.0 * share) % 1.0),
                angle: -0.5 + (11.0 * share) % 1.0,
            };
            let conditions = Conditions {
                session: "monday.mcap".into(),
                order: i as f64,
                yaw: None,
                moving: None,
                is_unstruck: false,
                is_pushed_on: false,
            };
            let initial = Point::new(0.25, 0.1 * share);
            let delivered = Command {
                speed: command.speed * (1.0 + SCATTER.0 * normal()),
                angle: command.angle + SCATTER.1 * normal(),
            };
            let made = effects::deliver(&acting, delivered, initial, &conditions);
            let read = Delivered {
                tip_speed: made.speed,
                tip_angle: made.angle,
                contact: 0.0,
                pushed_again: false,
            };
            let simulated = worker
                .strike(initial, delivered, &conditions)
                .expect("rests");
            let mut seen = |point: Point| point + Point::new(normal(), normal()) * SCATTER.2;
            let mut track = Track::default();
            for frame in 1.. {
                let t = f64::from(frame) / rig.camera.rate;
                if t > simulated.rest_time {
                    break;
                }
                let at = seen(simulated.at(t));
                track.t.push(t);
                track.x.push(at.x);
                track.y.push(at.y);
            }
            Strike {
                id: format!("{i:016x}"),
                log: conditions.session.clone(),
                index: i as u32,
                t_start: 5.0 * i as f64,
                initial,
                stop: seen(simulated.stop),
                command,
                track,
                split: if i % 6 == 5 {
                    Split::Test
                } else {
                    Split::Train
                },
                conditions,
                delivered: log_state.then_some(read),
            }
        })
        .collect()
}

/// The only name that strikes of a world with this effect are given, and its parameter's interval.
fn named(name: &str, parameter: &str, value: f64, log_state: bool) -> (f64, f64) {
    assert!(*LISTED);
    let rig = Rig::demo(Shape::Cylinder);
    let plain = World::nominal()
        .with("friction", 0.22)
        .with("restitution", 0.5);
    let mut hidden = plain.clone();
    hidden.effects.push(AddedEffect {
        name: name.into(),
        parameters: [(parameter.to_string(), Estimate::fixed(value))].into(),
    });
    let found = Diagnose::default()
        .run(
            &Input::of(rig.clone(), plain, strikes(&rig, &hidden, log_state)),
            &Progress::hidden(),
        )
        .expect("a diagnosis");
    let diagnosis = &found.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Named, "{}", diagnosis.summary);
    let names: Vec<&str> = diagnosis.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, [name], "{}", diagnosis.summary);
    let found = &diagnosis.effects[0].parameters[parameter];
    (found.low, found.high)
}

#[test]
fn an_effect_in_one_file_is_found_once_it_is_listed() {
    let (low, high) = named("turning_force", "rate", RATE, false);
    assert!(low < RATE && RATE < high, "{low} to {high}");
}

#[test]
fn an_effect_of_the_arm_is_found_with_its_logged_state_and_without() {
    for log_state in [true, false] {
        let (low, high) = named("lopsided_arm", "slope", SLOPE, log_state);
        assert!(low < SLOPE && SLOPE < high, "{log_state}: {low} to {high}");
    }
}
