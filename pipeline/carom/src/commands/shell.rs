//! `carom completions` and `carom manual`: what a shell and `man` know of both programs.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::{Args, Command, CommandFactory, ValueEnum};
use clap_complete::{Generator, Shell};
use serde_json::json;

use crate::Error;
use crate::error::Output;

/// `carom completions`.
#[derive(Args, Debug)]
pub struct CompletionsArgs {
    /// Shell that reads them.
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
    /// Program whose words are completed.
    #[arg(long, value_name = "PROGRAM", default_value = "carom")]
    pub program: Program,
}

/// `carom manual`.
#[derive(Args, Debug)]
pub struct ManualArgs {
    /// Folder for the pages, such as ~/.local/share/man/man1; made where it is not there.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// A program of carom.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Program {
    /// The pipeline.
    Carom,
    /// The executor.
    Strike,
}

impl Program {
    /// What it takes; `carom` is what this program does.
    fn command(self, carom: &Command) -> Command {
        match self {
            Self::Carom => carom.clone(),
            Self::Strike => strike::Args::command(),
        }
    }
}

/// A script that completes a program's words in a shell.
pub fn completions(args: &CompletionsArgs, carom: &Command) -> Output {
    let mut command = args.program.command(carom);
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    command.set_bin_name(name);
    command.build();
    args.shell.generate(&command, &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    Output::done(json!({ "script": script }), script)
}

/// The pages of both programs, one for each command.
pub fn manual(args: &ManualArgs, carom: &Command) -> Result<Output, Error> {
    write_pages(&args.out, carom).map_err(|error| {
        Error::failed(format!(
            "write manual pages to {}: {error}",
            args.out.display()
        ))
    })?;
    Ok(Output::done(
        json!({ "manual": args.out }),
        format!("manual     {}\n", args.out.display()),
    ))
}

fn write_pages(out: &Path, carom: &Command) -> io::Result<()> {
    fs::create_dir_all(out)?;
    for program in Program::value_variants() {
        clap_mangen::generate_to(program.command(carom).disable_help_subcommand(true), out)?;
    }
    Ok(())
}
