//! Runs the hidden-effect benchmark: in parallel, resuming where it stopped, and writes its page.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use anyhow::Context;
use clap::Parser;
use tests::blind::{
    Case, DiagnosedSet, HardOutcome, Judged, Outcome, Peers, Separation, beside, cases, diagnosed,
    diagnosed_hard, hard_cases, hard_page, is_for_peers, lines, page, peers, resumed, run,
    run_hard, separate, starts,
};

/// Hides effects in strikes, and grades whether the diagnosis names them.
#[derive(Debug, Parser)]
struct Args {
    /// The hard benchmark: noise, forms and phenomena that the library was not written for.
    #[arg(long)]
    hard: bool,
    /// Sets of the hard benchmark.
    #[arg(long, default_value_t = 400)]
    sets: usize,
    /// Seeds of each combination of the plain one.
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
    #[arg(long, default_value = "artifacts/runs/blind/outcomes.jsonl")]
    outcomes: PathBuf,
    /// The figures of all runs whose page was committed. A run with a page is added to it.
    #[arg(long, default_value = "tests/judged.json")]
    judged: PathBuf,
    /// Also what peers make of the same sets; a Python with pysindy.
    #[arg(long)]
    peers: Option<PathBuf>,
    /// Also how many strikes separate pairs, chosen and at random.
    #[arg(long)]
    chosen: bool,
    /// The page to write; without one it is printed, and the run is noted nowhere.
    #[arg(long)]
    page: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let mut judged = Judged::load(&args.judged)?;
    let text = if args.hard {
        hard(&args, &mut judged)?
    } else {
        plain(&args, &mut judged)?
    };
    match (text, &args.page) {
        (Some(text), Some(path)) => {
            fs::write(path, text).with_context(|| format!("write {}", path.display()))?;
            judged.save(&args.judged)?;
        }
        (Some(text), None) => println!("{text}"),
        (None, _) => {}
    }
    Ok(())
}

/// The hard benchmark's page; none where sets are only shown.
fn hard(args: &Args, judged: &mut Judged) -> anyhow::Result<Option<String>> {
    let mut all = hard_cases(args.sets, args.first);
    all.retain(|case| case.id.contains(&args.only));
    if args.show {
        for case in &all {
            show(&case.id, diagnosed_hard(case).map(|(_, found)| found))?;
        }
        return Ok(None);
    }
    let outcomes = resumed(
        &args.outcomes,
        &all,
        |case| &case.id,
        |outcome: &HardOutcome| &outcome.case.id,
        run_hard,
    )?;
    let only = match args.only.as_str() {
        "" => String::new(),
        only => format!(" ONLY={only}"),
    };
    let command = format!(
        "make blind HARD=1 SETS={} FIRST={}{only}",
        args.sets, args.first
    );
    Ok(Some(hard_page(&outcomes, judged, &command)))
}

/// The plain benchmark's page; none where sets are only shown.
fn plain(args: &Args, judged: &mut Judged) -> anyhow::Result<Option<String>> {
    let mut all = cases(args.seeds, args.first);
    all.retain(|case| case.id.contains(&args.only));
    if args.show {
        for case in &all {
            show(&case.id, diagnosed(case))?;
        }
        return Ok(None);
    }
    let outcomes = resumed(
        &args.outcomes,
        &all,
        |case| &case.id,
        |outcome: &Outcome| &outcome.case.id,
        run,
    )?;
    let peers = match &args.peers {
        Some(python) => Some(peers_of(&args.outcomes, python, &all)?),
        None => None,
    };
    let separations = if args.chosen {
        Some(resumed(
            &beside(&args.outcomes, "_chosen"),
            &starts(args.seeds, args.first),
            |case| &case.id,
            |separation: &Separation| &separation.id,
            separate,
        )?)
    } else {
        None
    };
    let command = format!("make blind SEEDS={} FIRST={}", args.seeds, args.first);
    Ok(Some(page(
        &outcomes,
        peers.as_deref(),
        separations.as_deref(),
        judged,
        &command,
    )))
}

/// What is hidden, and all that was found.
fn show(id: &str, found: Option<Result<DiagnosedSet, String>>) -> anyhow::Result<()> {
    println!("{id}");
    match found {
        None => println!("the rig cannot make it"),
        Some(Err(error)) => println!("{error}"),
        Some(Ok(done)) => {
            println!("{}", serde_json::to_string(&done.truth.noise)?);
            println!("{}", serde_json::to_string(&done.truth.hidden)?);
            println!("{}", serde_json::to_string_pretty(&done.found.diagnosis)?);
        }
    }
    Ok(())
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
    let mut tried_peers = resumed(
        &beside(outcomes, "_peers"),
        &tried,
        |case| &case.id,
        |p: &Peers| &p.id,
        |case: &Case| {
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
    if tried_peers
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
    for peers in &mut tried_peers {
        peers.regressed = regressed.get(&peers.id).cloned();
    }
    Ok(tried_peers)
}
