//! One strike beside a model: by how much it launched, went and pointed otherwise, and what a shift of the table does to each.

use serde::{Deserialize, Serialize};
use values::{Command, Conditions, Point, Strike, Track};

use super::linear::{Rows, Vector, matrix};
use crate::{Shift, Simulated, Simulator, effects, search::wrap};

/// Steps of the differences: of ln friction, ln gain, and heading in rad.
const STEPS: [f64; 3] = [0.02, 0.01, 0.01];
/// Fewer frames than these of a slide show no launch speed.
const LEAST_FRAMES: usize = 6;

/// What a strike shows: ln launch speed, ln distance, bearing in rad. The launch speed is that of a constant deceleration, √(2·a·d);
/// strike and simulation are read alike, so that what this leaves out cancels.
type Shown = [f64; 3];

/// A strike beside a model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observation {
    /// The shift of the table that the model was compared at.
    pub about: Shift,
    /// Observed less predicted: ln launch speed, ln distance, bearing in rad.
    pub away: [f64; 3],
    /// Derivatives of each of them by ln friction, ln gain and heading; a row each.
    pub slopes: Rows,
}

impl Observation {
    /// Observed less predicted at another shift, by the slopes.
    pub(super) fn away_at(&self, shift: &Vector) -> Vector {
        let by = shift - Vector::from(self.about.values());
        Vector::from(self.away) - matrix(self.slopes) * by
    }
}

/// A model's simulator at one shift of the table, and a step before and after it in each of its directions.
pub struct Observer {
    here: Simulator,
    beside: [[Simulator; 2]; 3],
}

impl Observer {
    /// An observer of a model's world, about the shift that it has.
    pub fn about(here: &Simulator) -> Self {
        let beside = std::array::from_fn(|i| {
            [-1.0, 1.0].map(|sign| {
                let mut values = here.shift().values();
                values[i] += sign * STEPS[i];
                here.shifted(values.into())
            })
        });
        Self {
            here: here.shifted(here.shift()),
            beside,
        }
    }

    /// Compares a strike with the model, as in a session that it does not know. `sent` is the command that the model's world takes for what was sent.
    /// None where the track shows no free slide, or the model cannot simulate it.
    pub fn observe(&self, strike: &Strike, sent: Command) -> Option<Observation> {
        if strike.is_pushed_again() || strike.track.len() < LEAST_FRAMES {
            return None;
        }
        let frame = 1.0 / self.here.rig().camera.rate;
        let shown = shown(&strike.after_impact(frame))?;
        let conditions = unknown(&strike.conditions);
        let predict = |simulator: &Simulator| {
            let mut worker = simulator.worker();
            let simulated = worker.strike(strike.initial, sent, &conditions).ok()?;
            shown_by(strike, &simulated, frame)
        };
        let here = predict(&self.here)?;
        let slopes = self.slopes(predict)?;
        Some(Observation {
            about: self.here.shift(),
            away: [
                shown[0] - here[0],
                shown[1] - here[1],
                wrap(shown[2] - here[2]),
            ],
            slopes,
        })
    }

    /// Derivatives of ln distance and bearing (rad) of a strike at `from` (m) by ln friction, ln gain and heading. None where the model cannot
    /// simulate it.
    pub fn stop_slopes(
        &self,
        from: Point,
        command: Command,
        conditions: &Conditions,
    ) -> Option<[[f64; 3]; 2]> {
        let [_, distance, bearing] = self.slopes(|simulator| {
            let path = simulator
                .worker()
                .strike(from, command, conditions)
                .ok()?
                .stop
                - from;
            Some([0.0, path.norm().ln(), path.bearing()])
        })?;
        Some([distance, bearing])
    }

    fn slopes(&self, predict: impl Fn(&Simulator) -> Option<Shown>) -> Option<Rows> {
        let mut slopes = [[0.0; 3]; 3];
        for (column, ([before, after], step)) in self.beside.iter().zip(STEPS).enumerate() {
            let (before, after) = (predict(before)?, predict(after)?);
            for (row, slopes) in slopes.iter_mut().enumerate() {
                slopes[column] = wrap(after[row] - before[row]) / (2.0 * step);
            }
        }
        Some(slopes)
    }
}

/// The conditions with a session that no world knows.
fn unknown(conditions: &Conditions) -> Conditions {
    Conditions {
        session: effects::UNKNOWN.into(),
        ..conditions.clone()
    }
}

fn shown(strike: &Strike) -> Option<Shown> {
    let path = strike.path();
    let distance = path.norm();
    let speed_squared = 2.0 * strike.deceleration()? * distance;
    let shown = [0.5 * speed_squared.ln(), distance.ln(), path.bearing()];
    shown.iter().all(|value| value.is_finite()).then_some(shown)
}

/// A simulated strike as the camera would have seen it, frame by frame.
fn shown_by(strike: &Strike, simulated: &Simulated, frame: f64) -> Option<Shown> {
    let mut track = Track::default();
    let mut time = frame;
    while time < simulated.rest_time {
        let at = simulated.at(time + 0.5 * frame);
        track.t.push(time);
        track.x.push(at.x);
        track.y.push(at.y);
        time += frame;
    }
    shown(&Strike {
        track,
        stop: simulated.stop,
        ..strike.clone()
    })
}
