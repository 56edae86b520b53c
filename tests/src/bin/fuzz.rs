//! Fuzzes what is read from outside: `fuzz [TARGET…] --seconds 600`. One process a target, so that each target's memory is measured.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use clap::Parser;
use tests::fuzz::{Budget, answer, fuzz, targets};

/// Tries changed inputs on all that is read from outside.
#[derive(Debug, Parser)]
struct Args {
    /// Names of targets [default: all].
    targets: Vec<String>,
    /// Seconds for each.
    #[arg(long, default_value_t = 10)]
    seconds: u64,
    /// First number of the random ones.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Try this one input, of one target, in place of random ones.
    #[arg(long, value_name = "FILE")]
    input: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let is_chosen =
        |name: &str| args.targets.is_empty() || args.targets.iter().any(|it| it == name);
    let chosen: Vec<_> = targets()
        .into_iter()
        .filter(|target| is_chosen(target.name))
        .collect();
    if chosen.is_empty() || chosen.len() < args.targets.len() {
        let names: Vec<_> = targets().iter().map(|target| target.name).collect();
        bail!("find the target: there are {}", names.join(", "));
    }
    // What panics is reported once, with its input; a library's panic that is caught below is an answer.
    std::panic::set_hook(Box::new(|_| ()));
    for target in chosen {
        if let Some(path) = &args.input {
            let input = fs::read(path).with_context(|| format!("read {}", path.display()))?;
            let said = answer(&target, &input).map_err(|finding| anyhow::anyhow!(finding.what))?;
            println!("{}: {said:?}", target.name);
            continue;
        }
        let begun = Instant::now();
        let budget = Budget {
            tries: u64::MAX,
            time: Duration::from_secs(args.seconds),
        };
        match fuzz(&target, args.seed, budget) {
            Ok(tally) => println!(
                "{:<9} {:>9} tries in {:.0} s, {} of them read, {} kinds of answers, at most {} MiB",
                target.name,
                tally.tries,
                begun.elapsed().as_secs_f64(),
                tally.read,
                tally.kinds,
                tests::soak::peak_memory().unwrap_or(0) >> 20,
            ),
            Err(finding) => {
                let path = PathBuf::from(format!("fuzz-{}.input", target.name));
                fs::write(&path, &finding.input)?;
                bail!(
                    "{}: {}; the input is in {}",
                    target.name,
                    finding.what,
                    path.display()
                );
            }
        }
    }
    Ok(())
}
