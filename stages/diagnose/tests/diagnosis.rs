//! What a diagnosis makes of the embedded rig's strikes, whose physics it does not share.

use diagnose::{Diagnose, DiagnoseError, Diagnosed, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{Hidden, demo};
use stage::{Progress, Stage};
use values::{Command, Rig, Shape, Split, Strike};
use world::World;

fn input(hidden: &str, strikes: usize, seed: u64) -> Input {
    input_of(Shape::Cylinder, hidden, strikes, seed)
}

/// Strikes of a rig that hides these effects, joined by `+`.
fn input_of(shape: Shape, hidden: &str, strikes: usize, seed: u64) -> Input {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden: Vec<&str> = hidden.split('+').collect();
    let hidden = Hidden::parse(&hidden).expect("effects");
    let settings = demo::Settings::new(shape, strikes, seed, Some(hidden));
    let written = demo::write(&settings, folder.path()).expect("writes");
    let rig = Rig::load(&written.rig).expect("the rig file is accepted");
    let outcomes = written
        .logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()).expect("the log is read"))
        .collect();
    let (strikes, _) = assemble(outcomes);
    let world = World::nominal()
        .with("friction", 0.2)
        .with("restitution", 0.45);
    Input::of(rig, world, strikes)
}

fn diagnose(input: &Input) -> Diagnosed {
    Diagnose::default()
        .run(input, &Progress::hidden())
        .expect("a diagnosis")
}

#[test]
fn with_nothing_hidden_it_says_so_and_what_it_could_have_seen() {
    let found = diagnose(&input("none", 60, 21));
    assert_eq!(found.diagnosis.verdict, Verdict::Consistent);
    // None of its commands was repeated: what repeats scatter by is not measured yet.
    let next = &found.diagnosis.next_strikes;
    assert_eq!(next.len(), 12);
    assert!(next.iter().all(|strike| *strike == next[0]), "{next:?}");
    assert!(found.world.is_none() && found.diagnosis.effects.is_empty());
    let tilt = found
        .diagnosis
        .detectable
        .iter()
        .find(|d| d.name == "table_tilt")
        .expect("every candidate is listed");
    assert!((1e-5..5e-3).contains(&tilt.least), "{tilt:?}");
}

#[test]
fn a_tilt_is_named_measured_and_taken_away() {
    let input = input("table_tilt=-0.003,0.006", 100, 22);
    let found = diagnose(&input);
    let diagnosis = &found.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Named, "{}", diagnosis.summary);
    assert_eq!(diagnosis.effects.len(), 1);
    let tilt = &diagnosis.effects[0];
    assert_eq!(
        (tilt.name.as_str(), tilt.equivalent.len()),
        ("table_tilt", 0)
    );
    for (parameter, truth) in [("tilt_x", -0.003), ("tilt_y", 0.006)] {
        let p = &tilt.parameters[parameter];
        let width = p.high - p.low;
        assert!((p.value - truth).abs() < width, "{parameter}: {p:?}");
        assert!(width < 0.002, "{parameter}: {p:?}");
    }
    let gap = &diagnosis.gap;
    assert!(
        gap.before > 1.25 * gap.noise_floor && gap.after < 1.25 * gap.noise_floor,
        "{gap:?}"
    );
    assert_eq!(diagnosis.next_strikes.len(), 12);
    let robot = &input.rig.robot;
    for strike in &diagnosis.next_strikes {
        assert!((robot.speed.low..=robot.speed.high).contains(&strike.speed));
        assert!((robot.angle.low..=robot.angle.high).contains(&strike.angle));
    }
    let world = found.world.expect("a world with the tilt");
    assert_eq!(world.effects.len(), 1);
    assert_eq!(World::parse(&world.to_toml()).expect("reads back"), world);
}

