//! `carom work`: a share of a run, beside any number of others on machines that see its folder.

use clap::Args;
use serde_json::json;
use stage::{Event, PATIENCE, Share};

use crate::Error;
use crate::args::{Global, LogsArgs};
use crate::error::Output;
use crate::inputs::Inputs;
use crate::pipeline::{Step, pipeline};
use crate::steps::{explained, join};

/// `carom work`.
#[derive(Args, Debug)]
pub struct WorkArgs {
    /// What to run on.
    #[command(flatten)]
    pub logs: LogsArgs,
    /// Share to begin with, from 1/N to N/N [default: by the index of a Slurm array, a Kubernetes Indexed Job or an AWS Batch array; else 1/1].
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
}

/// Which share, from 0, of how many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shard(usize, usize);

/// Goes through the whole pipeline, computes what nobody else has, and keeps it for the run; nothing is written beside the cache.
pub fn run(args: &WorkArgs, global: Global) -> Result<Output, Error> {
    let Shard(index, count) = match args.shard {
        Some(shard) => shard,
        None => assigned(|name| std::env::var(name).ok())?,
    };
    let inputs = Inputs::named(&args.logs)?;
    let share = Share {
        index,
        count,
        patience: PATIENCE,
    };
    let run = join(&args.logs.out, share, global)?;
    let worked = pipeline(&run, &inputs, Step::Publish);
    if let Err(error) = worked.map_err(|error| explained(error, &run, &inputs)) {
        run.tell(Event::Failed {
            why: error.to_string(),
        });
        return Err(error);
    }
    run.tell(Event::Ended);
    let summary = run.summary();
    let dir = args.logs.out.display();
    let text = format!(
        "{summary}\nwork       every answer is there; `carom run` with the same arguments gathers them in {dir}\n"
    );
    let json =
        json!({ "worker": run.writer(), "shard": [index + 1, count], "stages": summary.stages });
    Ok(Output::done(json, text))
}

fn shard(text: &str) -> Result<Shard, String> {
    let parts = text.split_once('/');
    let parts = parts.and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
    match parts {
        Some((index, count)) if (1..=count).contains(&index) => Ok(Shard(index - 1, count)),
        _ => Err("expected I/N with I from 1 to N, such as 3/8".into()),
    }
}

/// How schedulers number the processes of a job: index, number of processes, first index, step.
const SCHEDULERS: [[&str; 4]; 3] = [
    [
        "SLURM_ARRAY_TASK_ID",
        "SLURM_ARRAY_TASK_COUNT",
        "SLURM_ARRAY_TASK_MIN",
        "SLURM_ARRAY_TASK_STEP",
    ],
    // Kubernetes gives no count: the job's file repeats its `completions`.
    ["JOB_COMPLETION_INDEX", "JOB_COMPLETIONS", "", ""],
    [
        "AWS_BATCH_JOB_ARRAY_INDEX",
        "AWS_BATCH_JOB_ARRAY_SIZE",
        "",
        "",
    ],
];

/// The share that a scheduler's variables name; the whole where there is none.
fn assigned(variable: impl Fn(&str) -> Option<String>) -> Result<Shard, Error> {
    let Some([index, count, first, step]) = SCHEDULERS
        .into_iter()
        .find(|[index, ..]| variable(index).is_some())
    else {
        return Ok(Shard(0, 1));
    };
    let number = |name: &str, default: Option<usize>| {
        match variable(name) {
        None if default.is_some() => Ok(default.unwrap_or(0)),
        text => text.and_then(|text| text.parse().ok()).ok_or_else(|| {
            Error::input(format!(
                "take a share of the work: {index} is set, but {name} is no number; set it, or give --shard I/N"
            ))
        }),
    }
    };
    let from_first = number(index, None)?.saturating_sub(number(first, Some(0))?);
    let count = number(count, None)?.max(1);
    // A list of indices with gaps may go beyond.
    Ok(Shard(
        from_first / number(step, Some(1))?.max(1) % count,
        count,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assigned_by(variables: &[(&str, &str)]) -> Result<Shard, Error> {
        assigned(|name| {
            let found = variables.iter().find(|(other, _)| *other == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn a_share_is_one_of_many_from_the_first_to_the_last() {
        assert_eq!(shard("1/1"), Ok(Shard(0, 1)));
        assert_eq!(shard("8/8"), Ok(Shard(7, 8)));
        for text in ["0/8", "9/8", "1/0", "1", "a/b", "-1/2", "1/2/3"] {
            assert!(shard(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_share_is_that_of_the_scheduler() {
        let slurm = |index, count, first, step| {
            assigned_by(&[
                ("SLURM_ARRAY_TASK_ID", index),
                ("SLURM_ARRAY_TASK_COUNT", count),
                ("SLURM_ARRAY_TASK_MIN", first),
                ("SLURM_ARRAY_TASK_STEP", step),
            ])
            .expect("a share")
        };
        assert_eq!(assigned_by(&[]).expect("all"), Shard(0, 1));
        assert_eq!(slurm("0", "8", "0", "1"), Shard(0, 8));
        assert_eq!(slurm("8", "8", "1", "1"), Shard(7, 8));
        assert_eq!(slurm("15", "3", "5", "5"), Shard(2, 3));
        assert_eq!(slurm("100", "3", "1", "1"), Shard(0, 3));
        let kubernetes = [("JOB_COMPLETION_INDEX", "3"), ("JOB_COMPLETIONS", "64")];
        assert_eq!(assigned_by(&kubernetes).expect("a share"), Shard(3, 64));
        let batch = [
            ("AWS_BATCH_JOB_ARRAY_INDEX", "9"),
            ("AWS_BATCH_JOB_ARRAY_SIZE", "10"),
        ];
        assert_eq!(assigned_by(&batch).expect("a share"), Shard(9, 10));
        let error = assigned_by(&kubernetes[..1]).expect_err("no count");
        assert!(error.to_string().contains("JOB_COMPLETIONS"), "{error}");
    }
}
