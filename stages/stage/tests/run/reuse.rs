//! What a run computes, and what it reuses.

use std::fs;
use std::sync::atomic::{AtomicUsize, Ordering};

use stage::{Options, Run, StageError};

use crate::fixture::{
    Below, below, counted, expected, files, listed, open, options, sum, summed, times,
};

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
    let run = Run::open(dir.path(), options("test 2")).expect("free folder");
    summed(&run, 2.0, &runs, &[1.0]);
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
    run.items(&counted(&count), &1.0, &[2, 3, 4])
        .expect("multiplies");
    summed(&run, 1.5, &runs, &[1.0]);
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
fn a_second_run_in_the_folder_learns_that_it_is_busy() {
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
    for factor in (100..120).chain(100..120) {
        summed(&run, f64::from(factor), &runs, &[1.0]);
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
