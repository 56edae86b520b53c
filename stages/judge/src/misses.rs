//! Where a model misses: its stop errors by session, speed, angle and place.

use std::collections::HashMap;

use polars::prelude::*;
use serde::{Deserialize, Serialize};
use values::{StopErrors, Strike};

use crate::{JudgeError, Prediction};

/// Number of parts into which strikes are cut by a quantity, of as many strikes each.
const PARTS: usize = 3;
/// Least number of strikes of a part that says something.
const LEAST: usize = 4;

/// The stop errors of a part of the strikes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Misses {
    /// What the strikes are parted by: `session`, `speed` (m/s), `angle` (rad), `x` or `y` of the start, or `distance` of the path (m).
    pub by: String,
    /// The session; empty of a quantity.
    pub session: String,
    /// The least value of the quantity; none of a session.
    pub from: Option<f64>,
    /// The greatest value of the quantity; none of a session.
    pub to: Option<f64>,
    /// Stop errors of these strikes, in m.
    pub errors: StopErrors,
}

impl Misses {
    /// The part in words, such as `speed 0.45 to 0.61 m/s`, or `session monday`.
    pub fn part(&self) -> String {
        let unit = match self.by.as_str() {
            "speed" => "m/s",
            "angle" => "rad",
            _ => "m",
        };
        match (self.from, self.to) {
            (Some(from), Some(to)) => format!("{} {from:.2} to {to:.2} {unit}", self.by),
            _ => format!("{} {}", self.by, self.session),
        }
    }
}

/// A name, and the value of a strike.
type Quantity = (&'static str, fn(&Strike) -> f64);

/// The quantities that strikes are parted by.
const QUANTITIES: [Quantity; 5] = [
    ("speed", |strike| strike.command.speed),
    ("angle", |strike| strike.command.angle),
    ("x", |strike| strike.initial.x),
    ("y", |strike| strike.initial.y),
    ("distance", |strike| strike.path().norm()),
];

/// A model's stop errors by each quantity, and by session where there are several. Parts of fewer than four strikes are left out.
pub fn misses(
    model: &str,
    strikes: &[Strike],
    predictions: &[Prediction],
) -> Result<Vec<Misses>, JudgeError> {
    let table = joined(model, strikes, predictions)?;
    let mut parts = Vec::new();
    for (name, _) in QUANTITIES {
        let sorted = table.sort([name], SortMultipleOptions::default())?;
        let rows = sorted.height();
        for part in 0..PARTS {
            let (begin, end) = (part * rows / PARTS, (part + 1) * rows / PARTS);
            let part = sorted.slice(begin as i64, end - begin);
            let column = part.column(name)?.f64()?;
            let ends = (column.min(), column.max());
            parts.extend(summed_up(name, "", ends, &part)?);
        }
    }
    let sorted = table.sort(["session"], SortMultipleOptions::default())?;
    let sessions: Vec<&str> = sorted.column("session")?.str()?.iter().flatten().collect();
    let mut begin = 0;
    for same in sessions.chunk_by(|a, b| a == b) {
        if same.len() < sessions.len() {
            let part = sorted.slice(begin as i64, same.len());
            parts.extend(summed_up("session", same[0], (None, None), &part)?);
        }
        begin += same.len();
    }
    Ok(parts)
}

/// Strikes joined with a model's predictions of them, a row each that it predicts.
fn joined(
    model: &str,
    strikes: &[Strike],
    predictions: &[Prediction],
) -> Result<DataFrame, JudgeError> {
    let places = strikes
        .iter()
        .zip(0..)
        .map(|(strike, place)| (strike.id.as_str(), place));
    let places: HashMap<&str, IdxSize> = places.collect();
    let predicted = predictions.iter().filter(|row| row.model == model);
    let (rows, errors): (Vec<IdxSize>, Vec<f64>) = predicted
        .filter_map(|row| Some((*places.get(row.strike_id.as_str())?, row.error?)))
        .unzip();
    let sessions = strikes
        .iter()
        .map(|strike| strike.conditions.session.as_str());
    let mut table = df!("session" => sessions.collect::<Vec<_>>())?;
    for (name, of) in QUANTITIES {
        let column: Vec<f64> = strikes.iter().map(of).collect();
        table.with_column(Column::new(name.into(), column))?;
    }
    let mut table = table.take(&IdxCa::from_vec("rows".into(), rows))?;
    table.with_column(Column::new("error".into(), errors))?;
    Ok(table)
}

fn summed_up(
    by: &str,
    session: &str,
    (from, to): (Option<f64>, Option<f64>),
    part: &DataFrame,
) -> Result<Option<Misses>, JudgeError> {
    let errors = part.column("error")?.f64()?;
    let errors = StopErrors::of(errors.into_no_null_iter()).filter(|errors| errors.n >= LEAST);
    Ok(errors.map(|errors| Misses {
        by: by.into(),
        session: session.into(),
        from,
        to,
        errors,
    }))
}

#[cfg(test)]
mod tests {
    use values::{Command, Conditions, Point, Split};

    use super::*;
    use crate::PredictionStatus;

    #[test]
    fn a_model_that_misses_fast_strikes_on_one_day_is_seen_to() {
        let strikes: Vec<Strike> = (0..24_u32)
            .map(|index| Strike {
                id: index.to_string(),
                index,
                split: Split::Test,
                conditions: Conditions {
                    session: if index % 2 == 0 { "a" } else { "b" }.into(),
                    ..Conditions::default()
                },
                ..Strike::bare(
                    Command::new(0.4 + 0.02 * f64::from(index), 0.0),
                    Point::new(0.3, 0.0),
                    Point::new(0.6, 0.0),
                )
            })
            .collect();
        let predictions: Vec<Prediction> = strikes
            .iter()
            .rev()
            .map(|strike| Prediction {
                model: "sysid".into(),
                strike_id: strike.id.clone(),
                stop: None,
                error: (strike.id != "0").then_some(if strike.index >= 16 { 0.02 } else { 0.001 }),
                evaluations: 1,
                status: PredictionStatus::Simulated,
            })
            .collect();
        let parts = misses("sysid", &strikes, &predictions).expect("a table");
        let of = |by: &str| -> Vec<&Misses> { parts.iter().filter(|part| part.by == by).collect() };
        let speeds = of("speed");
        assert_eq!(speeds.len(), PARTS);
        assert!((speeds[0].errors.mean - 0.001).abs() < 1e-12);
        assert!((speeds[2].errors.mean - 0.02).abs() < 1e-12);
        assert!(speeds[0].to < speeds[1].from, "{speeds:?}");
        let sessions = of("session");
        assert_eq!(sessions.len(), 2);
        let counts: usize = sessions.iter().map(|part| part.errors.n).sum();
        assert_eq!(counts, 23, "what is not predicted has no error");
        assert!(
            misses("effect", &strikes, &predictions)
                .expect("none")
                .is_empty()
        );
    }
}
