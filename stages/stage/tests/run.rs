//! How a run behaves: what it computes, what it reuses, and what a kill, damage or a second run does to it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;
use stage::{ItemStage, ListStage, Options, Progress, Run, RunError, Stage, StageError};

/// Sums its input, times a factor; counts how often it is run.
#[derive(Serialize)]
struct Sum<'a> {
    factor: f64,
    #[serde(skip)]
    runs: &'a AtomicUsize,
}

impl Stage for Sum<'_> {
    const NAME: &'static str = "sum";
    const VERSION: u32 = 1;
    type Input = [f64];
    type Output = f64;
    type Error = StageError;

    fn run(&self, input: &[f64], _: &Progress) -> Result<f64, StageError> {
        self.runs.fetch_add(1, Ordering::Relaxed);
        Ok(input.iter().sum::<f64>() * self.factor)
    }
}

/// Multiplies each item with what is shared; counts the items, and fails from one on.
#[derive(Serialize)]
struct Times<'a> {
    #[serde(skip)]
    items: &'a AtomicUsize,
    #[serde(skip)]
    fails_at: Option<u32>,
}

#[derive(Debug, thiserror::Error)]
#[error("multiply")]
struct TimesError;

impl ItemStage for Times<'_> {
    const NAME: &'static str = "times";
    const VERSION: u32 = 1;
    type Shared = f64;
    type Item = u32;
    type Output = Vec<f64>;
    type Error = TimesError;

    fn run_items(
        &self,
        shared: &f64,
        items: &[&u32],
        progress: &Progress,
    ) -> Result<Vec<Vec<f64>>, TimesError> {
        if items
            .iter()
            .any(|item| self.fails_at.is_some_and(|at| **item >= at))
        {
            return Err(TimesError);
        }
        self.items.fetch_add(items.len(), Ordering::Relaxed);
        let answer = |item: &&u32| {
            progress.inc(1);
            vec![f64::from(**item) * shared; 3]
        };
        Ok(items.par_iter().map(answer).collect())
    }
}

/// Lists the numbers below each item, and tells their sum; counts the items.
#[derive(Serialize)]
struct Below<'a> {
    #[serde(skip)]
    items: &'a AtomicUsize,
}

impl ListStage for Below<'_> {
    const NAME: &'static str = "below";
    const VERSION: u32 = 1;
    type Shared = ();
    type Item = u32;
    type Entry = f64;
    type Output = f64;
    type Error = TimesError;

    fn run_item(&self, (): &(), item: &u32, keep: &mut dyn FnMut(f64)) -> Result<f64, TimesError> {
        self.items.fetch_add(1, Ordering::Relaxed);
        (0..*item).for_each(|number| keep(number.into()));
        Ok((0..*item).map(f64::from).sum())
    }
}

/// What is told of each list, its entries read backwards, and how many lists were computed.
type Lists = (Vec<(f64, Vec<f64>)>, usize);

fn below(dir: &Path, items: &[u32]) -> Result<Lists, StageError> {
    let options = Options {
        engine: "test 1".into(),
        is_quiet: true,
    };
    let run = Run::open(dir, options)?;
    let count = AtomicUsize::new(0);
    let lists = match run.lists(&Below { items: &count }, &(), items) {
        Ok(lists) => lists,
        Err(RunError::Store(error)) => return Err(error),
        Err(RunError::Stage(error)) => panic!("{error}"),
    };
    let read = items.iter().zip(lists).map(|(item, (sum, entries))| {
        let mut entries = entries.open()?;
        let backwards = (0..*item as usize).rev().map(|index| entries.entry(index));
        Ok((sum, backwards.collect::<Result<Vec<f64>, _>>()?))
    });
    let read = read.collect::<Result<Vec<_>, StageError>>()?;
    Ok((read, count.into_inner()))
}

/// What [`below`] must give.
fn listed(items: &[u32]) -> Vec<(f64, Vec<f64>)> {
    let list = |item: &u32| {
        let backwards: Vec<f64> = (0..*item).rev().map(f64::from).collect();
        (backwards.iter().sum(), backwards)
    };
    items.iter().map(list).collect()
}

fn open(dir: &Path) -> Run {
    let options = Options {
        engine: "test 1".into(),
        is_quiet: true,
    };
    Run::open(dir, options).expect("free folder")
}

