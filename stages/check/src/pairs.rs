//! Which command began which motion, and whether both clocks agree on it.

use ingest::{CommandSeen, Meeting, MotionSeen, Seen};
use values::{Command, Point};

use crate::statistics::{line, median, middle, wrapped};

/// Least number of strikes that say something of a whole log.
pub const FEWEST: usize = 6;
/// A motion begins between these times in s, after its command's rise and after its fall.
const FROM_RISE: f64 = -0.05;
const AFTER_FALL: f64 = 0.5;
/// Time, in s, after a command's fall from which the motion's beginning is told.
const LATE: f64 = 0.1;
/// Least launch speed by an impact that counts, as a part of the tip's speed.
pub const WEAKEST: f64 = 0.08;
/// Time, in s, over which clocks are compared; and number of strikes up to which they are compared over any time, where nothing follows a command
/// within it.
const FARTHEST: f64 = 60.0;
const STRIKES_OF_ANY_TIME: usize = 200;
/// Difference of a heading (rad) from the others of the log that is no strike: a box's gain and an arm's scatter together take it half as far.
const ASTRAY: f64 = 0.7;
/// Greatest variation of delays from command to motion over a log, in s.
const WINDOW: f64 = 0.6;

/// A command and the motion that it began.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub command: CommandSeen,
    pub motion: MotionSeen,
    /// Time, in s, from the command's rise to the motion, by the clocks as they are.
    pub lag: f64,
}

impl Pair {
    /// A strike as the tip's touch tells it, with a value that it tells in the place of the lag.
    pub(crate) fn of_touch(met: &Meeting, value: f64) -> Self {
        let Command { speed, angle } = met.command;
        Self {
            command: CommandSeen {
                rise: met.at,
                fall: met.at,
                speed,
                angle,
            },
            motion: MotionSeen {
                start: met.at,
                from: met.object,
                velocity: Point::polar(speed, angle),
                at_first: speed,
            },
            lag: value,
        }
    }

    /// Departure heading, in rad.
    pub fn heading(&self) -> f64 {
        self.motion.velocity.bearing()
    }

    /// Whether the object moves when a tip that is commanded so may touch, by the clocks as they are.
    pub fn is_timely(&self) -> bool {
        let lasts = self.command.fall - self.command.rise;
        (FROM_RISE..=lasts + AFTER_FALL).contains(&self.lag)
    }

    /// Ratio of launch speed to commanded speed.
    pub fn speed_ratio(&self) -> f64 {
        self.motion.velocity.norm() / self.command.speed
    }
}

#[cfg(test)]
impl Pair {
    /// For tests, the strike of this number in a row of strikes every 6 s, commanded so (m/s, rad), whose object leaves `lag` s later with this
    /// velocity.
    pub(crate) fn made(
        number: usize,
        [speed, angle]: [f64; 2],
        velocity: values::Point,
        lag: f64,
    ) -> Self {
        let rise = 6.0 * number as f64;
        Self {
            command: CommandSeen {
                rise,
                fall: rise + 0.4,
                speed,
                angle,
            },
            motion: MotionSeen {
                start: rise + lag,
                from: values::Point::new(0.3, 0.0),
                velocity,
                at_first: velocity.norm(),
            },
            lag,
        }
    }
}

/// The pairs of a log.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    pub pairs: Vec<Pair>,
    /// Seconds by which the camera's stamps lie behind the arm's, where no strike would take so long, and how far that may be off.
    pub delay: Option<f64>,
    pub uncertainty: f64,
    /// Whether the strikes are found by that delay alone.
    pub is_shifted: bool,
    /// Whether they are found by another rate of the camera's clock alone.
    pub is_rated: bool,
}

/// Spread of headings (rad), and its ratio to that at another delay, above which objects were not struck then.
const DISORDER: f64 = 0.17;
const ORDER: f64 = 3.0;
/// Spread in s of the times from command to touch, below which they are a tip's; a hand's spread by more.
const PROMPT: f64 = 0.05;

