//! Tables of stop errors in cm.

use std::collections::BTreeMap;
use std::fmt::Write;

use evaluate::Evaluation;
use store::Model;
use values::StopErrors;

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

fn stop_errors(models: &BTreeMap<String, StopErrors>, floor: Option<(&str, StopErrors)>) -> String {
    let models = Model::ALL
        .into_iter()
        .map(Model::name)
        .filter_map(|name| Some((name, *models.get(name)?)));
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
