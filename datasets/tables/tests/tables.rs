//! Tables read back as they were written, in the same bytes each time, and say what is wrong with them.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use tables::*;
use values::{
    Command, Conditions, Delivered, End, Point, Reject, RejectReason, Residual, Split, Strike,
    Track, Yaw,
};

fn strike(number: usize, frames: usize) -> Strike {
    let shift = number as f64 * 0.001;
    Strike {
        id: format!("{number:016x}"),
        log: format!("log_{}.mcap", number / 50),
        index: number as u32 % 50,
        t_start: 1.7e9 + shift,
        initial: Point::new(0.25, 0.05 - shift),
        stop: Point::new(0.55 + shift, 0.1),
        command: Command::new(0.7 + shift, -0.2),
        track: Track {
            t: (0..frames).map(|i| i as f64 / 60.0).collect(),
            x: (0..frames)
                .map(|i| 0.25 + i as f64 * 1e-3 + shift)
                .collect(),
            y: (0..frames).map(|i| 0.05 - i as f64 * 1e-4).collect(),
            yaw: number.is_multiple_of(4).then(|| Yaw {
                initial: 0.1 + shift,
                track: (0..frames).map(|i| 0.1 + i as f64 * 1e-2).collect(),
            }),
            end: End::Rest,
        },
        split: [Split::Train, Split::Validation, Split::Test][number % 3],
        conditions: Conditions {
            session: format!("log_{}.mcap", number / 50),
            order: number as f64,
            yaw: number.is_multiple_of(4).then_some(0.1 + shift),
            moving: None,
            is_unstruck: false,
            is_pushed_on: number % 9 == 1,
        },
        delivered: number.is_multiple_of(3).then_some(Delivered {
            tip_speed: 0.69 + shift,
            tip_angle: -0.19,
            contact: -0.004,
            pushed_again: number.is_multiple_of(2),
        }),
    }
}

fn rejects() -> Vec<Reject> {
    [
        RejectReason::NoRestBefore,
        RejectReason::ClockSkew,
        RejectReason::UnitsImplausible,
    ]
    .into_iter()
    .enumerate()
    .map(|(i, reason)| Reject {
        log: "a \"b\".mcap".into(),
        index: i as u32,
        t_start: 12.5,
        reason,
        detail: format!("μ at {i} m"),
    })
    .collect()
}

fn solution() -> SolutionRow {
    SolutionRow {
        strike_id: "1f".into(),
        speed_sim: 0.71,
        angle_sim: -0.11,
        miss: f64::NAN,
        evaluations: 4,
        status: "unreachable".into(),
    }
}

fn residual() -> Residual {
    Residual {
        strike_id: "1f".into(),
        path: Point::new(0.3, -0.1),
        speed_sim: 0.71,
        angle_sim: -0.11,
        d_speed: 0.02,
        d_angle: -0.003,
        split: Split::Test,
    }
}

#[test]
fn strikes_and_tracks_read_back_joined() {
    let dir = tempfile::tempdir().expect("folder");
    // More frames than a row group holds, and a strike without any.
    let mut strikes: Vec<_> = (0..700).map(|number| strike(number, 100)).collect();
    strikes[3].track = Track::default();
    write_strikes(dir.path(), &strikes).expect("writes");
    assert_eq!(read_strikes(dir.path()).expect("reads"), strikes);
}

#[test]
fn the_other_tables_read_back() {
    let dir = tempfile::tempdir().expect("folder");
    write_rejects(dir.path(), &rejects()).expect("writes");
    assert_eq!(read_rejects(dir.path()).expect("reads"), rejects());
    write_solutions(dir.path(), &[solution()]).expect("writes");
    let read = read_solutions(dir.path()).expect("reads");
    assert!(read[0].miss.is_nan());
    assert_eq!(
        (read[0].evaluations, read[0].status.as_str()),
        (4, "unreachable")
    );
    write_residuals(dir.path(), &[residual()]).expect("writes");
    assert_eq!(read_residuals(dir.path()).expect("reads"), [residual()]);
}

#[test]
fn no_rows_are_a_table_too() {
    let dir = tempfile::tempdir().expect("folder");
    write_strikes(dir.path(), &[]).expect("writes");
    write_rejects(dir.path(), &[]).expect("writes");
    assert_eq!(read_strikes(dir.path()).expect("reads"), []);
    assert_eq!(read_rejects(dir.path()).expect("reads"), []);
}

#[test]
fn the_same_rows_give_the_same_bytes() {
    let strikes: Vec<_> = (0..700).map(|number| strike(number, 100)).collect();
    let bytes = || {
        let dir = tempfile::tempdir().expect("folder");
        write_strikes(dir.path(), &strikes).expect("writes");
        write_residuals(dir.path(), &vec![residual(); 100]).expect("writes");
        let names = ["strikes", "tracks", "residuals"];
        names.map(|name| fs::read(dir.path().join(format!("{name}.parquet"))).expect("is there"))
    };
    let first = bytes();
    // Hash maps are seeded anew each time: were one written in its order, some round would show it.
    for _ in 0..8 {
        assert!(bytes() == first);
    }
}

