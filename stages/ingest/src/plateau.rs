//! The commanded speed and direction of a strike: the plateau of its commands.

use std::ops::Range;

use logs::Sample;
use values::{Command, RejectReason, Rig};

use crate::episode::{is_finite, speed};
use crate::order::since;
use crate::rejection::{Detail, Rejection};
use crate::robust::median;

/// Greatest relative difference of speeds on a plateau.
const PLATEAU_TOLERANCE: f64 = 0.01;
/// Greatest relative difference of speeds on a plateau that ripples, or that the speed overshoots before.
const RIPPLE_TOLERANCE: f64 = 0.05;
/// Least number of like commands that are a plateau.
const PLATEAU_COMMANDS: usize = 3;
/// Greatest relative excess of a peak in the place of a hardly sampled plateau with which its speed still counts as known.
const PEAK_TOLERANCE: f64 = 0.06;
/// Ratio to the robot's fastest strike from which a speed is in another unit.
const IMPLAUSIBLE: f64 = 10.0;

/// The plateau's speed and direction.
pub(crate) fn plateau(commands: &[Sample], rig: &Rig) -> Result<Command, Rejection> {
    let stamp = |command: Option<&Sample>| command.map_or(0, |command| command.stamp);
    let (start, end) = (stamp(commands.first()), stamp(commands.last()));
    if let Some(wrong) = commands.iter().find(|command| !is_finite(command)) {
        let Sample { x, y, .. } = *wrong;
        let detail = Detail::CommandNotFinite { x, y };
        return Err(Rejection::new(RejectReason::NotFinite, detail));
    }
    if end <= start {
        let detail = Detail::CommandsOfOneStamp {
            commands: commands.len(),
            stamp: start,
        };
        let reason = if commands.len() > 1 {
            RejectReason::ClockBackwards
        } else {
            RejectReason::NoPlateau
        };
        return Err(Rejection::new(reason, detail));
    }
    let speeds: Vec<f64> = commands.iter().map(speed).collect();
    let plateau = rippling(&speeds)
        .or_else(|| held(&speeds))
        .or_else(|| clipped(commands, &speeds))
        .ok_or_else(|| {
            let detail = Detail::NoPlateau {
                commands: speeds.len(),
                seconds: since(start, end),
                fastest: speeds.iter().copied().fold(0.0, f64::max),
                alike: PLATEAU_COMMANDS,
                within: PLATEAU_TOLERANCE,
            };
            Rejection::new(RejectReason::NoPlateau, detail)
        })?;
    let speed = median(speeds[plateau.clone()].iter().copied());
    if speed > IMPLAUSIBLE * rig.robot.speed.high {
        let fastest = rig.robot.speed.high;
        let detail = Detail::CommandsInMillimetres { speed, fastest };
        return Err(Rejection::new(RejectReason::UnitsImplausible, detail));
    }
    let (x, y) = commands[plateau]
        .iter()
        .fold((0.0, 0.0), |(x, y), c| (x + c.x, y + c.y));
    Ok(Command::new(speed, f64::atan2(y, x)))
}

/// What a measured tip did right before an object moved: the mean of its last velocities before.
pub(crate) fn at_contact(states: &[Sample], first_motion: i64) -> Result<Command, Rejection> {
    /// The impact lies within a frame before first motion, and the mean is taken over this time, in s, or over as many states.
    const TIME: f64 = 0.03;
    const STATES: usize = 3;
    let before = states.partition_point(|state| state.stamp <= first_motion);
    let from = states[..before].partition_point(|state| since(state.stamp, first_motion) > TIME);
    let near = &states[from.min(before.saturating_sub(STATES))..before];
    let finite: Vec<&Sample> = near.iter().filter(|state| is_finite(state)).collect();
    if finite.is_empty() {
        let detail = Detail::MovesBeforeArm;
        return Err(Rejection::new(RejectReason::ClockSkew, detail));
    }
    let (x, y) = finite
        .iter()
        .fold((0.0, 0.0), |(x, y), s| (x + s.x, y + s.y));
    Ok(Command::new(
        x.hypot(y) / finite.len() as f64,
        f64::atan2(y, x),
    ))
}

/// One or two commands at the top of a plateau that is short beside the time between commands (the paper's, 10 mm long, lasts
/// 10 ms at 1 m/s): the ramps on both sides, continued, pass above it, or a peak in its place would hardly be higher.
fn clipped(commands: &[Sample], speeds: &[f64]) -> Option<Range<usize>> {
    let top = speeds.iter().copied().fold(0.0, f64::max);
    let plateau = longest_run(speeds, |speed| alike(*speed, top));
    let (first, last) = (plateau.start, plateau.end - 1);
    if first < 2 || last + 2 >= speeds.len() {
        return None;
    }
    let time = |i: usize| since(commands[0].stamp, commands[i].stamp);
    // Slope of a ramp, and its height at the plateau's end.
    let ramp = |near: usize, far: usize, end: usize| {
        let slope = (speeds[near] - speeds[far]) / (time(near) - time(far));
        (slope, speeds[near] + slope * (time(end) - time(near)))
    };
    let (rise, before) = ramp(first - 1, first - 2, first);
    let (fall, after) = ramp(last + 1, last + 2, last);
    let (lower, upper) = (before.min(after), before.max(after));
    let above = (1.0 + PLATEAU_TOLERANCE) * top;
    let held = time(last) - time(first);
    let peak = (rise * (after - fall * held) - fall * before) / (rise - fall);
    let is_known = peak < (1.0 + PEAK_TOLERANCE) * top;
    let is_resolved = if plateau.len() > 1 {
        upper > above || is_known
    } else {
        lower > above || (upper > above && is_known)
    };
    (lower > (1.0 - PLATEAU_TOLERANCE) * top && is_resolved).then_some(plateau)
}

