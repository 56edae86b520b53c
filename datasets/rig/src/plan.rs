//! Which strikes to make.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use values::{Command, Interval, Point};

use crate::strike::PreparedRig;
use crate::{RigSimError, StrikeIndex};

/// Strikes in a row that leave the table before the draw is given up.
const TRIES: u32 = 1_000;
/// The object keeps this distance from the table's edge beyond its own size, in m.
const MARGIN: f64 = 0.02;

/// One strike to make: where the camera sees the object, and the command; other keys of a file (`why`) are not read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedStrike {
    /// Initial position along x, in m.
    pub x0: f64,
    /// Initial position along y, in m.
    pub y0: f64,
    /// Commanded speed in m/s.
    pub speed: f64,
    /// Commanded angle in rad.
    pub angle: f64,
}

impl PlannedStrike {
    /// Initial position, in m.
    pub fn initial(&self) -> Point {
        Point::new(self.x0, self.y0)
    }

    /// The command.
    pub fn command(&self) -> Command {
        Command::new(self.speed, self.angle)
    }
}

/// Reads a plan: a JSON array of strikes, or an object with one under `next_strikes` or `strikes`.
pub fn parse_plan(text: &str) -> Result<Vec<PlannedStrike>, RigSimError> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum File {
        List(Vec<PlannedStrike>),
        Next { next_strikes: Vec<PlannedStrike> },
        Plan { strikes: Vec<PlannedStrike> },
    }
    let wrong = |why: String| RigSimError::Parse {
        what: "plan".to_owned(),
        why,
    };
    match serde_json::from_str(text) {
        Ok(File::List(strikes) | File::Next { next_strikes: strikes } | File::Plan { strikes }) => Ok(strikes),
        Err(error) if error.is_data() => Err(wrong(
            r#"expected a list of {"x0": m, "y0": m, "speed": m/s, "angle": rad}, or an object with it under "next_strikes" or "strikes""#
                .to_owned(),
        )),
        Err(error) => Err(wrong(error.to_string())),
    }
}

/// Draws strikes as the paper's section 3.4: positions, speeds and angles at random, drawn again where the object
/// would leave the table. Positions lie in the table's near third, the paper's reach of the arm.
pub(crate) fn draw(
    prepared: &PreparedRig,
    index: impl Fn(usize) -> StrikeIndex,
    count: usize,
    random: &mut ChaCha8Rng,
) -> Result<Vec<PlannedStrike>, RigSimError> {
    let rig = &prepared.truth.rig;
    let within = |interval: Interval, from: f64, to: f64| {
        Interval::new(
            interval.low + from * (interval.high - interval.low),
            interval.low + to * (interval.high - interval.low),
        )
    };
    let (x, y) = (
        within(rig.table.x, 1.0 / 9.0, 1.0 / 3.0),
        within(rig.table.y, 1.0 / 3.0, 2.0 / 3.0),
    );
    let mut strikes = Vec::with_capacity(count);
    let mut tries = 0;
    while strikes.len() < count {
        let mut between = |interval: Interval| {
            interval.low + (interval.high - interval.low) * random.random::<f64>()
        };
        let strike = PlannedStrike {
            x0: round(between(x)),
            y0: round(between(y)),
            speed: round(between(rig.robot.speed)),
            angle: round(between(rig.robot.angle)),
        };
        if stays(prepared, &strike, index(strikes.len())) {
            strikes.push(strike);
            tries = 0;
        } else {
            tries += 1;
            if tries == TRIES {
                return Err(RigSimError::NoStrikeFits { tries });
            }
        }
    }
    Ok(strikes)
}

/// To the tenth of a millimetre, mm/s and mrad in which a person would type it.
fn round(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// Whether the object moves and stays on the table, as it is and as the camera sees it.
fn stays(prepared: &PreparedRig, strike: &PlannedStrike, index: StrikeIndex) -> bool {
    let truth = &prepared.truth;
    let from = truth
        .hidden
        .unsee(strike.initial(), truth.rig.camera.centre, index);
    let outcome = prepared.strike(
        from,
        truth.hidden.deliver(strike.command(), from, index),
        index,
        1.0,
    );
    let edge = MARGIN + prepared.reach();
    let inside = |at: Point| {
        let table = &truth.rig.table;
        (table.x.low + edge..=table.x.high - edge).contains(&at.x)
            && (table.y.low + edge..=table.y.high - edge).contains(&at.y)
    };
    outcome.rest_time() > 0.0
        && outcome
            .points()
            .all(|at| inside(at) && inside(truth.see(at, index)))
}

pub(crate) fn check(
    prepared: &PreparedRig,
    index: usize,
    strike: &PlannedStrike,
) -> Result<(), RigSimError> {
    let wrong = |why: String| Err(RigSimError::Strike { index, why });
    let numbers = [strike.x0, strike.y0, strike.speed, strike.angle];
    if numbers.iter().any(|number| !number.is_finite()) {
        return wrong("a number is not finite".to_owned());
    }
    if strike.speed <= 0.0 {
        return wrong(format!("its speed {} must be above 0 m/s", strike.speed));
    }
    if !prepared.truth.rig.table.contains(strike.initial()) {
        return wrong(format!(
            "({}, {}) is not on the table of the rig file",
            strike.x0, strike.y0
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_is_a_list_or_what_a_diagnosis_wrote() {
        let one = r#"{"x0": 0.27, "y0": 0.05, "speed": 0.9, "angle": 0.2, "why": "fast"}"#;
        for text in [
            format!("[{one}]"),
            format!(r#"{{"next_strikes": [{one}]}}"#),
            format!(r#"{{"strikes": [{one}]}}"#),
        ] {
            let plan = parse_plan(&text).expect("a plan");
            assert_eq!(
                plan,
                [PlannedStrike {
                    x0: 0.27,
                    y0: 0.05,
                    speed: 0.9,
                    angle: 0.2
                }]
            );
        }
        let error = parse_plan(r#"[{"x": 1}]"#)
            .expect_err("no plan")
            .to_string();
        assert!(error.contains("next_strikes"), "{error}");
    }
}
