//! What a diagnosis makes of a table whose friction scatters and whose camera is no ideal one, and of forms that the library does
//! not have. Seeds are of development: no page reports them.

#[expect(
    dead_code,
    reason = "the example that measures uses the other kinds of noise"
)]
#[path = "support/table.rs"]
mod table;

use diagnose::{Diagnosis, Verdict};
use table::{Hidden, Noise, Plan, Table};

fn diagnosed(noise: Noise, hidden: Hidden, seed: u64) -> Diagnosis {
    diagnosed_of(160, noise, hidden, seed)
}

fn diagnosed_of(strikes: usize, noise: Noise, hidden: Hidden, seed: u64) -> Diagnosis {
    let table = Table {
        noise,
        hidden: vec![hidden],
        plan: Plan::Random,
        strikes,
        seed,
    };
    table.diagnosed()
}

#[test]
fn friction_that_scatters_and_a_correlated_camera_are_noise_and_reported() {
    let found = diagnosed(Noise::Mixed, Hidden::Nothing, 12);
    assert_eq!(found.verdict, Verdict::Consistent, "{}", found.summary);
    let noise = found.noise;
    assert!((0.015..0.025).contains(&noise.friction), "{noise:?}");
    assert!((0.4..0.6).contains(&noise.camera_correlation), "{noise:?}");
    assert!((0.9e-3..1.1e-3).contains(&noise.camera), "{noise:?}");
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("friction scatters")),
        "{:?}",
        found.notes
    );
}

#[test]
fn stray_frames_are_left_out() {
    let found = diagnosed(Noise::Stray, Hidden::Nothing, 2);
    assert_eq!(found.verdict, Verdict::Consistent, "{}", found.summary);
    assert!(found.noise.frames_left_out > 10, "{:?}", found.noise);
    assert!(found.noise.camera < 1.1e-3, "{:?}", found.noise);
}

#[test]
fn a_rectangle_of_friction_is_a_patch_and_nothing_else() {
    let found = diagnosed(Noise::Mixed, Hidden::Rectangle(0.2), 40);
    assert_eq!(found.verdict, Verdict::Named, "{}", found.summary);
    let names: Vec<&str> = found.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["friction_patch"]);
    assert!(found.gap.after < found.gap.before);
    assert!(found.p_value >= 1.0 / (1 + found.replicates) as f64);
}

#[test]
fn friction_that_wanders_is_noise_and_neither_a_drift_nor_a_change_by_session() {
    let found = diagnosed(Noise::Mixed, Hidden::Wander(0.01), 7);
    assert_eq!(found.verdict, Verdict::Consistent, "{}", found.summary);
    assert!(found.noise.friction > 0.02, "{:?}", found.noise);
}

#[test]
fn a_force_across_the_motion_is_no_tilt() {
    let found = diagnosed(Noise::Ideal, Hidden::Magnus(0.2), 8);
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.summary);
    let across = |w: &diagnose::GapDependence| w.description.contains("push across the way");
    assert!(found.r#where.iter().any(across), "{:?}", found.r#where);
}

#[test]
fn a_wave_of_the_delivered_launch_is_no_scatter() {
    for (hidden, covariate) in [
        (Hidden::SpeedWave(0.08, 0.2), "speed"),
        (Hidden::AngleWave(0.04, 0.4), "angle"),
    ] {
        let found = diagnosed_of(60, Noise::Ideal, hidden, 21);
        assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.summary);
        assert_eq!(found.r#where[0].covariate, covariate, "{:?}", found.r#where);
    }
}

#[test]
fn effects_that_move_stops_and_cannot_be_shown_to_predict_are_no_scatter() {
    let found = (0..6).map(|seed| diagnosed_of(25, Noise::Mixed, Hidden::Rectangle(0.35), seed));
    let is_unpaid = |found: &Diagnosis| {
        let mut notes = found.notes.iter();
        notes.any(|note| note.contains("predicts the others no better"))
    };
    let found: Vec<Diagnosis> = found.filter(is_unpaid).collect();
    assert!(!found.is_empty());
    for found in found {
        assert_eq!(found.verdict, Verdict::Unexplained, "{}", found.summary);
        assert!(
            found.summary.contains("log more strikes"),
            "{}",
            found.summary
        );
    }
}
