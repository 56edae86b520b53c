//! Runs the hidden-effect benchmark: in parallel, resuming where it stopped, and writes its page.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Mutex;

use anyhow::Context;
use clap::Parser;
use rayon::prelude::*;
use tests::blind::{Outcome, cases, diagnosed, page, run};

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
    /// The page to write.
    #[arg(long)]
    page: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let known: BTreeMap<String, Outcome> = match fs::read_to_string(&args.outcomes) {
        // A line that a kill cut short is run again.
        Ok(text) => text
            .lines()
            .filter_map(|line| serde_json::from_str::<Outcome>(line).ok())
            .map(|outcome| (outcome.case.id.clone(), outcome))
            .collect(),
        Err(_) => BTreeMap::new(),
    };
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
                Some(Ok((truth, found, _))) => {
                    println!("{}", serde_json::to_string(&truth.hidden)?);
                    println!("{}", serde_json::to_string_pretty(&found.diagnosis)?);
                }
            }
        }
        return Ok(());
    }
    let missing: Vec<_> = all
        .iter()
        .filter(|case| !known.contains_key(&case.id))
        .collect();
    eprintln!("{} sets, {} of them to run", all.len(), missing.len());
    if let Some(folder) = args.outcomes.parent() {
        fs::create_dir_all(folder)?;
    }
    let file = fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(&args.outcomes)
        .with_context(|| format!("cannot write {}", args.outcomes.display()))?;
    let file = Mutex::new(file);
    let bar = indicatif::ProgressBar::new(missing.len() as u64);
    let fresh: Vec<Outcome> = missing
        .par_iter()
        .map(|case| {
            let outcome = run(case);
            let line = serde_json::to_string(&outcome)? + "\n";
            file.lock()
                .map_err(|_| anyhow::anyhow!("another set failed"))?
                .write_all(line.as_bytes())?;
            bar.inc(1);
            Ok(outcome)
        })
        .collect::<anyhow::Result<_>>()?;
    let fresh: BTreeMap<&str, &Outcome> = fresh.iter().map(|o| (o.case.id.as_str(), o)).collect();
    let outcomes: Vec<Outcome> = all
        .iter()
        .filter_map(|case| fresh.get(case.id.as_str()).copied().or(known.get(&case.id)))
        .cloned()
        .collect();
    let command = format!("make blind SEEDS={} FIRST={}", args.seeds, args.first);
    let text = page(&outcomes, &command);
    match &args.page {
        Some(path) => fs::write(path, text)?,
        None => println!("{text}"),
    }
    Ok(())
}