/// A plateau that ripples: the longest run within the wider tolerance of the highest held speed, without the ramps at its ends;
/// from its first crest to its last, so that the median is that of whole ripples. None where it hardly differs from a ramp's end.
fn rippling(speeds: &[f64]) -> Option<Range<usize>> {
    let top = highest_held(speeds);
    let near = |speed: f64| (speed - top).abs() <= RIPPLE_TOLERANCE * top;
    let mut run = longest_run(speeds, |speed| near(*speed));
    while run.len() > 1 && speeds[run.start] < speeds[run.start + 1] {
        run.start += 1;
    }
    while run.len() > 1 && speeds[run.end - 1] < speeds[run.end - 2] {
        run.end -= 1;
    }
    (run.len() >= PLATEAU_COMMANDS).then_some(run)
}

/// The longest plateau at the highest speed that is held for as many commands as a plateau has: no single spike counts.
fn held(speeds: &[f64]) -> Option<Range<usize>> {
    let top = highest_held(speeds);
    let plateau = longest_run(speeds, |speed| alike(*speed, top));
    (plateau.len() >= PLATEAU_COMMANDS).then_some(plateau)
}

/// The highest speed that is held for as many commands as a plateau has.
fn highest_held(speeds: &[f64]) -> f64 {
    speeds
        .windows(PLATEAU_COMMANDS)
        .map(|window| window.iter().copied().fold(f64::INFINITY, f64::min))
        .fold(0.0, f64::max)
}

fn alike(speed: f64, other: f64) -> bool {
    (speed - other).abs() <= PLATEAU_TOLERANCE * other
}

/// The longest run of values that satisfy a condition.
fn longest_run(values: &[f64], is_in: impl Fn(&f64) -> bool) -> Range<usize> {
    let (mut best, mut length) = (0..0, 0);
    for (index, value) in values.iter().enumerate() {
        length = if is_in(value) { length + 1 } else { 0 };
        if length > best.len() {
            best = index + 1 - length..index + 1;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    /// The plateau of commands at 100 Hz with these speeds at 0.5 rad, from the first to the last that is not zero.
    fn plateau(speeds: &[f64]) -> Result<Command, RejectReason> {
        let commands: Vec<Sample> = (0_i64..)
            .zip(speeds)
            .filter(|(_, speed)| **speed != 0.0)
            .map(|(i, speed)| {
                Sample::at(
                    1_000_000_000 + i * 10_000_000,
                    values::Point::new(speed * 0.5_f64.cos(), speed * 0.5_f64.sin()),
                )
            })
            .collect();
        super::plateau(&commands, &Rig::demo(Shape::Cylinder)).map_err(|rejection| rejection.reason)
    }

    #[test]
    fn the_plateau_is_what_is_commanded() {
        let command =
            plateau(&[0.0, 0.2, 0.5, 0.7, 0.7, 0.7, 0.7, 0.4, 0.1, 0.0]).expect("a plateau");
        assert!((command.speed - 0.7).abs() < 1e-12 && (command.angle - 0.5).abs() < 1e-12);
        let spiked = plateau(&[0.0, 0.5, 0.7, 0.7, 3.0, 0.7, 0.7, 0.7, 0.0]).expect("a plateau");
        assert!((spiked.speed - 0.7).abs() < 1e-12);
    }

    #[test]
    fn a_plateau_that_ripples_or_begins_with_an_overshoot_is_known_by_its_middle() {
        let ripple = |i: i32| 0.7 * (1.0 + 0.03 * (0.9 * f64::from(i)).sin());
        let ramps = [0.2, 0.5];
        let rippling: Vec<f64> = [0.0]
            .into_iter()
            .chain(ramps)
            .chain((0..40).map(ripple))
            .chain(ramps.into_iter().rev())
            .chain([0.0])
            .collect();
        let command = plateau(&rippling).expect("a plateau");
        assert!((command.speed - 0.7).abs() < 0.003, "{}", command.speed);
        let overshot = [
            0.0, 0.4, 0.73, 0.73, 0.73, 0.7, 0.7, 0.7, 0.7, 0.7, 0.3, 0.0,
        ];
        let command = plateau(&overshot).expect("a plateau");
        assert!((command.speed - 0.7).abs() < 1e-9, "{}", command.speed);
    }

    #[test]
    fn what_holds_no_plateau_is_rejected() {
        assert_eq!(
            plateau(&[0.0, 0.2, 0.5, 0.9, 0.5, 0.2, 0.0]),
            Err(RejectReason::NoPlateau)
        );
        assert_eq!(plateau(&[0.0, 0.7, 0.0]), Err(RejectReason::NoPlateau));
        assert_eq!(
            plateau(&[0.0, 0.7, f64::NAN, 0.7, 0.0]),
            Err(RejectReason::NotFinite)
        );
        assert_eq!(
            plateau(&[0.0, 700.0, 700.0, 700.0, 0.0]),
            Err(RejectReason::UnitsImplausible)
        );
    }

    #[test]
    fn a_plateau_of_one_or_two_commands_differs_from_a_peak_by_its_ramps() {
        for (top, down) in [
            (&[1.0][..], [0.97, 0.92, 0.0]),
            (&[1.0, 1.0], [0.95, 0.9, 0.0]),
        ] {
            let up = [0.0, 0.9, 0.95];
            let command = plateau(&[&up[..], top, &down].concat()).expect("a plateau");
            assert!((command.speed - 1.0).abs() < 1e-12);
        }
        assert_eq!(
            plateau(&[0.0, 0.6, 0.8, 1.0, 1.0, 0.8, 0.6, 0.0]),
            Err(RejectReason::NoPlateau)
        );
    }
}