fn sum(dir: &Path, factor: f64, input: &[f64]) -> (f64, usize) {
    let runs = AtomicUsize::new(0);
    let answer = open(dir)
        .stage(
            &Sum {
                factor,
                runs: &runs,
            },
            input,
        )
        .expect("sums");
    (answer, runs.into_inner())
}

fn times(dir: &Path, shared: f64, items: &[u32]) -> (Vec<Vec<f64>>, usize) {
    let count = AtomicUsize::new(0);
    let answers = open(dir)
        .items(
            &Times {
                items: &count,
                fails_at: None,
            },
            &shared,
            items,
        )
        .expect("multiplies");
    (answers, count.into_inner())
}

fn expected(shared: f64, items: &[u32]) -> Vec<Vec<f64>> {
    items
        .iter()
        .map(|item| vec![f64::from(*item) * shared; 3])
        .collect()
}

fn files(dir: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for stage in fs::read_dir(dir.join("cache")).expect("cache") {
        let stage = stage.expect("entry").path();
        if stage.is_dir() {
            found.extend(
                fs::read_dir(stage)
                    .expect("folder")
                    .map(|file| file.expect("entry").path()),
            );
        }
    }
    found.retain(|path| path.extension().is_some_and(|end| end == extension));
    found.sort();
    found
}

#[test]
fn a_stage_runs_again_only_for_other_settings_or_input() {
    let dir = tempfile::tempdir().expect("folder");
    assert_eq!(sum(dir.path(), 2.0, &[1.0, 2.0]), (6.0, 1));
    assert_eq!(sum(dir.path(), 2.0, &[1.0, 2.0]), (6.0, 0));
    assert_eq!(sum(dir.path(), 3.0, &[1.0, 2.0]), (9.0, 1));
    assert_eq!(sum(dir.path(), 2.0, &[1.0, 2.5]), (7.0, 1));
    assert_eq!(sum(dir.path(), 2.0, &[1.0, 2.0]), (6.0, 0));
}

#[test]
fn another_engine_computes_anew() {
    let dir = tempfile::tempdir().expect("folder");
    sum(dir.path(), 2.0, &[1.0]);
    let runs = AtomicUsize::new(0);
    let options = Options {
        engine: "test 2".into(),
        is_quiet: true,
    };
    let run = Run::open(dir.path(), options).expect("free folder");
    run.stage(
        &Sum {
            factor: 2.0,
            runs: &runs,
        },
        &[1.0],
    )
    .expect("sums");
    assert_eq!(runs.into_inner(), 1);
}

#[test]
fn ten_new_items_compute_ten_and_order_is_that_of_the_items() {
    let dir = tempfile::tempdir().expect("folder");
    let old: Vec<u32> = (0..500).collect();
    assert_eq!(times(dir.path(), 0.5, &old), (expected(0.5, &old), 500));
    assert_eq!(times(dir.path(), 0.5, &old), (expected(0.5, &old), 0));
    let mut new: Vec<u32> = (1000..1010).collect();
    new.extend(old.iter().rev());
    assert_eq!(times(dir.path(), 0.5, &new), (expected(0.5, &new), 10));
    assert_eq!(
        times(dir.path(), 0.25, &old).1,
        500,
        "what is shared has changed"
    );
}

#[test]
fn equal_items_are_computed_once_and_no_items_are_no_work() {
    let dir = tempfile::tempdir().expect("folder");
    assert_eq!(
        times(dir.path(), 1.0, &[7, 8, 7, 7]),
        (expected(1.0, &[7, 8, 7, 7]), 2)
    );
    assert_eq!(times(dir.path(), 1.0, &[]), (vec![], 0));
}

#[test]
fn the_summary_counts_what_was_computed_and_reused() {
    let dir = tempfile::tempdir().expect("folder");
    times(dir.path(), 1.0, &[1, 2, 3]);
    let (count, runs) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let run = open(dir.path());
    run.items(
        &Times {
            items: &count,
            fails_at: None,
        },
        &1.0,
        &[2, 3, 4],
    )
    .expect("multiplies");
    run.stage(
        &Sum {
            factor: 1.5,
            runs: &runs,
        },
        &[1.0],
    )
    .expect("sums");
    let summary = run.summary();
    let rows: Vec<_> = summary
        .stages
        .iter()
        .map(|row| (row.name, row.computed, row.reused))
        .collect();
    assert_eq!(rows, [("times", 1, 2), ("sum", 1, 0)]);
    assert!(!summary.is_all_reused());
    assert!(summary.to_string().contains("times"), "{summary}");
    let records = run.records();
    assert_eq!(records[1].settings, serde_json::json!({"factor": 1.5}));
    assert_eq!((records[1].name, records[1].version), ("sum", 1));
}

