//! The command line as typed by a person.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use values::Shape;

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

/// What every command takes.
#[derive(Args, Clone, Copy, Debug)]
pub struct Global {
    /// Print the result as one JSON object.
    #[arg(long, global = true)]
    pub json: bool,
    /// Show no progress; results and errors are still told.
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Threads to compute with; the results do not depend on it [default: as many as cores].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write demo logs from the embedded rig: rig.toml, logs/*.mcap, truth.json.
    #[command(after_help = examples(&[
        "carom demo --out artifacts/demo/rig",
        "carom demo --object box --strikes 200 --out box",
        "carom demo --hide table_tilt=0.004,0.002 --hide friction_patch --out tilted",
        "carom demo --hide none --out clean",
        "carom demo --hide table_tilt --plan runs/a/next_strikes.json --out more",
    ]))]
    Demo(DemoArgs),
    /// Begin a rig file.
    #[command(subcommand)]
    Rig(RigCommand),
    /// Read logs and find the strikes in them.
    #[command(after_help = examples(&["carom ingest logs/ --rig rig.toml --out runs/a"]))]
    Ingest(LogsArgs),
    /// Identify the simulator from the strikes' tracks.
    #[command(after_help = examples(&["carom sysid --out runs/a"]))]
    Sysid(DirArgs),
    /// Say where simulation and strikes disagree, and which effect is missing: diagnosis.json and the report.
    #[command(after_help = examples(&["carom diagnose --out runs/a"]))]
    Diagnose(DirArgs),
    /// Solve every strike's path backwards in the identified simulator.
    #[command(after_help = examples(&["carom solve --out runs/a"]))]
    Solve(DirArgs),
    /// Compare what was commanded with what the simulator would have commanded.
    #[command(after_help = examples(&["carom residual --out runs/a"]))]
    Residual(DirArgs),
    /// Train the residual model, and its learning curve.
    #[command(after_help = examples(&["carom train --out runs/a"]))]
    Train(DirArgs),
    /// Measure every model's stop error on held-out strikes.
    #[command(after_help = examples(&["carom evaluate --out runs/a"]))]
    Evaluate(DirArgs),
    /// Publish a version for the executor.
    #[command(after_help = examples(&[
        "carom publish --out runs/a",
        "carom publish --out runs/a --key carom.key",
    ]))]
    Publish(PublishArgs),
    /// Run the whole pipeline; only what changed is computed again.
    #[command(after_help = examples(&[
        "carom run logs/ --rig rig.toml --out runs/a",
        "carom run monday.mcap tuesday.mcap --rig rig.toml --out runs/a --seed 7",
        "carom run logs/ --rig rig.toml --out runs/plain --without-effects",
        "carom run logs/ --rig rig.toml --out runs/a --key carom.key",
    ]))]
    Run(RunArgs),
    /// Run on what is new, and promote the result only if it beats the version in use on held-out strikes.
    #[command(after_help = examples(&[
        "carom nightly logs/ --rig rig.toml --out runs/a --key carom.key",
        "carom nightly --out runs/a --key carom.key --log-json",
    ]))]
    Nightly(NightlyArgs),
    /// Strike targets with each model and measure where the object stops.
    #[command(after_help = examples(&[
        "carom trial --artifacts artifacts/demo --robot sim",
        "carom trial --artifacts runs/tilted --robot sim:tilted --targets 20 --repeats 3",
    ]))]
    Trial(TrialArgs),
    /// Measure how well a version predicts these logs' strikes: has the rig drifted?
    #[command(after_help = examples(&[
        "carom score today.mcap --artifacts artifacts/demo",
        "carom score logs/ --artifacts artifacts/demo --version v0002 --json",
    ]))]
    Score(ScoreArgs),
    /// Datasets with a version: logs pinned by hash, tables rebuilt to the same bytes.
    #[command(subcommand)]
    Dataset(DatasetCommand),
    /// Compute a version again from the inputs it records and compare byte by byte.
    #[command(after_help = examples(&["carom rebuild v0001 --artifacts artifacts/demo"]))]
    Rebuild(RebuildArgs),
    /// Keys that versions are signed with.
    #[command(subcommand)]
    Key(KeyCommand),
    /// Look into the store of versions.
    #[command(subcommand)]
    Artifacts(ArtifactsCommand),
    /// Write the HTML report again.
    #[command(after_help = examples(&["carom report artifacts/demo"]))]
    Report(ReportArgs),
}

/// `carom demo`.
#[derive(Args, Debug)]
pub struct DemoArgs {
    /// How many strikes.
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub strikes: u32,
    /// Where everything random comes from.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// What is struck.
    #[arg(long, value_enum, default_value_t = DemoObject::Cylinder)]
    pub object: DemoObject,
    /// What to hide in place of the demo's mixture: an effect, with values where its defaults do not serve (all in order, or
    /// some by NAME:VALUE), or `none`; repeat it for several effects.
    #[arg(long, value_name = "EFFECT[=VALUE,…]")]
    pub hide: Vec<String>,
    /// Strikes to make in place of random ones: a JSON list of {x0, y0, speed, angle}, or a diagnosis.json.
    #[arg(long, value_name = "FILE", conflicts_with = "strikes")]
    pub plan: Option<PathBuf>,
    /// Also log /striker/state.
    #[arg(long)]
    pub state: bool,
    /// Folder to write.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// What the demo can strike.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum DemoObject {
    /// An upright cylinder.
    Cylinder,
    /// A box.
    Box,
    /// A ball.
    Sphere,
}

impl From<DemoObject> for Shape {
    fn from(object: DemoObject) -> Self {
        match object {
            DemoObject::Cylinder => Self::Cylinder,
            DemoObject::Box => Self::Box,
            DemoObject::Sphere => Self::Sphere,
        }
    }
}

/// `carom rig`.
#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Write a commented rig file to start from.
    #[command(after_help = examples(&["carom rig init > rig.toml", "carom rig init --out rig.toml"]))]
    Init {
        /// File to write, which must not be there yet [default: stdout].
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

/// Logs, their rig and a folder.
#[derive(Args, Debug)]
pub struct LogsArgs {
    /// MCAP files, or folders that are searched for them with all below.
    #[arg(required = true, value_name = "LOGS")]
    pub logs: Vec<PathBuf>,
    /// The rig file; `carom rig init` writes one.
    #[arg(long, value_name = "FILE")]
    pub rig: PathBuf,
    /// Folder of the run.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Deals strikes into learning and judging, and seeds training.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Diagnose, but add no effect to the world: the residual model carries all that the identified simulator gets wrong.
    #[arg(long)]
    pub without_effects: bool,
}

/// `carom run`.
#[derive(Args, Debug)]
pub struct RunArgs {
    /// What to run on.
    #[command(flatten)]
    pub logs: LogsArgs,
    /// Who signs.
    #[command(flatten)]
    pub sign: SignArgs,
}

/// `carom nightly`.
#[derive(Args, Debug)]
pub struct NightlyArgs {
    /// MCAP files, or folders that are searched for them with all below [default: those that the run was begun with].
    #[arg(value_name = "LOGS", requires = "rig")]
    pub logs: Vec<PathBuf>,
    /// The rig file.
    #[arg(long, value_name = "FILE", requires = "logs")]
    pub rig: Option<PathBuf>,
    /// Folder of the run.
    #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
    pub out: PathBuf,
    /// Deals strikes into learning and judging, and seeds training; goes with LOGS.
    #[arg(long, default_value_t = 0, requires = "logs")]
    pub seed: u64,
    /// Diagnose, but add no effect to the world; goes with LOGS.
    #[arg(long, requires = "logs")]
    pub without_effects: bool,
    /// Versions to keep: older ones are removed, the one in use never.
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u16).range(2..))]
    pub keep: u16,
    /// Log as JSON, an object a line, on standard error, and nothing else there.
    #[arg(long)]
    pub log_json: bool,
    /// Who signs.
    #[command(flatten)]
    pub sign: SignArgs,
}

/// Who signs what is put to use.
#[derive(Args, Debug)]
pub struct SignArgs {
    /// Secret key that signs the version, in minisign's format; `carom key new` writes one [default: not signed].
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
}

/// `carom publish`.
#[derive(Args, Debug)]
pub struct PublishArgs {
    /// Folder of a run that has ingested logs.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Who signs.
    #[command(flatten)]
    pub sign: SignArgs,
}

/// A run's folder.
#[derive(Args, Debug)]
pub struct DirArgs {
    /// Folder of a run that has ingested logs.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// `carom trial`.
#[derive(Args, Debug)]
pub struct TrialArgs {
    /// Folder of a run.
    #[arg(long, value_name = "DIR")]
    pub artifacts: PathBuf,
    /// What strikes: `sim`, the embedded rig, with the hidden truth of DIR/truth.json or DIR/rig/truth.json where `carom
    /// demo` wrote one, else the demo's mixture; `sim:FOLDER` with the truth in FOLDER.
    #[arg(long, value_name = "sim[:FOLDER]")]
    pub robot: rig::SimChoice,
    /// Random targets, struck once with each model.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub targets: u32,
    /// Strikes at each target of the paper's Figure 8, with each model.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    pub repeats: u32,
    /// Where targets and launch scatter come from.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Version to strike with [default: the latest].
    #[arg(long, value_name = "VERSION")]
    pub version: Option<String>,
}

/// `carom score`.
#[derive(Args, Debug)]
pub struct ScoreArgs {
    /// MCAP files, or folders that are searched for them with all below.
    #[arg(required = true, value_name = "LOGS")]
    pub logs: Vec<PathBuf>,
    /// Folder of a run.
    #[arg(long, value_name = "DIR")]
    pub artifacts: PathBuf,
    /// Version to score [default: the latest].
    #[arg(long, value_name = "VERSION")]
    pub version: Option<String>,
}

/// `carom dataset`.
#[derive(Debug, Subcommand)]
pub enum DatasetCommand {
    /// Pin every log of a recipe by SHA-256 and record the hashes of the tables, in RECIPE's `.lock`.
    #[command(after_help = examples(&[
        "carom dataset lock datasets/recipes/demo.toml",
        "carom dataset lock datasets/recipes/demo.toml --again",
    ]))]
    Lock {
        /// What and where.
        #[command(flatten)]
        dataset: DatasetArgs,
        /// Pin anew, though logs that were pinned have changed or are gone.
        #[arg(long)]
        again: bool,
    },
    /// Write the tables from the pinned logs.
    #[command(after_help = examples(&["carom dataset build datasets/recipes/demo.toml --out datasets/demo"]))]
    Build {
        /// What and where.
        #[command(flatten)]
        dataset: DatasetArgs,
        /// Folder of the tables [default: RECIPE without its `.toml`].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Build again beside, and compare with the lock and with tables that are there, byte by byte.
    #[command(after_help = examples(&["carom dataset verify datasets/recipes/demo.toml --logs /mnt/copy"]))]
    Verify {
        /// What and where.
        #[command(flatten)]
        dataset: DatasetArgs,
        /// Folder of the tables [default: RECIPE without its `.toml`].
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
}

/// A recipe and its logs.
#[derive(Args, Debug)]
pub struct DatasetArgs {
    /// The recipe, a TOML file that names logs, rig, filters and seed.
    pub recipe: PathBuf,
    /// Where else logs lie, under whatever names: files or folders; repeat it for several.
    #[arg(long, value_name = "PATH")]
    pub logs: Vec<PathBuf>,
}

/// `carom rebuild`.
#[derive(Args, Debug)]
pub struct RebuildArgs {
    /// Version to compute again.
    pub version: String,
    /// Folder of the run that published it.
    #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
    pub artifacts: PathBuf,
}

/// `carom artifacts`.
#[derive(Debug, Subcommand)]
pub enum ArtifactsCommand {
    /// List the versions.
    #[command(after_help = examples(&["carom artifacts list --artifacts artifacts/demo"]))]
    List(StoreArgs),
    /// Show a version's manifest.
    #[command(after_help = examples(&["carom artifacts show v0001 --artifacts artifacts/demo"]))]
    Show(VersionArgs),
    /// Check a version's hashes, shapes and schemas, and its signature where a public key is given.
    #[command(after_help = examples(&["carom artifacts verify --artifacts artifacts/demo --key carom.pub"]))]
    Verify {
        /// What to check.
        #[command(flatten)]
        version: VersionArgs,
        /// Public key that must have signed it.
        #[arg(long, value_name = "FILE")]
        key: Option<PathBuf>,
    },
    /// Sign the latest version.
    #[command(after_help = examples(&["carom artifacts sign --artifacts artifacts/demo --key carom.key"]))]
    Sign {
        /// Folder of a run.
        #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
        artifacts: PathBuf,
        /// Secret key.
        #[arg(long, value_name = "FILE")]
        key: PathBuf,
    },
    /// Make an earlier version the latest; where versions are signed it is signed anew, so that robots take it.
    #[command(after_help = examples(&[
        "carom artifacts rollback v0001 --artifacts artifacts/demo",
        "carom artifacts rollback --artifacts artifacts/demo --key carom.key",
    ]))]
    Rollback {
        /// Version to go back to [default: the one before the latest].
        version: Option<String>,
        /// Folder of a run.
        #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
        artifacts: PathBuf,
        /// Who signs.
        #[command(flatten)]
        sign: SignArgs,
    },
}

/// `carom key`.
#[derive(Debug, Subcommand)]
pub enum KeyCommand {
    /// Write a key pair: a secret key to sign versions with, and FILE.pub for the robots.
    #[command(after_help = examples(&["carom key new --out carom.key"]))]
    New {
        /// File of the secret key, which must not be there yet; the public key's ends in `.pub`.
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
}

/// A store.
#[derive(Args, Debug)]
pub struct StoreArgs {
    /// Folder of a run.
    #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
    pub artifacts: PathBuf,
}

/// A version in a store.
#[derive(Args, Debug)]
pub struct VersionArgs {
    /// Version [default: the latest].
    pub version: Option<String>,
    /// Folder of a run.
    #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
    pub artifacts: PathBuf,
}

/// `carom report`.
#[derive(Args, Debug)]
pub struct ReportArgs {
    /// Folder of a run.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
}

fn examples(lines: &[&str]) -> String {
    let lines: Vec<String> = lines.iter().map(|line| format!("  {line}")).collect();
    format!("Examples:\n{}", lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

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