#[test]
fn a_mixture_is_taken_apart_though_its_largest_error_looks_like_scatter() {
    // Three effects turn every launch by 8.7° together: at the scatter that this makes by itself, the turn is no news.
    let found = diagnose(&input("demo", 240, 1));
    let diagnosis = &found.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Named, "{}", diagnosis.summary);
    let turns = [
        "striker_angle_bias",
        "off_centre_contact",
        "camera_rotation",
    ];
    for class in [
        &turns[..],
        &["speed_weakening_friction"],
        &["table_tilt"],
        &["striker_speed_error"],
    ] {
        let names = || diagnosis.effects.iter().map(|effect| effect.name.as_str());
        assert!(
            names().any(|name| class.contains(&name)),
            "{class:?}: {}",
            diagnosis.summary
        );
    }
    // The arm saturates at 1.02 m/s of 1.2 times the command, which restitution makes up for.
    let arm = diagnosis
        .effects
        .iter()
        .find(|e| e.name == "striker_speed_error");
    let cap = arm.expect("named").parameters["cap"].value;
    assert!((0.82..0.88).contains(&cap), "{cap}");
    let gap = &diagnosis.gap;
    assert!(
        gap.before > 6.0 * gap.noise_floor && gap.after < 1.5 * gap.noise_floor,
        "{gap:?}"
    );
    let speed = diagnosis.r#where.iter().find(|w| w.covariate == "speed");
    let text = &speed.expect("launches depend on speed").description;
    assert!(text.contains("moves stops by"), "{text}");
}

#[test]
fn the_answer_does_not_depend_on_threads() {
    let input = input("friction_patch", 60, 24);
    let run = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool")
            .install(|| diagnose(&input))
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn too_few_strikes_are_an_error_that_says_how_many() {
    let mut few = input("none", 40, 25);
    let learning: Vec<Strike> = few
        .strikes
        .iter()
        .filter(|strike| strike.split != Split::Test)
        .take(5)
        .cloned()
        .collect();
    few.strikes = learning;
    let error = Diagnose::default()
        .run(&few, &Progress::hidden())
        .expect_err("too few");
    assert!(matches!(
        error,
        DiagnoseError::TooFewStrikes {
            strikes: 5,
            needed: 8
        }
    ));
}

#[test]
fn friction_that_jumps_in_one_session_is_named_as_such() {
    let mut input = input("none", 100, 26);
    // A session on another surface: its strikes stop in half the way.
    for strike in &mut input.strikes {
        if strike.conditions.session.contains("002") {
            let initial = strike.initial;
            let stretch = |x: f64, from: f64| from + 0.5 * (x - from);
            for i in 0..strike.track.len() {
                strike.track.t[i] *= 0.5;
                strike.track.x[i] = stretch(strike.track.x[i], initial.x);
                strike.track.y[i] = stretch(strike.track.y[i], initial.y);
            }
            strike.stop = values::Point::new(
                stretch(strike.stop.x, initial.x),
                stretch(strike.stop.y, initial.y),
            );
        }
    }
    let diagnosis = diagnose(&input).diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Named, "{}", diagnosis.summary);
    assert!(
        diagnosis
            .effects
            .iter()
            .any(|e| e.name == "friction_by_session")
    );
}

#[test]
fn strikes_that_judge_the_gap_veto_no_name_and_move_no_parameter() {
    // They were made on a table that leans the other way: the gap says so, and nothing else changes.
    let usual = input("table_tilt=-0.003,0.006", 100, 22);
    let other = input("table_tilt=0.003,-0.006", 100, 22);
    let judges = |strike: &Strike| strike.split == Split::Test;
    let mut spoilt = usual.clone();
    spoilt.strikes.retain(|strike| !judges(strike));
    spoilt
        .strikes
        .extend(other.strikes.into_iter().filter(judges));
    let (found, spoilt) = (diagnose(&usual), diagnose(&spoilt));
    assert_eq!(classes(&found), [["table_tilt"]]);
    assert_eq!(found.world, spoilt.world);
    let (found, spoilt) = (found.diagnosis, spoilt.diagnosis);
    assert_eq!(found.effects, spoilt.effects);
    assert_eq!((found.verdict, found.noise), (spoilt.verdict, spoilt.noise));
    assert!(found.gap.after < found.gap.before, "{:?}", found.gap);
    let half = spoilt.gap.change_half_95.expect("many judge");
    assert!(spoilt.gap.change > half, "{:?}", spoilt.gap);
}

