//! A known world must be recovered from its own strikes.

use ingest::{Ingest, assemble, ingest_log};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use rayon::prelude::*;
use rig::{Hidden, Truth};
use stage::{Progress, Stage};
use sysid::{Fit, Input, Note, Sysid, algorithm2::algorithm2};
use values::{Command, Conditions, Point, Rig, Sentence, Shape, Split, Strike, Track};
use world::{Simulator, World};

const FRICTION: f64 = 0.25;
const RESTITUTION: f64 = 0.45;

struct Noise {
    speed: f64,
    angle: f64,
    camera: f64,
}

/// Strikes of a world by itself, with launches that scatter and a camera that is noisy and unsynchronised.
fn strikes(rig: &Rig, world: &World, count: usize, noise: &Noise, seed: u64) -> Vec<Strike> {
    let simulator = Simulator::new(rig, world).expect("a valid world");
    let mut worker = simulator.worker();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let normal = Normal::new(0.0, 1.0).expect("a valid distribution");
    (0..count)
        .map(|i| {
            let mut gauss = |sd: f64| sd * normal.sample(&mut rng);
            let (faster, turned) = (gauss(noise.speed), gauss(noise.angle));
            let phase: f64 = rng.random_range(0.0..1.0);
            let initial = Point::new(rng.random_range(0.2..0.4), rng.random_range(-0.2..0.2));
            let command = Command {
                speed: rng.random_range(0.45..0.9),
                angle: rng.random_range(-0.4..0.4),
            };
            let delivered = Command {
                speed: command.speed * (1.0 + faster),
                angle: command.angle + turned,
            };
            let simulated = worker
                .strike(initial, delivered, &Conditions::default())
                .expect("rests");
            let frames = (simulated.rest_time * rig.camera.rate) as usize + 12;
            let mut gauss = |sd: f64| sd * normal.sample(&mut rng);
            let mut track = Track::default();
            for frame in 0..frames {
                let t = frame as f64 / rig.camera.rate;
                let seen = simulated.at(t + 0.5 * (phase - 0.5) / rig.camera.rate);
                track.t.push(t);
                track.x.push(seen.x + gauss(noise.camera));
                track.y.push(seen.y + gauss(noise.camera));
            }
            Strike {
                id: format!("{seed:x}-{i}"),
                log: "synthetic.mcap".into(),
                index: i as u32,
                t_start: i as f64,
                initial,
                stop: simulated.stop
                    + Point::new(gauss(0.3 * noise.camera), gauss(0.3 * noise.camera)),
                command,
                track,
                split: Split::Train,
                conditions: Conditions::default(),
                delivered: None,
            }
        })
        .collect()
}

fn truth() -> World {
    World::nominal()
        .with("friction", FRICTION)
        .with("restitution", RESTITUTION)
}

fn identify(rig: &Rig, start: World, strikes: Vec<Strike>, free: &[&str]) -> Fit {
    let free = free.iter().map(ToString::to_string).collect();
    Sysid {
        free,
        ..Sysid::default()
    }
    .run(
        &Input {
            rig: rig.clone(),
            world: start,
            strikes,
            later: Vec::new(),
        },
        &Progress::hidden(),
    )
    .expect("identified")
}

const BOTH: &[&str] = &["friction", "restitution"];
const REALISTIC: Noise = Noise {
    speed: 0.01,
    angle: 0.008,
    camera: 0.0007,
};
const CLEAN: Noise = Noise {
    speed: 0.0,
    angle: 0.0,
    camera: 1e-5,
};

#[test]
fn clean_strikes_give_friction_and_launch_within_one_per_cent_from_any_start() {
    let rig = Rig::demo(Shape::Cylinder);
    let data = strikes(&rig, &truth(), 50, &CLEAN, 1);
    for (friction, restitution) in [(0.6, 0.1), (0.1, 0.9), (0.3, 0.5)] {
        let start = World::nominal()
            .with("friction", friction)
            .with("restitution", restitution);
        let fit = identify(&rig, start, data.clone(), BOTH);
        let found = |name| fit.world.value(name).expect("freed");
        assert!((found("friction") / FRICTION - 1.0).abs() < 0.01, "{fit:?}");
        assert!(
            ((1.0 + found("restitution")) / (1.0 + RESTITUTION) - 1.0).abs() < 0.01,
            "{fit:?}"
        );
    }
}

