//! What a command tells a person.

pub mod diagnosis;

use std::collections::BTreeMap;
use std::fmt::Write;

use evaluate::Evaluation;
use sysid::Fit;
use train::Trained;
use values::Reject;
use world::{PARAMETERS, Solution, SolveStatus};

use crate::results::Results;
use crate::trial::{Outcome, Trial};

/// Models in the order of tables.
const MODELS: [&str; 5] = [
    "nominal",
    "sysid",
    "sysid_residual",
    "effect",
    "effect_residual",
];

/// What the steps gave, in the order in which they were gone.
pub fn results(results: &Results) -> String {
    let mut text = strikes(results);
    if let Some(fit) = &results.fit {
        text += &world(fit);
    }
    if let Some(found) = &results.found {
        text += &diagnosis::diagnosis(&found.diagnosis);
        if found.world.is_some() && results.effect.is_none() {
            text += "           not added to the world, as asked\n";
        }
    }
    if let Some(why) = &results.no_diagnosis {
        let _ = writeln!(text, "diagnosis  none: {why}");
    }
    let learnt = [("sysid", &results.sysid), ("effect", &results.effect)];
    for (name, learnt) in learnt {
        let Some(learnt) = learnt else { continue };
        if !learnt.solutions.is_empty() {
            text += &solutions(name, &learnt.solutions);
        }
        if let Some(trained) = &learnt.trained {
            text += &residual(name, trained);
        } else if results.evaluation.is_some() {
            text += "residual   none: too few strikes to train on\n";
        }
    }
    if let Some(evaluation) = &results.evaluation {
        text += "\nStop error on held-out strikes\n";
        text += &evaluation_table(evaluation);
    }
    text
}

fn strikes(results: &Results) -> String {
    let mut text = format!("strikes    {} kept", results.kept.len());
    if results.rejects.is_empty() {
        text += ", none rejected\n";
    } else {
        let _ = writeln!(
            text,
            ", {} rejected: {}",
            results.rejects.len(),
            reasons(&results.rejects)
        );
        for example in examples(&results.rejects) {
            let _ = writeln!(text, "           {example}");
        }
    }
    for note in &results.log_notes {
        let _ = writeln!(text, "           {note}");
    }
    text
}

/// Such as "3 off_table, 1 truncated".
pub fn reasons(rejects: &[Reject]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for reject in rejects {
        *counts.entry(reject.reason.name()).or_default() += 1;
    }
    let counts: Vec<String> = counts
        .iter()
        .map(|(reason, count)| format!("{count} {reason}"))
        .collect();
    counts.join(", ")
}

/// The first of each reason, in words.
pub fn examples(rejects: &[Reject]) -> Vec<String> {
    let mut firsts: BTreeMap<&str, &Reject> = BTreeMap::new();
    for reject in rejects {
        firsts.entry(reject.reason.name()).or_insert(reject);
    }
    let example = |(reason, first): (&str, &Reject)| {
        let Reject {
            log, index, detail, ..
        } = first;
        format!("{reason}, such as strike {index} of {log}: {detail}")
    };
    firsts.into_iter().map(example).collect()
}

fn world(fit: &Fit) -> String {
    let mut text = format!(
        "sysid      tracks of {} strikes: {:.2} mm rms before, {:.2} mm after, {} simulations\n",
        fit.strikes,
        fit.rms_before * 1e3,
        fit.rms_after * 1e3,
        fit.simulations
    );
    for spec in PARAMETERS
        .iter()
        .filter(|spec| fit.freed.iter().any(|name| name == spec.name))
    {
        let Some(estimate) = fit.world.parameters.get(spec.name) else {
            continue;
        };
        let _ = write!(text, "           {:<14} {:.4}", spec.name, estimate.value);
        if let (Some(low), Some(high)) = (estimate.low, estimate.high) {
            let _ = write!(text, "  [{low:.4}, {high:.4}]");
        }
        let _ = writeln!(text, " {}", spec.unit);
    }
    let scatter = fit.world.scatter;
    let _ = writeln!(
        text,
        "           launches scatter by {:.2} % in speed and {:.2}° in angle, centroids by {:.2} mm",
        scatter.speed * 100.0,
        scatter.angle.to_degrees(),
        scatter.camera * 1e3
    );
    for note in &fit.notes {
        let _ = writeln!(text, "           {note}");
    }
    text
}

