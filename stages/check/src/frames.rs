//! Departure headings beside commanded angles: turns, reflections, a frame that turns with the arm, commands of something else.
//!
//! An object leaves a tip in a direction β that grows with the commanded angle α: β = gα, with a gain g that is 1 for a round object
//! and may be 0.6 for a box. A camera that is mirrored gives g < 0; a base that is turned adds a constant; a command in the tool's
//! frame has one α for every β; commands of another log have nothing to do with β.

use std::f64::consts::{FRAC_PI_2, PI};

use ingest::Meeting;
use values::{Command, Point};

use crate::finding::{Finding, LogRead, TURNED};
use crate::pairs::Pair;
use crate::statistics::{Line, at_most, line, median, middle, wrapped};

/// Least number of pairs of one log, and of all logs, that say anything.
const FEWEST_OF_ONE: usize = 10;
const FEWEST: usize = 6;
/// Spread of commanded angles below which they are one, in rad (standard deviation).
const ONE_ANGLE: f64 = 0.02;
/// Difference of two turns, in rad, up to which they are one, and spread of the turns of one frame.
const ONE_TURN: f64 = 0.1;
/// Spread of commanded angles, in rad, above which they tell a gain.
const MANY_ANGLES: f64 = 0.04;
/// Spread of departure headings, in rad, at one commanded angle from which they follow something else: arms and round objects scatter by 0.06, boxes
/// that are hit off their middle by 0.1.
const MANY_HEADINGS: f64 = 0.17;
/// Relative spread of commanded speeds below which they are one (standard deviation); and spread of launch speeds at one commanded speed from which
/// they follow something else: an arm's speed scatters by 0.05.
const ONE_SPEED: f64 = 0.02;
const MANY_SPEEDS: f64 = 0.25;
/// Spread of headings about any line, in rad, above which they follow none, and the number of strikes that show it.
const DISORDER: f64 = 0.35;
const FEWEST_IN_DISORDER: usize = 12;
/// Turn, in rad, from which it is told.
const PERHAPS_TURNED: f64 = 0.1;
/// Gains of an object's heading over the commanded angle.
const GAINS: (f64, f64) = (0.5, 1.5);
/// Difference, in rad, within which a turn counts as two axes exchanged, or one reversed.
const NEAR: f64 = 0.3;
/// Standard errors from which a finding is sure.
const SURE: f64 = 4.0;
/// Spread of angles, in rad, above which they tell whether there is a gain at all; a gain below this value is none, where it is below the least by so
/// many standard errors.
const TELLS_GAIN: f64 = 0.1;
const LEAST_GAIN: f64 = 0.3;
const UNSURE: f64 = 2.5;
const FOLLOWS_CLOSELY: f64 = 0.7;
/// Correlation of speeds surely below which they are not related; and the number of strikes and the relative variations that tell it.
const RELATED: f64 = 0.4;
const FEWEST_SPEEDS: usize = 12;
const SPEEDS_VARY: f64 = 0.1;
const LAUNCHES_VARY: f64 = 0.15;

/// Median of departure heading less commanded angle, in rad; none of too few pairs.
pub fn turn(pairs: &[Pair]) -> Option<f64> {
    middle(&turns(pairs, 1.0)).map(|(turn, _)| turn)
}

fn turns(pairs: &[Pair], sign: f64) -> Vec<f64> {
    let turn = |pair: &Pair| wrapped(pair.heading() - sign * pair.command.angle);
    pairs.iter().map(turn).collect()
}