#[test]
fn launch_scatter_and_camera_noise_are_told_apart() {
    let rig = Rig::demo(Shape::Cylinder);
    let fit = identify(
        &rig,
        World::nominal(),
        strikes(&rig, &truth(), 80, &REALISTIC, 3),
        &[],
    );
    let scatter = fit.world.scatter;
    assert!(
        (scatter.speed / REALISTIC.speed - 1.0).abs() < 0.3,
        "{scatter:?}"
    );
    assert!(
        (scatter.angle / REALISTIC.angle - 1.0).abs() < 0.3,
        "{scatter:?}"
    );
    assert!(
        (scatter.camera / REALISTIC.camera - 1.0).abs() < 0.1,
        "{scatter:?}"
    );
    assert!(
        fit.notes.iter().any(|note| note.contains("solimp_width")),
        "{:?}",
        fit.notes
    );
}

// Of 600 sets of other seeds 95.7 % (friction) and 96.2 % (restitution) hold the truth.
#[test]
fn intervals_of_ninety_five_per_cent_cover_the_truth_in_ninety_to_ninety_eight() {
    let rig = Rig::demo(Shape::Cylinder);
    let sets = 100;
    let covered: Vec<[bool; 2]> = (0..sets)
        .into_par_iter()
        .map(|seed| {
            let fit = identify(
                &rig,
                truth(),
                strikes(&rig, &truth(), 24, &REALISTIC, 1000 + seed),
                BOTH,
            );
            [("friction", FRICTION), ("restitution", RESTITUTION)].map(|(name, value)| {
                let estimate = fit.world.parameters[name];
                estimate.low <= Some(value) && Some(value) <= estimate.high
            })
        })
        .collect();
    let count = |p: usize| covered.iter().filter(|set| set[p]).count();
    let (friction, restitution) = (count(0), count(1));
    println!("covered of {sets}: friction {friction}, restitution {restitution}");
    let pooled = (friction + restitution) as f64 / (2 * sets) as f64;
    assert!(
        (0.90..=0.98).contains(&pooled),
        "{friction} and {restitution} of {sets} covered"
    );
    assert!(
        friction.min(restitution) >= 90,
        "{friction} and {restitution} of {sets} covered"
    );
}

#[test]
fn sessions_that_differ_and_an_arm_that_wanders_widen_intervals() {
    let rig = Rig::demo(Shape::Cylinder);
    let faster = [1.02, 0.98, 1.03, 0.97, 1.01, 0.99];
    let width = |group: &dyn Fn(usize) -> usize, session: &dyn Fn(usize) -> usize| {
        let mut strikes = strikes(&rig, &truth(), 60, &REALISTIC, 3);
        for (i, strike) in strikes.iter_mut().enumerate() {
            strike.command.speed /= faster[group(i)];
            strike.conditions.session = session(i).to_string();
            strike.conditions.order = i as f64;
        }
        let fit = identify(&rig, World::nominal(), strikes, BOTH);
        let restitution = &fit.world.parameters["restitution"];
        let is_held = (restitution.low..=restitution.high).contains(&Some(RESTITUTION));
        (
            restitution.high.expect("known") - restitution.low.expect("known"),
            is_held,
        )
    };
    let (in_turn, in_order) = (|i: usize| i % 6, |i: usize| i / 10);
    let (each, _) = width(&in_turn, &|_| 0);
    let (by_session, is_held) = width(&in_turn, &in_turn);
    assert!(by_session > 2.0 * each && is_held, "{by_session} {each}");
    let (by_order, is_held) = width(&in_order, &|_| 0);
    assert!(by_order > 2.0 * each && is_held, "{by_order} {each}");
}

#[test]
fn a_box_reveals_the_friction_of_the_tip() {
    let rig = Rig::demo(Shape::Box);
    // A tip of 0.35 slips in the widest strikes alone.
    for (friction, seed) in [(0.25, 5), (0.35, 6)] {
        let world = truth().with("tip_friction", friction);
        let fit = identify(
            &rig,
            World::nominal(),
            strikes(&rig, &world, 50, &REALISTIC, seed),
            &[],
        );
        assert!(
            fit.freed.iter().any(|name| name == "tip_friction"),
            "{fit:?}"
        );
        let found = fit.world.value("tip_friction").expect("freed");
        assert!((found - friction).abs() < 0.02, "{found} for {friction}");
    }
}

