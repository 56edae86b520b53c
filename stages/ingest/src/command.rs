//! Strikes in the stream of commands: speed rises from rest, holds a plateau, and falls back.

use std::ops::Range;

use logs::Sample;
use values::{Command, RejectReason, Rig};

use crate::robust::median;
use crate::segment::seconds;

/// Below this part of the robot's slowest strike the arm is idle.
const IDLE: f64 = 0.05;
/// The arm is idle again when it was so this long, in ns: a single zero within a strike does not end it.
const IDLE_TIME: i64 = 100_000_000;
/// A strike also ends when no command comes for this long, in ns.
const SILENCE: i64 = 500_000_000;
/// No strike takes more commands than this: an arm that never stops is not striking.
const MOST_COMMANDS: usize = 200_000;
/// Speeds on a plateau differ by no more than this part.
const PLATEAU_TOLERANCE: f64 = 0.01;
/// Those of one that ripples, or that the speed overshoots before, by no more than this one.
const RIPPLE_TOLERANCE: f64 = 0.05;
/// So many commands the other way are a motion of their own, though none between was idle.
const REVERSED: usize = 3;
/// An arm that moves for fewer commands or a shorter time, in ns, has not struck: a blip.
const BLIP_COMMANDS: usize = 3;
const BLIP_TIME: i64 = 20_000_000;
/// This many commands that are alike are a plateau.
const PLATEAU_COMMANDS: usize = 3;
/// Of a plateau that is hardly sampled the speed is known if a peak in its place would be higher by no more than this part.
const PEAK_TOLERANCE: f64 = 0.06;
/// A speed this many times the robot's fastest strike is in another unit.
const IMPLAUSIBLE: f64 = 10.0;

/// Why a strike is not kept, and what was seen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rejection {
    pub(crate) reason: RejectReason,
    pub(crate) detail: String,
}

impl Rejection {
    pub(crate) fn new(reason: RejectReason, detail: impl Into<String>) -> Self {
        Self {
            reason,
            detail: detail.into(),
        }
    }
}

/// A rise and fall of the command.
#[derive(Clone, Debug)]
pub(crate) struct Episode {
    /// Its place among those of the log, from 0.
    pub(crate) index: u32,
    /// Commands from the first to the last that is not idle.
    pub(crate) commands: Vec<Sample>,
    /// What is wrong with it in any case.
    pub(crate) fault: Option<Rejection>,
}

impl Episode {
    /// Stamp at which the command left rest, in ns.
    pub(crate) fn start(&self) -> i64 {
        self.commands.first().map_or(0, |command| command.stamp)
    }

    /// Stamp of the last command before it rested again, in ns.
    pub(crate) fn end(&self) -> i64 {
        self.commands.last().map_or(0, |command| command.stamp)
    }

    /// The plateau's speed and direction.
    pub(crate) fn plateau(&self, rig: &Rig) -> Result<Command, Rejection> {
        if let Some(wrong) = self.commands.iter().find(|command| !is_finite(command)) {
            let detail = format!("a command is ({}, {}) m/s", wrong.x, wrong.y);
            return Err(Rejection::new(RejectReason::NotFinite, detail));
        }
        if self.end() <= self.start() {
            let detail = format!(
                "all {} commands have the stamp {} ns",
                self.commands.len(),
                self.start()
            );
            let reason = if self.commands.len() > 1 {
                RejectReason::ClockBackwards
            } else {
                RejectReason::NoPlateau
            };
            return Err(Rejection::new(reason, detail));
        }
        let speeds: Vec<f64> = self.commands.iter().map(speed).collect();
        let plateau = rippling(&speeds)
            .or_else(|| held(&speeds))
            .or_else(|| self.clipped(&speeds))
            .ok_or_else(|| {
                let detail = format!(
                    "of {} commands in {:.2} s up to {:.3} m/s, no {PLATEAU_COMMANDS} in a row are alike within {} %, and those at the top \
                     are not told from the ramps: hold the speed longer, or log the command more often",
                    speeds.len(),
                    seconds(self.end() - self.start()),
                    speeds.iter().copied().fold(0.0, f64::max),
                    100.0 * PLATEAU_TOLERANCE
                );
                Rejection::new(RejectReason::NoPlateau, detail)
            })?;
        let speed = median(speeds[plateau.clone()].iter().copied());
        if speed > IMPLAUSIBLE * rig.robot.speed.high {
            let detail = format!(
                "the commanded speed is {speed:.3}, the robot's fastest is {} m/s: are commands in mm/s?",
                rig.robot.speed.high
            );
            return Err(Rejection::new(RejectReason::UnitsImplausible, detail));
        }
        let (x, y) = self.commands[plateau]
            .iter()
            .fold((0.0, 0.0), |(x, y), c| (x + c.x, y + c.y));
        Ok(Command {
            speed,
            angle: f64::atan2(y, x),
        })
    }

