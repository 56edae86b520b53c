//! Where the arm's state is logged, what the arm does is estimated from it, apart from the impact and the camera.

use diagnose::{Diagnose, Diagnosed, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{Hidden, demo};
use stage::{Progress, Stage};
use values::{Rig, Shape, Strike};
use world::World;

/// The diagnosis of a demo of 120 strikes with this hidden, its arm's state logged or not.
fn diagnosis(hidden: &str, log_state: bool) -> Diagnosed {
    diagnosis_of(hidden, log_state, |_| {})
}

/// The same, where this was done to each strike.
fn diagnosis_of(hidden: &str, log_state: bool, done: impl Fn(&mut Strike)) -> Diagnosed {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden = Hidden::parse(&[hidden]).expect("an effect");
    let mut settings = demo::Settings::new(Shape::Cylinder, 120, 11, Some(hidden));
    settings.log_state = log_state;
    let written = demo::write(&settings, folder.path()).expect("writes");
    let rig = Rig::load(&written.rig).expect("the rig file is accepted");
    let read = |log| ingest_log(log, &rig, &Ingest::default()).expect("the log is read");
    let (mut strikes, _) = assemble(written.logs.iter().map(|log| read(log)).collect());
    strikes.iter_mut().for_each(done);
    let identify = sysid::Input {
        rig: rig.clone(),
        world: World::nominal(),
        strikes: strikes.clone(),
        later: Vec::new(),
    };
    let fit = sysid::Sysid::default()
        .run(&identify, &Progress::hidden())
        .expect("identifies");
    let input = Input::of(rig, fit.world, strikes);
    Diagnose::default()
        .run(&input, &Progress::hidden())
        .expect("diagnoses")
}

fn names(found: &Diagnosed) -> Vec<&str> {
    let effects = found.diagnosis.effects.iter();
    effects.map(|effect| effect.name.as_str()).collect()
}

#[test]
fn the_arms_effects_and_what_they_are_taken_for_are_each_named_alone() {
    for hidden in [
        "striker_speed_error",
        // Most of its strikes are slower than that: what a cap does to the others must not be taken for what is not typical.
        "striker_speed_error=a:0,b:1,cap:0.8,softness:0",
        "striker_angle_bias",
        "striker_error_by_place=speed_x:-0.6,angle_y:0.3",
        "speed_dependent_restitution",
    ] {
        let found = diagnosis(hidden, true);
        let diagnosis = &found.diagnosis;
        println!("{hidden}: {}", diagnosis.summary);
        for note in &diagnosis.notes {
            println!("  {note}");
        }
        assert_eq!(diagnosis.verdict, Verdict::Named, "{hidden}");
        let name = hidden.split('=').next().expect("a name");
        assert_eq!(names(&found), [name], "{}", diagnosis.summary);
        assert_eq!(diagnosis.effects[0].equivalent, [] as [&str; 0], "{hidden}");
        assert!(
            diagnosis.gap.after < 0.7 * diagnosis.gap.before,
            "{hidden} {:?}",
            diagnosis.gap
        );
    }
}

#[test]
fn a_turned_camera_is_not_taken_for_the_arm() {
    let found = diagnosis("camera_rotation", true);
    println!("{}", found.diagnosis.summary);
    let effect = &found.diagnosis.effects[0];
    let class: Vec<&str> = [effect.name.as_str()]
        .into_iter()
        .chain(effect.equivalent.iter().map(String::as_str))
        .collect();
    assert!(class.contains(&"camera_rotation"), "{class:?}");
    assert!(
        class.iter().all(|name| !name.starts_with("striker")),
        "{class:?}"
    );
}

#[test]
fn a_lens_that_looks_down_elsewhere_is_one_lens() {
    let found = diagnosis("off_centre_lens=k1:0.35,off_x:0.05,off_y:-0.06", false);
    assert_eq!(
        names(&found),
        ["camera_distortion"],
        "{}",
        found.diagnosis.summary
    );
    let lens = &found.diagnosis.effects[0].parameters;
    let off = [lens["center_x"].value - 0.5, lens["center_y"].value + 0.06];
    assert!(off.iter().all(|off| off.abs() < 0.02), "{lens:?}");
}

#[test]
fn of_an_arm_that_delivers_its_commands_nothing_is_named() {
    let found = diagnosis("viscous_drag", true);
    assert_eq!(
        names(&found),
        ["viscous_drag"],
        "{}",
        found.diagnosis.summary
    );
    let notes = found.diagnosis.notes.join("\n");
    assert!(
        notes.contains("in the arm") && notes.contains("at the impact"),
        "{notes}"
    );
    // 0.3 % is no law of an arm whose state is read to 0.5 %, however surely neighbours agree on it.
    let found = diagnosis("striker_speed_error=0,1.003,9,0.01", true);
    assert_eq!(names(&found), [""; 0], "{}", found.diagnosis.summary);
    let notes = found.diagnosis.notes.join("\n");
    assert!(notes.contains("than a state is read to"), "{notes}");
}

#[test]
fn what_an_arm_does_beside_its_commands_is_no_scatter_of_it() {
    let hidden = "warming_arm=change:-0.12";
    let [commanded, delivered] = [false, true].map(|log_state| diagnosis(hidden, log_state));
    for found in [&commanded, &delivered] {
        let diagnosis = &found.diagnosis;
        assert_ne!(diagnosis.verdict, Verdict::Consistent);
        let is_of_speed = names(found).contains(&"striker_speed_error");
        assert!(!is_of_speed, "{}", diagnosis.summary);
    }
    let floors = [commanded, delivered].map(|found| found.diagnosis.gap.noise_floor);
    assert!(floors[1] < 1.3 * floors[0], "{floors:?}");
}

#[test]
fn a_state_that_objects_do_not_follow_is_not_believed() {
    // Whoever logs it cuts its peaks off.
    let found = diagnosis_of("none", true, |strike| {
        if let Some(delivered) = &mut strike.delivered {
            delivered.tip_speed = delivered.tip_speed.min(0.7);
        }
    });
    let diagnosis = &found.diagnosis;
    assert_eq!(names(&found), [""; 0], "{}", diagnosis.summary);
    let is_told = diagnosis
        .notes
        .iter()
        .any(|note| matches!(note.finding(), Some(diagnose::Note::AsCommanded)));
    assert!(is_told, "{:?}", diagnosis.notes);
}

#[test]
fn an_arm_that_errs_as_no_law_does_is_told_and_where() {
    for (hidden, covariate) in [("speed_ripple", "speed"), ("angle_ripple", "angle")] {
        let found = diagnosis(hidden, true).diagnosis;
        assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.summary);
        assert_eq!(found.r#where[0].covariate, covariate, "{hidden}");
        assert!(found.cause.expect("known").contains("depends on"));
        assert!(
            found.gap.after > 1.5 * found.gap.noise_floor,
            "{:?}",
            found.gap
        );
    }
    let found = diagnosis("none", true).diagnosis;
    assert_eq!(found.verdict, Verdict::Consistent, "{}", found.summary);
    let floor = found.gap.noise_floor;
    assert!(
        (0.6 * floor..1.5 * floor).contains(&found.gap.after),
        "{:?}",
        found.gap
    );
}
