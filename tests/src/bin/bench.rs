//! What `make bench` measures of carom inside the process: each part answers with one JSON object, as its peer in
//! `tests/peers` does, so that neither is charged for starting up.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Parser, Subcommand};
use diagnose::Diagnose;
use ingest::{Ingest, assemble, ingest_log};
use judge::{Model, Solve, residuals};
use rayon::prelude::*;
use rig::{RecordingWriter, Sim};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use stage::{ItemStage, Progress, Stage};
use sysid::Sysid;
use train::Settings;
use values::{Command, Point, Residual, Rig, Split, Strike};
use world::{Simulator, SolveStatus, Steps, World, contact_solref};

#[derive(Debug, Parser)]
struct Args {
    /// Threads to compute with.
    #[arg(long, default_value_t = 1, global = true)]
    threads: usize,
    #[command(subcommand)]
    part: Part,
}

#[derive(Debug, Subcommand)]
enum Part {
    /// Writes what the parts and their peers share: DIR/input.json and DIR/model.mjb.
    Prepare {
        dir: PathBuf,
        rig: PathBuf,
        logs: Vec<PathBuf>,
    },
    /// Strikes in the identified world, for so many seconds.
    Step { dir: PathBuf, seconds: f64 },
    /// Solves every strike's path.
    Solve { dir: PathBuf },
    /// Identifies these parameters from the first so many strikes that learn.
    Sysid {
        dir: PathBuf,
        strikes: usize,
        free: Vec<String>,
    },
    /// Trains for exactly so many epochs, or as a run does.
    Train { dir: PathBuf, epochs: Option<usize> },
    /// Diagnoses as a run does.
    Diagnose { dir: PathBuf },
    /// Writes one log of about so many bytes.
    Log {
        rig: PathBuf,
        bytes: u64,
        file: PathBuf,
    },
}

/// What carom and its peers are given.
#[derive(Serialize, Deserialize)]
struct Input {
    rig: Rig,
    /// Every parameter of the identified world.
    parameters: BTreeMap<String, f64>,
    world: World,
    strikes: Vec<Strike>,
    residuals: Vec<Residual>,
    /// Of the strike's contact: spring and damper, as MuJoCo's direct solref.
    solref: [f64; 2],
    /// Lengths of the steps in s.
    steps: [f64; 2],
}

impl Input {
    fn load(dir: &Path) -> anyhow::Result<Self> {
        Ok(serde_json::from_slice(&fs::read(dir.join("input.json"))?)?)
    }
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads)
        .build_global()?;
    let answer = match &args.part {
        Part::Prepare { dir, rig, logs } => prepare(dir, &Rig::load(rig)?, logs)?,
        Part::Step { dir, seconds } => step(&Input::load(dir)?, *seconds)?,
        Part::Solve { dir } => solve(&Input::load(dir)?)?,
        Part::Sysid { dir, strikes, free } => sysid(Input::load(dir)?, *strikes, free)?,
        Part::Train { dir, epochs } => train(&Input::load(dir)?, *epochs)?,
        Part::Diagnose { dir } => diagnose(Input::load(dir)?)?,
        Part::Log { rig, bytes, file } => log(&Rig::load(rig)?, *bytes, file)?,
    };
    println!("{answer}");
    Ok(())
}

