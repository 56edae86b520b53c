//! Several workers in one folder, killed or stuck, and the run that takes their answers in.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, mpsc};
use std::thread;
use std::time::Duration;

use serde::Serialize;
use stage::{Event, Options, PATIENCE, Progress, Run, Share, Stage, StageError, workers};

use crate::fixture::{
    Below, Sum, below, counted, expected, files, listed, open, options, sum, times,
};

const ITEMS: u32 = 300;

fn join(dir: &Path, index: usize, count: usize, patience: Duration) -> Result<Run, StageError> {
    let share = Share {
        index,
        count,
        patience,
    };
    Run::join(dir, options("test 1"), share)
}

/// All that a worker is asked in these tests; how many answers it computed.
fn work(run: &Run) -> Result<usize, String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let (sums, products, lists) = Default::default();
    let items: Vec<u32> = (0..ITEMS).collect();
    let below = Below { items: &lists };
    let lengths: Vec<u32> = (0..20).collect();
    let listed_here = run.lists(&below, &(), &lengths);
    let listed_here = listed_here.map_err(|error| said(&error))?;
    for ((sum, _), (other, _)) in listed_here.into_iter().zip(listed(&lengths)) {
        assert_eq!(sum, other);
    }
    let factor = Sum {
        factor: 2.0,
        runs: &sums,
    };
    let sum = run.stage(&factor, &[1.0, 2.0][..]);
    assert_eq!(sum.map_err(|error| said(&error))?, 6.0);
    let stage = counted(&products);
    // What a call before asked is not asked again, wherever the blocks begin.
    let some = run.items(&stage, &3.0, &items[5..100]);
    some.map_err(|error| said(&error))?;
    let answers = run.items(&stage, &3.0, &items);
    assert_eq!(
        answers.map_err(|error| said(&error))?,
        expected(3.0, &items)
    );
    Ok([sums, products, lists]
        .map(AtomicUsize::into_inner)
        .iter()
        .sum())
}

/// The run afterwards finds all of it, and leaves nothing of the work behind.
fn all_is_found(dir: &Path) {
    let items: Vec<u32> = (0..ITEMS).collect();
    let lengths: Vec<u32> = (0..20).collect();
    assert_eq!(times(dir, 3.0, &items), (expected(3.0, &items), 0));
    assert_eq!(sum(dir, 2.0, &[1.0, 2.0]), (6.0, 0));
    assert_eq!(below(dir, &lengths).expect("lists"), (listed(&lengths), 0));
    assert!(files(dir, "parts").is_empty() && !dir.join("cache/work").exists());
    assert_eq!(
        times(dir, 3.0, &items),
        (expected(3.0, &items), 0),
        "taken in, it stays"
    );
}

#[test]
fn each_answer_is_computed_by_one_of_many_workers_and_the_run_finds_it() {
    let dir = tempfile::tempdir().expect("folder");
    let one = |index| {
        let dir = dir.path();
        move || work(&join(dir, index, 4, PATIENCE).expect("joins")).expect("works")
    };
    let computed: usize = thread::scope(|scope| {
        let workers: Vec<_> = (0..4).map(|index| scope.spawn(one(index))).collect();
        workers
            .into_iter()
            .map(|worker| worker.join().expect("lives"))
            .sum()
    });
    assert_eq!(computed, 1 + ITEMS as usize + 20);
    let seen = workers(dir.path()).expect("reads");
    assert!(seen.len() == 4 && seen.iter().all(|worker| !worker.is_alive));
    let done = |line: &stage::Line| match &line.event {
        Event::Done { items, .. } => *items,
        _ => 0,
    };
    let done: usize = seen
        .iter()
        .flat_map(|worker| worker.lines.iter().map(done))
        .sum();
    assert_eq!(done, ITEMS as usize + 20);
    all_is_found(dir.path());
}

#[test]
fn one_worker_after_another_does_what_is_left_and_a_single_one_does_everything() {
    let dir = tempfile::tempdir().expect("folder");
    let computed = [(5, 9), (0, 2), (0, 1)].map(|(index, count)| {
        work(&join(dir.path(), index, count, PATIENCE).expect("joins")).expect("works")
    });
    assert_eq!(computed, [1 + ITEMS as usize + 20, 0, 0]);
    all_is_found(dir.path());
}