    /// Whether it is too short to be a strike.
    pub(crate) fn is_blip(&self) -> bool {
        self.commands.len() < BLIP_COMMANDS || self.end() - self.start() < BLIP_TIME
    }

    /// Whether it goes where the arm may strike: going back, or sideways to the next start, it does not.
    pub(crate) fn is_towards_strikes(&self, rig: &Rig) -> bool {
        let commands = self.commands.iter().filter(|command| is_finite(command));
        let (x, y) = commands.fold((0.0, 0.0), |(x, y), c| (x + c.x, y + c.y));
        rig.robot.angle.contains(f64::atan2(y, x))
    }

    /// One or two commands at the top of a plateau that is short beside the time between commands (the paper's, 10 mm long, lasts
    /// 10 ms at 1 m/s): the ramps on both sides, continued, pass above it, or a peak in its place would hardly be higher.
    fn clipped(&self, speeds: &[f64]) -> Option<Range<usize>> {
        let top = speeds.iter().copied().fold(0.0, f64::max);
        let plateau = longest_run(speeds, |speed| alike(*speed, top));
        let (first, last) = (plateau.start, plateau.end - 1);
        if first < 2 || last + 2 >= speeds.len() {
            return None;
        }
        let time = |i: usize| seconds(self.commands[i].stamp - self.start());
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
        let is_told = if plateau.len() > 1 {
            upper > above || is_known
        } else {
            lower > above || (upper > above && is_known)
        };
        (lower > (1.0 - PLATEAU_TOLERANCE) * top && is_told).then_some(plateau)
    }
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

fn speed(command: &Sample) -> f64 {
    command.x.hypot(command.y)
}

fn is_finite(command: &Sample) -> bool {
    command.x.is_finite() && command.y.is_finite()
}

/// Cuts the stream of commands into episodes.
#[derive(Debug)]
pub(crate) struct Episodes {
    idle_below: f64,
    current: Option<Episode>,
    /// Sum of the current episode's commands: the direction that it goes in.
    towards: (f64, f64),
    /// Commands since the last active one that are idle or go the other way, which are part of the episode if it goes on.
    idle: Vec<Sample>,
    /// How many of them, the last ones, go the other way.
    against: usize,
    seen: u32,
}

impl Episodes {
    pub(crate) fn new(rig: &Rig) -> Self {
        Self {
            idle_below: IDLE * rig.robot.speed.low,
            current: None,
            towards: (0.0, 0.0),
            idle: Vec::new(),
            against: 0,
            seen: 0,
        }
    }