#[test]
fn a_second_run_in_the_folder_is_told_that_it_is_busy() {
    let dir = tempfile::tempdir().expect("folder");
    let first = open(dir.path());
    assert!(matches!(
        Run::open(dir.path(), Options::default()),
        Err(StageError::Busy { .. })
    ));
    drop(first);
    open(dir.path());
}

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
    let run = Run::open(
        dir,
        Options {
            engine: "test 1".into(),
            is_quiet: true,
        },
    )?;
    let store = |error| match error {
        RunError::Stage(error) => error,
        RunError::Store(error) => error,
    };
    let total = run
        .stage(
            &Sum {
                factor: 1.0,
                runs: &runs,
            },
            &[1.0, 2.0],
        )
        .map_err(store)?;
    let answers = run.items(
        &Times {
            items: &count,
            fails_at: None,
        },
        &2.0,
        items,
    );
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
fn one_thread_and_two_write_the_same_bytes() {
    let items: Vec<u32> = (0..400).collect();
    let pack = |threads| {
        let dir = tempfile::tempdir().expect("folder");
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| times(dir.path(), 0.1, &items));
        fs::read(&files(dir.path(), "pack")[0]).expect("one pack")
    };
    assert_eq!(pack(1), pack(2));
}

#[test]
fn answers_that_nothing_asks_for_do_not_pile_up() {
    let dir = tempfile::tempdir().expect("folder");
    for step in 0..30 {
        sum(dir.path(), f64::from(step), &[1.0]);
        times(dir.path(), f64::from(step), &[1, 2]);
    }
    assert_eq!(files(dir.path(), "answer").len(), 9);
    assert_eq!(files(dir.path(), "pack").len(), 9);
    assert_eq!(sum(dir.path(), 29.0, &[1.0]).1, 0, "the newest is kept");
    // One run may ask for more than are spared.
    let runs = AtomicUsize::new(0);
    let run = open(dir.path());
    for factor in 100..120 {
        run.stage(
            &Sum {
                factor: f64::from(factor),
                runs: &runs,
            },
            &[1.0],
        )
        .expect("sums");
    }
    for factor in 100..120 {
        run.stage(
            &Sum {
                factor: f64::from(factor),
                runs: &runs,
            },
            &[1.0],
        )
        .expect("sums");
    }
    assert_eq!(runs.into_inner(), 20);
}

#[test]
fn fifty_thousand_items_are_kept_in_seconds() {
    let dir = tempfile::tempdir().expect("folder");
    let items: Vec<u32> = (0..50_000).collect();
    let started = std::time::Instant::now();
    assert_eq!(times(dir.path(), 1.0, &items).1, 50_000);
    assert_eq!(times(dir.path(), 1.0, &items), (expected(1.0, &items), 0));
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}

#[test]
fn lists_are_computed_once_and_their_entries_read_in_any_order() {
    let dir = tempfile::tempdir().expect("folder");
    let read = |items: &[u32]| below(dir.path(), items).expect("lists");
    assert_eq!(read(&[5, 0, 3, 5]), (listed(&[5, 0, 3, 5]), 3));
    assert_eq!(read(&[3, 2000, 5]), (listed(&[3, 2000, 5]), 1));
    assert_eq!(read(&[]), (vec![], 0));
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

#[test]
fn what_is_still_kept_of_an_item_is_read_and_nothing_is_computed() {
    let dir = tempfile::tempdir().expect("folder");
    below(dir.path(), &[3]).expect("lists");
    let run = open(dir.path());
    let count = AtomicUsize::new(0);
    let kept = |item: u32| run.kept_list(&Below { items: &count }, &(), &item);
    assert_eq!(kept(3).expect("read").map(|(sum, _)| sum), Some(3.0));
    assert!(kept(4).expect("read").is_none());
    assert_eq!(count.load(Ordering::Relaxed), 0);
}
