//! What a kill, damage or a failing stage does to a run.

use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicUsize;

use serde::Serialize;
use stage::{ItemStage, Progress, Run, RunError, Stage, StageError};

use crate::fixture::{
    Sum, Times, TimesError, below, counted, expected, files, listed, open, options, sum, times,
};

#[test]
fn every_damaged_byte_of_an_answer_is_seen_and_the_answer_computed_again() {
    let dir = tempfile::tempdir().expect("folder");
    sum(dir.path(), 2.0, &[1.0]);
    let path = files(dir.path(), "answer").pop().expect("one answer");
    let whole = fs::read(&path).expect("is there");
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x40;
        fs::write(&path, &bytes).expect("writes");
        assert_eq!(sum(dir.path(), 2.0, &[1.0]), (2.0, 1), "byte {at}");
        fs::write(&path, &whole[..at]).expect("writes");
        assert_eq!(sum(dir.path(), 2.0, &[1.0]), (2.0, 1), "cut at {at}");
    }
    assert_eq!(fs::read(&path).expect("is there"), whole);
}

#[test]
fn an_answer_under_the_name_of_another_input_is_computed_again() {
    let dir = tempfile::tempdir().expect("folder");
    sum(dir.path(), 2.0, &[1.0]);
    let first = files(dir.path(), "answer").pop().expect("one answer");
    let bytes = fs::read(&first).expect("is there");
    fs::remove_file(&first).expect("removes");
    sum(dir.path(), 2.0, &[5.0]);
    let second = files(dir.path(), "answer").pop().expect("one answer");
    fs::write(second, bytes).expect("writes");
    assert_eq!(sum(dir.path(), 2.0, &[5.0]), (10.0, 1));
}

#[test]
fn an_answer_of_another_type_is_computed_again() {
    #[derive(Serialize)]
    struct Older;
    impl Stage for Older {
        const NAME: &'static str = "sum";
        const VERSION: u32 = 1;
        type Input = [f64];
        type Output = String;
        type Error = StageError;
        fn run(&self, _: &[f64], _: &Progress) -> Result<String, StageError> {
            Ok("three".into())
        }
    }
    #[derive(Serialize)]
    struct Newer;
    impl Stage for Newer {
        const NAME: &'static str = "sum";
        const VERSION: u32 = 1;
        type Input = [f64];
        type Output = f64;
        type Error = StageError;
        fn run(&self, _: &[f64], _: &Progress) -> Result<f64, StageError> {
            Ok(3.0)
        }
    }
    let dir = tempfile::tempdir().expect("folder");
    open(dir.path()).stage(&Older, &[1.0]).expect("answers");
    let run = open(dir.path());
    assert_eq!(run.stage(&Newer, &[1.0]).expect("answers"), 3.0);
    assert_eq!(run.summary().stages[0].damaged, 1);
}

#[test]
fn a_failed_batch_loses_no_earlier_batch() {
    let dir = tempfile::tempdir().expect("folder");
    let items: Vec<u32> = (0..300).collect();
    let count = AtomicUsize::new(0);
    let failed = open(dir.path()).items(
        &Times {
            items: &count,
            fails_at: Some(250),
        },
        &1.0,
        &items,
    );
    assert!(matches!(failed, Err(RunError::Stage(TimesError))));
    let kept = count.into_inner();
    assert!(kept > 0);
    assert_eq!(
        times(dir.path(), 1.0, &items),
        (expected(1.0, &items), 300 - kept)
    );
}

#[test]
fn a_wrong_number_of_answers_is_an_error() {
    #[derive(Serialize)]
    struct Short;
    impl ItemStage for Short {
        const NAME: &'static str = "short";
        const VERSION: u32 = 1;
        type Shared = ();
        type Item = u32;
        type Output = u32;
        type Error = TimesError;
        fn run_items(&self, _: &(), _: &[&u32], _: &Progress) -> Result<Vec<u32>, TimesError> {
            Ok(vec![1])
        }
    }
    let dir = tempfile::tempdir().expect("folder");
    let failed = open(dir.path()).items(&Short, &(), &[1, 2]);
    assert!(matches!(
        failed,
        Err(RunError::Store(StageError::Rows {
            answers: 1,
            items: 2,
            ..
        }))
    ));
}

