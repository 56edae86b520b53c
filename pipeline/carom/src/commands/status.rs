//! `carom status`: what workers did to a run, and what is left, from its files alone.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use clap::Args;
use diagnose::Diagnose;
use durable::{Lock, LockError};
use ingest::Ingest;
use judge::{Predict, Solve};
use serde::Serialize;
use stage::{Event, ItemStage, ListStage, Stage, WorkerSeen, workers};
use sysid::Sysid;
use train::Train;

use crate::Error;
use crate::error::{Output, to_json};

/// `carom status`.
#[derive(Args, Debug)]
pub struct StatusArgs {
    /// Folder of a run.
    #[arg(value_name = "SHARED")]
    pub dir: PathBuf,
}

/// The stages that every run goes through, in their order.
const STAGES: [&str; 6] = [
    Ingest::NAME,
    Sysid::NAME,
    Diagnose::NAME,
    Solve::NAME,
    Train::NAME,
    Predict::NAME,
];

#[derive(Debug, Default, Serialize)]
struct Status {
    /// Whether a run works in the folder, alone.
    is_run_at_work: bool,
    /// The version in use.
    latest: Option<String>,
    /// In the order in which workers came to them.
    stages: Vec<StageStatus>,
    /// Stages that no worker has come to.
    to_come: Vec<&'static str>,
    workers: Vec<WorkerStatus>,
}

/// What is known of a stage; jobs are logs, blocks of items, or the whole.
#[derive(Debug, Default, Serialize)]
struct StageStatus {
    stage: String,
    jobs: usize,
    left: usize,
    /// Mean time of a job of those that workers did, in s.
    seconds_each: Option<f64>,
    /// When what is left will be done by those who live, in s from now.
    ends_in: Option<f64>,
}

#[derive(Debug, Serialize)]
struct WorkerStatus {
    name: String,
    /// From 1, of how many.
    shard: [usize; 2],
    state: &'static str,
    /// What it does, or did last.
    doing: String,
    /// Since when, in s before now by the clocks of both machines; none where it has ended.
    doing_for: Option<f64>,
    jobs: usize,
    seconds: f64,
}

/// Reads what workers say of themselves.
pub fn run(args: &StatusArgs) -> Result<Output, Error> {
    let cache = args.dir.join("cache");
    if !cache.is_dir() {
        return Err(Error::input(format!(
            "tell how far the run in {} is: nobody has worked there; `carom work LOGS --rig rig.toml --out {}` begins",
            args.dir.display(),
            args.dir.display()
        )));
    }
    let is_run_at_work = match Lock::share(&cache.join("lock")) {
        Ok(_) => false,
        Err(LockError::Busy { .. }) => true,
        Err(LockError::Io(error)) => return Err(error.into()),
    };
    let latest = fs::read_to_string(args.dir.join("latest")).ok();
    let status = Status {
        is_run_at_work,
        latest: latest.map(|latest| latest.trim().to_owned()),
        ..Status::of(&workers(&args.dir)?)
    };
    Ok(Output::done(to_json(&status)?, status.text()))
}

/// What is known of jobs that have a stage, its settings and what is shared in common.
#[derive(Default)]
struct Group {
    jobs: usize,
    /// Missing when the first worker came, and when the last one did.
    missing: [usize; 2],
    done: BTreeSet<String>,
    seconds: f64,
    /// Whether a worker has gone on to the next.
    is_passed: bool,
}

impl Group {
    fn left(&self) -> usize {
        // A worker that is killed between an answer and its line has said nothing of it.
        let [first, last] = self.missing;
        match self.is_passed {
            true => 0,
            false => last.min(first.saturating_sub(self.done.len())),
        }
    }
}

