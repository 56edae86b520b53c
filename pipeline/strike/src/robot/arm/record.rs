//! From an arm's reports to the samples of a log.

use std::time::{Duration, Instant};

use logs::write::{Samples, Stamped, StateSample};
use values::Point;

use super::driver::norm;
use super::guard::Sample;
use super::setup::Setup;
use crate::Plan;
use crate::epoch::Epoch;

/// Rate of the commands in the log, in Hz.
const COMMAND_RATE: f64 = 250.0;
/// Idle commands before and after the motion, in s.
const IDLE: f64 = 0.3;

/// The log's samples, stamped by this computer's clock, and the speed (m/s) that was delivered where the tip touches; none where
/// it did not come so far. `begun` is when the controller took the line, without which nothing was commanded, `stopped` when it was stopped.
pub(super) fn samples(
    record: &[Sample],
    plan: &Plan,
    setup: &Setup,
    epoch: Epoch,
    (begun, stopped): (Option<Instant>, Option<Instant>),
) -> (Samples, Option<f64>) {
    let state = |sample: &Sample| StateSample {
        stamp: epoch.stamp(sample.made),
        position: setup.on_table(sample.report.pose.at).into(),
        velocity: setup.turned(sample.report.velocity).into(),
    };
    let stroke = plan.stroke();
    let ticks = ((stroke.t_stop + 2.0 * IDLE) * COMMAND_RATE) as u32;
    let command = |begun: Instant, tick: u32| {
        let time = f64::from(tick) / COMMAND_RATE - IDLE;
        let at = begun + Duration::from_secs_f64(time.max(0.0));
        let velocity = if time < 0.0 || stopped.is_some_and(|stopped| at > stopped) {
            Point::default()
        } else {
            stroke.at(time).1
        };
        Stamped {
            stamp: (epoch.stamp(begun) as i64 + (time * 1e9) as i64).max(0) as u64,
            x: velocity.x,
            y: velocity.y,
        }
    };
    let samples = Samples {
        states: record.iter().map(state).collect(),
        commands: begun.map_or_else(Vec::new, |begun| {
            (0..=ticks).map(|tick| command(begun, tick)).collect()
        }),
        ..Samples::default()
    };
    (samples, delivered(record, plan, setup))
}

/// The speed (m/s) between the two reports around the place where the tip touches.
fn delivered(record: &[Sample], plan: &Plan, setup: &Setup) -> Option<f64> {
    let direction = plan.stroke().direction();
    let left =
        |sample: &Sample| (plan.strike - setup.on_table(sample.report.pose.at)).dot(direction);
    let speed = |sample: &Sample| norm(sample.report.velocity);
    record.windows(2).find_map(|pair| {
        let (before, after) = (left(&pair[0]), left(&pair[1]));
        let passes = before > 0.0 && after <= 0.0;
        passes.then(|| {
            let share = before / (before - after);
            speed(&pair[0]) + share * (speed(&pair[1]) - speed(&pair[0]))
        })
    })
}