/// One run of both stages, in a folder where a fault may strike.
fn both(dir: &Path, items: &[u32]) -> Result<(f64, Vec<Vec<f64>>), StageError> {
    let (count, runs) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let run = Run::open(dir, options("test 1"))?;
    let store = |error| match error {
        RunError::Stage(error) => error,
        RunError::Store(error) => error,
    };
    let sum = Sum {
        factor: 1.0,
        runs: &runs,
    };
    let total = run.stage(&sum, &[1.0, 2.0][..]).map_err(store)?;
    let answers = run.items(&counted(&count), &2.0, items);
    match answers {
        Ok(answers) => Ok((total, answers)),
        Err(RunError::Store(error)) => Err(error),
        Err(RunError::Stage(error)) => panic!("{error}"),
    }
}

#[test]
fn a_run_killed_at_any_step_is_resumed_with_the_same_bytes() {
    let items: Vec<u32> = (0..200).collect();
    let clean = tempfile::tempdir().expect("folder");
    let truth = both(clean.path(), &items).expect("runs");
    let contents = |dir: &Path| -> Vec<Vec<u8>> {
        let all = [files(dir, "answer"), files(dir, "pack")].concat();
        all.iter()
            .map(|path| fs::read(path).expect("is there"))
            .collect()
    };
    for step in 1.. {
        let dir = tempfile::tempdir().expect("folder");
        let (killed, struck) = durable::faults::after(step, || both(dir.path(), &items));
        assert_eq!(killed.is_err(), struck, "step {step}");
        assert_eq!(
            both(dir.path(), &items).expect("resumes"),
            truth,
            "step {step}"
        );
        assert_eq!(contents(dir.path()), contents(clean.path()), "step {step}");
        assert!(files(dir.path(), "partial").is_empty(), "step {step}");
        if !struck {
            assert!(step > 10, "only {step} steps");
            break;
        }
    }
}

#[test]
fn every_damaged_byte_of_a_list_is_seen_and_the_list_computed_again() {
    let dir = tempfile::tempdir().expect("folder");
    below(dir.path(), &[3]).expect("lists");
    let folder = files(dir.path(), "lists").pop().expect("one folder");
    let list = fs::read_dir(folder).expect("folder").next();
    let path = list.expect("one list").expect("entry").path();
    let whole = fs::read(&path).expect("is there");
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x40;
        for damaged in [&bytes, &whole[..at]] {
            fs::write(&path, damaged).expect("writes");
            let again = below(dir.path(), &[3]).expect("lists");
            assert_eq!(again, (listed(&[3]), 1), "byte {at}");
        }
    }
    assert_eq!(fs::read(&path).expect("is there"), whole);
}

#[test]
fn lists_of_a_run_killed_at_any_step_are_resumed() {
    // Faults are set for one thread.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.expect("a thread").install(|| {
        for step in 1.. {
            let dir = tempfile::tempdir().expect("folder");
            let items = [40, 2, 3000];
            let (killed, struck) = durable::faults::after(step, || below(dir.path(), &items));
            assert_eq!(killed.is_err(), struck, "step {step}");
            let (lists, computed) = below(dir.path(), &items).expect("resumes");
            assert_eq!(lists, listed(&items), "step {step}");
            assert!(computed <= 3, "step {step}");
            if !struck {
                assert!(computed == 0 && step > 15, "only {step} steps");
                break;
            }
        }
    });
}

#[test]
fn the_list_of_another_item_is_seen_in_its_place() {
    let dir = tempfile::tempdir().expect("folder");
    below(dir.path(), &[3, 5]).expect("lists");
    let folder = files(dir.path(), "lists").pop().expect("one folder");
    let lists: Vec<_> = fs::read_dir(folder)
        .expect("folder")
        .map(|entry| entry.expect("entry").path())
        .collect();
    fs::copy(&lists[0], &lists[1]).expect("copied");
    let again = below(dir.path(), &[3, 5]).expect("lists");
    assert_eq!(again, (listed(&[3, 5]), 1));
}
