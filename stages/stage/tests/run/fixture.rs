//! Three small stages, and runs of them.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;
use stage::{ItemStage, ListStage, Options, Progress, Run, RunError, Stage, StageError};

/// Sums its input, times a factor; counts how often it is run.
#[derive(Serialize)]
pub struct Sum<'a> {
    pub factor: f64,
    #[serde(skip)]
    pub runs: &'a AtomicUsize,
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
pub struct Times<'a> {
    #[serde(skip)]
    pub items: &'a AtomicUsize,
    #[serde(skip)]
    pub fails_at: Option<u32>,
}

#[derive(Debug, thiserror::Error)]
#[error("multiply")]
pub struct TimesError;

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

/// Lists the numbers below each item, and returns their sum; counts the items.
#[derive(Serialize)]
pub struct Below<'a> {
    #[serde(skip)]
    pub items: &'a AtomicUsize,
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

/// The answer for each list, its entries read backwards, and how many lists were computed.
pub type Lists = (Vec<(f64, Vec<f64>)>, usize);

pub fn below(dir: &Path, items: &[u32]) -> Result<Lists, StageError> {
    let run = Run::open(dir, options("test 1"))?;
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
pub fn listed(items: &[u32]) -> Vec<(f64, Vec<f64>)> {
    let list = |item: &u32| {
        let backwards: Vec<f64> = (0..*item).rev().map(f64::from).collect();
        (backwards.iter().sum(), backwards)
    };
    items.iter().map(list).collect()
}

pub fn options(engine: &str) -> Options {
    Options {
        engine: engine.into(),
        is_quiet: true,
    }
}

pub fn open(dir: &Path) -> Run {
    Run::open(dir, options("test 1")).expect("free folder")
}

/// Multiplies without failing.
pub fn counted(items: &AtomicUsize) -> Times<'_> {
    let fails_at = None;
    Times { items, fails_at }
}

/// What a run sums.
pub fn summed(run: &Run, factor: f64, runs: &AtomicUsize, input: &[f64]) -> f64 {
    run.stage(&Sum { factor, runs }, input).expect("sums")
}

pub fn sum(dir: &Path, factor: f64, input: &[f64]) -> (f64, usize) {
    let runs = AtomicUsize::new(0);
    let answer = summed(&open(dir), factor, &runs, input);
    (answer, runs.into_inner())
}

pub fn times(dir: &Path, shared: f64, items: &[u32]) -> (Vec<Vec<f64>>, usize) {
    let count = AtomicUsize::new(0);
    let answers = open(dir)
        .items(&counted(&count), &shared, items)
        .expect("multiplies");
    (answers, count.into_inner())
}

pub fn expected(shared: f64, items: &[u32]) -> Vec<Vec<f64>> {
    items
        .iter()
        .map(|item| vec![f64::from(*item) * shared; 3])
        .collect()
}

pub fn files(dir: &Path, extension: &str) -> Vec<PathBuf> {
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
