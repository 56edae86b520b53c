//! Nights of 25 strikes with `carom nightly`, on a table that is steady and on one whose friction changes for good.

use std::fs;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{RecordingWriter, Sim, Truth};
use serde::{Deserialize, Serialize};
use store::{ArtifactError, Store};
use strike::Planner;
use values::{Command, Point};

use super::drawn::{Case, LivingRig};
use crate::carom;

/// Nights, and strikes of each.
const NIGHTS: usize = 10;
const STRIKES: usize = 25;
/// The night before which friction changes for good, by this share.
const CHANGED: (usize, f64) = (6, 0.12);
/// Targets after each night, and how often each is struck.
const TARGETS: usize = 40;
const REPEATS: usize = 8;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NightOutcome {
    pub rig: u64,
    /// Whether friction changed before the seventh night.
    pub changes: bool,
    /// Number of the night, from 1.
    pub night: usize,
    pub exit: u8,
    pub status: String,
    /// Strikes that the version in use learnt from.
    pub learnt: usize,
    /// Mean miss at targets with the version in use, over the mean distance of repeats from their mean; none before a first version passed.
    pub ratio: Option<f64>,
    pub change: Option<String>,
    /// Why it ended so, a sentence each.
    pub why: Vec<String>,
}

/// The nights of one rig.
///
/// # Errors
/// What failed, for a person.
pub fn nights(number: u64, changes: bool, dir: &Path) -> anyhow::Result<Vec<NightOutcome>> {
    let rig = LivingRig::draw(number)?;
    let usual = rig.before(Case::Steady)?;
    let mut changed = usual.clone();
    changed.friction *= 1.0 + CHANGED.1;
    let logs = dir.join("logs");
    fs::create_dir_all(&logs)?;
    fs::write(dir.join("rig.toml"), usual.rig.to_toml())?;
    let mut outcomes = Vec::new();
    for night in 0..NIGHTS {
        let truth = if changes && night >= CHANGED.0 {
            &changed
        } else {
            &usual
        };
        let seed = number ^ (night as u64) << 20;
        strike(truth, night, seed, &logs)?;
        let line = format!(
            "nightly {} --rig {} --out {}",
            logs.display(),
            dir.join("rig.toml").display(),
            dir.join("run").display()
        );
        let said = carom(&line)?;
        let artifact = match Store::open(&dir.join("run")).load(None) {
            Err(ArtifactError::NoLatest { .. }) => None,
            loaded => Some(loaded?),
        };
        let known = artifact
            .as_ref()
            .and_then(|artifact| artifact.manifest.provenance.strikes);
        let ratio = |artifact: &store::Artifact| ratio(artifact, truth, night, seed);
        outcomes.push(NightOutcome {
            rig: number,
            changes,
            night: night + 1,
            exit: said.outcome as u8,
            status: said.json["status"].as_str().unwrap_or_default().into(),
            learnt: known.map_or(0, |known| known.count),
            ratio: artifact.as_ref().map(ratio).transpose()?,
            change: said.json["change"]["what"].as_str().map(String::from),
            why: serde_json::from_value(said.json["why"].clone())?,
        });
        println!("{:?}", outcomes[outcomes.len() - 1]);
    }
    Ok(outcomes)
}

/// A night's log: strikes at random.
fn strike(truth: &Truth, night: usize, seed: u64, logs: &Path) -> anyhow::Result<()> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut sim = Sim::from(truth.clone())?
        .after(night * STRIKES)
        .in_session(night);
    let path = logs.join(format!("night_{night:02}.mcap"));
    let mut writer = RecordingWriter::create(&path, &truth.rig.topics)?;
    for _ in 0..STRIKES {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let from = Point::new(between(0.22, 0.36), between(-0.12, 0.12));
        let command = Command::new(between(0.5, 0.9), between(-0.35, 0.35));
        writer.write(&sim.strike(from, command).samples)?;
    }
    writer.finish()?;
    Ok(())
}

/// Misses at targets over what repeats scatter by.
fn ratio(
    artifact: &store::Artifact,
    truth: &Truth,
    night: usize,
    seed: u64,
) -> anyhow::Result<f64> {
    let planner = Planner::new(artifact, artifact.manifest.provenance.default_model)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x7A6);
    let mut sim = Sim::from(truth.clone())?
        .after(10_000 + night * 100)
        .in_session(night);
    let (mut misses, mut distances) = (Vec::new(), Vec::new());
    for _ in 0..20 * TARGETS {
        let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let from = Point::new(between(0.24, 0.34), between(-0.1, 0.1));
        let to = from + Point::polar(between(0.12, 0.4), between(-0.3, 0.3));
        let Ok(plan) = planner.plan(from, to) else {
            continue;
        };
        let stops = [(); REPEATS].map(|()| sim.strike(from, plan.command()).stop);
        let repeats = REPEATS as f64;
        misses.extend(stops.map(|stop| stop.distance(to)));
        let sum = stops.iter().fold(Point::default(), |sum, stop| sum + *stop);
        let widening = (repeats / (repeats - 1.0)).sqrt();
        distances.extend(stops.map(|stop| widening * stop.distance(sum * (1.0 / repeats))));
        if misses.len() == TARGETS * REPEATS {
            break;
        }
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    anyhow::ensure!(!misses.is_empty(), "no target was planned");
    Ok(mean(&misses) / mean(&distances))
}

/// The page's table.
pub fn table(outcomes: &[NightOutcome]) -> String {
    let mut text = String::from(
        "## Nights\n\nNights of 25 strikes with `carom nightly`; misses at 40 targets, each struck eight times, with the version in use after each night, over the repeat \
         scatter. In the second table friction is 12 % higher from the seventh night on.\n",
    );
    for changes in [false, true] {
        text += "\n| rig |";
        for night in 1..=NIGHTS {
            text += &format!(" {night} |");
        }
        text += &format!(
            " in use at the end | exits |\n|---|{}---|---|\n",
            "---|".repeat(NIGHTS)
        );
        let of = |outcome: &&NightOutcome| outcome.changes == changes;
        let mut rigs: Vec<u64> = outcomes.iter().filter(of).map(|o| o.rig).collect();
        rigs.dedup();
        for rig in rigs {
            let all: Vec<&NightOutcome> = outcomes
                .iter()
                .filter(of)
                .filter(|o| o.rig == rig)
                .collect();
            text += &format!("| {rig} |");
            for outcome in &all {
                match outcome.ratio {
                    Some(ratio) => text += &format!(" {ratio:.2} |"),
                    None => text += " – |",
                }
            }
            let exits: Vec<String> = all.iter().map(|outcome| outcome.exit.to_string()).collect();
            let learnt = all.last().map_or(0, |outcome| outcome.learnt);
            text += &format!(" {learnt} strikes' | {} |\n", exits.join(" "));
        }
    }
    text
}
