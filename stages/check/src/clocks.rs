//! Whether the clocks of camera and arm are one: delays, rates, steps, as commands and motions, and the tip's touches, tell them.

use values::{Reject, RejectReason, Rig};

use crate::finding::{Delay, Finding, LogRead};
use crate::pairs::{self, FEWEST, Pair, Pairs};
use crate::parts;
use crate::statistics::{self, median, median_error, median_spread};

/// Least drift of clocks over a log that is told: in s, and in standard errors.
const DRIFT: f64 = 0.1;
const DRIFT_ERRORS: f64 = 6.0;

/// The finding that clocks drift apart by at least so much (s) over a log; what a hand moved meanwhile tells nothing of it.
pub(crate) fn clock_drift(log: &str, pairs: &[Pair], least: f64, certain: bool) -> Option<Finding> {
    let each = pairs.iter().zip(pairs::are_astray(pairs));
    let struck: Vec<Pair> = each.filter(|of| !of.1).map(|of| *of.0).collect();
    let rises = beside_speed(&struck, |pair| pair.command.rise);
    let lags = beside_speed(&struck, |pair| pair.lag);
    let points: Vec<(f64, f64)> = rises.into_iter().zip(lags).collect();
    let line = statistics::line(&points)?;
    let rises = pairs.iter().map(|pair| pair.command.rise);
    let span =
        rises.clone().fold(f64::NEG_INFINITY, f64::max) - rises.fold(f64::INFINITY, f64::min);
    let drifted = line.slope * span;
    let is_sure = line.slope.abs() > DRIFT_ERRORS * line.slope_error;
    (drifted.abs() > least && is_sure).then(|| Finding::ClockDrift {
        log: log.into(),
        rate: line.slope,
        drifted,
        certain,
        by_touch: false,
    })
}

/// Values of pairs with their dependence on the commanded speed taken off: the ramp to a faster plateau takes longer.
fn beside_speed(pairs: &[Pair], of: impl Fn(&Pair) -> f64) -> Vec<f64> {
    let points: Vec<(f64, f64)> = pairs.iter().map(|p| (p.command.speed, of(p))).collect();
    let line = statistics::line(&points);
    let at = |speed: f64| line.map_or(0.0, |line| line.at_zero + line.slope * speed);
    let left = points.iter().map(|(speed, value)| value - at(*speed));
    left.collect()
}

/// The findings on the clocks of camera and arm, as commands and motions tell them.
pub(crate) fn findings(logs: &[LogRead<'_>], paired: &[Pairs]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (log, of) in logs.iter().zip(paired) {
        if of.is_rated {
            findings.extend(clock_drift(log.name, &of.pairs, DRIFT, true));
            continue;
        }
        let step = parts::clock_step(log.name, &of.pairs).filter(|_| !of.is_shifted);
        if let (Some(delay), None) = (of.delay, &step) {
            findings.push(Finding::ClockOffset {
                log: log.name.into(),
                delay,
                uncertainty: of.uncertainty,
                strikes: of.pairs.len(),
                certain: of.is_shifted,
            });
            if of.is_shifted {
                continue;
            }
        }
        findings.extend(other_times(log, of));
        let commands = log.seen.commands.len();
        // In another unit nothing is seen to move, nor at one time; nor in too few frames.
        let is_unseen = |reject: &&&Reject| {
            let unseen = [
                RejectReason::UnitsImplausible,
                RejectReason::ClockBackwards,
                RejectReason::FramesMissing,
            ];
            unseen.contains(&reject.reason)
        };
        let unseen = log.rejects.iter().filter(is_unseen).count();
        let is_seen = 4 * of.pairs.len().max(log.kept) >= commands;
        if commands >= FEWEST && !is_seen && 2 * unseen < commands {
            findings.push(Finding::NothingMoves {
                log: log.name.into(),
                commands,
                moved: of.pairs.len(),
                motions: log.seen.motions.len(),
            });
        }
        let drifts = || clock_drift(log.name, &of.pairs, DRIFT, false);
        findings.extend(step.or_else(drifts));
    }
    findings
}