/// Pairs by the clocks as they are; where at least twice as many come at another delay, or about as many, and in good order where these are in
/// none (a hand moves objects too), by that one.
///
/// Commands of less than `slowest` (m/s) move an arm from place to place, where they are slower by far than all others; else the rig file states
/// another arm's speeds.
pub fn pairs(seen: &Seen, slowest: f64) -> Pairs {
    /// Least ratio of the slowest strike's speed to the fastest command that is none.
    const FASTER: f64 = 1.5;
    let is_fast = |command: &&CommandSeen| command.speed >= slowest;
    let (fast, slow): (Vec<&CommandSeen>, Vec<_>) = seen.commands.iter().partition(is_fast);
    let least = fast.iter().map(|c| c.speed).fold(f64::INFINITY, f64::min);
    let is_apart = slow.iter().all(|c| FASTER * c.speed < least);
    let seen = match fast.len() >= FEWEST && is_apart {
        true => &Seen {
            commands: fast.into_iter().copied().collect(),
            ..seen.clone()
        },
        false => seen,
    };
    let plain = matched(seen, 0.0, |command| {
        (command.rise + FROM_RISE, command.fall + AFTER_FALL)
    });
    let least = seen
        .commands
        .len()
        .min(seen.motions.len())
        .div_ceil(2)
        .max(FEWEST);
    let shifted_within = |farthest: f64| {
        let shift = best_shift(seen, farthest)?;
        let shifted = matched(seen, shift, |c| {
            (c.rise - 0.5 * WINDOW, c.rise + 0.5 * WINDOW)
        });
        let (disorder, order) = (disorder(&plain), disorder(&shifted));
        // Motions that follow as tips that gather speed touch are those of the commands' own time, whatever the commands say.
        let is_in_order = disorder > DISORDER && disorder > ORDER * order && !is_prompt(&plain);
        let is_more = shifted.len() > 2 * plain.len();
        let is_better = is_more || 10 * shifted.len() >= 9 * plain.len() && is_in_order;
        (shifted.len() >= least && is_better).then_some(shifted)
    };
    // Clocks of two epochs, or an hour apart.
    let of_any_time = || {
        let few = plain.len() < least;
        few.then(|| shifted_within(f64::INFINITY)).flatten()
    };
    let shifted = shifted_within(FARTHEST).or_else(of_any_time);
    if let Some(pairs) = at_another_rate(seen, shifted.as_ref().unwrap_or(&plain)) {
        return Pairs {
            pairs,
            is_rated: true,
            ..Pairs::default()
        };
    }
    let is_shifted = shifted.is_some();
    let mut pairs = shifted.unwrap_or(plain);
    pairs.extend(at_another_time(seen, &pairs));
    pairs.sort_by(|a, b| a.command.rise.total_cmp(&b.command.rise));
    let lag = median(pairs.iter().map(|pair| pair.lag)).unwrap_or(0.0);
    let lasts = median(pairs.iter().map(|p| p.command.fall - p.command.rise)).unwrap_or(0.0);
    let round = |seconds: f64| (seconds * 100.0).round() / 100.0;
    let (delay, uncertainty) = (lag - 0.5 * lasts, 0.5 * lasts);
    // A tip strikes while it is commanded to move; a camera and a recorder take some time.
    let is_late = pairs.len() >= FEWEST && delay > uncertainty + LATE;
    Pairs {
        pairs,
        delay: (is_shifted || is_late).then_some(round(delay)),
        uncertainty: round(uncertainty),
        is_shifted,
        is_rated: false,
    }
}

/// Of each pair, whether its object leaves quite elsewhere than most.
pub(crate) fn are_astray(pairs: &[Pair]) -> Vec<bool> {
    let turns: Vec<f64> = pairs
        .iter()
        .map(|pair| wrapped(pair.heading() - pair.command.angle))
        .collect();
    let usual = middle(&turns).map_or(0.0, |(usual, _)| usual);
    let is_astray = |turn: &f64| wrapped(turn - usual).abs() > ASTRAY;
    turns.iter().map(is_astray).collect()
}

