//! Tables of stop errors in cm, and those of a trial.

use std::collections::BTreeMap;
use std::fmt::Write;

use judge::{Evaluation, Misses};
use store::Model;
use values::StopErrors;

use crate::trial::{Outcome, Trial};

/// One line of a table of stop errors, in m.
pub struct Line<'a> {
    pub name: &'a str,
    /// Mean, sd, median, p95.
    pub numbers: [f64; 4],
    pub n: usize,
    /// What is said behind.
    pub remark: String,
}

impl<'a> Line<'a> {
    fn of(name: &'a str, errors: StopErrors, remark: String) -> Self {
        Self {
            name,
            numbers: [errors.mean, errors.sd, errors.median, errors.p95],
            n: errors.n,
            remark,
        }
    }
}

/// Characters of a name, at the least.
const NAME_WIDTH: usize = 16;

/// A table of stop errors in cm.
pub fn table<'a>(lines: impl Iterator<Item = Line<'a>>) -> String {
    let lines: Vec<Line<'_>> = lines.collect();
    let names = lines.iter().map(|line| line.name.chars().count());
    let width = names.fold(NAME_WIDTH, usize::max);
    let mut text = format!(
        "{:<width$} {:>8} {:>8} {:>8} {:>8} {:>6}\n",
        "cm", "mean", "sd", "median", "95 %", "n"
    );
    for line in lines {
        let [mean, sd, median, p95] = line.numbers.map(|number| number * 100.0);
        let row = format!(
            "{:<width$} {mean:>8.2} {sd:>8.2} {median:>8.2} {p95:>8.2} {:>6}  {}",
            line.name, line.n, line.remark
        );
        let _ = writeln!(text, "{}", row.trim_end());
    }
    text
}

/// An evaluation's table, the noise floor last; below it, where something differs by session, the errors in new ones.
pub fn evaluation_table(evaluation: &Evaluation) -> String {
    let floor = evaluation.noise_floor.map(|floor| ("noise_floor", floor));
    let mut text = stop_errors(&evaluation.models, floor);
    if let Some(new) = evaluation.differing_sessions() {
        let _ = write!(
            text,
            "each of {} sessions as if it had never been seen\n{}",
            new.sessions,
            stop_errors(&new.models, None)
        );
    }
    text
}

/// Where a model misses; empty where too few strikes say so.
pub fn misses_table(model: &str, parts: &[Misses]) -> String {
    if parts.is_empty() {
        return String::new();
    }
    let names: Vec<String> = parts.iter().map(Misses::part).collect();
    let lines = parts.iter().zip(&names);
    let lines = lines.map(|(part, name)| Line::of(name, part.errors, String::new()));
    format!("\nwhere `{model}` misses\n{}", table(lines))
}

fn stop_errors(models: &BTreeMap<String, StopErrors>, floor: Option<(&str, StopErrors)>) -> String {
    let models = Model::ALL
        .into_iter()
        .map(Model::name)
        .filter_map(|name| Some((name, *models.get(name)?)));
    table(models.chain(floor).map(|(name, errors)| {
        let remark = match errors.failed {
            0 => String::new(),
            failed => format!("{failed} not predicted"),
        };
        Line::of(name, errors, remark)
    }))
}

/// The two tables of a trial as text.
pub fn trial(trial: &Trial) -> String {
    let lines = |outcomes: &BTreeMap<String, Outcome>| {
        let models = Model::ALL.into_iter().map(Model::name).filter_map(|name| {
            let outcome = outcomes.get(name)?;
            let errors = outcome.errors.unwrap_or_default();
            Some(Line::of(name, errors, remark(outcome)))
        });
        let of_floor = |errors| Line::of("noise_floor", errors, "repeats of one command".into());
        table(models.chain(trial.noise_floor.map(of_floor)))
    };
    let random = trial.models.values().next();
    let struck = random.map_or(0, |outcome| outcome.strikes.len() + outcome.refusals.len());
    let session = trial.session.as_ref().map_or_else(String::new, |session| {
        format!(", in its last logged session {session}")
    });
    let new = trial.new_sessions.as_ref().map_or_else(String::new, |new| {
        format!(
            "\nThe same targets in {} new sessions, which the version has never seen\n{}",
            new.sessions,
            lines(&new.models)
        )
    });
    format!(
        "Version {} against {}{session}\n\nFigure 8: two starts, four targets each, repeated\n{}\n\
         Random targets: {struck} struck at, {} of {} drawn were refused by the default model\n{}{new}",
        trial.artifact,
        trial.robot,
        lines(&trial.figure_8),
        trial.drawn - struck,
        trial.drawn,
        lines(&trial.models),
    )
}

/// What the plans promised, and how many were refused.
fn remark(outcome: &Outcome) -> String {
    let expected = outcome
        .expected_miss
        .map(|expected| format!("{:.2} expected", 100.0 * expected));
    let refused = match outcome.refusals.len() {
        0 => None,
        refused => Some(format!("{refused} refused")),
    };
    let parts: Vec<String> = expected.into_iter().chain(refused).collect();
    parts.join(", ")
}