#[test]
fn a_missing_a_foreign_and_a_torn_table_are_distinguished() {
    let dir = tempfile::tempdir().expect("folder");
    let path = dir.path();
    assert!(matches!(
        read_rejects(path),
        Err(TableError::Missing { .. })
    ));
    write_solutions(path, &[solution()]).expect("writes");
    fs::rename(path.join("solutions.parquet"), path.join("rejects.parquet")).expect("renames");
    let error = read_rejects(path).expect_err("foreign");
    assert!(matches!(error, TableError::Layout { .. }), "{error}");
    assert!(
        error.to_string().contains("speed_sim: Float64 m/s"),
        "{error}"
    );
    fs::write(path.join("rejects.parquet"), b"PAR1 no table PAR1").expect("writes");
    assert!(matches!(
        read_rejects(path),
        Err(TableError::Damaged { .. })
    ));
}

#[test]
fn tracks_of_another_run_are_refused() {
    let (dir, other) = (
        tempfile::tempdir().expect("folder"),
        tempfile::tempdir().expect("folder"),
    );
    let swap = |strikes: &[Strike]| {
        write_strikes(other.path(), strikes).expect("writes");
        fs::copy(
            other.path().join("tracks.parquet"),
            dir.path().join("tracks.parquet"),
        )
        .expect("copies");
        read_strikes(dir.path()).expect_err("refused").to_string()
    };
    write_strikes(dir.path(), &[strike(1, 5), strike(2, 5)]).expect("writes");
    let text = swap(&[strike(1, 5), strike(3, 5)]);
    assert!(text.contains("is not in strikes.parquet"), "{text}");
    let text = swap(&[strike(1, 5), strike(2, 4)]);
    assert!(
        text.contains("has 4 frames in tracks.parquet and should have 5"),
        "{text}"
    );
    write_strikes(dir.path(), &[strike(1, 5), strike(1, 5)]).expect("writes");
    assert!(
        read_strikes(dir.path())
            .expect_err("refused")
            .to_string()
            .contains("twice")
    );
}

#[test]
fn a_write_stopped_at_any_step_leaves_the_old_table_or_the_new_one() {
    let dir = tempfile::tempdir().expect("folder");
    for step in 1.. {
        write_rejects(dir.path(), &[]).expect("writes");
        let (_, struck) = durable::faults::after(step, || write_rejects(dir.path(), &rejects()));
        let rows = read_rejects(dir.path()).expect("whole").len();
        assert!(rows == 0 || rows == 3);
        if !struck {
            assert_eq!(rows, 3);
            break;
        }
    }
}

fn damaged(dir: &Path, at: prop::sample::Index, flip: u8, cut: bool) {
    let path = dir.join("strikes.parquet");
    let mut bytes = fs::read(&path).expect("is there");
    let at = at.index(bytes.len());
    if cut {
        bytes.truncate(at);
    } else {
        bytes[at] ^= flip;
    }
    fs::write(&path, bytes).expect("writes");
}

#[test]
fn no_byte_that_is_changed_ends_the_program() {
    // A page that is of another kind than the reader expects, too, which it asserts against.
    const FLIP: u8 = 176;
    let dir = tempfile::tempdir().expect("folder");
    write_strikes(dir.path(), &[strike(1, 3)]).expect("writes");
    let path = dir.path().join("strikes.parquet");
    let whole = fs::read(&path).expect("is there");
    let mut gave_up = 0;
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= FLIP;
        fs::write(&path, bytes).expect("writes");
        if let Err(error) = read_strikes(dir.path()) {
            gave_up += usize::from(error.to_string().contains("gave up"));
        }
    }
    assert!(
        gave_up > 0,
        "nothing shows that the reader's own end is caught"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn damage_is_an_error_or_harmless_and_never_a_crash(at in any::<prop::sample::Index>(), flip in 1u8.., cut: bool) {
        let dir = tempfile::tempdir().expect("folder");
        write_strikes(dir.path(), &[strike(1, 3), strike(2, 3)]).expect("writes");
        damaged(dir.path(), at, flip, cut);
        match read_strikes(dir.path()) {
            Ok(strikes) => prop_assert!(!cut && strikes.len() <= 2),
            Err(error) => prop_assert!(error.to_string().contains(".parquet")),
        }
    }

    #[test]
    fn any_text_and_number_reads_back(detail: String, log: String, index: u32, t_start: f64) {
        let dir = tempfile::tempdir().expect("folder");
        let reject = Reject { log, index, t_start, reason: RejectReason::OffTable, detail };
        write_rejects(dir.path(), std::slice::from_ref(&reject)).expect("writes");
        let read = read_rejects(dir.path()).expect("reads").remove(0);
        prop_assert_eq!(read.t_start.to_bits(), reject.t_start.to_bits());
        prop_assert_eq!((read.log, read.index, read.detail), (reject.log, reject.index, reject.detail));
    }
}