/// Pairs by another rate of the camera's clock, where many more objects then leave in good order, and as promptly as tips strike; `known` are those
/// by the rate as it is.
fn at_another_rate(seen: &Seen, known: &[Pair]) -> Option<Vec<Pair>> {
    /// Greatest difference of the rates, the time in s whose commands tell it, and by how much (s) a step of it shifts the last of them.
    const MOST: f64 = 0.04;
    const TELLS: f64 = 300.0;
    const STEP: f64 = 0.3;
    let in_order = |pairs: &[Pair]| {
        let astray = are_astray(pairs);
        astray.iter().filter(|is_astray| !**is_astray).count()
    };
    let commands = seen.commands.len();
    let enough = in_order(known) + FEWEST.max(commands / 10);
    if enough > commands {
        return None;
    }
    let start = seen.commands[0].rise;
    // As a camera whose clock is faster by this share would have stamped them.
    let rated = |rate: f64, count: usize| {
        let mut rated = seen.clone();
        rated.commands.truncate(count);
        for motion in &mut rated.motions {
            motion.start = start + (motion.start - start) / (1.0 + rate);
        }
        rated
    };
    let within = |seen: &Seen| {
        let shift = best_shift(seen, FARTHEST)?;
        Some(matched(seen, shift, |c| {
            (c.rise - 0.5 * WINDOW, c.rise + 0.5 * WINDOW)
        }))
    };
    let count = seen.commands.partition_point(|c| c.rise < start + TELLS);
    let span = seen.commands[count - 1].rise - start;
    if span <= 0.0 {
        return None;
    }
    let steps = (MOST * span / STEP).ceil() as i32;
    let tried = (-steps..=steps).filter_map(|step| {
        let rate = f64::from(step) * STEP / span;
        let pairs = within(&rated(rate, count))?;
        Some((in_order(&pairs), rate, pairs))
    });
    let (_, rate, pairs) = tried.max_by_key(|tried| tried.0)?;
    // What these leave of it is their own line's.
    let points: Vec<(f64, f64)> = pairs
        .iter()
        .map(|p| (p.command.rise - start, p.lag))
        .collect();
    let rate = rate + line(&points)?.slope;
    let rated = rated(rate, commands);
    let mut pairs = within(&rated)?;
    if in_order(&pairs) < enough || !is_prompt(&pairs) {
        return None;
    }
    for pair in &mut pairs {
        let place = rated
            .motions
            .partition_point(|m| m.start < pair.motion.start);
        pair.motion = seen.motions[place];
        pair.lag = pair.motion.start - pair.command.rise;
    }
    Some(pairs)
}

/// Pairs among the commands and motions that have none yet, where most of these follow at one delay of their own: a clock was set while the log ran.
fn at_another_time(seen: &Seen, pairs: &[Pair]) -> Vec<Pair> {
    let is_left = |own: fn(&Pair) -> f64, time: f64| pairs.iter().all(|pair| own(pair) != time);
    let commands = seen.commands.iter();
    let motions = seen.motions.iter();
    let left = Seen {
        commands: commands
            .filter(|c| is_left(|p| p.command.rise, c.rise))
            .copied()
            .collect(),
        motions: motions
            .filter(|m| is_left(|p| p.motion.start, m.start))
            .copied()
            .collect(),
        ..Seen::default()
    };
    let shift = match left.commands.len() >= FEWEST {
        true => best_shift(&left, FARTHEST),
        false => None,
    };
    let found = shift.map(|shift| {
        matched(&left, shift, |c| {
            (c.rise - 0.5 * WINDOW, c.rise + 0.5 * WINDOW)
        })
    });
    let is_struck = |found: &Vec<Pair>| {
        found.len() >= FEWEST
            && 4 * found.len() >= 3 * left.commands.len()
            && disorder(found) < DISORDER
    };
    found.filter(is_struck).unwrap_or_default()
}

/// Whether these motions are strikes, by their speeds: the times from command to motion are those of one arm, and hardly spread beside what goes with
/// the speed that it reaches.
fn is_prompt(pairs: &[Pair]) -> bool {
    let points = pairs
        .iter()
        .map(|pair| (pair.motion.velocity.norm(), pair.lag));
    let points: Vec<(f64, f64)> = points.collect();
    let Some(line) = line(&points) else {
        return false;
    };
    let left = points
        .iter()
        .map(|p| (p.1 - line.at_zero - line.slope * p.0).abs());
    let is_struck = median(pairs.iter().map(Pair::speed_ratio)).is_some_and(|r| r > WEAKEST);
    is_struck && median(left).is_some_and(|spread| spread < PROMPT)
}

/// Commands with the first motion in the time that each allows, `shift` later; a motion belongs to one command.
fn matched(seen: &Seen, shift: f64, time: impl Fn(&CommandSeen) -> (f64, f64)) -> Vec<Pair> {
    let mut from = 0;
    let mut pairs = Vec::new();
    for command in &seen.commands {
        let (first, last) = time(command);
        let place = seen
            .motions
            .partition_point(|m| m.start < first + shift)
            .max(from);
        if let Some(motion) = seen.motions.get(place).filter(|m| m.start <= last + shift) {
            from = place + 1;
            pairs.push(Pair {
                command: *command,
                motion: *motion,
                lag: motion.start - command.rise,
            });
        }
    }
    pairs
}

/// Spread of departure headings about the commanded ones, or about those mirrored, in rad.
fn disorder(pairs: &[Pair]) -> f64 {
    let spread = |sign: f64| {
        let turns = pairs
            .iter()
            .map(|pair| wrapped(pair.heading() - sign * pair.command.angle));
        middle(&turns.collect::<Vec<f64>>()).map_or(f64::INFINITY, |(_, spread)| spread)
    };
    spread(1.0).min(spread(-1.0))
}

