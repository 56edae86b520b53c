//! Night after night, each with a fault.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, ensure};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::fault::Fault;
use super::folder::{Folder, WORKED};

#[derive(Clone, Copy, Debug)]
pub struct Settings {
    pub nights: usize,
    pub first: usize,
    /// Strikes of each night after it.
    pub strikes: usize,
    /// Draws strikes and faults.
    pub seed: u64,
}

#[derive(Clone, Debug)]
pub struct Soaked {
    /// Strikes at the end, all of them in the tables.
    pub strikes: usize,
    /// Nights by the fault that struck them, in the order of their names.
    pub faults: Vec<(&'static str, usize)>,
    /// Undisturbed nights that promoted a version.
    pub promoted: usize,
    /// Nights that promoted one though a fault struck them.
    pub promoted_after_fault: usize,
    /// The version in use at the end.
    pub latest: String,
    /// Peak memory of the nights that computed, in bytes, in their order.
    pub memory: Vec<u64>,
}

/// Nights of which a mean peak says whether memory grows.
const FEWEST: usize = 10;

impl Soaked {
    /// Mean peak memory of the middle and the last third of the nights, in bytes. The first nights have too few strikes for
    /// what the later ones do. None of a few nights: what a fault interrupts takes half the memory of a whole night.
    pub fn memory_ends(&self) -> Option<[u64; 2]> {
        let third = self.memory.len() / 3;
        if third < FEWEST {
            return None;
        }
        let mean = |part: &[u64]| part.iter().sum::<u64>() / part.len().max(1) as u64;
        let last = self.memory.len() - third;
        Some([
            mean(&self.memory[last - third..last]),
            mean(&self.memory[last..]),
        ])
    }
}

/// Goes through the nights; `faulty` is that program, and `report` is called with each night. An error says what did not hold.
pub fn soak(
    faulty: &Path,
    settings: Settings,
    report: &mut dyn FnMut(String),
) -> anyhow::Result<Soaked> {
    let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
    let mut folder = Folder::new(faulty, settings.seed)?;
    folder.log_strikes(0, settings.first)?;
    let mut last = folder.night()?;
    ensure!(last.status() == "promoted", "the first night: {last:?}");
    let mut soaked = Soaked {
        strikes: 0,
        faults: Vec::new(),
        promoted: 1,
        promoted_after_fault: 0,
        latest: folder.latest()?,
        memory: Vec::new(),
    };
    let mut counts = std::collections::BTreeMap::new();
    for night in 1..=settings.nights {
        folder.log_strikes(night, settings.strikes)?;
        let fault = Fault::draw(&mut random);
        *counts.entry(fault.name()).or_insert(0) += 1;
        let before = soaked.latest.clone();
        let begun = Instant::now();
        let named = || format!("night {night}, {}", fault.name());

        fault
            .strike(&mut folder, &last, &mut random)
            .with_context(named)?;
        let after_fault = folder.latest().with_context(named)?;
        ensure!(
            after_fault == before || folder.is_next(&after_fault, &before)?,
            "{}: {after_fault} is in use after {before}",
            named()
        );
        soaked.promoted_after_fault += usize::from(after_fault != before);

        let ended = folder.night().with_context(named)?;
        ensure!(WORKED.contains(&ended.code), "{}: {ended:?}", named());
        folder.holds_every_strike().with_context(named)?;
        soaked.latest = folder.latest().with_context(named)?;
        let is_promoted = ended.status() == "promoted";
        ensure!(
            (soaked.latest != after_fault) == is_promoted && ended.json["latest"] == *soaked.latest,
            "{}: {} is in use after {after_fault}: {ended:?}",
            named(),
            soaked.latest
        );
        soaked.promoted += usize::from(is_promoted);
        if ended.status() != "nothing_new" {
            soaked.memory.push(ended.memory);
        }
        report(format!(
            "{night:>4} {:<22} {:<11} {} in use, {} strikes, {} MiB, {:.1} s",
            fault.name(),
            ended.status(),
            soaked.latest,
            ended.json["strikes"],
            ended.memory >> 20,
            begun.elapsed().as_secs_f64()
        ));
        if ended.status() != "nothing_new" {
            last = ended;
        }
    }
    soaked.strikes = folder.holds_every_strike()?;
    soaked.faults = counts.into_iter().collect();
    if let Some([middle, last]) = soaked.memory_ends() {
        ensure!(
            last <= middle + middle / 4,
            "the memory grows: {middle} bytes in the middle third of the nights, {last} in the last"
        );
    }
    Ok(soaked)
}
