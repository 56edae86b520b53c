//! Every figure that the steps gave, in their order: what `--verbose` prints.

use std::fmt::Write;

use judge::Solved;
use sysid::Fit;
use train::Learned;
use world::{PARAMETERS, Solution, SolveStatus};

use super::diagnosis;
use super::shared::{stop_errors, strikes, unused_diagnosis, warnings};
use crate::results::Results;

/// What the steps gave, in the order in which they were gone.
pub fn details(results: &Results) -> String {
    let mut text = strikes(results, usize::MAX);
    if let Some(worlds) = &results.worlds {
        text += &world(&worlds.fit);
        if let Some(found) = worlds.found() {
            text += &diagnosis::diagnosis(&found.diagnosis);
        }
        text += &unused_diagnosis(worlds);
        for (name, of_world) in worlds.each() {
            if let Some(solved) = &of_world.solved {
                text += &solutions(name.name(), &solved.paths, results.strikes.len());
            }
            if let Some(learned) = &of_world.learned {
                text += &residual(name.name(), learned);
            }
        }
    }
    text += &warnings(results);
    text += &stop_errors(results);
    text
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

fn solutions(model: &str, paths: &[(usize, Solved)], strikes: usize) -> String {
    let all = paths.len();
    let solutions = || paths.iter().map(|(_, path)| &path.solution);
    let is_solved = |solution: &&Solution| solution.status == SolveStatus::Solved;
    let solved = solutions().filter(is_solved).count();
    let evaluations: u32 = solutions().map(|s| s.evaluations).sum();
    format!(
        "solve      {solved} of {all} paths in `{model}`, {:.2} simulations each{}\n",
        f64::from(evaluations) / all as f64,
        match strikes - all {
            0 => String::new(),
            others => format!("; {others} more strikes are neither solved nor learnt from"),
        }
    )
}

fn residual(model: &str, learned: &Learned) -> String {
    let mut text = format!("residual   on `{model}`: {}", learned.kind.name());
    if learned.scores.len() > 1 {
        let scores: Vec<String> = learned
            .scores
            .iter()
            .map(|score| format!("{} {:.2} cm", score.kind.name(), 100.0 * score.by_setting))
            .collect();
        let _ = write!(text, "; held-out commands: {}", scores.join(", "));
    }
    text + "\n"
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