fn prepare(dir: &Path, rig: &Rig, logs: &[PathBuf]) -> anyhow::Result<Value> {
    let read = logs
        .iter()
        .map(|log| ingest_log(log, rig, &Ingest::default()))
        .collect::<Result<Vec<_>, _>>()?;
    let (strikes, _) = assemble(read);
    let given = sysid::Input {
        rig: rig.clone(),
        world: World::nominal(),
        strikes,
        later: Vec::new(),
    };
    let world = Sysid::default().run(&given, &Progress::hidden())?.world;
    let strikes = given.strikes;
    let paths: Vec<judge::Path> = strikes.iter().map(Into::into).collect();
    let solved = Solve::default().run_items(
        &Model::of_world(rig, &world),
        &paths.iter().collect::<Vec<_>>(),
        &Progress::hidden(),
    )?;
    let solutions = solved.iter().map(|path| &path.solution);
    let steps = Steps::default();
    let value = |name: &str| world.value(name);
    let input = Input {
        residuals: residuals(strikes.iter().zip(solutions)).rows,
        parameters: world
            .values()
            .map(|(name, value)| (name.into(), value))
            .collect(),
        solref: contact_solref(
            value("contact_time")?,
            value("restitution")?.max(0.2),
            steps.contact,
        ),
        steps: [steps.contact, steps.slide],
        rig: rig.clone(),
        world,
        strikes,
    };
    fs::create_dir_all(dir)?;
    fs::write(dir.join("input.json"), serde_json::to_vec(&input)?)?;
    fs::write(
        dir.join("model.mjb"),
        Simulator::new(rig, &input.world)?.to_mjb(),
    )?;
    Ok(json!({ "strikes": input.strikes.len(), "residuals": input.residuals.len() }))
}

/// Times that all strikes are simulated in one round.
const ROUND: usize = 8;