#[test]
fn a_tip_that_sticks_is_not_taken_for_one_that_slips() {
    let rig = Rig::demo(Shape::Box);
    let nominal = World::nominal();
    for seed in 7..10 {
        let world = truth().with("tip_friction", 0.9);
        let data = strikes(&rig, &world, 40, &REALISTIC, seed);
        let fit = identify(&rig, nominal.clone(), data, &[]);
        let of = |world: &World| world.value("tip_friction").expect("known");
        assert!(of(&fit.world) > 0.95 * of(&nominal), "{fit:?}");
    }
}

/// The embedded rig's ball, which has another physics: rolling holds it back as one force once it rolls.
#[test]
fn a_ball_has_its_own_friction_and_restitution() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = Hidden::parse(&["viscous_drag=0.001"]).expect("an effect");
    let settings = rig::demo::Settings::new(Shape::Sphere, 40, 11, Some(none));
    let data = written(&settings, folder.path());
    let truth = &settings.truth;
    let fit = identify(&truth.rig, World::nominal(), data, &[]);
    let radius = truth.rig.object.solid.half_height();
    for (name, real, width) in [
        ("friction", truth.friction, 0.2),
        ("restitution", truth.restitution, 0.2),
        ("rolling_friction", 1.4 * radius * truth.rolling, 0.06),
    ] {
        let found = fit.world.parameters[name];
        let (low, high) = (found.low.expect("freed"), found.high.expect("freed"));
        assert!(low < real && real < high, "{name}: {found:?}");
        assert!(high - low < width * real, "{name}: {found:?}");
    }
}

/// The demo's strikes with a cylinder, with an effect too small to matter in place of its hidden mixture.
fn demo(count: usize) -> (Truth, Vec<Strike>) {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden = Hidden::parse(&["viscous_drag=0.001"]).expect("an effect");
    let settings = rig::demo::Settings::new(Shape::Cylinder, count, 11, Some(hidden));
    let strikes = written(&settings, folder.path());
    (settings.truth, strikes)
}

/// The strikes of a demo that is written here, all to learn from.
fn written(settings: &rig::demo::Settings, folder: &std::path::Path) -> Vec<Strike> {
    let written = rig::demo::write(settings, folder).expect("writes");
    let rig = Rig::load(&written.rig).expect("the rig file is accepted");
    let outcomes = written
        .logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()).expect("the log is read"))
        .collect();
    let (mut strikes, _) = assemble(outcomes);
    for strike in &mut strikes {
        strike.split = Split::Train;
    }
    strikes
}

#[test]
fn where_nothing_is_hidden_the_scatter_is_the_rigs_in_a_few_iterations() {
    let (truth, data) = demo(100);
    let fit = identify(&truth.rig, World::nominal(), data, &[]);
    let (found, real) = (fit.world.scatter, truth.scatter);
    println!(
        "{found:?} for {real:?}, {} iterations, {} simulations",
        fit.iterations, fit.simulations
    );
    assert!((found.speed / real.speed - 1.0).abs() < 0.25, "{found:?}");
    assert!((found.angle / real.angle - 1.0).abs() < 0.25, "{found:?}");
    assert!(fit.iterations <= 5, "{} iterations", fit.iterations);
}

#[test]
fn what_turns_every_strike_alike_is_told_and_is_no_scatter() {
    let rig = Rig::demo(Shape::Cylinder);
    let mut data = strikes(&rig, &truth(), 60, &REALISTIC, 7);
    for strike in &mut data {
        strike.command.angle -= 0.15;
    }
    let fit = identify(&rig, World::nominal(), data, &[]);
    assert!(
        (fit.world.scatter.angle / REALISTIC.angle - 1.0).abs() < 0.3,
        "{:?}",
        fit.world.scatter
    );
    let friction = fit.world.value("friction").expect("freed");
    assert!((friction / FRICTION - 1.0).abs() < 0.01, "{friction}");
    assert!(
        fit.notes.iter().any(|note| note.contains("8.5")),
        "{:?}",
        fit.notes
    );
}

