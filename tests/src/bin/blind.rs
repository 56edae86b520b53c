//! Runs the hidden-effect benchmark: in parallel, resuming where it stopped, and writes its page.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use anyhow::Context;
use clap::Parser;
use rayon::prelude::*;
use serde::{Serialize, de::DeserializeOwned};
use tests::blind::{
    Case, Outcome, Peers, Struck, cases, diagnosed, is_for_peers, page, peers, run, starts, struck,
};

/// Hides effects in strikes, and grades whether the diagnosis names them.
#[derive(Debug, Parser)]
struct Args {
    /// Seeds of each combination.
    #[arg(long, default_value_t = 2)]
    seeds: u64,
    /// The first seed.
    #[arg(long, default_value_t = 100)]
    first: u64,
    /// Only sets whose name holds this.
    #[arg(long, default_value = "")]
    only: String,
    /// Print what is hidden and what was found of each set, in place of grading them.
    #[arg(long)]
    show: bool,
    /// Outcomes, one JSON object a line; sets that it holds are not run again.
    #[arg(long, default_value = "artifacts/blind.jsonl")]
    outcomes: PathBuf,
    /// Also what peers make of the same sets; a Python with pysindy.
    #[arg(long)]
    peers: Option<PathBuf>,
    /// Also how many strikes tell pairs apart, chosen and at random.
    #[arg(long)]
    chosen: bool,
    /// The page to write.
    #[arg(long)]
    page: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let all: Vec<_> = cases(args.seeds, args.first)
        .into_iter()
        .filter(|case| case.id.contains(&args.only))
        .collect();
    if args.show {
        for case in &all {
            println!("{}", case.id);
            match diagnosed(case) {
                None => println!("the rig cannot make it"),
                Some(Err(error)) => println!("{error}"),
                Some(Ok(done)) => {
                    println!("{}", serde_json::to_string(&done.truth.hidden)?);
                    println!("{}", serde_json::to_string_pretty(&done.found.diagnosis)?);
                }
            }
        }
        return Ok(());
    }
    let outcomes = resumed(&args.outcomes, "", &all, |o: &Outcome| &o.case.id, run)?;
    let beside = match &args.peers {
        Some(python) => Some(peers_of(&args.outcomes, python, &all)?),
        None => None,
    };
    let struck = if args.chosen {
        let starts = starts(args.seeds, args.first);
        let struck = resumed(
            &args.outcomes,
            "_chosen",
            &starts,
            |s: &Struck| &s.id,
            struck,
        )?;
        Some(struck)
    } else {
        None
    };
    let command = format!("make blind SEEDS={} FIRST={}", args.seeds, args.first);
    let text = page(&outcomes, beside.as_deref(), struck.as_deref(), &command);
    match &args.page {
        Some(path) => fs::write(path, text)?,
        None => println!("{text}"),
    }
    Ok(())
}

/// Lines of a file beside the outcomes that can be read; one that a kill cut short is none.
fn lines<T: DeserializeOwned>(path: &Path) -> Vec<T> {
    fs::read_to_string(path)
        .unwrap_or_default()
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect()
}

/// `outcomes` with a word before its ending.
fn beside(outcomes: &Path, word: &str) -> PathBuf {
    let stem = outcomes.file_stem().unwrap_or_default().to_string_lossy();
    outcomes.with_file_name(format!("{stem}{word}.jsonl"))
}

/// One answer a case, in their order; those that the file holds are not made again, and the file holds them all in the end.
fn resumed<T: DeserializeOwned + Serialize + Clone + Send>(
    outcomes: &Path,
    word: &str,
    all: &[Case],
    id: impl Fn(&T) -> &String,
    make: impl Fn(&Case) -> T + Sync,
) -> anyhow::Result<Vec<T>> {
    let path = beside(outcomes, word);
    let mut known: BTreeMap<String, T> = lines(&path)
        .into_iter()
        .map(|one: T| (id(&one).clone(), one))
        .collect();
    let missing: Vec<_> = all
        .iter()
        .filter(|case| !known.contains_key(&case.id))
        .collect();
    eprintln!(
        "{}: {} sets, {} of them to run",
        path.display(),
        all.len(),
        missing.len()
    );
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let file = fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(&path)
        .with_context(|| format!("cannot write {}", path.display()))?;
    let file = Mutex::new(file);
    let bar = indicatif::ProgressBar::new(missing.len() as u64);
    let fresh: Vec<T> = missing
        .par_iter()
        .map(|case| {
            let made = make(case);
            let line = serde_json::to_string(&made)? + "\n";
            file.lock()
                .map_err(|_| anyhow::anyhow!("another set failed"))?
                .write_all(line.as_bytes())?;
            bar.inc(1);
            Ok(made)
        })
        .collect::<anyhow::Result<_>>()?;
    known.extend(fresh.into_iter().map(|one| (id(&one).clone(), one)));
    Ok(all
        .iter()
        .filter_map(|case| known.get(&case.id))
        .cloned()
        .collect())
}

/// What the peers make of the sets that they are tried on; the regression's are named by Python, from the tracks in a file.
fn peers_of(outcomes: &Path, python: &Path, all: &[Case]) -> anyhow::Result<Vec<Peers>> {
    let tried: Vec<Case> = all
        .iter()
        .filter(|case| is_for_peers(case))
        .cloned()
        .collect();
    let tracks = beside(outcomes, "_tracks");
    let named = beside(outcomes, "_sindy");
    let file = Mutex::new(
        fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&tracks)?,
    );
    let mut beside = resumed(
        outcomes,
        "_peers",
        &tried,
        |p: &Peers| &p.id,
        |case| {
            let (peers, tracks) = peers(case);
            if let (Ok(mut file), Some(tracks)) = (file.lock(), tracks) {
                // What cannot be written is missed by Python, below.
                let _ = file.write_all((tracks + "\n").as_bytes());
            }
            peers
        },
    )?;
    #[derive(serde::Deserialize)]
    struct Regressed {
        id: String,
        named: Vec<String>,
    }
    let read = |path: &Path| -> BTreeMap<String, Vec<String>> {
        let all: Vec<Regressed> = lines(path);
        all.into_iter().map(|r| (r.id, r.named)).collect()
    };
    let is_made = |p: &Peers| p.freed.is_none();
    let mut regressed = read(&named);
    if beside
        .iter()
        .any(|p| !is_made(p) && !regressed.contains_key(&p.id))
    {
        let status = Command::new(python)
            .arg("tests/peers/sindy.py")
            .stdin(fs::File::open(&tracks)?)
            .stdout(fs::File::create(&named)?)
            .status()
            .with_context(|| format!("cannot run {}", python.display()))?;
        anyhow::ensure!(status.success(), "tests/peers/sindy.py failed");
        regressed = read(&named);
    }
    for peers in &mut beside {
        peers.regressed = regressed.get(&peers.id).cloned();
    }
    Ok(beside)
}