#[test]
fn of_an_effect_that_is_smaller_than_stops_scatter_the_gaps_change_is_given_with_its_interval() {
    // The tracks show this tilt beyond doubt; it moves stops by 2 to 3 mm, where repeats scatter by 5 mm: a few strikes that judge say nothing of it.
    let found = diagnose(&input("table_tilt=0.0015,0.001", 60, 51));
    assert_eq!(classes(&found), [["table_tilt"]]);
    let gap = &found.diagnosis.gap;
    let half = gap.change_half_95.expect("more than one strike judges");
    assert!(gap.change.abs() < half, "{} ± {half}", gap.change);
}

#[test]
fn an_effect_that_moves_stops_by_little_is_told_and_not_named() {
    // By 1 mm, where repeats scatter by 5 mm; the tracks show it all the same.
    let found = diagnose(&input("table_tilt=0.0006,0.0004", 60, 51)).diagnosis;
    assert_eq!(found.verdict, Verdict::Consistent, "{}", found.summary);
    let told = "table_tilt (it moves stops by less than a third of what repeats scatter by)";
    let is_told = found.notes.iter().any(|note| note.contains(told));
    assert!(is_told, "{:?}", found.notes);
}

#[test]
fn a_form_at_the_end_of_its_range_is_reported_and_is_not_named_alone() {
    // A hollow whose middle lies as far beyond the strikes as is looked for it.
    let hidden = "table_bowl=kappa:0.03,center_x:1.1,center_y:0.5";
    let found = diagnose(&input(hidden, 120, 31));
    let diagnosis = &found.diagnosis;
    assert_eq!(diagnosis.verdict, Verdict::Named, "{}", diagnosis.summary);
    let [bowl] = &diagnosis.effects[..] else {
        panic!("{}", diagnosis.summary)
    };
    assert_eq!(bowl.name, "table_bowl");
    let middle = &bowl.parameters["center_x"];
    assert!(
        middle.high - middle.low > 1.0,
        "its whole range: {middle:?}"
    );
    assert!(!bowl.equivalent.is_empty(), "it is not named alone");
    let said = "center_x of table_bowl was fitted at the end of its range";
    assert!(
        diagnosis.notes.iter().any(|note| note.contains(said)),
        "{:?}",
        diagnosis.notes
    );
}

#[test]
fn a_stain_that_is_wider_than_any_disc_of_the_library_is_a_curved_edge_or_a_disc() {
    // Of 0.6 m radius beside the strikes, which meet no more than its edge: the library's discs end at 0.5 m.
    let hidden = "friction_patch=center_x:0.5,center_y:-0.55,radius:0.6,change:0.6,stretch:1.0";
    let found = diagnose(&input(hidden, 120, 31));
    assert_eq!(classes(&found), [["friction_step", "friction_patch"]]);
    let curvature = &found.diagnosis.effects[0].parameters["curvature"];
    assert!(
        (curvature.value.abs() - 1.0 / 0.6).abs() < 0.15,
        "{curvature:?}"
    );
}

/// For each effect named, its name and those that the data cannot distinguish from it.
fn classes(found: &Diagnosed) -> Vec<Vec<&str>> {
    let effects = found.diagnosis.effects.iter();
    effects
        .map(|effect| {
            let others = effect.equivalent.iter().map(String::as_str);
            [effect.name.as_str()].into_iter().chain(others).collect()
        })
        .collect()
}

#[test]
fn a_form_that_is_wider_than_the_usual_one_is_one_name() {
    for (hidden, name) in [
        // Friction by heading without a force across, a table that sags one way only, lengths foreshortened along a lean.
        ("cosine_grain=0.3,1.2", "anisotropic_friction"),
        ("trough=0.16,0.5,-0.05,0.5", "table_bowl"),
        ("camera_lean=0.19,1.1,0.8", "camera_lean"),
    ] {
        let found = diagnose(&input(hidden, 80, 41));
        let classes = classes(&found);
        assert!(
            matches!(&classes[..], [class] if class[0] == name),
            "{hidden}: {}",
            found.diagnosis.summary
        );
    }
}