/// What is wrong with the frames of these pairs: of one log, or of all. Commands that are not logged (`is_logged`), for which the arm's measured
/// motion stands, are in no other form.
pub fn findings(pairs: &[Pair], log: Option<&str>, is_logged: bool) -> Vec<Finding> {
    let fewest = if log.is_some() { FEWEST_OF_ONE } else { FEWEST };
    // Slower than any strike, a motion is not the command's.
    let pairs: Vec<Pair> = pairs
        .iter()
        .filter(|pair| pair.motion.velocity.norm() > 0.02 && pair.motion.velocity.is_finite())
        .copied()
        .collect();
    if pairs.len() < fewest {
        return Vec::new();
    }
    let strikes = pairs.len();
    let log = || log.map(str::to_owned);
    let angles: Vec<f64> = pairs.iter().map(|pair| pair.command.angle).collect();
    let Some((centre, _)) = middle(&angles) else {
        return Vec::new();
    };
    let about: Vec<f64> = angles.iter().map(|angle| wrapped(angle - centre)).collect();
    let spread = (about.iter().map(|a| a * a).sum::<f64>() / strikes as f64).sqrt();
    let headings: Vec<f64> = pairs.iter().map(Pair::heading).collect();
    let Some((heading, heading_spread)) = middle(&headings) else {
        return Vec::new();
    };
    if is_logged && spread < ONE_ANGLE && heading_spread > MANY_HEADINGS {
        return vec![Finding::ConstantHeading {
            log: log(),
            strikes,
            angle: centre,
            spread: heading_spread,
        }];
    }
    let of_record = || constant_speed(&pairs, log()).or_else(|| speed_and_angle(&pairs, log()));
    if let Some(found) = is_logged.then(of_record).flatten() {
        return vec![found];
    }
    let points: Vec<(f64, f64)> = about
        .iter()
        .zip(&headings)
        .map(|(about, one)| (*about, wrapped(one - heading)))
        .collect();
    let line = line(&points).filter(|_| spread > MANY_ANGLES);
    if let Some(line) = line {
        let beside: Vec<f64> = points
            .iter()
            .map(|(about, heading)| heading - line.at_zero - line.slope * about)
            .collect();
        let is_disorder = middle(&beside).is_some_and(|(_, spread)| spread > DISORDER);
        if is_disorder && strikes >= FEWEST_IN_DISORDER {
            return vec![unrelated(log(), strikes, line)];
        }
    }
    let speed = unrelated_speeds(&pairs);
    let beside = turn(&pairs).unwrap_or_default();
    let Some(line) = line else {
        if let Some(line) = speed {
            return vec![unrelated(log(), strikes, line)];
        }
        // With one angle a mirror is a turn.
        return turned(&log, strikes, heading, centre, beside, None)
            .into_iter()
            .collect();
    };
    if line.slope + SURE * line.slope_error < 0.0 {
        return vec![reflected(&pairs, line, log())];
    }
    // A box that leaves a slippery tip across its face follows little of the angle, and closely.
    let is_told =
        spread > TELLS_GAIN && line.slope < LEAST_GAIN && line.correlation < FOLLOWS_CLOSELY;
    if is_told && line.slope + UNSURE * line.slope_error < GAINS.0 {
        return vec![unrelated(log(), strikes, line)];
    }
    if let Some(line) = speed {
        return vec![unrelated(log(), strikes, line)];
    }
    if line.slope - SURE * line.slope_error <= 0.0 {
        return Vec::new();
    }
    turned(&log, strikes, heading, centre, beside, Some(line))
        .into_iter()
        .collect()
}

/// Whether headings follow a field of the command as it is, and much more closely than the direction of both fields together.
fn speed_and_angle(pairs: &[Pair], log: Option<String>) -> Option<Finding> {
    /// Least number of strikes that tell, and the greatest part of the spread that a line may leave.
    const FEWEST: usize = 12;
    const CLOSER: f64 = 0.4;
    /// Difference from the direction of both fields, in rad, below which headings follow it: at one speed a field alone does nearly the same.
    const LEAVES: f64 = 0.02;
    /// Variation, in rad, below which a field tells nothing.
    const VARIES: f64 = 0.1;
    if pairs.len() < FEWEST {
        return None;
    }
    let spread_of = |of: &dyn Fn(&Pair) -> f64| {
        let points: Vec<(f64, f64)> = pairs.iter().map(|p| (of(p), p.heading())).collect();
        let line = line(&points)?;
        let left = |p: &(f64, f64)| wrapped(p.1 - line.at_zero - line.slope * p.0);
        let (_, spread) = middle(&points.iter().map(left).collect::<Vec<f64>>())?;
        Some((spread, line))
    };
    let (spread_as_stated, _) = spread_of(&|pair| pair.command.angle)?;
    if spread_as_stated < LEAVES {
        return None;
    }
    let fields = |pair: &Pair| {
        let (sine, cosine) = pair.command.angle.sin_cos();
        [pair.command.speed * cosine, pair.command.speed * sine]
    };
    for (exchanged, speed, angle) in [(false, 0, 1), (true, 1, 0)] {
        let are_speeds = pairs.iter().all(|pair| fields(pair)[speed] > 0.0);
        let follows = spread_of(&|pair| fields(pair)[angle]);
        let Some((spread, line)) = follows.filter(|_| are_speeds) else {
            continue;
        };
        let angles: Vec<f64> = pairs.iter().map(|pair| fields(pair)[angle]).collect();
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        let varies = angles.iter().map(|a| (a - mean).powi(2)).sum::<f64>() / angles.len() as f64;
        for (degrees, unit) in [(false, 1.0), (true, 1f64.to_radians())] {
            let gain = line.slope / unit;
            let is_gain = (GAINS.0..=GAINS.1).contains(&gain) && varies.sqrt() * unit > VARIES;
            if is_gain && spread < CLOSER * spread_as_stated {
                return Some(Finding::SpeedAndAngle {
                    log,
                    strikes: pairs.len(),
                    degrees,
                    exchanged,
                    spread,
                    spread_as_stated,
                });
            }
        }
    }
    None
}