#[test]
fn the_papers_algorithm_brings_the_stops_together() {
    let rig = Rig::demo(Shape::Cylinder);
    let data = strikes(&rig, &truth(), 12, &CLEAN, 9);
    let (_, error) = algorithm2(
        &rig,
        &World::nominal(),
        &data,
        &["friction", "restitution"],
        60,
    )
    .expect("valid");
    assert!(error < 2e-3, "{error}");
}

#[test]
fn an_arm_that_delivers_half_of_what_it_is_commanded_is_told_by_a_restitution_that_no_impact_has() {
    let rig = Rig::demo(Shape::Cylinder);
    let noise = Noise {
        speed: 0.01,
        angle: 0.005,
        camera: 5e-4,
    };
    let mut strikes = strikes(&rig, &truth(), 30, &noise, 11);
    let is_told = |fit: &Fit| {
        let negative = |w: &Sentence<Note>| matches!(w.finding(), Some(Note::NegativeRestitution { high, .. }) if *high < 0.0);
        fit.warnings.iter().any(negative)
    };
    assert!(!is_told(&identify(
        &rig,
        World::nominal(),
        strikes.clone(),
        &[]
    )));
    strikes
        .iter_mut()
        .for_each(|strike| strike.command.speed *= 2.0);
    assert!(is_told(&identify(&rig, World::nominal(), strikes, &[])));
}

#[test]
fn too_few_strikes_are_told() {
    let rig = Rig::demo(Shape::Cylinder);
    let input = Input {
        rig: rig.clone(),
        world: World::nominal(),
        strikes: strikes(&rig, &truth(), 3, &CLEAN, 1),
        later: Vec::new(),
    };
    let error = Sysid::default()
        .run(&input, &Progress::hidden())
        .expect_err("three are too few")
        .to_string();
    assert!(error.contains("at least 5 are needed"), "{error}");
}

#[test]
fn friction_that_scatters_widely_biases_neither_friction_nor_launch() {
    let rig = Rig::demo(Shape::Cylinder);
    let noise = Noise {
        camera: 1e-4,
        ..REALISTIC
    };
    let data: Vec<Strike> = (0..60)
        .flat_map(|seed| {
            let other = if seed % 2 == 0 { 0.1f64 } else { -0.1 };
            let world = truth().with("friction", FRICTION * other.exp());
            strikes(&rig, &world, 1, &noise, 100 + seed / 2)
        })
        .collect();
    let fit = identify(&rig, World::nominal(), data, &[]);
    let found = |name| fit.world.value(name).expect("freed");
    // A stop is off by half the square of what friction differs by, on average: 0.5 % of the way.
    assert!(
        (found("friction") / FRICTION - 1.0).abs() < 2e-3,
        "{:?}",
        fit.world
    );
    assert!(
        ((1.0 + found("restitution")) / (1.0 + RESTITUTION) - 1.0).abs() < 2e-3,
        "{:?}",
        fit.world
    );
}

#[test]
fn friction_of_another_simulator_is_found_to_two_parts_in_ten_thousand() {
    let mut truth = Truth::demo(&Truth::demo_rig(Shape::Cylinder), 77_000);
    truth.hidden = Hidden::none();
    truth.friction = 0.15;
    truth.rig.camera.noise = 1e-5;
    (truth.camera.jitter, truth.camera.dropped) = (0.0, 0.0);
    (truth.scatter.speed, truth.scatter.angle) = (0.0, 0.0);
    let folder = tempfile::tempdir().expect("a folder");
    let settings = rig::demo::Settings {
        strikes: 30,
        truth: truth.clone(),
        plan: None,
        log_state: false,
        log_pose: false,
        sessions: Some(1),
    };
    let written = rig::demo::write(&settings, folder.path()).expect("written");
    let rig = Rig::load(&written.rig).expect("its rig file is valid");
    let outcomes = written
        .logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()).expect("its log is read"))
        .collect();
    let fit = identify(&rig, World::nominal(), assemble(outcomes).0, &[]);
    let friction = fit.world.value("friction").expect("freed");
    assert!((friction / 0.15 - 1.0).abs() < 2e-4, "{friction}");
}