    /// Takes the next command; the episode that it ends, if it ends one.
    pub(crate) fn take(&mut self, command: Sample) -> Option<Episode> {
        // A command that is not a number is not known to be idle.
        let active = speed(&command) > self.idle_below || !is_finite(&command);
        let silent = self.current.as_ref().is_some_and(|episode| {
            let since = command.stamp.saturating_sub(episode.end());
            since > SILENCE || (!active && since > IDLE_TIME)
        });
        let mut ended = if silent { self.finish() } else { None };
        let opposes = active && command.x * self.towards.0 + command.y * self.towards.1 < 0.0;
        match &mut self.current {
            Some(_) if opposes && self.against + 1 == REVERSED => {
                let back = self.idle.split_off(self.idle.len() - self.against);
                ended = self.finish();
                for command in back.into_iter().chain([command]) {
                    self.add(command);
                }
            }
            Some(_) if active && !opposes => self.add(command),
            Some(_) => {
                self.against = if opposes { self.against + 1 } else { 0 };
                if self.idle.len() < MOST_COMMANDS {
                    self.idle.push(command);
                }
            }
            None if active => self.add(command),
            None => {}
        }
        ended
    }

    /// Adds a command to the current episode, with those that were set aside before it; begins one where there is none.
    fn add(&mut self, command: Sample) {
        if is_finite(&command) {
            self.towards.0 += command.x;
            self.towards.1 += command.y;
        }
        self.against = 0;
        let Some(episode) = &mut self.current else {
            self.current = Some(Episode {
                index: self.seen,
                commands: vec![command],
                fault: None,
            });
            self.seen += 1;
            return;
        };
        episode.commands.append(&mut self.idle);
        if episode.commands.len() < MOST_COMMANDS {
            episode.commands.push(command);
        } else if let Some(last) = episode.commands.last_mut() {
            *last = command;
            episode.fault.get_or_insert_with(|| {
                let detail = format!(
                    "the command does not fall back to rest within {MOST_COMMANDS} messages"
                );
                Rejection::new(RejectReason::NoPlateau, detail)
            });
        }
    }

    /// The episode that has not ended.
    pub(crate) fn current(&mut self) -> Option<&mut Episode> {
        self.current.as_mut()
    }

    /// Ends the episode that has not ended.
    pub(crate) fn finish(&mut self) -> Option<Episode> {
        self.idle.clear();
        self.against = 0;
        self.towards = (0.0, 0.0);
        self.current.take()
    }
}

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;

    /// Commands at 100 Hz with these speeds at 0.5 rad.
    fn episodes(speeds: &[f64]) -> Vec<Episode> {
        let mut episodes = Episodes::new(&Rig::demo(Shape::Cylinder));
        let mut ended = Vec::new();
        for (i, speed) in (0_i64..).zip(speeds) {
            let (x, y) = (speed * 0.5_f64.cos(), speed * 0.5_f64.sin());
            ended.extend(episodes.take(Sample {
                stamp: 1_000_000_000 + i * 10_000_000,
                x,
                y,
            }));
        }
        ended.extend(episodes.finish());
        ended
    }

    fn plateau(speeds: &[f64]) -> Result<Command, RejectReason> {
        let mut episodes = episodes(speeds);
        assert_eq!(episodes.len(), 1);
        episodes
            .remove(0)
            .plateau(&Rig::demo(Shape::Cylinder))
            .map_err(|rejection| rejection.reason)
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
    fn a_plateau_of_one_or_two_commands_is_told_from_a_peak_by_its_ramps() {
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

    #[test]
    fn rises_and_falls_are_counted_and_single_zeros_do_not_part_them() {
        let strike = [0.7, 0.7, 0.0, 0.7, 0.7];
        let rest = [0.0; 30];
        let seen = episodes(&[&rest[..], &strike, &rest, &strike, &rest].concat());
        assert_eq!(
            seen.iter().map(|episode| episode.index).collect::<Vec<_>>(),
            [0, 1]
        );
        assert!(seen.iter().all(|episode| episode.commands.len() == 5));
    }

    #[test]
    fn an_arm_that_creeps_below_its_slowest_strike_is_idle() {
        assert!(episodes(&[0.0, 0.01, 0.015, 0.01, 0.0]).is_empty());
    }
}