#[test]
fn killed_at_any_step_a_worker_leaves_whole_answers_that_count_once() {
    let mut kills = 0;
    for step in (1..).step_by(3) {
        let dir = tempfile::tempdir().expect("folder");
        // One thread: the fault is that thread's.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let (result, struck) = pool.expect("a pool").install(|| {
            durable::faults::after(step, || {
                let run = join(dir.path(), 0, 2, PATIENCE).map_err(|error| error.to_string())?;
                work(&run)
            })
        });
        assert_eq!(result.is_err(), struck, "step {step}");
        let next = join(dir.path(), 1, 2, PATIENCE).expect("joins");
        work(&next).unwrap_or_else(|error| panic!("step {step}: failed to {error}"));
        drop(next);
        all_is_found(dir.path());
        if !struck {
            break;
        }
        kills += 1;
    }
    assert!(kills > 30, "{kills}");
}

/// Waits, where it is told to, until it is released.
#[derive(Serialize)]
struct Slow<'a> {
    #[serde(skip)]
    begun: &'a mpsc::SyncSender<()>,
    #[serde(skip)]
    release: Option<&'a Mutex<mpsc::Receiver<()>>>,
    #[serde(skip)]
    runs: &'a AtomicUsize,
}

impl Stage for Slow<'_> {
    const NAME: &'static str = "slow";
    const VERSION: u32 = 1;
    type Input = ();
    type Output = u32;
    type Error = StageError;

    fn run(&self, (): &(), _: &Progress) -> Result<u32, StageError> {
        self.runs.fetch_add(1, Ordering::Relaxed);
        if let Some(release) = self.release {
            self.begun.send(()).expect("heard");
            release.lock().expect("free").recv().expect("released");
        }
        Ok(7)
    }
}

#[test]
fn a_worker_that_neither_answers_nor_ends_holds_nobody_up_for_ever() {
    let dir = tempfile::tempdir().expect("folder");
    let (begun, has_begun) = mpsc::sync_channel(1);
    let (release, released) = mpsc::channel();
    let released = Mutex::new(released);
    let runs = AtomicUsize::new(0);
    let slow = |release| Slow {
        begun: &begun,
        release,
        runs: &runs,
    };
    let stuck = slow(Some(&released));
    thread::scope(|scope| {
        let first = scope.spawn(|| {
            let run = join(dir.path(), 0, 2, PATIENCE).expect("joins");
            run.stage(&stuck, &()).expect("answers")
        });
        has_begun.recv().expect("begins");
        let second = join(dir.path(), 1, 2, Duration::from_millis(5)).expect("joins");
        assert_eq!(second.stage(&slow(None), &()).expect("answers"), 7);
        release.send(()).expect("waits");
        assert_eq!(first.join().expect("lives"), 7);
    });
    assert_eq!(runs.load(Ordering::Relaxed), 2);
    assert_eq!(open(dir.path()).stage(&slow(None), &()).expect("kept"), 7);
    assert_eq!(runs.into_inner(), 2, "the answer is there once");
}

#[test]
fn a_run_and_workers_exclude_each_other() {
    let dir = tempfile::tempdir().expect("folder");
    let worker = join(dir.path(), 0, 1, PATIENCE).expect("joins");
    let options = Options::default();
    assert!(matches!(
        Run::open(dir.path(), options),
        Err(StageError::Busy { .. })
    ));
    assert!(workers(dir.path()).expect("reads")[0].is_alive);
    drop(worker);
    let _run = open(dir.path());
    assert!(matches!(
        join(dir.path(), 0, 1, PATIENCE),
        Err(StageError::Busy { .. })
    ));
}

#[test]
fn a_damaged_answer_of_a_worker_is_computed_again() {
    let dir = tempfile::tempdir().expect("folder");
    work(&join(dir.path(), 0, 1, PATIENCE).expect("joins")).expect("works");
    let parts = files(dir.path(), "parts").pop().expect("parts");
    let mut parts: Vec<_> = fs::read_dir(parts).expect("parts").flatten().collect();
    parts.sort_by_key(fs::DirEntry::path);
    let path = parts[0].path();
    let mut bytes = fs::read(&path).expect("is there");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&path, &bytes).expect("writes");
    let again = join(dir.path(), 0, 1, PATIENCE).expect("joins");
    let count = work(&again).expect("works");
    assert!(count > 0 && count < ITEMS as usize, "{count}");
    drop(again);
    all_is_found(dir.path());
}
