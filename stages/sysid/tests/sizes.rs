//! Sizes in the rig file that are wrong must be said, and no others.

use ingest::{Ingest, assemble, ingest_log};
use rig::{Hide, Truth};
use stage::{Progress, Stage};
use sysid::{Input, Sysid};
use values::{Command, Conditions, Point, Rig, Shape, Solid, Split, Strike};
use world::{Simulator, World};

/// Strikes of the embedded rig with one shape; `hide` as for `carom demo --hide`.
fn strikes(shape: Shape, count: usize, seed: u64, hide: &str) -> (Rig, Vec<Strike>) {
    let mut truth = Truth::demo(&Truth::demo_rig(shape), seed);
    let flags: Vec<&str> = hide.split(' ').collect();
    let hide = Hide::parse(&flags).expect("effects and kinds of noise");
    (truth.hidden, truth.noise) = (hide.hidden, hide.noise);
    let folder = tempfile::tempdir().expect("a folder");
    let settings = rig::demo::Settings {
        strikes: count,
        truth,
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
    let mut strikes = assemble(outcomes).0;
    for strike in &mut strikes {
        strike.split = Split::Train;
    }
    (rig, strikes)
}

/// What identification says of sizes.
fn note(rig: &Rig, strikes: &[Strike]) -> Option<String> {
    let input = Input {
        rig: rig.clone(),
        world: World::nominal(),
        strikes: strikes.to_vec(),
        later: Vec::new(),
    };
    let sysid = Sysid {
        most_strikes: strikes.len(),
        ..Sysid::default()
    };
    let fit = sysid.run(&input, &Progress::hidden()).expect("identified");
    let mut warnings = fit.warnings.iter().map(ToString::to_string);
    warnings.find(|note| note.contains("another size"))
}

/// A rig file whose box is so many times as large as it is.
fn with_sides(rig: &Rig, factor: f64) -> Rig {
    let mut rig = rig.clone();
    if let Solid::Box {
        half_size: [x, y, _],
    } = &mut rig.object.solid
    {
        *x *= factor;
        *y *= factor;
    }
    rig
}

/// What the strikes want for half a side, and by how much it may be off, in mm.
fn half_side(note: &str) -> (f64, f64) {
    let words: Vec<&str> = note
        .split_once("object.half_size ")
        .expect("it names the key")
        .1
        .split(' ')
        .collect();
    let number = |word: &str| word.parse().expect("a number");
    (number(words[0]), number(words[2]))
}

// Of 20 other seeds (`measure`) all are said at 10 % too much or too little, 14 of 40 at 5 %, none where the rig file is right; every
// interval holds the truth.
#[test]
fn sides_that_are_ten_per_cent_wrong_are_said_with_what_they_are() {
    let (rig, strikes) = strikes(Shape::Box, 90, 4000, "none");
    for factor in [1.1, 0.9] {
        let note = note(&with_sides(&rig, factor), &strikes).expect("a note");
        let (wanted, half) = half_side(&note);
        assert!((wanted - 30.0).abs() < half && half < 2.0, "{note}");
        assert!(note.contains("striker.radius") && note.contains("the commanded angle"));
    }
}

#[test]
fn of_a_rig_file_that_is_right_nothing_is_said() {
    for seed in 4000..4004 {
        let (rig, strikes) = strikes(Shape::Box, 60, seed, "none");
        assert_eq!(note(&rig, &strikes), None, "seed {seed}");
    }
}

#[test]
fn a_force_during_the_slide_is_no_other_size() {
    for effect in ["anisotropic_friction", "table_tilt", "table_bowl"] {
        let (rig, strikes) = strikes(Shape::Box, 90, 4000, effect);
        assert_eq!(note(&rig, &strikes), None, "{effect}");
    }
}

#[test]
fn an_arm_whose_speed_saturates_is_no_other_size() {
    let (rig, strikes) = strikes(Shape::Box, 90, 5000, "tanh_speed");
    assert_eq!(note(&rig, &strikes), None);
}

#[test]
fn of_a_cylinders_sizes_nothing_is_said() {
    let (mut rig, strikes) = strikes(Shape::Cylinder, 60, 4000, "none");
    rig.object.solid = rig.object.solid.scaled(1.1);
    assert_eq!(note(&rig, &strikes), None);
}

#[test]
fn only_the_ratio_of_the_two_sizes_counts() {
    let rig = Rig::demo(Shape::Box);
    let stop = |rig: &Rig| {
        let world = World::nominal();
        let simulator = Simulator::new(rig, &world).expect("a valid world");
        let command = Command {
            speed: 0.7,
            angle: 0.3,
        };
        simulator
            .worker()
            .strike(Point::new(0.3, 0.0), command, &Conditions::default())
            .expect("rests")
            .stop
    };
    let mut wide_tip = rig.clone();
    wide_tip.striker.radius *= 1.1;
    let [right, box_wrong, tip_wrong] = [&rig, &with_sides(&rig, 1.0 / 1.1), &wide_tip].map(stop);
    let moved = right.distance(tip_wrong);
    assert!(moved > 1e-3, "{moved}");
    assert!(box_wrong.distance(tip_wrong) < 0.02 * moved);
}

/// How often a note is made, and how often its interval holds the truth.
#[test]
#[ignore = "measures for minutes; SIZES_COUNT, SIZES_SEEDS, SIZES_FACTORS and SIZES_HIDE say what"]
fn measure() {
    let get = |name, or: &str| std::env::var(name).unwrap_or_else(|_| or.into());
    let count = get("SIZES_COUNT", "90").parse().expect("a number");
    let seeds: u64 = get("SIZES_SEEDS", "10").parse().expect("a number");
    let hide = get("SIZES_HIDE", "none");
    let factors: Vec<f64> = get("SIZES_FACTORS", "1 0.95 1.05 0.9 1.1")
        .split(' ')
        .map(|factor| factor.parse().expect("a number"))
        .collect();
    let mut tally = vec![(0, 0); factors.len()];
    for seed in 5000..5000 + seeds {
        let (rig, strikes) = strikes(Shape::Box, count, seed, &hide);
        for (factor, (said, covered)) in factors.iter().zip(&mut tally) {
            if let Some(note) = note(&with_sides(&rig, *factor), &strikes) {
                let (wanted, half) = half_side(&note);
                *said += 1;
                *covered += u32::from((wanted - 30.0).abs() < half);
                println!("{factor} {seed}: {wanted} ± {half}");
            }
        }
    }
    for (factor, (said, covered)) in factors.iter().zip(tally) {
        println!("{count} strikes, sides times {factor}: {said} of {seeds} said, {covered} cover");
    }
}