fn step(input: &Input, seconds: f64) -> anyhow::Result<Value> {
    let simulator = Simulator::new(&input.rig, &input.world)?;
    let begun = Instant::now();
    let (mut rounds, mut fine, mut slides) = (0, 0, 0);
    // So many that what one thread does at the end of a round, while the other waits, is none of it.
    let round: Vec<&Strike> = (0..ROUND).flat_map(|_| &input.strikes).collect();
    while begun.elapsed().as_secs_f64() < seconds {
        let steps = round
            .par_chunks(16)
            .map_init(
                || simulator.worker(),
                |worker, strikes| {
                    let before = worker.steps();
                    for strike in strikes {
                        // One that runs off the table costs its steps like any other.
                        let _ = worker.strike(strike.initial, strike.command, &strike.conditions);
                    }
                    let after = worker.steps();
                    [after[0] - before[0], after[1] - before[1]]
                },
            )
            .reduce(|| [0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        rounds += 1;
        fine += steps[0];
        slides += steps[1];
    }
    let seconds = begun.elapsed().as_secs_f64();
    let strikes = (rounds * round.len()) as f64;
    Ok(json!({
        "seconds": seconds,
        "strikes_per_second": strikes / seconds,
        "step_ns": seconds * 1e9 / (fine + slides) as f64,
        "fine_steps": fine as f64 / strikes,
        "slide_steps": slides as f64 / strikes,
    }))
}

fn solve(input: &Input) -> anyhow::Result<Value> {
    let model = Model::of_world(&input.rig, &input.world);
    let paths: Vec<judge::Path> = input.strikes.iter().map(Into::into).collect();
    let paths: Vec<&judge::Path> = paths.iter().collect();
    let begun = Instant::now();
    let solved = Solve::default().run_items(&model, &paths, &Progress::hidden())?;
    let seconds = begun.elapsed().as_secs_f64();
    let solutions: Vec<_> = solved.iter().map(|path| path.solution).collect();
    let solved: Vec<f64> = solutions
        .iter()
        .filter(|solution| solution.status == SolveStatus::Solved)
        .map(|solution| solution.miss)
        .collect();
    // Each solution struck again with steps of half the length: what of the miss is the integrator's.
    let Steps { contact, slide } = Steps::default();
    let halved = Steps {
        contact: 0.5 * contact,
        slide: 0.5 * slide,
    };
    let halved = Simulator::with_steps(&input.rig, &input.world, halved)?;
    let checked = |(path, solution): (&&judge::Path, &world::Solution)| {
        let struck = halved
            .worker()
            .strike(path.initial, solution.command, &path.conditions);
        struck.map_or(f64::INFINITY, |struck| struck.stop.distance(path.target))
    };
    let mut checked: Vec<f64> = paths
        .iter()
        .zip(&solutions)
        .filter(|(_, solution)| solution.status == SolveStatus::Solved)
        .map(checked)
        .collect();
    checked.sort_by(f64::total_cmp);
    let evaluations: u32 = solutions.iter().map(|solution| solution.evaluations).sum();
    Ok(json!({
        "seconds": seconds,
        "targets": solutions.len(),
        "solved": solved.len(),
        "simulations": f64::from(evaluations) / solutions.len() as f64,
        "miss": solved.iter().sum::<f64>() / solved.len() as f64,
        "checked_p95": checked[(0.95 * checked.len() as f64) as usize],
    }))
}

fn sysid(input: Input, strikes: usize, free: &[String]) -> anyhow::Result<Value> {
    let rig = input.rig;
    let sysid = Sysid {
        free: free.to_vec(),
        most_strikes: strikes,
    };
    let given = sysid::Input {
        world: World::nominal(),
        rig,
        strikes: input.strikes,
        later: Vec::new(),
    };
    let begun = Instant::now();
    let fit = sysid.run(&given, &Progress::hidden())?;
    Ok(json!({
        "seconds": begun.elapsed().as_secs_f64(),
        "strikes": fit.strikes,
        "simulations": fit.simulations,
        "rms": fit.rms_after,
        "parameters": fit.world.parameters,
    }))
}

fn train(input: &Input, epochs: Option<usize>) -> anyhow::Result<Value> {
    let default = Settings::default();
    let settings = Settings {
        epochs: epochs.unwrap_or(default.epochs),
        stop_after: epochs.map_or(default.stop_after, |epochs| epochs + 1),
        ..default
    };
    let begun = Instant::now();
    let trained = train::fit(&input.residuals, &settings, &mut |_| {})?;
    Ok(json!({
        "seconds": begun.elapsed().as_secs_f64(),
        "epochs": trained.history.len(),
        "rows": trained.train_rows,
        "mae": trained.validation.raw,
    }))
}

fn diagnose(input: Input) -> anyhow::Result<Value> {
    let diagnose = Diagnose::default();
    let given = diagnose::Input::sampled(&diagnose, input.rig, input.world, &input.strikes);
    let begun = Instant::now();
    let found = diagnose.run(&given, &Progress::hidden())?;
    let learning = |strike: &&Strike| strike.split != Split::Test;
    Ok(json!({
        "seconds": begun.elapsed().as_secs_f64(),
        "strikes": given.strikes.iter().filter(learning).count(),
        "effects": found.diagnosis.effects.iter().map(|named| &named.name).collect::<Vec<_>>(),
    }))
}

/// A hundred strikes, made once and written over and over at later times.
fn log(rig: &Rig, bytes: u64, file: &Path) -> anyhow::Result<Value> {
    let mut sim = Sim::default_for(rig, 1)?;
    let recordings: Vec<_> = (0..100)
        .map(|i| {
            let share = f64::from(i) / 100.0;
            let initial = Point::new(0.25, 0.2 * (share - 0.5));
            let command = Command::new(0.45 + 0.3 * share, 0.4 * (9.0 * share).sin());
            sim.strike(initial, command).samples
        })
        .collect();
    let first = recordings[0].commands[0].stamp;
    let last = recordings
        .iter()
        .flat_map(|samples| samples.commands.iter().map(|at| at.stamp))
        .max();
    let round = last.unwrap_or(first) - first + 5_000_000_000;
    let mut writer = RecordingWriter::create(file, &rig.topics)?;
    let (mut strikes, mut later) = (0_u64, 0);
    while fs::metadata(file)?.len() < bytes {
        for samples in &recordings {
            let mut samples = samples.clone();
            for at in samples.centroids.iter_mut().chain(&mut samples.commands) {
                at.stamp += later;
            }
            writer.write(&samples)?;
            strikes += 1;
        }
        later += round;
    }
    writer.finish()?;
    Ok(json!({ "strikes": strikes, "bytes": fs::metadata(file)?.len() }))
}
