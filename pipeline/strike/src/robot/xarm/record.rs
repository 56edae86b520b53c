//! What an arm's reports become in a log.

use std::time::{Instant, SystemTime};

use logs::write::{Samples, Stamped, StateSample};
use values::Point;

use super::guard::{Sample, norm};
use super::setup::Setup;
use crate::Plan;

/// Commands a second in the log, in Hz.
const COMMAND_RATE: f64 = 250.0;
/// Idle commands before and after the motion, in s.
const IDLE: f64 = 0.3;

/// The log's samples, stamped by this computer's clock, and the speed (m/s) that was delivered where the tip touches; none where
/// it did not come so far. `begun` is when the controller took the line.
pub(super) fn samples(
    record: &[Sample],
    plan: &Plan,
    setup: &Setup,
    clock: (SystemTime, Instant),
    begun: Instant,
) -> (Samples, Option<f64>) {
    let epoch = clock.0.duration_since(SystemTime::UNIX_EPOCH);
    let origin = epoch.map_or(0, |since| since.as_nanos() as u64);
    let stamp = |at: Instant| origin + at.saturating_duration_since(clock.1).as_nanos() as u64;
    let state = |sample: &Sample| {
        let [x, y, z, ..] = sample.report.pose;
        let [vx, vy, _] = sample.report.velocity;
        StateSample {
            stamp: stamp(sample.at),
            position: setup.on_table([x, y, z]).into(),
            velocity: [vx * 1e-3, vy * 1e-3],
        }
    };
    let stroke = plan.stroke();
    let ticks = ((stroke.t_stop + 2.0 * IDLE) * COMMAND_RATE) as u32;
    let command = |tick: u32| {
        let time = f64::from(tick) / COMMAND_RATE - IDLE;
        let velocity = if time < 0.0 {
            Point::default()
        } else {
            stroke.at(time).1
        };
        Stamped {
            stamp: (stamp(begun) as i64 + (time * 1e9) as i64).max(0) as u64,
            x: velocity.x,
            y: velocity.y,
        }
    };
    let samples = Samples {
        states: record.iter().map(state).collect(),
        commands: (0..=ticks).map(command).collect(),
        ..Samples::default()
    };
    (samples, delivered(record, plan, setup))
}

/// The speed (m/s) between the two reports around the place where the tip touches.
fn delivered(record: &[Sample], plan: &Plan, setup: &Setup) -> Option<f64> {
    let direction = plan.stroke().direction();
    let left = |sample: &Sample| {
        let [x, y, z, ..] = sample.report.pose;
        (plan.strike - setup.on_table([x, y, z])).dot(direction)
    };
    let speed = |sample: &Sample| norm(sample.report.velocity) * 1e-3;
    record.windows(2).find_map(|pair| {
        let (before, after) = (left(&pair[0]), left(&pair[1]));
        let passes = before > 0.0 && after <= 0.0;
        passes.then(|| {
            let share = before / (before - after);
            speed(&pair[0]) + share * (speed(&pair[1]) - speed(&pair[0]))
        })
    })
}