/// The delay at which most motions follow their commands. Strikes that come as regularly as a clock fit at several: then the one at which
/// objects leave as commanded, else the smallest.
fn best_shift(seen: &Seen, farthest: f64) -> Option<f64> {
    let most = if farthest.is_finite() {
        usize::MAX
    } else {
        STRIKES_OF_ANY_TIME
    };
    let mut lags: Vec<f64> = Vec::new();
    for command in seen.commands.iter().take(most) {
        let first = seen
            .motions
            .partition_point(|m| m.start < command.rise - farthest);
        let after = seen.motions[first..].iter().take(most);
        let near = after.map(|m| m.start - command.rise);
        lags.extend(near.take_while(|lag| *lag <= farthest));
    }
    lags.sort_by(f64::total_cmp);
    let count = |from: usize| lags.partition_point(|lag| *lag <= lags[from] + WINDOW) - from;
    let counts: Vec<usize> = (0..lags.len()).map(count).collect();
    let most = *counts.iter().max()?;
    let mut candidates: Vec<f64> = Vec::new();
    for (from, count) in counts.iter().enumerate() {
        if 10 * count >= 9 * most {
            let within = &lags[from..from + count];
            let shift = within[within.len() / 2];
            if candidates.last().is_none_or(|last| shift - last > WINDOW) {
                candidates.push(shift);
            }
        }
    }
    // Alike to a degree, they are equally good.
    let rank = |shift: f64| {
        let pairs = matched(seen, shift, |c| {
            (c.rise - 0.5 * WINDOW, c.rise + 0.5 * WINDOW)
        });
        ((disorder(&pairs) / 0.02).round(), shift.abs())
    };
    candidates.into_iter().min_by(|a, b| {
        let (a, b) = (rank(*a), rank(*b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forty strikes as regular as a clock, each struck by the command so many places before its own; from this one on the camera's stamps are late
    /// by so many s.
    fn seen(before: usize, from: usize, late: f64) -> Seen {
        let angle = |i: usize| -0.7 + 1.4 * (0.618 * i as f64).fract();
        let made = (0..40).map(|i| {
            let lag = 0.2 + 0.01 * (5.1 * i as f64).sin();
            let leaves = Point::polar(0.8, angle(i + before));
            Pair::made(
                i,
                [0.6, angle(i)],
                leaves,
                lag + if i < from { 0.0 } else { late },
            )
        });
        let made: Vec<Pair> = made.collect();
        Seen {
            commands: made.iter().map(|pair| pair.command).collect(),
            motions: made.iter().map(|pair| pair.motion).collect(),
            ..Seen::default()
        }
    }

    #[test]
    fn another_strikes_commands_are_no_other_time() {
        for before in [0, 1] {
            let found = pairs(&seen(before, 40, 0.0), 0.1);
            assert_eq!((found.delay, found.pairs.len()), (None, 40), "{before}");
        }
        let found = pairs(&seen(0, 0, 2.0), 0.1);
        assert!(found.is_shifted && found.pairs.len() >= 39, "{found:?}");
    }

    #[test]
    fn a_camera_whose_clock_is_fast_or_slow_is_one() {
        for rate in [-0.02, 0.01, 0.03] {
            let mut seen = seen(0, 40, 0.0);
            let start = seen.motions[0].start;
            let mut motions = Vec::new();
            for (i, motion) in seen.motions.iter().enumerate() {
                // A hand puts each back, at no regular time.
                let part = (0.414 * i as f64).fract();
                let back = MotionSeen {
                    start: motion.start + 2.0 + 2.0 * part,
                    velocity: Point::polar(0.1 + 0.2 * part, 2.0 + 2.0 * part),
                    ..*motion
                };
                let struck = MotionSeen {
                    velocity: motion.velocity * (0.9 + 0.2 * part),
                    ..*motion
                };
                motions.extend([struck, back]);
            }
            for motion in &mut motions {
                motion.start = start + (motion.start - start) * (1.0 + rate);
            }
            seen.motions = motions;
            let found = pairs(&seen, 0.1);
            assert!(
                found.is_rated && found.pairs.len() >= 39,
                "{rate}: {found:?}"
            );
            let (first, last) = (found.pairs[0], found.pairs[found.pairs.len() - 1]);
            let told = (last.lag - first.lag) / (last.command.rise - first.command.rise);
            assert!((told - rate).abs() < 1e-3, "{rate}: {told}");
        }
    }

    #[test]
    fn a_clock_that_was_set_is_one_from_then_on() {
        for from in [12, 30] {
            let found = pairs(&seen(0, from, 2.0), 0.1);
            let timely = found.pairs.iter().filter(|pair| pair.is_timely()).count();
            assert_eq!((found.pairs.len(), timely), (40, from), "{found:?}");
        }
    }
}