fn unrelated(log: Option<String>, strikes: usize, line: Line) -> Finding {
    Finding::Unrelated {
        log,
        strikes,
        correlation: line.correlation,
    }
}

/// The finding that objects leave at many speeds where one is commanded.
fn constant_speed(pairs: &[Pair], log: Option<String>) -> Option<Finding> {
    if pairs.len() < FEWEST_SPEEDS {
        return None;
    }
    let spread = |of: &dyn Fn(&Pair) -> f64| {
        let values: Vec<f64> = pairs.iter().map(|pair| of(pair).ln()).collect();
        let middle = median(values.iter().copied())?;
        let spread = median(values.iter().map(|value| (value - middle).abs()))?;
        Some((middle.exp(), 1.4826 * spread))
    };
    let (_, spread_of_launches) = spread(&|pair| pair.motion.velocity.norm())?;
    let (speed, _) = spread(&|pair| pair.command.speed)?;
    let is_one = |pair: &Pair| (pair.command.speed / speed - 1.0).abs() < ONE_SPEED;
    (pairs.iter().all(is_one) && spread_of_launches > MANY_SPEEDS).then_some(
        Finding::ConstantSpeed {
            log,
            strikes: pairs.len(),
            speed,
            spread: spread_of_launches,
        },
    )
}