impl Status {
    fn of(workers: &[WorkerSeen]) -> Self {
        let mut order: Vec<String> = Vec::new();
        let mut groups: BTreeMap<(String, String), Group> = BTreeMap::new();
        for worker in workers {
            let mut at = None;
            for line in &worker.lines {
                let next = match &line.event {
                    Event::Found {
                        stage,
                        group,
                        jobs,
                        missing,
                    } => {
                        if !order.contains(stage) {
                            order.push(stage.clone());
                        }
                        let key = (stage.clone(), group.clone());
                        let of_group = groups.entry(key.clone()).or_default();
                        let [first, last] = of_group.missing;
                        of_group.missing = match of_group.jobs {
                            0 => [*missing; 2],
                            _ => [first.max(*missing), last.min(*missing)],
                        };
                        of_group.jobs = of_group.jobs.max(*jobs);
                        Some(Some(key))
                    }
                    Event::Done {
                        stage,
                        group,
                        job,
                        seconds,
                        ..
                    } => {
                        let of_group = groups.entry((stage.clone(), group.clone()));
                        let of_group = of_group.or_default();
                        of_group.done.insert(job.clone());
                        of_group.seconds += seconds;
                        None
                    }
                    Event::Ended => Some(None),
                    _ => None,
                };
                if let Some(next) = next
                    && let Some(passed) = at.replace(next).flatten()
                    && let Some(passed) = groups.get_mut(&passed)
                {
                    passed.is_passed = true;
                }
            }
        }
        let alive = workers.iter().filter(|worker| worker.is_alive).count();
        let stage = |stage: &String| {
            let of_stage = || groups.iter().filter(|((other, _), _)| other == stage);
            let sum = |count: fn(&Group) -> usize| of_stage().map(|(_, g)| count(g)).sum();
            let (jobs, left): (usize, usize) = (sum(|group| group.jobs), sum(Group::left));
            let done: usize = sum(|group| group.done.len());
            let seconds: f64 = of_stage().map(|(_, group)| group.seconds).sum();
            let seconds_each = (done > 0).then(|| seconds / done as f64);
            let ends_in = seconds_each.filter(|_| alive > 0);
            StageStatus {
                stage: stage.clone(),
                jobs,
                left,
                seconds_each,
                ends_in: ends_in.map(|each| each * left.div_ceil(alive.max(1)) as f64),
            }
        };
        let is_to_come = |stage: &&str| !order.iter().any(|seen| seen == *stage);
        Self {
            stages: order.iter().map(stage).collect(),
            to_come: STAGES.into_iter().filter(is_to_come).collect(),
            workers: workers.iter().map(WorkerStatus::of).collect(),
            ..Self::default()
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for stage in self.stages.iter().filter(|stage| stage.jobs > 0) {
            let done = stage.jobs - stage.left;
            let _ = write!(text, "{:<10} {done} of {}", stage.stage, stage.jobs);
            if let Some(each) = stage.seconds_each {
                let _ = write!(text, ", {each:.2} s each");
            }
            match (stage.left, stage.ends_in) {
                (0, _) => {}
                (left, None) => {
                    let _ = write!(text, ", {left} left");
                }
                (left, Some(end)) => {
                    let _ = write!(text, ", {left} left: some {end:.0} s");
                }
            }
            text.push('\n');
        }
        if !self.to_come.is_empty() && !self.workers.is_empty() {
            let _ = writeln!(text, "{:<10} {}", "to come", self.to_come.join(", "));
        }
        for worker in &self.workers {
            let WorkerStatus {
                name,
                shard: [index, count],
                state,
                doing,
                doing_for,
                jobs,
                seconds,
            } = worker;
            let since = doing_for.map_or(String::new(), |since| format!(" for {since:.0} s"));
            let _ = writeln!(
                text,
                "{state:<10} {name} ({index}/{count}): {doing}{since}; {jobs} answered in {seconds:.1} s"
            );
        }
        let run = match (self.is_run_at_work, self.workers.is_empty()) {
            (true, _) => "a run gathers what is there\n",
            (false, true) => "no worker since the last run\n",
            (false, false) => "",
        };
        text += run;
        if let Some(latest) = &self.latest {
            let _ = writeln!(text, "{:<10} {latest}", "version");
        }
        text
    }
}

impl WorkerStatus {
    fn of(worker: &WorkerSeen) -> Self {
        let mut status = Self {
            name: worker.name.clone(),
            shard: [1, 1],
            state: if worker.is_alive { "alive" } else { "killed" },
            doing: "reads the logs".into(),
            doing_for: None,
            jobs: 0,
            seconds: 0.0,
        };
        for line in &worker.lines {
            match &line.event {
                Event::Began {
                    shard: [index, count],
                    ..
                } => status.shard = [index + 1, *count],
                Event::Took { stage } => status.doing = format!("computes {stage}"),
                Event::Waits { stage } => status.doing = format!("waits for {stage}"),
                Event::Done { stage, seconds, .. } => {
                    status.doing = format!("is at {stage}");
                    status.jobs += 1;
                    status.seconds += seconds;
                }
                Event::Failed { why } => {
                    status.state = "failed";
                    status.doing = format!("failed to {why}");
                }
                Event::Ended => {
                    status.state = "done";
                    status.doing = "every answer is there".into();
                }
                Event::Found { .. } => {}
            }
        }
        let last = worker.lines.last().filter(|_| worker.is_alive);
        let now = SystemTime::now().duration_since(UNIX_EPOCH).ok();
        status.doing_for = last
            .zip(now)
            .map(|(line, now)| (now.as_secs_f64() - line.at).max(0.0));
        status
    }
}
