//! Arguments that several commands share.

use std::path::PathBuf;

use clap::Args;

/// Heading in the help of what every command takes.
const COMMON: &str = "Common options";

/// Flags of every command.
#[derive(Args, Clone, Copy, Debug)]
pub struct Global {
    /// Print the result as one JSON object.
    #[arg(long, global = true, help_heading = COMMON)]
    pub json: bool,
    /// Print every figure that the command computed, not the summary alone.
    #[arg(long, global = true, help_heading = COMMON)]
    pub verbose: bool,
    /// Show no progress; results and errors are still printed.
    #[arg(long, global = true, help_heading = COMMON)]
    pub quiet: bool,
    /// Threads to compute with; the results do not depend on it [default: as many as cores].
    #[arg(long, global = true, help_heading = COMMON, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

/// Logs, their rig and a folder.
#[derive(Args, Debug)]
pub struct LogsArgs {
    /// MCAP files, or folders or URLs (s3://, gs://, az://) that are searched for them with all below.
    #[arg(required = true, value_name = "LOGS")]
    pub logs: Vec<PathBuf>,
    /// The rig file; `carom rig init` writes one.
    #[arg(long, value_name = "FILE")]
    pub rig: PathBuf,
    /// Folder of the run.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Seed of the split into training and held-out strikes, and of training.
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Diagnose, but add no effect to the world: the residual model carries all that the identified simulator gets wrong.
    #[arg(long)]
    pub without_effects: bool,
}

/// Who signs what is put to use.
#[derive(Args, Clone, Debug)]
pub struct SignArgs {
    /// Secret key that signs the version, in minisign's format; `carom key new` writes one [default: not signed].
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
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

/// The examples below a command's help.
pub fn examples(lines: &[&str]) -> String {
    let lines: Vec<String> = lines.iter().map(|line| format!("  {line}")).collect();
    format!("Examples:\n{}", lines.join("\n"))
}