#[test]
fn a_drag_of_any_power_is_no_friction_that_weakens_with_speed() {
    let found = diagnose(&input("power_drag=0.65,1.54", 90, 43));
    let [class] = &classes(&found)[..] else {
        panic!("{}", found.diagnosis.summary)
    };
    assert!(class[0].ends_with("_drag"), "{class:?}");
    assert!(!class.contains(&"speed_weakening_friction"), "{class:?}");
}

#[test]
fn two_effects_that_may_both_be_taken_for_others_are_both_named() {
    let found = diagnose(&input(
        "viscous_drag=1.2+viscoelastic_restitution=1.8",
        120,
        42,
    ));
    let classes = classes(&found);
    for name in ["viscous_drag", "speed_dependent_restitution"] {
        assert!(
            classes.iter().any(|class| class.contains(&name)),
            "{name}: {classes:?}"
        );
    }
    assert_eq!(classes.len(), 2, "{classes:?}");
}

#[test]
fn restitution_that_falls_as_one_over_the_speed_is_an_arms_offset_too() {
    let found = diagnose(&input("speed_dependent_restitution=0.98,0.78", 60, 45));
    let classes = classes(&found);
    assert_eq!(classes.len(), 1, "{classes:?}");
    for name in ["striker_speed_error", "speed_dependent_restitution"] {
        assert!(classes[0].contains(&name), "{classes:?}");
    }
}

#[test]
fn a_box_that_an_effect_brakes_on_its_way_slides_as_the_world_with_it_says() {
    let input = input_of(Shape::Box, "logarithmic_stribeck=0.45,0.5", 80, 43);
    let found = diagnose(&input);
    assert_eq!(classes(&found), [["speed_weakening_friction"]]);
}

#[test]
fn where_most_objects_are_pushed_on_their_way_that_is_the_reason_and_nothing_is_named() {
    let found = diagnose(&input("vibration=9.1,2.3,0.65,-3", 60, 44)).diagnosis;
    assert_eq!(found.verdict, Verdict::Unexplained);
    assert!(found.summary.contains("speeds up again"), "{found:?}");
    assert!(found.cause.expect("known").contains("table moves"));
}

#[test]
fn a_line_of_glue_is_stated_where_it_lies_and_is_no_smooth_field() {
    let (x, lean) = (0.47, 0.2);
    let hidden = format!("sticky_line={x},{lean},0.06,0.008");
    let found = diagnose(&input(&hidden, 100, 45)).diagnosis;
    assert_eq!(found.verdict, Verdict::Unexplained);
    let stated = found
        .summary
        .split_once("a line lies across the table through (");
    let (at, _) = stated.expect("stated").1.split_once(')').expect("a place");
    let (at_x, at_y) = at.split_once(", ").expect("x and y");
    let [at_x, at_y]: [f64; 2] = [at_x, at_y].map(|value| value.parse().expect("in m"));
    assert!((at_x - lean * at_y - x).abs() < 0.015, "{}", found.summary);
}

#[test]
fn a_table_of_bumps_is_named_and_what_pulls_towards_one_place_is_stated() {
    let bumps = diagnose(&input("table_map=0.02,0.15,7", 120, 46));
    assert_eq!(classes(&bumps), [["table_map"]]);
    let gap = &bumps.diagnosis.gap;
    assert!(gap.after < 0.5 * gap.before, "{gap:?}");
    let magnet = diagnose(&input("magnet=0.48,0.04,0.07,0.9", 120, 47)).diagnosis;
    assert_eq!(magnet.verdict, Verdict::Unexplained, "{}", magnet.summary);
    let notes = magnet.notes.join("\n");
    assert!(notes.contains("may lie outside their intervals"), "{notes}");
    let said = "something pulls objects towards (0.4";
    assert!(magnet.summary.contains(said), "{}", magnet.summary);
}

#[test]
fn what_no_table_and_no_arm_does_is_stated_and_nothing_is_named_for_it() {
    for (hidden, seed, said) in [
        (
            "side_force=0.35",
            51,
            "paths curl to the left, by a force across the way of 0.3",
        ),
        (
            "swirl=1.0,0.5,-0.1",
            52,
            "something pushes objects round about (0.5",
        ),
        (
            "stitched_cameras=0.48,0.004,0.008",
            53,
            "objects are seen shifted by",
        ),
    ] {
        let found = diagnose(&input(hidden, 90, seed)).diagnosis;
        assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.summary);
        assert!(found.summary.contains(said), "{}", found.summary);
    }
}