/// That the camera's stamps go faster or slower than the arm's, by the recorder's clock: in all logs alike, or in some.
pub(crate) fn slow_stamps(logs: &[LogRead<'_>]) -> Vec<Finding> {
    /// Least part by which they do that is told: of it, friction is off by twice as much. Its least size in standard errors, and the least of these.
    const LEAST: f64 = 0.005;
    const ERRORS: f64 = 5.0;
    const RESOLVED: f64 = 1e-4;
    let of_log = |log: &LogRead<'_>| {
        let [times, error] = log.seen.slow?;
        Some((log.name.to_owned(), times, error.max(RESOLVED)))
    };
    let each: Vec<(String, f64, f64)> = logs.iter().filter_map(of_log).collect();
    let weigh = |e: &(String, f64, f64)| e.2.powi(-2);
    let weight: f64 = each.iter().map(weigh).sum();
    let together = each.iter().map(|e| weigh(e) * e.1).sum::<f64>() / weight;
    let is_told = |times: f64, error: f64| times.ln().abs() > LEAST.max(ERRORS * error);
    let are_alike = each
        .iter()
        .all(|(_, times, error)| (times - together).abs() < ERRORS * error);
    if are_alike && is_told(together, weight.powf(-0.5)) {
        let (times, error) = (together, weight.powf(-0.5));
        return vec![Finding::SlowStamps {
            log: None,
            times,
            error,
        }];
    }
    let told = each
        .into_iter()
        .filter(|(_, times, error)| is_told(*times, *error));
    let finding = |(log, times, error)| Finding::SlowStamps {
        log: Some(log),
        times,
        error,
    };
    told.map(finding).collect()
}

/// Logs whose arm's measured state has another clock than its commands and the camera. By the state the arm then moves before it is commanded to, or
/// after the object does; else, where the touches tell the same time, the camera's clock agrees with the commands'.
pub(crate) fn state_clocks(rig: &Rig, logs: &[LogRead<'_>], paired: &[Pairs]) -> Vec<Finding> {
    /// Least time that is told, time by which a command may be logged late, that to which both times are known, and that from which touches alone
    /// tell it, in s; and the spread below which strikes tell one time.
    const LEAST: f64 = 0.01;
    const FAR: f64 = 0.5;
    const LATE: f64 = 0.02;
    const KNOWN: f64 = 0.005;
    const ONE: f64 = 0.02;
    let of_log = |log: &LogRead<'_>, of: &Pairs| {
        let touches = encoder_to_camera(rig, std::slice::from_ref(log)).filter(Delay::is_sure);
        let touched = touches.map_or(0.0, |delay| delay.seconds[0]);
        let lags: Vec<f64> = match touched.abs() > FAR {
            true => log.seen.delays.iter().map(|touch| -touch.seconds).collect(),
            false => log.seen.behind.clone(),
        };
        let strikes = lags.len();
        let (behind, spread) = median_spread(&lags)?;
        let to_motion = median(of.pairs.iter().map(|pair| pair.lag))?;
        let is_early = behind < -LATE && touched >= 0.0;
        // An arm that lags farther than the touches are off may as well be seen by a camera that is early.
        let beside = behind + touched;
        let is_late = touched < -LEAST && (-KNOWN..-touched).contains(&beside);
        let is_apart = is_early || is_late || behind > to_motion.max(LATE);
        let is_told = strikes >= FEWEST.max(log.seen.commands.len() / 2) && spread < ONE;
        (is_told && is_apart && of.delay.is_none()).then(|| Finding::StateClock {
            log: log.name.into(),
            behind,
            strikes,
        })
    };
    let each = logs.iter().zip(paired);
    each.filter_map(|(log, of)| of_log(log, of)).collect()
}

