//! Fuzzing of all that is read from outside: bytes that are changed at random must be read or refused, never panic, hang or fill
//! the memory.
//!
//! Seeds are made, not kept. An input that is answered as none before it was joins them, so that later ones go on from there:
//! the kinds of answers replace the coverage that stable Rust does not report.

mod executor;
mod images;
mod live;
mod mutate;
mod seeds;
mod segmenter;
mod targets;

use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use targets::targets;

/// Something that reads bytes.
pub struct Target {
    pub name: &'static str,
    pub seeds: Vec<Vec<u8>>,
    pub words: Vec<&'static str>,
    pub read: Reads,
}

/// Reads an input, or says why not.
pub type Reads = Box<dyn Fn(&[u8]) -> anyhow::Result<()> + Send + Sync>;

/// Inputs that are gone on from, at the most.
const LARGEST_CORPUS: usize = 500;
/// Longest input, in bytes.
const LONGEST: usize = 64 << 10;
/// No input may take longer.
const SLOWEST: Duration = Duration::from_secs(10);

#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Until so many inputs were tried.
    pub tries: u64,
    pub time: Duration,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct FuzzCounts {
    pub tries: u64,
    pub read: u64,
    pub kinds: usize,
}

#[derive(Debug)]
pub struct Finding {
    pub input: Vec<u8>,
    pub what: String,
}

/// Tries inputs on a target until the budget is spent, or one does harm. The same seed tries the same ones.
pub fn fuzz(target: &Target, seed: u64, budget: Budget) -> Result<FuzzCounts, Box<Finding>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut corpus = target.seeds.clone();
    let mut kinds = HashSet::new();
    let mut tally = FuzzCounts::default();
    let begun = Instant::now();
    while tally.tries < budget.tries && begun.elapsed() < budget.time {
        let at = usize::try_from(tally.tries).unwrap_or(usize::MAX);
        // Each seed as it is, first.
        let input = match corpus.get(at).filter(|_| at < target.seeds.len()) {
            Some(seed) => seed.clone(),
            None => {
                // What is read as often as what is refused.
                let from = if random.random() {
                    &target.seeds
                } else {
                    &corpus
                };
                let mut input = from[random.random_range(0..from.len())].clone();
                mutate::mutate(&mut input, &corpus, &target.words, &mut random);
                input.truncate(LONGEST);
                input
            }
        };
        let answer = answer(target, &input)?;
        tally.tries += 1;
        tally.read += u64::from(answer.is_ok());
        if kinds.insert(kind(&answer)) && corpus.len() < LARGEST_CORPUS {
            corpus.push(input);
        }
    }
    Ok(FuzzCounts {
        kinds: kinds.len(),
        ..tally
    })
}

pub fn answer(target: &Target, input: &[u8]) -> Result<Result<(), String>, Box<Finding>> {
    let found = |what: String| {
        Box::new(Finding {
            input: input.to_vec(),
            what,
        })
    };
    let begun = Instant::now();
    let answer = catch_unwind(AssertUnwindSafe(|| (target.read)(input)))
        .map_err(|_| found("it panics".into()))?;
    let took = begun.elapsed();
    if took > SLOWEST {
        return Err(found(format!("it takes {:.0} s", took.as_secs_f64())));
    }
    Ok(answer.map_err(|error| error.to_string()))
}

/// An answer without its numbers and names.
fn kind(answer: &Result<(), String>) -> String {
    let text = answer.as_ref().err().map_or("read", String::as_str);
    let plain = text.split('`').step_by(2).flat_map(str::chars);
    plain.filter(|c| c.is_ascii_lowercase()).take(160).collect()
}