#[test]
fn a_table_that_is_levelled_anew_for_each_session_is_no_arm_and_no_friction() {
    let tilts = ["-0.012,0.02", "0.015,-0.02", "0.01,0.025"];
    let mut all = input("none", 2, 1);
    all.strikes.clear();
    for (tilt, seed) in tilts.into_iter().zip(50..) {
        let session = format!("{seed}.mcap");
        let strikes = input(&format!("table_tilt={tilt}"), 40, seed).strikes;
        all.strikes.extend(strikes.into_iter().map(|mut strike| {
            strike.id = format!("{session}/{}", strike.id);
            strike.log.clone_from(&session);
            strike.conditions.session.clone_from(&session);
            strike.conditions.order += 40.0 * (seed - 50) as f64;
            strike
        }));
    }
    let diagnosis = diagnose(&all).diagnosis;
    assert_eq!(
        diagnosis.verdict,
        Verdict::Unexplained,
        "{}",
        diagnosis.summary
    );
    let said = "the table slopes down otherwise in each session";
    assert!(diagnosis.summary.contains(said), "{}", diagnosis.summary);
}

#[test]
fn a_seam_along_which_strikes_go_is_no_smooth_field() {
    // Along +x, nearly: y = 0.05 · (x - 0.3).
    let seam = diagnose(&input("friction_step=0.3,20,0,0.2,0.005", 120, 48));
    assert_eq!(classes(&seam), [["friction_step"]]);
}

/// Strikes with nothing hidden, of which these were made with another command than is logged.
fn struck_otherwise(is_other: impl Fn(usize) -> bool, logged: fn(Command) -> Command) -> Diagnosed {
    let mut input = input("none", 120, 31);
    for (i, strike) in input.strikes.iter_mut().enumerate() {
        if is_other(i) {
            strike.command = logged(strike.command);
        }
    }
    diagnose(&input)
}

#[test]
fn a_few_strikes_that_were_struck_otherwise_are_told_and_nothing_stands_on_them() {
    let slower = |command: Command| Command::new(command.speed / 1.5, command.angle);
    let diagnosis = struck_otherwise(|i| i % 15 == 7, slower).diagnosis;
    assert_eq!(
        diagnosis.verdict,
        Verdict::Consistent,
        "{}",
        diagnosis.summary
    );
    let told = diagnosis.strays.expect("eight are told");
    assert!(told.starts_with("8 of "), "{told}");
    assert!(diagnosis.summary.contains(&*told) && !diagnosis.is_another_now);
    let clean = struck_otherwise(|_| false, slower).diagnosis;
    assert!(clean.strays.is_none());
    let ratio = diagnosis.gap.noise_floor / clean.gap.noise_floor;
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
}

#[test]
fn the_latest_strikes_that_were_struck_otherwise_are_a_gap_though_they_are_few() {
    let turned = |command: Command| Command::new(command.speed, command.angle + 0.1);
    let diagnosis = struck_otherwise(|i| i >= 108, turned).diagnosis;
    assert_eq!(
        diagnosis.verdict,
        Verdict::Unexplained,
        "{}",
        diagnosis.summary
    );
    assert!(diagnosis.is_another_now, "{}", diagnosis.summary);
    assert!(
        diagnosis.summary.contains("the latest"),
        "{}",
        diagnosis.summary
    );
}

#[test]
fn what_has_no_name_is_predicted_without_one() {
    let found = diagnose(&input("magnet=0.48,0.04,0.07,0.9", 120, 47));
    assert!(found.world.is_none());
    let carried = found
        .carried
        .as_ref()
        .expect("a world that predicts better");
    assert_eq!(found.used(), Some(carried));
    assert!(!carried.effects.is_empty() && found.diagnosis.effects.is_empty());
    let notes = found.diagnosis.notes.join("\n");
    assert!(notes.contains("not named, but fit to serve"), "{notes}");
}