/// Commands of one session beside a camera of another: a strike's command begins a motion, and a strike's motion was commanded.
fn other_times(log: &LogRead<'_>, of: &Pairs) -> Option<Finding> {
    /// Share of the slowest command's speed below which a motion may be a hand's doing.
    const STRUCK: f64 = 0.5;
    let commands = &log.seen.commands;
    let slowest = commands
        .iter()
        .map(|c| c.speed)
        .fold(f64::INFINITY, f64::min);
    let followed = of.pairs.len();
    let is_paired = |start: f64| of.pairs.iter().any(|pair| pair.motion.start == start);
    let motions = log.seen.motions.iter();
    let struck = motions
        .filter(|m| m.velocity.norm() > STRUCK * slowest && !is_paired(m.start))
        .count();
    let is_apart = commands.len() >= FEWEST
        && 4 * followed >= commands.len()
        && 2 * followed < commands.len()
        && 2 * struck >= commands.len();
    is_apart.then(|| Finding::OtherTimes {
        log: log.name.into(),
        commands: commands.len(),
        followed,
        struck,
    })
}

/// The delay between the camera and the arm's encoders, by touches at several speeds. A box is met anywhere between its sides and its corners.
pub(crate) fn encoder_to_camera(rig: &Rig, logs: &[LogRead<'_>]) -> Option<Delay> {
    /// Standard error of a length, in m, from which it is not told from a delay.
    const LENGTH: f64 = 0.0015;
    let touches: Vec<(f64, f64)> = logs
        .iter()
        .flat_map(|log| &log.seen.delays)
        .filter(|touch| touch.speed > 0.0 && touch.seconds.is_finite())
        .map(|touch| (1.0 / touch.speed, touch.seconds))
        .collect();
    let strikes = touches.len();
    if strikes < FEWEST {
        return None;
    }
    let solid = &rig.object.solid;
    let line = statistics::line(&touches).filter(|line| line.slope_error < LENGTH);
    if let Some(line) = line {
        return Some(Delay {
            seconds: [line.at_zero, line.at_zero_error],
            // Behind a reach that is longer than stated the object moves before the touch.
            reach: solid.radius().map(|_| [-line.slope, line.slope_error]),
            strikes,
        });
    }
    let delays: Vec<f64> = touches.iter().map(|touch| touch.1).collect();
    let (middle, spread) = median_spread(&delays)?;
    let by_chance = median_error(spread, strikes);
    let a_metre = median(touches.iter().map(|touch| touch.0))?;
    let by_corners = 0.25 * (solid.reach() - solid.narrowest()) * a_metre;
    Some(Delay {
        seconds: [middle, by_chance.hypot(by_corners)],
        reach: None,
        strikes,
    })
}

#[cfg(test)]
mod tests {
    use ingest::Seen;
    use values::Point;

    use super::*;

    /// Whether clocks of forty strikes seem to drift, which do by so many s from one strike to the next.
    fn is_drifting(is_sorted: bool, by: f64) -> bool {
        let pairs: Vec<Pair> = (0..40)
            .map(|i| {
                let part = |k: f64| (k * i as f64).fract();
                let share = if is_sorted {
                    i as f64 / 40.0
                } else {
                    part(0.618)
                };
                let speed = 0.4 + 0.6 * share;
                let lag = 0.02 + speed / 5.0 + by * i as f64 + 0.004 * part(0.41);
                Pair::made(i, [speed, 0.0], Point::new(speed, 0.0), lag)
            })
            .collect();
        clock_drift("one.mcap", &pairs, DRIFT, false).is_some()
    }

    #[test]
    fn stamps_that_run_slow_are_told_of_all_logs_together_or_of_the_one_that_does() {
        let told = |paces: &[Option<[f64; 2]>]| -> Vec<(bool, f64)> {
            let of = |slow: &Option<[f64; 2]>| Seen {
                slow: *slow,
                ..Seen::default()
            };
            let seen: Vec<Seen> = paces.iter().map(of).collect();
            let logs: Vec<LogRead<'_>> = seen.iter().map(LogRead::made).collect();
            let found = slow_stamps(&logs).into_iter().map(|found| match found {
                Finding::SlowStamps { log, times, .. } => (log.is_none(), times),
                other => panic!("{other:?}"),
            });
            found.collect()
        };
        assert_eq!(told(&[None, None]), []);
        assert_eq!(told(&[Some([1.001, 0.0]), Some([1.0, 0.001])]), []);
        // Each for itself is no more than its error.
        let alike = told(&[Some([1.03, 0.01]); 9]);
        assert!(matches!(alike[..], [(true, times)] if (times - 1.03).abs() < 1e-9));
        assert_eq!(
            told(&[Some([1.0, 1e-4]), Some([1.1, 1e-4]), None]),
            [(false, 1.1)]
        );
    }

    #[test]
    fn a_longer_ramp_to_a_faster_plateau_is_no_drift() {
        assert!(!is_drifting(true, 0.0) && !is_drifting(false, 0.0));
        assert!(is_drifting(false, 0.005) && is_drifting(false, -0.005));
    }

    #[test]
    fn what_a_hand_moves_late_in_a_log_hides_no_drift() {
        let pairs: Vec<Pair> = (0..12)
            .map(|i| {
                let (speed, part) = (0.4 + 0.6 * (0.618 * i as f64).fract(), 0.41 * i as f64);
                let (leaves, late) = if i > 9 { (2.5, -0.5) } else { (0.0, 0.0) };
                let lag = 0.1 + speed / 5.0 + 0.05 * i as f64 + 0.01 * part.fract() + late;
                Pair::made(i, [speed, 0.0], Point::polar(speed, leaves), lag)
            })
            .collect();
        let found = clock_drift("one.mcap", &pairs, DRIFT, false);
        assert!(
            matches!(found, Some(Finding::ClockDrift { rate, .. }) if (rate - 0.05 / 6.0).abs() < 1e-3),
            "{found:?}"
        );
    }

    #[test]
    fn a_state_of_another_clock_is_told_from_an_arm_that_lags_and_from_a_late_camera() {
        use ingest::{Seen, TouchDelay};
        // By so much the state lies behind the commands, and the camera behind the state.
        let found = |behind: f64, camera: f64| {
            let made = (0..40).map(|i| {
                let speed = 0.4 + 0.6 * (0.618 * i as f64).fract();
                Pair::made(i, [speed, 0.0], Point::new(speed, 0.0), 0.2)
            });
            let made: Vec<Pair> = made.collect();
            let delays = made.iter().map(|pair| TouchDelay {
                seconds: camera + 0.002 * (7.1 * pair.command.rise).sin(),
                speed: pair.command.speed,
            });
            let seen = Seen {
                commands: made.iter().map(|pair| pair.command).collect(),
                motions: made.iter().map(|pair| pair.motion).collect(),
                delays: delays.collect(),
                behind: vec![behind; 40],
                ..Seen::default()
            };
            let rig = Rig::demo(values::Shape::Cylinder);
            let paired = [pairs::pairs(&seen, 0.1)];
            !state_clocks(&rig, &[LogRead::made(&seen)], &paired).is_empty()
        };
        for (behind, camera) in [
            (0.0, 0.0),
            (0.08, 0.0),
            (0.0, 0.06),
            (0.02, -0.06),
            (0.03, 0.04),
        ] {
            assert!(!found(behind, camera), "{behind} {camera}");
        }
        for (behind, camera) in [
            (0.06, -0.06),
            (0.08, -0.06),
            (0.3, -0.3),
            (-0.15, 0.15),
            (1.0, -1.0),
        ] {
            assert!(found(behind, camera), "{behind} {camera}");
        }
    }
}