#[test]
fn launches_that_scatter_move_restitution_by_their_mean_and_friction_not_at_all() {
    let rig = Rig::demo(Shape::Cylinder);
    // A camera that sees what no derivative does: a stop goes as the square of the speed.
    let noise = Noise {
        speed: 0.01,
        angle: 0.008,
        camera: 2e-5,
    };
    let seeds = 3000..3060;
    let data = seeds
        .clone()
        .flat_map(|seed| strikes(&rig, &truth(), 1, &noise, seed))
        .collect();
    let fit = identify(&rig, World::nominal(), data, &[]);
    // The first draw of a seed is its strike's speed.
    let faster: f64 = seeds
        .map(|seed| {
            let normal = Normal::new(0.0, noise.speed).expect("a valid distribution");
            let drawn: f64 = normal.sample(&mut ChaCha8Rng::seed_from_u64(seed));
            drawn.ln_1p() / 60.0
        })
        .sum();
    let found = |name| fit.world.value(name).expect("freed");
    let launch = ((1.0 + found("restitution")) / (1.0 + RESTITUTION)).ln();
    assert!((launch - faster).abs() < 2e-4, "{launch} for {faster}");
    let friction = found("friction") / FRICTION - 1.0;
    assert!(friction.abs() < 2e-4, "{friction}");
}

/// Strikes turned into slides that no strike began: each track from its sixth frame on, the command the velocity (m/s, rad) that the object has
/// there.
fn pushes(strikes: &[Strike]) -> Vec<Strike> {
    let push = |strike: &Strike| {
        let mut slide = strike.clone();
        let (mut track, from) = (strike.track.clone(), 5);
        track.t = track.t[from..].iter().map(|t| t - track.t[from]).collect();
        track.x.drain(..from);
        track.y.drain(..from);
        let velocity = (track.point(4) - track.point(0)) * (1.0 / track.t[4]);
        slide.command = Command::new(velocity.norm(), velocity.bearing());
        slide.initial = track.point(0);
        slide.track = track;
        slide.conditions.is_unstruck = true;
        slide
    };
    strikes.iter().map(push).collect()
}

#[test]
fn slides_that_no_strike_began_teach_friction_and_nothing_of_the_impact() {
    let rig = Rig::demo(Shape::Cylinder);
    let struck = strikes(&rig, &truth(), 24, &REALISTIC, 71);
    let slides = pushes(&strikes(&rig, &truth(), 48, &REALISTIC, 72));
    let both = [struck.clone(), slides.clone()].concat();
    let fit = |strikes| identify(&rig, World::nominal(), strikes, &[]);
    let interval = |fit: &Fit, name: &str| {
        let estimate = fit.world.parameters[name];
        (
            estimate.low.expect("an end")..estimate.high.expect("an end"),
            estimate.value,
        )
    };
    let width = |range: &std::ops::Range<f64>| range.end - range.start;
    let (alone, beside) = (fit(struck), fit(both));
    let (before, _) = interval(&alone, "friction");
    let (after, _) = interval(&beside, "friction");
    assert!(after.contains(&FRICTION), "{after:?}");
    assert!(width(&after) < 0.8 * width(&before), "{before:?} {after:?}");
    let (before, value) = interval(&alone, "restitution");
    let (after, with) = interval(&beside, "restitution");
    assert!(
        (value - with).abs() < 0.25 * width(&before),
        "{value} {with}"
    );
    assert!(width(&after) < 1.2 * width(&before) && after.contains(&RESTITUTION));
    let scatter = |fit: &Fit| fit.world.scatter.speed;
    assert!((scatter(&alone) / scatter(&beside)).ln().abs() < 0.2);
    assert_eq!((alone.strikes, beside.strikes), (24, 24));

    let none = fit(slides);
    let (after, _) = interval(&none, "friction");
    assert!(
        after.contains(&FRICTION) && width(&after) < 0.02,
        "{after:?}"
    );
    assert_eq!(
        (none.freed, none.strikes),
        (vec!["friction".to_string()], 0)
    );
}