fn solutions(model: &str, solutions: &[Solution]) -> String {
    let all = solutions.len();
    let is_solved = |solution: &&Solution| solution.status == SolveStatus::Solved;
    let solved = solutions.iter().filter(is_solved).count();
    let evaluations: u32 = solutions.iter().map(|s| s.evaluations).sum();
    format!(
        "solve      {solved} of {all} paths in `{model}`, {:.2} simulations each\n",
        f64::from(evaluations) / all as f64
    )
}

fn residual(model: &str, trained: &Trained) -> String {
    let mae = trained.validation;
    format!(
        "residual   on `{model}`: validation error {:.4} ({:.4} m/s, {:.4} rad), epoch {} of {}\n",
        mae.raw,
        mae.d_speed,
        mae.d_angle,
        trained.best_epoch,
        trained.history.len()
    )
}

/// Where a rollback took the version out of use: what is in use instead, and how to change that.
pub fn rolled_back(version: &str, latest: Option<&str>) -> String {
    match latest {
        Some(latest) if latest != version => format!(
            "           it was rolled back, and {latest} stays in use; `carom artifacts rollback {version}` takes it again\n"
        ),
        _ => String::new(),
    }
}

/// One line of a table of stop errors, in m.
pub struct Line<'a> {
    /// Model.
    pub name: &'a str,
    /// Mean, sd, median, p95.
    pub numbers: [f64; 4],
    /// Strikes.
    pub n: usize,
    /// What is said behind.
    pub remark: String,
}

/// A table of stop errors in cm.
pub fn table<'a>(lines: impl Iterator<Item = Line<'a>>) -> String {
    let mut text = format!(
        "{:<16} {:>8} {:>8} {:>8} {:>8} {:>6}\n",
        "cm", "mean", "sd", "median", "95 %", "n"
    );
    for line in lines {
        let [mean, sd, median, p95] = line.numbers.map(|number| number * 100.0);
        let row = format!(
            "{:<16} {mean:>8.2} {sd:>8.2} {median:>8.2} {p95:>8.2} {:>6}  {}",
            line.name, line.n, line.remark
        );
        let _ = writeln!(text, "{}", row.trim_end());
    }
    text
}

/// An evaluation's table, the noise floor last.
pub fn evaluation_table(evaluation: &Evaluation) -> String {
    let models = MODELS
        .iter()
        .filter_map(|name| Some((*name, *evaluation.models.get(*name)?)));
    let floor = evaluation.noise_floor.map(|floor| ("noise_floor", floor));
    table(models.chain(floor).map(|(name, errors)| Line {
        name,
        numbers: [errors.mean, errors.sd, errors.median, errors.p95],
        n: errors.n,
        remark: match errors.failed {
            0 => String::new(),
            failed => format!("{failed} not predicted"),
        },
    }))
}

/// Both tables of a trial.
pub fn trial(trial: &Trial) -> String {
    let lines = |outcomes: &BTreeMap<String, Outcome>| {
        let models = MODELS.iter().filter_map(|name| {
            let outcome = outcomes.get(*name)?;
            let errors = outcome.errors.unwrap_or_default();
            Some(Line {
                name,
                numbers: [errors.mean, errors.sd, errors.median, errors.p95],
                n: errors.n,
                remark: match outcome.refusals.len() {
                    0 => String::new(),
                    refused => format!("{refused} refused"),
                },
            })
        });
        let floor = trial.noise_floor.map(|errors| Line {
            name: "noise_floor",
            numbers: [errors.mean, errors.sd, errors.median, errors.p95],
            n: errors.n,
            remark: "repeats of one command".into(),
        });
        table(models.chain(floor))
    };
    let random = trial.models.values().next();
    let struck = random.map_or(0, |outcome| outcome.strikes.len() + outcome.refusals.len());
    format!(
        "Version {} against the embedded rig ({})\n\nFigure 8: two starts, four targets each, repeated\n{}\n\
         Random targets: {struck} struck at, {} of {} drawn were refused by the default model\n{}",
        trial.artifact,
        trial.robot,
        lines(&trial.figure_8),
        trial.drawn - struck,
        trial.drawn,
        lines(&trial.models),
    )
}
