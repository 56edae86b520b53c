//! Logs, or parts of one, that differ in what the tip's touches tell of them: how far the camera's stamps lie behind the arm's, and where the camera
//! sees objects beside the tip.
//!
//! In all logs together one that is late, or a camera that was moved in one, is some scatter, or a mean that is true of none.

use ingest::Meeting;
use values::{Point, Rig};

use crate::clocks::{clock_drift, encoder_to_camera};
use crate::finding::{Finding, LogRead};
use crate::pairs::Pair;
use crate::parts::{PART, Step, by_from, step, step_at};
use crate::statistics::median;

/// What is asked of each strike.
type Value<'a> = dyn Fn(&Meeting) -> Option<f64> + 'a;

/// The findings on logs that differ, and on steps and drifts within one; on places of round objects alone: boxes are met anywhere.
pub(crate) fn findings(rig: &Rig, logs: &[LogRead<'_>]) -> Vec<Finding> {
    /// Least differences that are told: of a delay, in s, and of a place, in m.
    const LATE: f64 = 0.008;
    const ELSEWHERE: f64 = 0.015;
    let solid = &rig.object.solid;
    let reach = solid.reach() + rig.striker.radius;
    let beside = |m: &Meeting| {
        let beside = m.object - m.tip - m.towards(0.0) * reach - m.velocity * m.earlier;
        solid.radius().map(|_| beside)
    };
    // Each strike as a pair whose lag is the value that is asked for.
    let series = |log: &LogRead<'_>, of: &Value<'_>| -> Vec<Pair> {
        let met = log.seen.meetings.iter();
        let met = met.filter(|m| m.velocity.norm() > 0.0 && m.velocity.is_finite());
        met.filter_map(|m| Some(Pair::of_touch(m, of(m).filter(|value| value.is_finite())?)))
            .collect()
    };
    let values: [(f64, &Value<'_>); 3] = [
        (LATE, &|m| m.delay),
        (ELSEWHERE, &|m| Some(beside(m)?.x)),
        (ELSEWHERE, &|m| Some(beside(m)?.y)),
    ];
    let of_logs: Vec<[Vec<Pair>; 3]> = logs
        .iter()
        .map(|log| values.map(|(_, of)| series(log, of)))
        .collect();
    let lags = |pairs: &[Pair]| -> Vec<f64> { pairs.iter().map(|pair| pair.lag).collect() };
    let clearest = |found: &mut dyn Iterator<Item = (usize, usize, Step)>| {
        found.max_by(|a, b| a.2.clearness().total_cmp(&b.2.clearness()))
    };
    let elsewhere =
        |log: usize, strike: Option<usize>, by: Point, error: f64| Finding::DisplacedApart {
            log: logs[log].name.into(),
            strike,
            by,
            error,
            strikes: of_logs[log][1].len(),
            misses: by.norm() > reach,
        };
    let mut findings = Vec::new();
    for (log, of) in of_logs.iter().enumerate() {
        let mut steps = (0..3).filter_map(|what| {
            let step = step(&of[what], &lags(&of[what]), values[what].0)?;
            Some((log, what, step))
        });
        let name = logs[log].name;
        let Some((_, what, found)) = clearest(&mut steps) else {
            let drift = clock_drift(name, &of[0], LATE, false);
            findings.extend(drift.map(Finding::told_by_touches));
            continue;
        };
        let first = of[what][found.at].command.rise;
        let commands = &logs[log].seen.commands;
        let strike = commands.partition_point(|c| c.rise < first).max(1);
        findings.push(match what {
            0 => Finding::ClockStep {
                log: name.into(),
                strike,
                by: found.by,
                error: found.error,
                untimely: 0,
                by_touch: true,
            },
            _ => {
                let by =
                    [1, 2].map(|i| by_from(&of[i], &lags(&of[i]), found.at).unwrap_or_default());
                elsewhere(log, Some(strike), Point::new(by[0], by[1]), found.error)
            }
        });
    }
    if !findings.is_empty() {
        return findings;
    }
    // Of each log that is unlike most, the clearest first.
    let mut left: Vec<usize> = (0..logs.len()).collect();
    loop {
        let own = |log: usize, what: usize| median(lags(&of_logs[log][what]));
        let others = |log: usize, what: usize| -> Vec<Pair> {
            let others = left.iter().filter(|other| **other != log);
            others
                .flat_map(|other| of_logs[*other][what].clone())
                .collect()
        };
        let is_less = |log: usize, what: usize| {
            let size = |log: usize| own(log, what).map_or(0.0, f64::abs);
            // Of two, that which is farther from none.
            left.len() == 2 && left.iter().any(|other| size(*other) > size(log))
        };
        let each = left
            .iter()
            .flat_map(|log| [0, 1, 2].map(|what| (*log, what)));
        let mut apart = each.filter_map(|(log, what)| {
            let own = &of_logs[log][what];
            if own.len() < PART || is_less(log, what) {
                return None;
            }
            let mut pairs = others(log, what);
            let at = pairs.len();
            pairs.extend(own);
            let is_enough = at >= PART;
            let found = is_enough.then(|| step_at(&pairs, &lags(&pairs), at, values[what].0));
            Some((log, what, found??))
        });
        let Some((log, what, found)) = clearest(&mut apart) else {
            return findings;
        };
        let delay = encoder_to_camera(rig, std::slice::from_ref(&logs[log]));
        findings.extend(match (what, delay) {
            (0, Some(delay)) if delay.is_sure() => Some(Finding::EncoderDelay {
                log: Some(logs[log].name.into()),
                delay,
                misleads: true,
            }),
            // Touches that are early or late by no one time are elsewhere; where a box is, its places tell.
            _ if of_logs[log][1].is_empty() => None,
            _ => {
                let by = [1, 2].map(|i| {
                    let beside = |others| Some(own(log, i)? - others);
                    median(lags(&others(log, i)))
                        .and_then(beside)
                        .unwrap_or_default()
                });
                Some(elsewhere(log, None, Point::new(by[0], by[1]), found.error))
            }
        });
        left.retain(|other| *other != log);
    }
}

#[cfg(test)]
mod tests {
    use ingest::Seen;
    use values::{Command, Shape};

    use super::*;

    /// What is found in logs of forty strikes each, of a tip whose radius is stated 3 mm too great, where the camera lies so many s behind, and the
    /// object so far (m) from where it should, by the log's and the strike's number.
    fn found(
        logs: usize,
        late: impl Fn(usize, usize) -> f64,
        by: impl Fn(usize, usize) -> Point,
    ) -> Vec<Finding> {
        let rig = Rig::demo(Shape::Cylinder);
        let reach = rig.object.solid.reach() + rig.striker.radius;
        let seen = (0..logs).map(|log| {
            let meetings = (0..40).map(|i| {
                let part = |k: f64| (k * (40 * log + i) as f64).fract();
                let command = Command::new(0.4 + 0.6 * part(0.414), -0.6 + 1.2 * part(0.618));
                let velocity = Point::polar(command.speed, command.angle);
                let towards = velocity * (1.0 / command.speed);
                let object = Point::new(0.2 + 0.2 * part(0.732), -0.2 + 0.4 * part(0.236));
                let noise = 0.003 * (5.1 * i as f64).sin();
                let (delay, by) = (late(log, i) + noise, by(log, i));
                // A displaced object is touched sooner or later.
                let touched = delay - (by.dot(towards) - 0.003) / command.speed;
                Meeting {
                    tip: object - towards * (reach - 0.003) + velocity * delay,
                    velocity,
                    moved: None,
                    object: object + by,
                    pushed: None,
                    earlier: 0.0,
                    at: 6.0 * i as f64 + 0.2,
                    command,
                    delay: Some(touched),
                    delivered: None,
                }
            });
            let meetings: Vec<Meeting> = meetings.collect();
            let delays = meetings.iter().map(|m| ingest::TouchDelay {
                seconds: m.delay.unwrap_or_default(),
                speed: m.velocity.norm(),
            });
            Seen {
                commands: meetings
                    .iter()
                    .map(|m| Pair::of_touch(m, 0.0).command)
                    .collect(),
                delays: delays.collect(),
                meetings,
                ..Seen::default()
            }
        });
        let seen: Vec<Seen> = seen.collect();
        let names = ["one.mcap", "two.mcap", "three.mcap"];
        let read: Vec<LogRead<'_>> = seen
            .iter()
            .zip(names)
            .map(|(seen, name)| LogRead {
                name,
                seen,
                kept: 40,
                rejects: Vec::new(),
            })
            .collect();
        findings(&rig, &read)
    }

    fn nowhere(_: usize, _: usize) -> Point {
        Point::default()
    }

    #[test]
    fn what_all_logs_say_together_is_no_difference() {
        for late in [0.0, 0.025] {
            for logs in [1, 2, 3] {
                assert_eq!(found(logs, |_, _| late, |_, _| Point::new(0.05, 0.02)), []);
                assert_eq!(found(logs, |_, _| late, nowhere), []);
            }
        }
    }

    #[test]
    fn a_camera_that_is_late_in_one_log_is_told_by_its_name() {
        let told = |found: &[Finding], name: &str, late: f64| {
            let is_it = |f: &Finding| {
                matches!(f, Finding::EncoderDelay { log: Some(log), delay, .. }
                    if log == name && (delay.seconds[0] - late).abs() < 0.004)
            };
            assert!(found.iter().any(is_it), "{name}: {found:?}");
            found.len()
        };
        let one = found(3, |log, _| if log == 1 { 0.06 } else { 0.0 }, nowhere);
        assert_eq!(told(&one, "two.mcap", 0.06), 1);
        for late in 0..2 {
            let one = found(2, |log, _| if log == late { 0.02 } else { 0.0 }, nowhere);
            assert_eq!(told(&one, ["one.mcap", "two.mcap"][late], 0.02), 1);
        }
        let two = found(3, |log, _| [0.05, -0.04, 0.0][log], nowhere);
        assert_eq!(
            told(&two, "one.mcap", 0.05) + told(&two, "two.mcap", -0.04),
            4
        );
    }

    #[test]
    fn a_step_and_a_drift_within_a_log_are_told_as_what_they_are() {
        let step = found(
            2,
            |log, i| if log == 0 && i >= 25 { 0.04 } else { 0.0 },
            nowhere,
        );
        assert!(
            matches!(&step[..], [Finding::ClockStep { log, strike: 25..=27, by, by_touch: true, .. }]
                if log == "one.mcap" && (by - 0.04).abs() < 0.004),
            "{step:?}"
        );
        // 60 ms over the log.
        let drift = found(1, |_, i| 0.06 * i as f64 / 39.0, nowhere);
        assert!(
            matches!(&drift[..], [Finding::ClockDrift { drifted, by_touch: true, .. }]
                if (drifted - 0.06).abs() < 0.004),
            "{drift:?}"
        );
    }

    #[test]
    fn a_camera_that_was_moved_is_no_clock() {
        let by = Point::new(0.05, 0.02);
        let one = found(
            2,
            |_, _| 0.0,
            |log, _| if log == 1 { by } else { Point::default() },
        );
        assert!(
            matches!(&one[..], [Finding::DisplacedApart { log, strike: None, by: told, .. }]
                if log == "two.mcap" && told.distance(by) < 0.006),
            "{one:?}"
        );
        let within = found(
            1,
            |_, _| 0.0,
            |_, i| if i >= 20 { by } else { Point::default() },
        );
        assert!(
            matches!(&within[..], [Finding::DisplacedApart { strike: Some(20..=22), by: told, .. }]
                if told.distance(by) < 0.006),
            "{within:?}"
        );
    }
}
