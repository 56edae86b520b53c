//! The command line as typed by a person.

use clap::{CommandFactory, Parser, Subcommand};

use crate::Error;
use crate::args::{Global, LogsArgs, examples};
use crate::commands::{
    artifacts, camera, check, collect, dataset, demo, key, nightly, predict, query, rebuild, rig,
    run, score, shell, status, track, trial, view, work,
};
use crate::error::Output;
use crate::pipeline::Step;

const EXIT_CODES: &str = "\
Exit codes: 0 done, 1 failed, 2 wrong usage or bad input, 3 done but some input was rejected, 4 refused (a gate or a \
safety limit), 75 busy: another run works in the folder.";

/// From strike logs to a robot that strikes: identifies a simulator from logs, learns what it still gets wrong, and
/// publishes both as a version that the `strike` executor loads.
#[derive(Debug, Parser)]
#[command(name = "carom", version, after_help = EXIT_CODES, after_long_help = format!("{}\n\n{EXIT_CODES}", examples(&[
    "carom demo --strikes 500 --seed 1 --out artifacts/demo/rig",
    "carom run artifacts/demo/rig/logs --rig artifacts/demo/rig/rig.toml --out artifacts/demo",
    "carom trial --artifacts artifacts/demo --robot sim",
    "carom artifacts list --artifacts artifacts/demo",
])))]
pub struct Cli {
    /// What every command takes.
    #[command(flatten)]
    pub global: Global,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Whether standard error is for a machine, an object a line and nothing else.
    pub fn logs_json(&self) -> bool {
        matches!(&self.command, Command::Nightly(args) if args.log_json)
    }
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write demo logs from the embedded rig: rig.toml, logs/*.mcap, truth.json.
    #[command(after_help = examples(&[
        "carom demo --out artifacts/demo/rig",
        "carom demo --object box --strikes 200 --out box",
        "carom demo --hide table_tilt=0.004,0.002 --hide friction_patch --out tilted",
        "carom demo --hide friction_scatter=0.02 --hide camera_correlation=0.6 --out noisy",
        "carom demo --hide none --out clean",
        "carom demo --strikes 100 --camera --out filmed",
        "carom demo --hide table_tilt --plan runs/a/next_strikes.json --out more",
    ]))]
    Demo(demo::DemoArgs),
    /// Check whether logs mean what the rig file says: frames, clocks, units, coverage. Every run begins with it.
    #[command(after_help = examples(&[
        "carom check logs/ --rig rig.toml",
        "carom check monday.mcap --rig rig.toml --json",
    ]))]
    Check(check::CheckArgs),
    /// Collect strikes that cover the range of speeds, angles and places, a log each; an interrupted collection is continued.
    #[command(after_help = examples(&[
        "carom collect --rig rig.toml --robot sim --strikes 100 --out logs/",
        "carom collect --rig rig.toml --robot xarm:192.168.1.10 --watch ws://localhost:8765 --key carom.pub --strikes 100 --out logs/",
        "carom collect --rig rig.toml --robot sim --strikes 20 --plan runs/a/next_strikes.json --out more/",
    ]))]
    Collect(collect::CollectArgs),
    /// Write a rig file to start from.
    #[command(subcommand)]
    Rig(rig::RigCommand),
    /// Read logs and find the strikes in them.
    #[command(after_help = examples(&["carom ingest logs/ --rig rig.toml --out runs/a"]))]
    Ingest(LogsArgs),
    /// Find the object in the images of logs, and write logs with its centroids.
    #[command(after_help = examples(&[
        "carom track logs/ --rig rig.toml --out tracked",
        "carom track session.mcap --rig rig.toml --out tracked --view view.mcap",
    ]))]
    Track(track::TrackArgs),
    /// Calibrate the camera's lens and pose, and find the object's colour range.
    #[command(subcommand)]
    Camera(camera::CameraCommand),
    /// Identify the simulator from the strikes' tracks.
    #[command(after_help = examples(&["carom sysid --out runs/a"]))]
    Sysid(run::DirArgs),
    /// Test where simulation and strikes disagree, and name the effects that are missing: diagnosis.json and the report.
    #[command(after_help = examples(&["carom diagnose --out runs/a"]))]
    Diagnose(run::DirArgs),
    /// Solve for the command that the identified simulator needs for each strike's path.
    #[command(after_help = examples(&["carom solve --out runs/a"]))]
    Solve(run::DirArgs),
    /// Compute the residual: the command that was sent less the one that the simulator needs.
    #[command(after_help = examples(&["carom residual --out runs/a"]))]
    Residual(run::DirArgs),
    /// Train the residual model, and its learning curve.
    #[command(after_help = examples(&["carom train --out runs/a"]))]
    Train(run::DirArgs),
    /// Measure every model's stop error on held-out strikes.
    #[command(after_help = examples(&["carom evaluate --out runs/a"]))]
    Evaluate(run::DirArgs),
    /// Publish a version for the executor.
    #[command(after_help = examples(&[
        "carom publish --out runs/a",
        "carom publish --out runs/a --key carom.key",
    ]))]
    Publish(run::PublishArgs),
    /// Run the whole pipeline; only what changed is computed again.
    #[command(after_help = examples(&[
        "carom run logs/ --rig rig.toml --out runs/a",
        "carom run monday.mcap tuesday.mcap --rig rig.toml --out runs/a --seed 7",
        "carom run logs/ --rig rig.toml --out runs/plain --without-effects",
        "carom run logs/ --rig rig.toml --out runs/a --key carom.key",
    ]))]
    Run(run::RunArgs),
    /// Do a share of a run on any machine that sees its folder, beside any number of others; `carom run` then gathers all.
    #[command(after_help = examples(&[
        "carom work logs/ --rig rig.toml --out /shared/a --shard 3/8",
        "carom work logs/ --rig rig.toml --out /shared/a",
    ]))]
    Work(work::WorkArgs),
    /// Tell what workers did to a run, what failed, what is left and when it will end.
    #[command(after_help = examples(&["carom status /shared/a", "carom status /shared/a --json"]))]
    Status(status::StatusArgs),
    /// Run on what is new, and promote the result only if it beats the version in use on held-out strikes.
    #[command(after_help = examples(&[
        "carom nightly logs/ --rig rig.toml --out runs/a --key carom.key",
        "carom nightly --out runs/a --key carom.key --log-json",
        "carom nightly --fleet fleet.toml --out runs --key carom.key",
    ]))]
    Nightly(nightly::NightlyArgs),
    /// Strike targets with each model and measure where the object stops.
    #[command(after_help = examples(&[
        "carom trial --artifacts artifacts/demo --robot sim",
        "carom trial --artifacts runs/tilted --robot sim:tilted --targets 20 --repeats 3",
    ]))]
    Trial(trial::TrialArgs),
    /// Show the track that a version expects of a strike.
    #[command(after_help = examples(&[
        "carom predict --artifacts artifacts/demo --from 0.3 0.0 --speed 0.8 --angle 0.1",
        "carom predict --from 0.3 -0.1 --speed 0.6 --angle -0.2 --json",
    ]))]
    Predict(predict::PredictArgs),
    /// Ask the tables of a run in SQL: strikes, tracks, rejects, slides, solutions, residuals, predictions.
    #[command(after_help = examples(&[
        "carom query artifacts/demo \"SELECT session, count(*) FROM strikes GROUP BY session\"",
        "carom query artifacts/demo \"SELECT model, avg(error) FROM predictions GROUP BY model\" --json",
    ]))]
    Query(query::QueryArgs),
    /// Measure how well a version predicts these logs' strikes: has the rig drifted?
    #[command(after_help = examples(&[
        "carom score today.mcap --artifacts artifacts/demo",
        "carom score logs/ --artifacts artifacts/demo --version v0002 --json",
    ]))]
    Score(score::ScoreArgs),
    /// Versioned datasets: logs pinned by hash, tables rebuilt to the same bytes.
    #[command(subcommand)]
    Dataset(dataset::DatasetCommand),
    /// Compute a version again from the inputs it records and compare byte by byte.
    #[command(after_help = examples(&["carom rebuild v0001 --artifacts artifacts/demo"]))]
    Rebuild(rebuild::RebuildArgs),
    /// Keys that versions are signed with.
    #[command(subcommand)]
    Key(key::KeyCommand),
    /// List, show, verify, sign and roll back versions.
    #[command(subcommand)]
    Artifacts(artifacts::ArtifactsCommand),
    /// Write the HTML report again.
    #[command(after_help = examples(&["carom report artifacts/demo"]))]
    Report(run::ReportArgs),
    /// Write strikes for viewers, Foxglove and Rerun: measured tracks beside simulated ones, and the effects named where they act.
    #[command(after_help = examples(&[
        "carom view artifacts/demo -o view.mcap",
        "carom view artifacts/demo --strike 0f3c --strike 91b2 -o two.rrd",
    ]))]
    View(view::ViewArgs),
    /// Print a script that completes a program's words in a shell.
    #[command(after_help = examples(&[
        "carom completions bash > ~/.local/share/bash-completion/completions/carom",
        "carom completions zsh --program strike > ~/.zfunc/_strike",
    ]))]
    Completions(shell::CompletionsArgs),
    /// Write the manual pages of both programs.
    #[command(after_help = examples(&["carom manual --out ~/.local/share/man/man1"]))]
    Manual(shell::ManualArgs),
}

/// What `--version` prints behind the name.
pub fn about() -> String {
    let formats = [
        ("versions", store::SCHEMA_VERSION),
        ("tables", tables::SCHEMA_VERSION),
    ];
    strike::about(&formats)
}

/// Does what was asked.
pub fn execute(cli: &Cli) -> Result<Output, Error> {
    let global = cli.global;
    match &cli.command {
        Command::Demo(args) => demo::run(args),
        Command::Collect(args) => collect::run(args, global),
        Command::Rig(command) => rig::run(command),
        Command::Check(args) => check::run(args, global),
        Command::Ingest(args) => run::ingest(args, global),
        Command::Run(args) => run::run(args, global),
        Command::Work(args) => work::run(args, global),
        Command::Status(args) => status::run(args),
        Command::Track(args) => track::run(args),
        Command::Camera(command) => camera::run(command),
        Command::Sysid(args) => run::proceed_to(args, Step::Sysid, global),
        Command::Diagnose(args) => run::proceed_to(args, Step::Diagnose, global),
        Command::Solve(args) => run::proceed_to(args, Step::Solve, global),
        Command::Residual(args) => run::proceed_to(args, Step::Residual, global),
        Command::Train(args) => run::proceed_to(args, Step::Train, global),
        Command::Evaluate(args) => run::proceed_to(args, Step::Evaluate, global),
        Command::Publish(args) => run::publish(args, global),
        Command::Report(args) => run::report(args, global),
        Command::View(args) => view::run(args, global),
        Command::Nightly(args) => nightly::run(args, global),
        Command::Trial(args) => trial::run(args, global),
        Command::Predict(args) => predict::run(args, global),
        Command::Query(args) => query::run(args),
        Command::Score(args) => score::run(args, global),
        Command::Dataset(command) => dataset::run(command),
        Command::Rebuild(args) => rebuild::run(args, global),
        Command::Key(command) => key::run(command),
        Command::Artifacts(command) => artifacts::run(command),
        Command::Completions(args) => Ok(shell::completions(args, &Cli::command())),
        Command::Manual(args) => shell::manual(args, &Cli::command()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_shows_examples() {
        fn without(command: &clap::Command, found: &mut Vec<String>) {
            let mut subs = command.get_subcommands().peekable();
            if subs.peek().is_none() && command.get_after_help().is_none() {
                found.push(command.get_name().into());
            }
            subs.for_each(|sub| without(sub, found));
        }
        let mut found = Vec::new();
        without(&Cli::command(), &mut found);
        assert!(found.is_empty(), "{found:?}");
    }

    #[test]
    fn every_example_parses() {
        fn texts(command: &clap::Command, found: &mut Vec<String>) {
            for help in [command.get_after_help(), command.get_after_long_help()] {
                found.extend(help.map(ToString::to_string));
            }
            for sub in command.get_subcommands() {
                texts(sub, found);
            }
        }
        let mut found = Vec::new();
        texts(&Cli::command(), &mut found);
        let examples: Vec<&str> = found
            .iter()
            .flat_map(|text| text.lines())
            .filter_map(|line| line.strip_prefix("  carom "))
            .collect();
        assert!(examples.len() > 15, "{examples:?}");
        for example in examples {
            let words = example.split(" > ").next().expect("words").split(' ');
            if let Err(error) = Cli::try_parse_from(std::iter::once("carom").chain(words)) {
                panic!("carom {example}: {error}");
            }
        }
    }
}