/// By how much the arm's measured velocity is turned against its commands, in rad, where that is more than any arm errs by.
pub fn beside_commands(logs: &[LogRead<'_>]) -> Option<f64> {
    let met = logs.iter().flat_map(|log| &log.seen.meetings);
    let turn = |m: &Meeting| wrapped(m.velocity.bearing() - m.command.angle);
    let turns: Vec<f64> = met.filter(|m| m.velocity.norm() > 0.0).map(turn).collect();
    let (by, spread) = middle(&turns)?;
    (turns.len() >= FEWEST_OF_ONE && spread < ONE_TURN && by.abs() > TURNED).then_some(by)
}

/// The arm's measured velocity where it points beside its commands, by no one turn, and objects leave as they say: a state that is mirrored, or another
/// strike's.
pub(crate) fn state_beside(logs: &[LogRead<'_>], pairs: &[Pair]) -> Option<Finding> {
    /// Angle, in rad, in the middle, from which it is told, and how much of it objects may leave beside the commands.
    const BESIDE: f64 = 0.15;
    const SHOWN: f64 = 0.5;
    let logged = logs.iter().filter(|log| !log.seen.is_by_state);
    let met = logged.flat_map(|log| &log.seen.meetings);
    let met = met.filter(|m| m.velocity.norm() > 0.0);
    let state = met.map(|m| wrapped(m.velocity.bearing() - m.command.angle).abs());
    let state: Vec<f64> = state.collect();
    let strikes = state.len();
    let beside = median(state)?;
    let left = median(turns(pairs, 1.0).into_iter().map(f64::abs))?;
    (strikes >= FEWEST_OF_ONE && beside > BESIDE && left < SHOWN * beside)
        .then_some(Finding::StateBeside { beside, strikes })
}

/// Whether the arm's measured motion and the objects are turned alike, in rad.
pub fn is_one_turn(moved: f64, left: f64) -> bool {
    wrapped(moved - left).abs() < ONE_TURN
}

/// Commands of one angle, where the arm's measured motion (velocities of the tip, each with its command) goes in many directions. Boxes leave where
/// their sides point, and do not show it.
pub fn constant_heading(met: &[(Command, Point)], log: &str) -> Option<Finding> {
    let angles: Vec<f64> = met.iter().map(|(command, _)| command.angle).collect();
    let ways: Vec<f64> = met.iter().map(|(_, velocity)| velocity.bearing()).collect();
    let ((angle, spread), (_, spread_of_ways)) = (middle(&angles)?, middle(&ways)?);
    let is_one = met.len() >= FEWEST_OF_ONE && spread < ONE_ANGLE;
    (is_one && spread_of_ways > MANY_HEADINGS).then(|| Finding::ConstantHeading {
        log: Some(log.into()),
        strikes: met.len(),
        angle,
        spread: spread_of_ways,
    })
}

/// The launch speed over the commanded one, where both vary and are surely not related. An arm that delivers one speed whatever is
/// commanded launches at one speed.
fn unrelated_speeds(pairs: &[Pair]) -> Option<Line> {
    let varies = |values: &[f64], part: f64| {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n;
        variance.sqrt() > part * mean
    };
    let (speeds, launches): (Vec<f64>, Vec<f64>) = pairs
        .iter()
        .map(|pair| (pair.command.speed, pair.motion.velocity.norm()))
        .unzip();
    if pairs.len() < FEWEST_SPEEDS
        || !varies(&speeds, SPEEDS_VARY)
        || !varies(&launches, LAUNCHES_VARY)
    {
        return None;
    }
    let points: Vec<(f64, f64)> = speeds.into_iter().zip(launches).collect();
    line(&points).filter(|line| at_most(line.correlation, points.len(), UNSURE) < RELATED)
}

fn reflected(pairs: &[Pair], line: Line, log: Option<String>) -> Finding {
    let strikes = pairs.len();
    let by = middle(&turns(pairs, -1.0)).map_or(0.0, |(turn, _)| turn);
    let (slope, error) = (line.slope, line.slope_error);
    if by.abs() < NEAR {
        Finding::Mirrored {
            log,
            strikes,
            slope,
            error,
        }
    } else if (by - FRAC_PI_2).abs() < NEAR {
        Finding::AxesSwapped {
            log,
            strikes,
            slope,
            error,
        }
    } else {
        // Read mirrored, the headings change their signs: what is then left is the other way about.
        Finding::Turned {
            log,
            strikes,
            by: wrapped(-by),
            mirrored: true,
            certain: true,
            origin: None,
        }
    }
}

/// A turn that no gain explains, and by how much: the heading in the middle beside gains times the commanded angle, and, where angles vary, the heading at
/// angle zero too.
fn turned(
    log: &impl Fn() -> Option<String>,
    strikes: usize,
    heading: f64,
    centre: f64,
    beside_commands: f64,
    line: Option<Line>,
) -> Option<Finding> {
    // As the strikes tell it, where they do.
    let gains = line.map_or(GAINS, |line| {
        let error = SURE * line.slope_error;
        let gain = |gain: f64| gain.clamp(GAINS.0, GAINS.1);
        (gain(line.slope - error), gain(line.slope + error))
    });
    let (one, other) = (gains.0 * centre, gains.1 * centre);
    let (low, high) = (one.min(other), one.max(other));
    // About the commanded angle, so that nothing wraps.
    let turn = wrapped(heading - centre);
    let beside = if turn > high - centre {
        turn - (high - centre)
    } else if turn < low - centre {
        turn - (low - centre)
    } else {
        0.0
    };
    let at_zero = line.map(|line| {
        let constant = wrapped(heading + line.at_zero - line.slope * centre);
        let error = line.at_zero_error + centre.abs() * line.slope_error;
        // As much of it as is sure.
        constant.signum() * (constant.abs() - 2.0 * error).max(0.0)
    });
    let sure = match at_zero {
        Some(at_zero) if at_zero.signum() != beside.signum() && beside.abs() < FRAC_PI_2 => 0.0,
        Some(at_zero) => beside.abs().min(at_zero.abs()),
        None => beside.abs(),
    };
    // Where objects would leave along x: as the gain tells it, where it is another than 1; else as headings lie beside commands.
    let of_gain = line.filter(|line| (line.slope - 1.0).abs() > SURE * line.slope_error);
    let by = match of_gain {
        Some(line) => wrapped((heading + line.at_zero) / line.slope - centre),
        None => beside_commands,
    };
    (sure > PERHAPS_TURNED).then(|| Finding::Turned {
        log: log(),
        strikes,
        by: if turn.abs() > PI - NEAR { PI } else { by },
        mirrored: false,
        certain: sure > TURNED,
        origin: None,
    })
}

#[cfg(test)]
mod tests {
    use ingest::Seen;

    use super::*;

    /// Forty strikes whose objects leave by this function of the commanded angle, with a scatter of 2°.
    fn found(angles: (f64, f64), heading: impl Fn(f64, usize) -> f64) -> Vec<Finding> {
        let pairs: Vec<Pair> = (0..40)
            .map(|i| {
                let part = (0.618_034 * i as f64).fract();
                let angle = angles.0 + (angles.1 - angles.0) * part;
                let scatter = 0.035 * (5.1 * i as f64).sin();
                let speed = 0.4 + 0.6 * (0.414 * i as f64).fract();
                let velocity = Point::polar(1.2 * speed, heading(angle, i) + scatter);
                Pair::made(i, [speed, angle], velocity, 0.2)
            })
            .collect();
        findings(&pairs, None, true)
    }

    #[test]
    fn frames_that_are_as_stated_are_not_doubted() {
        for gain in [0.6, 1.0, 1.3] {
            for bias in [-0.05, 0.0, 0.05] {
                for angles in [(-0.8, 0.8), (0.2, 0.6), (0.5, 0.5), (-0.6, -0.5)] {
                    let found = found(angles, |angle, _| gain * angle + bias);
                    assert_eq!(found, [], "{gain} {bias} {angles:?}");
                }
            }
        }
    }

    #[test]
    fn a_state_that_is_mirrored_is_told_and_one_of_an_arm_that_objects_follow_is_not() {
        let told = |state: fn(f64) -> f64, object: fn(f64) -> f64| {
            let part = |i: usize| -0.6 + 1.2 * (0.618_034 * i as f64).fract();
            let pairs: Vec<Pair> = (0..40)
                .map(|i| {
                    let velocity = Point::polar(0.8, object(part(i)));
                    Pair::made(i, [0.6, part(i)], velocity, 0.2)
                })
                .collect();
            let meetings = pairs.iter().map(|pair| Meeting {
                tip: Point::default(),
                velocity: Point::polar(0.6, state(pair.command.angle)),
                moved: None,
                object: Point::default(),
                pushed: None,
                earlier: 0.0,
                at: pair.motion.start,
                command: Command::new(0.6, pair.command.angle),
                delay: None,
                delivered: None,
            });
            let seen = Seen {
                meetings: meetings.collect(),
                ..Seen::default()
            };
            state_beside(&[LogRead::made(&seen)], &pairs)
        };
        let found = told(|angle| -angle, |angle| angle);
        assert!(
            matches!(found, Some(Finding::StateBeside { beside, strikes: 40 }) if beside > 0.4),
            "{found:?}"
        );
        assert_eq!(told(|angle| angle + 0.05, |angle| angle), None);
        assert_eq!(told(|angle| 0.5 * angle, |angle| 0.5 * angle), None);
    }

    #[test]
    fn a_turn_of_twenty_degrees_is_one_where_angles_lie_on_one_side_too() {
        for (turn, angles) in [(0.35, (-0.85, 0.15)), (-0.35, (-0.15, 0.85))] {
            let found = found(angles, |angle, _| angle + turn);
            assert!(
                matches!(found[..], [Finding::Turned { certain: true, .. }]),
                "{found:?}"
            );
        }
    }

    #[test]
    fn a_turn_is_told_as_it_is_where_objects_leave_at_a_part_of_the_angle_too() {
        for (gain, turn) in [(1.0, 0.52), (0.6, 0.52), (0.6, -0.4), (0.75, 1.57)] {
            // The arm strikes to both sides, and more to one.
            let angles = (-0.7 - turn, 0.9 - turn);
            match found(angles, |a, _| gain * (a + turn))[..] {
                [
                    Finding::Turned {
                        by, certain: true, ..
                    },
                ] => {
                    assert!((by - turn).abs() < 0.03, "{gain} {turn}: {by}");
                }
                ref other => panic!("{gain} {turn}: {other:?}"),
            }
        }
    }

    #[test]
    fn a_mirror_a_swap_and_a_turn_are_told_from_one_another() {
        let wide = (-0.8, 0.8);
        assert!(matches!(
            found(wide, |a, _| -a)[..],
            [Finding::Mirrored { .. }]
        ));
        assert!(matches!(
            found(wide, |a, _| FRAC_PI_2 - a)[..],
            [Finding::AxesSwapped { .. }]
        ));
        for turn in [0.52, -0.52, 1.57, 3.1, -2.0] {
            match found(wide, |a, _| a + turn)[..] {
                [
                    Finding::Turned {
                        by,
                        mirrored: false,
                        certain: true,
                        ..
                    },
                ] => {
                    assert!(wrapped(by - turn).abs() < 0.1, "{turn} {by}");
                }
                ref other => panic!("{turn}: {other:?}"),
            }
        }
        // x reversed: mirrored, and then turned by half a turn.
        match found(wide, |a, _| PI - a)[..] {
            [
                Finding::Turned {
                    by,
                    mirrored: true,
                    certain: true,
                    ..
                },
            ] => assert!(by.abs() > 3.0),
            ref other => panic!("{other:?}"),
        }
        assert!(matches!(
            found((0.5, 0.5), |a, _| a - 1.0)[..],
            [Finding::Turned { certain: true, .. }]
        ));
    }

    #[test]
    fn a_frame_that_turns_with_the_arm_and_commands_of_something_else_are_known() {
        let other = |i: usize| -0.8 + 1.6 * (0.739 * i as f64 + 0.3).fract();
        assert!(matches!(
            found((0.0, 0.0), |_, i| other(i))[..],
            [Finding::ConstantHeading { .. }]
        ));
        let unrelated = found((-0.8, 0.8), |_, i| other(i));
        // Their speeds follow the commands: headings that do not are enough.
        assert!(
            matches!(unrelated[..], [Finding::Unrelated { .. }]),
            "{unrelated:?}"
        );
    }

    /// What forty strikes say of which the arm moves so far beside the command (rad), by its measured velocity.
    fn moved(command: impl Fn(f64) -> f64, beside: f64) -> Seen {
        let meetings = (0..40).map(|i| {
            let way = -0.6 + 1.2 * (0.618_034 * f64::from(i)).fract();
            Meeting {
                tip: Point::default(),
                velocity: Point::polar(0.7, way + beside),
                moved: None,
                object: Point::default(),
                pushed: None,
                earlier: 0.0,
                at: f64::from(i),
                command: Command::new(0.7, command(way)),
                delay: None,
                delivered: None,
            }
        });
        Seen {
            meetings: meetings.collect(),
            ..Seen::default()
        }
    }

    #[test]
    fn the_arm_s_measured_motion_tells_of_commands_in_another_frame() {
        let told = |seen: &Seen| {
            beside_commands(&[LogRead {
                name: "one.mcap",
                seen,
                kept: 40,
                rejects: Vec::new(),
            }])
        };
        // No arm errs by 30°; by 6° one may.
        let by = told(&moved(|way| way, 0.52)).expect("a turn");
        assert!(is_one_turn(by, 0.5) && !is_one_turn(by, 0.0));
        assert_eq!(told(&moved(|way| way, 0.1)), None);
        assert_eq!(told(&moved(|_| 0.0, 0.52)), None);

        let of = |seen: &Seen| {
            let met: Vec<_> = seen
                .meetings
                .iter()
                .map(|m| (m.command, m.velocity))
                .collect();
            constant_heading(&met, "one.mcap")
        };
        let found = of(&moved(|_| 0.0, 0.0));
        assert!(
            matches!(&found, Some(Finding::ConstantHeading { log: Some(log), strikes: 40, .. }) if log == "one.mcap"),
            "{found:?}"
        );
        assert_eq!(of(&moved(|way| way, 0.0)), None);
    }
}
