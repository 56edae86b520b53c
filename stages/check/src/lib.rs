//! Whether logs mean what the rig file says they mean: frames, clocks, units, limits, coverage, noise, lost frames.
//!
//! A model that is fitted to a mirrored camera or to a turned arm is wrong, and may look right. So commands and motions, each as the
//! log shows them on their own ([`ingest::Seen`]), are held against each other before anything is fitted: which command began which
//! motion ([`pairs`]), in which direction objects leave beside the commanded one ([`frames`], [`strays`]), how fast, and where the tip then
//! was ([`places`]). What is wrong is a
//! [`Finding`]: data, which the pipeline puts into words. One that makes a model [meaningless](Severity::Meaningless) is published
//! by nothing; where the rig file states what is so, the logs are read so, and the finding is gone.
//!
//! No finding hangs on a fit or on an effect: limits are those of what the library can hold (a bias of the arm up to 0.3 rad, an angle
//! gain above one half, a launch of at most twice the tip's speed).

mod clocks;
mod coverage;
mod finding;
mod frames;
mod other_commands;
mod pairs;
mod parts;
mod places;
mod statistics;
mod strays;
mod touches;

pub use finding::{CONTACT, Check, Coverage, Delay, Finding, Limit, LogRead, Measured, Severity};

use std::collections::BTreeMap;
use std::f64::consts::PI;

use ingest::{FoundFence, Seen};
use values::{CommandFrame, Reject, RejectReason, Rig, Solid};

use crate::pairs::{FEWEST, Pair, Pairs, WEAKEST};
use crate::parts::{MOVED, MOVED_ERRORS};
pub use crate::statistics::wrapped;
use crate::statistics::{median, median_error, median_spread};

/// Share of the speed of the robot's slowest strike below which a command is no strike.
const SLOWER: f64 = 0.5;

/// Checks logs that were read; `fences` are those that were found in them beside the rig file's.
pub fn check(rig: &Rig, logs: &[LogRead<'_>], fences: &[FoundFence]) -> Check {
    let slowest = SLOWER * rig.robot.speed.low;
    let is_by_state = logs.iter().any(|log| log.seen.is_by_state);
    // Of places that are two cameras' in turn all else tells nothing.
    let two: Vec<Option<Finding>> = logs.iter().map(two_sources).collect();
    if two.iter().any(Option::is_some) {
        let others = logs.iter().zip(&two).filter(|(_, two)| two.is_none());
        let others: Vec<LogRead<'_>> = others.map(|(log, _)| log.clone()).collect();
        let mut check = match others.is_empty() {
            true => Check::default(),
            false => self::check(rig, &others, fences),
        };
        check.findings.splice(0..0, two.into_iter().flatten());
        return check;
    }
    let encoder_to_camera = clocks::encoder_to_camera(rig, logs);
    // Where touches are not seen at their time, what is taken for strikes and for commands is anything.
    if let Some(delay) =
        encoder_to_camera.filter(|d| is_by_state && d.is_sure() && d.misleads(true))
    {
        return Check {
            findings: vec![Finding::EncoderDelay {
                log: None,
                delay,
                misleads: true,
            }],
            measured: Measured {
                encoder_to_camera,
                ..Measured::default()
            },
        };
    }
    let paired: Vec<Pairs> = logs
        .iter()
        .map(|log| pairs::pairs(log.seen, slowest))
        .collect();
    let all: Vec<Pair> = paired.iter().flat_map(|of| of.pairs.clone()).collect();
    let is_logged = |log: &LogRead<'_>| !log.seen.is_by_state;
    let commanded = logs.iter().any(is_logged);
    let mut findings = frames::findings(&all, None, commanded);
    let moved = frames::beside_commands(logs);
    for finding in &mut findings {
        if let Finding::Turned {
            log,
            strikes,
            by,
            mirrored: false,
            origin,
            ..
        } = finding
        {
            match moved.filter(|moved| frames::is_one_turn(*moved, *by)) {
                Some(by) => {
                    *finding = Finding::CommandFrame {
                        log: log.take(),
                        strikes: *strikes,
                        by,
                    }
                }
                None => *origin = places::Origins::of_turned(rig, logs, *by),
            }
        }
    }
    let is_wrong = |finding: &Finding| finding.severity() == Severity::Meaningless;
    // One log of another robot among others is not seen in all of them together, or makes them seem unrelated to their commands.
    let is_vague = |finding: &Finding| matches!(finding, Finding::Unrelated { .. });
    let jumps = jumps(logs);
    let is_torn = jumps.iter().any(is_wrong);
    if is_torn {
        // Headings and speeds from one object to another say nothing.
        findings.clear();
    }
    if !is_torn && logs.len() > 1 && findings.iter().all(|f| !is_wrong(f) || is_vague(f)) {
        let each = logs.iter().zip(&paired);
        let of_logs: Vec<Finding> = each
            .flat_map(|(log, of)| frames::findings(&of.pairs, Some(log.name), is_logged(log)))
            .filter(is_wrong)
            .collect();
        let says_more = of_logs.iter().any(|finding| !is_vague(finding));
        findings.retain(|finding| !(says_more && is_vague(finding)));
        if !findings.iter().any(is_vague) {
            findings.extend(of_logs);
        }
    }
    let each = logs.iter().zip(&paired);
    let each = each.filter(|(log, _)| !is_torn && is_logged(log));
    let others: Vec<Finding> = each
        .filter_map(|(log, of)| other_commands::findings(&of.pairs, log.name))
        .collect();
    // These say what headings follow.
    findings.retain(|finding| others.is_empty() || !is_vague(finding));
    findings.extend(others);
    // Where frames are wrong, all are astray.
    if !is_torn && !findings.iter().any(is_wrong) {
        let each = logs.iter().zip(&paired);
        findings.extend(each.filter_map(|(log, of)| strays::findings(&of.pairs, log.name)));
    }
    if !findings.iter().any(is_wrong) {
        let of_log = |log: &LogRead<'_>| {
            let met = log.seen.meetings.iter();
            let met: Vec<_> = met.map(|m| (m.command, m.velocity)).collect();
            frames::constant_heading(&met, log.name)
        };
        let logged = logs.iter().filter(|log| is_logged(log));
        findings.extend(logged.filter_map(of_log));
    }
    // Angles that stand for speeds have no unit of theirs, and are rejected as such.
    let is_polar = findings
        .iter()
        .any(|f| matches!(f, Finding::SpeedAndAngle { .. }));
    findings.extend(base_turns(rig, &all));
    if !is_torn {
        let state_clocks = clocks::state_clocks(rig, logs, &paired);
        if state_clocks.is_empty() {
            findings.extend(delivers(logs));
        }
        findings.extend(state_clocks);
        findings.extend(clocks::findings(logs, &paired));
        findings.extend(clocks::slow_stamps(logs));
        let reach = places::reach(rig, logs);
        if !is_polar {
            // What no touch began tells no speed.
            let scale = speeds(rig, &all).filter(|_| reach.is_none());
            let is_in_other_unit = scale.is_some();
            findings.extend(scale);
            // In another frame angles are others, and in another unit speeds.
            let is_apart = findings.iter().any(|f| is_wrong(f) && f.is_of_frames());
            let of_all = limits(rig, &all, commanded);
            let of_logs = || {
                let each = logs.iter().zip(&paired);
                each.filter_map(|(log, of)| log_limits(rig, log, &of.pairs, &all))
            };
            let limits = match of_all.is_empty() {
                true => of_logs().collect(),
                false => of_all,
            };
            findings.extend(limits.into_iter().filter(|finding| match finding {
                Finding::OutsideLimits { limit, .. } => match limit {
                    Limit::Angle => !is_apart,
                    Limit::Speed => !is_in_other_unit,
                },
                _ => true,
            }));
        }
        findings.extend(reach);
    }
    // Speeds in two units follow none.
    let is_unit = |f: &Finding| {
        matches!(
            f,
            Finding::Delivers { .. } | Finding::OutsideLimits { log: Some(_), .. }
        )
    };
    if findings.iter().any(is_unit) {
        findings.retain(|finding| !is_vague(finding));
    }
    let of_units: Vec<&str> = logs
        .iter()
        .filter(|log| is_in_other_unit(log))
        .map(|log| log.name)
        .collect();
    let is_of_units =
        |f: &Finding| matches!(f, Finding::Jumps { log, .. } if of_units.contains(&log.as_str()));
    findings.extend(jumps.into_iter().filter(|f| !is_of_units(f)));
    let is_told = |f: &Finding| {
        let unit = RejectReason::UnitsImplausible;
        !(is_polar && matches!(f, Finding::MostlyRejected { reason, .. } if *reason == unit))
    };
    findings.extend(rejected(logs).into_iter().filter(is_told));
    findings.extend(fences.iter().map(|found| Finding::Fence {
        fence: found.fence,
        bounces: found.bounces,
    }));
    findings.extend(noise(rig, logs));
    findings.extend(
        gathering(logs)
            .filter(is_wrong)
            .or_else(|| swelling(logs))
            .or_else(|| gathering(logs)),
    );
    findings.extend(density(rig));
    let is_clear = !findings.iter().any(is_wrong);
    if is_clear {
        findings.extend(sessions(logs, &paired, &findings));
        findings.extend(session_speeds(logs, &paired));
    }
    // What seems unrelated may be two set-ups, one after the other.
    if findings.iter().all(|f| !is_wrong(f) || is_vague(f)) {
        let each = logs.iter().zip(&paired);
        let of_parts: Vec<Finding> = each
            .flat_map(|(log, of)| parts::findings(log.name, &of.pairs, is_logged(log)))
            .filter(|finding| is_clear || matches!(finding, Finding::InPart { .. }))
            .collect();
        findings.retain(|finding| of_parts.is_empty() || !is_vague(finding));
        findings.extend(of_parts);
    }
    let (seen, lost) = logs.iter().fold((0, 0), |(seen, lost), log| {
        (seen + log.seen.frames, lost + log.seen.lost)
    });
    let share = lost as f64 / (seen + lost).max(1) as f64;
    if share > MOST_LOST {
        findings.push(Finding::LostFrames { share });
    }
    let coverage = Coverage::of(&all);
    findings.extend(coverage.findings());
    let noises = logs.iter().filter_map(|log| log.seen.noise_at_rest());
    // What looks like a delay, or like other radii, may be another origin.
    let delay = match places::Origins::of(rig, logs) {
        Some(apart) => Some(apart.delay),
        None => encoder_to_camera,
    };
    let mut is_other = false;
    if !findings.iter().any(is_wrong) {
        findings.extend(places::state_frame(logs).or_else(|| frames::state_beside(logs, &all)));
        let apart = touches::findings(rig, logs);
        if apart.is_empty() {
            findings.extend(places::findings(rig, logs, delay));
        } else {
            // They tell more finely what commands tell of the clocks.
            findings.retain(|f| !f.is_of_clocks());
            findings.extend(apart);
            is_other = true;
        }
    }
    // Where the tip is not where the camera sees it, touches tell no time; and where something else makes them late, none of the clocks'.
    let is_apart = findings.iter().any(|f| is_wrong(f) && f.is_of_frames());
    is_other |= findings.iter().any(|f| {
        matches!(
            f,
            Finding::Scaled { .. }
                | Finding::Bent { .. }
                | Finding::Swelling { .. }
                | Finding::StateClock { .. }
        )
    });
    let is_sure = delay.filter(|delay| !is_apart && !is_other && delay.is_sure());
    // By touches alone the tip is looked up at their time.
    findings.extend(is_sure.map(|delay| Finding::EncoderDelay {
        log: None,
        delay,
        misleads: delay.misleads(is_by_state),
    }));
    // What an arm delivers is read as its tip touches: a camera that is late in a log has it read as the arm brakes.
    let is_untimely = |f: &Finding| f.is_of_clocks() || matches!(f, Finding::EncoderDelay { .. });
    if !findings.iter().any(|f| is_wrong(f) || is_untimely(f)) {
        findings.extend(delivers_apart(logs, &paired));
    }
    // It tells more finely what the commands tell of the clocks.
    let is_told = |f: &Finding| matches!(f, Finding::EncoderDelay { .. });
    if findings.iter().any(is_told) {
        findings.retain(|f| !matches!(f, Finding::ClockOffset { certain: false, .. }));
    }
    Check {
        measured: Measured {
            paired: all.len(),
            turn: frames::turn(&all),
            speed_ratio: median(
                all.iter()
                    .filter(|p| p.command.speed > 0.0)
                    .map(Pair::speed_ratio),
            ),
            rise_to_motion: median(all.iter().map(|pair| pair.lag)),
            encoder_to_camera: delay,
            noise_at_rest: median(noises),
            frames_lost: share,
            coverage,
        },
        findings,
    }
}

/// The finding that two cameras, or trackers, write to one topic.
fn two_sources(log: &LogRead<'_>) -> Option<Finding> {
    /// Frames of a resting object that tell it.
    const FRAMES: u64 = 100;
    let Seen {
        resting,
        alternating,
        alternating_by,
        ..
    } = log.seen;
    (*resting >= FRAMES && 2 * alternating > *resting).then(|| Finding::TwoSources {
        log: log.name.into(),
        apart: alternating_by / *alternating as f64,
    })
}

/// What a stated turn of the base hides: a constant error of heading looks like a base that is turned a little farther.
fn base_turns(rig: &Rig, pairs: &[Pair]) -> Option<Finding> {
    let is_turned = rig.frames.command == CommandFrame::Base;
    let base_yaw = rig.robot.base_yaw.filter(|_| is_turned)?;
    let left = frames::turn(pairs)?;
    Some(Finding::BaseTurns { base_yaw, left })
}

/// Share of lost frames from which they are told.
const MOST_LOST: f64 = 0.05;
/// Shares of frames that lie elsewhere than any object gets: from the first on tracks suffer, from the second on none is one object's.
const JUMPS: f64 = 0.05;
const TORN: f64 = 0.2;

/// The finding that centroids jump to and fro: two objects, or an object and what looks like it.
fn jumps(logs: &[LogRead<'_>]) -> Vec<Finding> {
    /// In one of so many strikes another object is tracked for a while.
    const MANY: usize = 10;
    let share = |log: &LogRead<'_>| log.seen.jumps as f64 / log.seen.frames.max(1) as f64;
    let often = |log: &LogRead<'_>| {
        let bursts = log.seen.bursts as usize;
        bursts >= FEWEST && MANY * bursts >= log.seen.commands.len()
    };
    let torn = logs.iter().filter(|log| share(log) > JUMPS || often(log));
    torn.map(|log| Finding::Jumps {
        log: log.name.into(),
        share: share(log),
        bursts: log.seen.bursts,
        certain: share(log) > TORN,
    })
    .collect()
}

/// Whether most of what was rejected of this log is in another unit: what jumps there jumps by millimetres.
fn is_in_other_unit(log: &LogRead<'_>) -> bool {
    let unit = RejectReason::UnitsImplausible;
    let in_unit = log.rejects.iter().filter(|r| r.reason == unit).count();
    2 * in_unit > log.rejects.len()
}

/// Greatest ratio of an object's launch speed to the tip's by an impact: (1 + e)·M/(M + m) is at most 2, and the first frames are noisy.
const FASTEST: f64 = 2.3;

/// Whether positions and commands are in one unit.
fn speeds(rig: &Rig, pairs: &[Pair]) -> Option<Finding> {
    let ratio = median(pairs.iter().map(Pair::speed_ratio))?;
    let is_possible = (WEAKEST..FASTEST).contains(&ratio);
    (pairs.len() >= FEWEST && !is_possible).then(|| Finding::Scale {
        ratio,
        strikes: pairs.len(),
        topic: rig.topics.centroid.name.clone(),
    })
}

/// Whether most commands lie outside what the rig file says that this arm may be commanded.
fn limits(rig: &Rig, pairs: &[Pair], commanded: bool) -> Vec<Finding> {
    let of = |limit: Limit, value: fn(&Pair) -> f64, low: f64, high: f64, slack: f64| {
        let values: Vec<f64> = pairs.iter().map(value).collect();
        let is_outside = |value: &&f64| !(low - slack..=high + slack).contains(*value);
        let outside = values.iter().filter(is_outside).count();
        let (least, most) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| {
                (least.min(*v), most.max(*v))
            });
        (pairs.len() >= FEWEST && 2 * outside > pairs.len()).then(|| Finding::OutsideLimits {
            log: None,
            ratio: median(pairs.iter().map(Pair::speed_ratio)),
            others: None,
            commanded,
            limit,
            outside,
            strikes: pairs.len(),
            low: least,
            high: most,
        })
    };
    let (speed, angle) = (rig.robot.speed, rig.robot.angle);
    [
        of(
            Limit::Speed,
            |p| p.command.speed,
            speed.low,
            speed.high,
            0.05 * speed.high,
        ),
        of(
            Limit::Angle,
            |p| p.command.angle,
            angle.low,
            angle.high,
            0.02,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Whether most commands of one log lie outside those limits, where its objects also leave at quite another part of the commanded speed than `all`
/// do, in the sense of another unit: faster commands, and a lesser part of them.
fn log_limits(rig: &Rig, log: &LogRead<'_>, pairs: &[Pair], all: &[Pair]) -> Option<Finding> {
    /// Ratio of both parts that no friction and no impact makes.
    const TIMES: f64 = 1.5;
    let mut found = limits(rig, pairs, !log.seen.is_by_state)
        .into_iter()
        .find(|found| {
            let limit = |f: &Finding| match f {
                Finding::OutsideLimits { limit, .. } => Some(*limit),
                _ => None,
            };
            limit(found) == Some(Limit::Speed)
        })?;
    let is_own = |one: &Pair| pairs.iter().any(|p| p.command.rise == one.command.rise);
    let rest: Vec<&Pair> = all.iter().filter(|pair| !is_own(pair)).collect();
    let speeds = |of: &mut dyn Iterator<Item = f64>| median(of);
    let faster = speeds(&mut pairs.iter().map(|p| p.command.speed))?
        / speeds(&mut rest.iter().map(|p| p.command.speed))?;
    let usual = median(rest.iter().map(|pair| pair.speed_ratio()))?;
    let times = median(pairs.iter().map(Pair::speed_ratio))? / usual;
    let is_unit = times.ln().abs() > TIMES.ln() && times.ln() * faster.ln() < 0.0;
    if let Finding::OutsideLimits {
        log: name, others, ..
    } = &mut found
    {
        (*name, *others) = (Some(log.name.into()), Some(usual));
    }
    (is_unit && rest.len() >= FEWEST).then_some(found)
}

/// The finding that an arm moves at another speed than commanded, by its measured state: of all logs together, or of one.
fn delivers(logs: &[LogRead<'_>]) -> Option<Finding> {
    /// What an arm may deliver of the commanded speed, and the relative spread below which it is one share.
    const SHARES: std::ops::Range<f64> = 0.3..2.0;
    const ONE: f64 = 0.1;
    let of = |logs: &[LogRead<'_>], log: Option<&str>| {
        let meetings = logs.iter().flat_map(|log| &log.seen.meetings);
        let shares: Vec<f64> = meetings.filter_map(|m| m.delivered).collect();
        let (share, spread) = median_spread(&shares)?;
        let is_told = !SHARES.contains(&share) && spread < ONE * share;
        (is_told && shares.len() >= FEWEST).then(|| Finding::Delivers {
            log: log.map(str::to_owned),
            share,
            strikes: shares.len(),
        })
    };
    let of_one = |log| of(std::slice::from_ref(log), Some(log.name));
    of(logs, None).or_else(|| logs.iter().find_map(of_one))
}

/// A log in which the arm moves at another part of the commanded speed than in most, by its measured state, while objects leave as fast as in these.
fn delivers_apart(logs: &[LogRead<'_>], paired: &[Pairs]) -> Option<Finding> {
    /// Ratio of the parts that is told; how much of it objects may show; and the relative spread below which it is one part.
    const APART: f64 = 1.05;
    const SHOWN: f64 = 1.0 / 3.0;
    const ONE: f64 = 0.1;
    let each = logs.iter().zip(paired).filter_map(|(log, of)| {
        let shares: Vec<f64> = log
            .seen
            .meetings
            .iter()
            .filter_map(|m| m.delivered)
            .collect();
        let (share, spread) = median_spread(&shares)?;
        let launch = median(of.pairs.iter().map(Pair::speed_ratio))?;
        (shares.len() >= FEWEST && spread < ONE * share && launch > 0.0).then_some((
            log,
            shares.len(),
            share,
            launch,
        ))
    });
    let each: Vec<_> = each.collect();
    let parts: Vec<f64> = each.iter().map(|(_, _, share, _)| share.ln()).collect();
    let launches: Vec<f64> = each.iter().map(|(.., launch)| launch.ln()).collect();
    let (part, launch) = (usual(&parts)?, usual(&launches)?);
    each.iter().zip(parts.iter().zip(&launches)).find_map(
        |((log, strikes, share, _), (own, left))| {
            let apart = own - part;
            let is_told = apart.abs() > APART.ln() && (left - launch).abs() < SHOWN * apart.abs();
            is_told.then(|| Finding::Delivers {
                log: Some(log.name.into()),
                share: *share,
                strikes: *strikes,
            })
        },
    )
}

/// Logs of which many strikes were not kept, each with the reason that most were rejected for. What another log holds is no loss.
fn rejected(logs: &[LogRead<'_>]) -> Vec<Finding> {
    /// One in so many.
    const MANY: usize = 4;
    let many = logs.iter().filter_map(|log| {
        let lost = |reject: &&&Reject| reject.reason != RejectReason::Duplicate;
        let rejects: Vec<&&Reject> = log.rejects.iter().filter(lost).collect();
        let seen = log.kept + rejects.len();
        if seen < FEWEST || MANY * rejects.len() <= seen {
            return None;
        }
        let count = |reason| rejects.iter().filter(|r| r.reason == reason).count();
        let most = rejects.iter().max_by_key(|reject| count(reject.reason))?;
        Some(Finding::MostlyRejected {
            log: log.name.into(),
            rejected: rejects.len(),
            seen,
            reason: most.reason,
            count: count(most.reason),
            detail: most.detail.clone(),
        })
    });
    many.collect()
}

/// The finding that objects gather speed: a table only slows them down.
fn gathering(logs: &[LogRead<'_>]) -> Option<Finding> {
    /// Ratio of speeds from which it is told: noise is no more than this of a speed over a frame or two, in the middle of many.
    const TOLD: f64 = 1.2;
    let all: Vec<f64> = logs
        .iter()
        .flat_map(|log| &log.seen.gathered)
        .copied()
        .collect();
    let strikes = all.len();
    let times = median(all).filter(|times| strikes >= FEWEST && *times > TOLD)?;
    Some(Finding::Gathering { times, strikes })
}

/// The finding that objects begin to move little by little: they are tracked through a filter, or pushed for a while. Then they gain speed; an object
/// that brakes less at first than later looks the same in its way, but loses speed from the start.
fn swelling(logs: &[LogRead<'_>]) -> Option<Finding> {
    /// Variance in standard errors, and time (s) from which it is told, of as many strikes: a contact of 10 ms makes 2 ms, and an exposure of 33 ms
    /// makes 10.
    const ERRORS: f64 = 4.0;
    const TOLD: f64 = 0.012;
    const FEWEST: usize = 10;
    let of_all = |values: &dyn Fn(&LogRead<'_>) -> Vec<f64>| {
        let all: Vec<f64> = logs.iter().flat_map(values).collect();
        let (middle, spread) = median_spread(&all)?;
        Some((all.len(), middle, median_error(spread, all.len())))
    };
    let (strikes, smeared, error) = of_all(&|log| log.seen.smeared.clone())?;
    let seconds = (2.0 * smeared.max(0.0)).sqrt();
    let is_told = strikes >= FEWEST && seconds > TOLD && smeared > ERRORS * error;
    let risen = of_all(&|log| log.seen.risen.clone());
    let gains_speed = risen.is_some_and(|(_, times, error)| times - error > 1.0);
    is_told.then_some(Finding::Swelling {
        seconds,
        gains_speed,
        strikes,
    })
}

/// Whether the stated object may be made of anything: a size or a mass in another unit.
fn density(rig: &Rig) -> Option<Finding> {
    /// Range of densities of materials, from foam to osmium, in kg/m³.
    const MATERIALS: std::ops::Range<f64> = 15.0..23_000.0;
    let volume = match rig.object.solid {
        Solid::Cylinder {
            radius,
            half_height,
        } => 2.0 * PI * radius * radius * half_height,
        Solid::Box {
            half_size: [x, y, z],
        } => 8.0 * x * y * z,
        Solid::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
    };
    let density = rig.object.mass / volume;
    (!MATERIALS.contains(&density)).then_some(Finding::Density { density })
}

/// Logs whose objects leave turned against those of the others by more than an arm differs by from day to day: the camera or the arm's base
/// was moved.
fn sessions(logs: &[LogRead<'_>], paired: &[Pairs], known: &[Finding]) -> Vec<Finding> {
    let turn = |pair: &Pair| statistics::wrapped(pair.heading() - pair.command.angle);
    // An arm may err by the angle, of which sessions may strike others: as each log shows it by itself.
    let within = paired.iter().flat_map(|of| {
        let middle_of = |value: &dyn Fn(&Pair) -> f64| {
            let values: Vec<f64> = of.pairs.iter().map(value).collect();
            statistics::middle(&values).map_or(0.0, |(middle, _)| middle)
        };
        let middle = (middle_of(&|p| p.command.angle), middle_of(&turn));
        let beside = |one: f64, other: f64| statistics::wrapped(one - other);
        let pairs = of.pairs.iter();
        pairs.map(move |p| (beside(p.command.angle, middle.0), beside(turn(p), middle.1)))
    });
    let within: Vec<(f64, f64)> = within.collect();
    let by_angle = statistics::line(&within).map_or(0.0, |line| line.slope);
    let turns = paired.iter().map(|of| {
        let turns = of
            .pairs
            .iter()
            .map(|p| turn(p) - by_angle * p.command.angle);
        let turns: Vec<f64> = turns.collect();
        let (middle, spread) = statistics::middle(&turns).filter(|_| turns.len() >= FEWEST)?;
        Some((middle, median_error(spread, turns.len()), turns.len()))
    });
    let turns: Vec<Option<(f64, f64, usize)>> = turns.collect();
    let all: Vec<f64> = turns.iter().flatten().map(|turn| turn.0).collect();
    // Of two, the first one stands for both.
    let usual = match all[..] {
        [first, _] => Some(first),
        _ => statistics::middle(&all).map(|(usual, _)| usual),
    };
    let is_known = |name: &str| {
        let is_its =
            |f: &Finding| matches!(f, Finding::Turned { log: Some(log), .. } if log == name);
        known.iter().any(is_its)
    };
    let each = logs.iter().zip(turns);
    each.filter_map(|(log, turn)| {
        let (turn, error, strikes) = turn?;
        let by = statistics::wrapped(turn - usual?);
        let is_turned = by.abs() > MOVED.max(MOVED_ERRORS * error) && !is_known(log.name);
        is_turned.then(|| Finding::SessionTurned {
            log: log.name.into(),
            by,
            error,
            strikes,
        })
    })
    .collect()
}

/// Logs whose objects leave at another part of the commanded speed than those of the others: speeds are commanded in another unit, or through
/// an override, or the camera has another scale.
fn session_speeds(logs: &[LogRead<'_>], paired: &[Pairs]) -> Vec<Finding> {
    /// Ratio of speeds that is told, the least number of strikes that show it, and the relative difference within which commanded speeds compare.
    const TIMES: f64 = 1.5;
    const FEWEST: usize = 8;
    // From so many times on, and so many standard errors, it is told.
    const TOLD: f64 = 1.15;
    const ERRORS: f64 = 5.0;
    const NEAR: f64 = 0.05;
    // Logarithms of the launch speed in the commanded one, of each log that struck at a speed.
    let mut by_speed: BTreeMap<i64, BTreeMap<usize, Vec<f64>>> = BTreeMap::new();
    for (log, of) in paired.iter().enumerate() {
        for pair in &of.pairs {
            let ratio = pair.speed_ratio().ln();
            if ratio.is_finite() && pair.command.speed > 0.0 {
                let speed = (pair.command.speed.ln() / NEAR).floor() as i64;
                let at_speed = by_speed.entry(speed).or_default();
                at_speed.entry(log).or_default().push(ratio);
            }
        }
    }
    let mut beside: Vec<Vec<f64>> = vec![Vec::new(); logs.len()];
    for at_speed in by_speed.values() {
        let middles = at_speed
            .values()
            .map(|ratios| median(ratios.iter().copied()));
        let middles: Vec<f64> = middles.flatten().collect();
        let usual = usual(&middles);
        for (log, ratios) in at_speed {
            beside[*log].extend(usual.iter().flat_map(|u| ratios.iter().map(move |r| r - u)));
        }
    }
    let each = logs.iter().zip(beside);
    each.filter_map(|(log, beside)| {
        let strikes = beside.len();
        let (middle, spread) = median_spread(&beside)?;
        let error = median_error(spread, strikes);
        let is_told = middle.abs() > TOLD.ln().max(ERRORS * error);
        let certain = middle.abs() > TIMES.ln();
        (strikes >= FEWEST && (is_told || certain)).then(|| Finding::SessionSpeed {
            log: log.name.into(),
            times: middle.exp(),
            strikes,
            certain,
        })
    })
    .collect()
}

/// The median of several logs' values; where as many lie on either side of it, that of the first one's side. None of one alone.
fn usual(of_logs: &[f64]) -> Option<f64> {
    let [first, _, ..] = of_logs else {
        return None;
    };
    let mut sorted = of_logs.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
    let is_low = (low - first).abs() <= (high - first).abs();
    Some(if is_low { low } else { high })
}

/// The camera's noise at rest beside the rig file's.
fn noise(rig: &Rig, logs: &[LogRead<'_>]) -> Option<Finding> {
    /// Ratio of noises from which the difference is told.
    const OTHER: f64 = 3.0;
    let measured = median(logs.iter().filter_map(|log| log.seen.noise_at_rest()))?;
    let stated = rig.camera.noise;
    (measured > OTHER * stated).then_some(Finding::Noise { measured, stated })
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::*;

    #[test]
    fn a_session_whose_speeds_mean_something_else_is_told_and_one_of_a_slower_arm_is_not() {
        let seen = ingest::Seen::default();
        let logs = ["one.mcap", "two.mcap", "three.mcap"].map(|name| LogRead {
            name,
            seen: &seen,
            kept: 40,
            rejects: Vec::new(),
        });
        let told = |unit: f64, gain: f64| {
            let of = |unit: f64, gain: f64| Pairs {
                pairs: (0..40)
                    .map(|i| {
                        let delivered = 0.4 + 0.6 * (0.618 * i as f64).fract();
                        let leaves = Point::new(gain * delivered, 0.0);
                        Pair::made(i, [unit * delivered, 0.0], leaves, 0.1)
                    })
                    .collect(),
                ..Pairs::default()
            };
            let paired = [of(1.0, 1.5), of(unit, gain), of(1.0, 1.5)];
            session_speeds(&logs, &paired)
        };
        assert_eq!(told(1.0, 1.4), []);
        // As another tip may do, or a camera of another scale.
        let found = told(1.0, 1.2);
        assert!(
            matches!(&found[..], [Finding::SessionSpeed { certain: false, .. }]),
            "{found:?}"
        );
        let found = told(2.0, 1.5);
        assert!(
            matches!(&found[..], [Finding::SessionSpeed { log, times, certain: true, .. }]
                if log == "two.mcap" && (times - 0.5).abs() < 0.03),
            "{found:?}"
        );
    }

    fn read(seen: &ingest::Seen) -> LogRead<'_> {
        LogRead {
            name: "two.mcap",
            seen,
            kept: 40,
            rejects: Vec::new(),
        }
    }

    #[test]
    fn a_log_whose_commands_are_in_another_unit_is_told_and_one_of_faster_strikes_is_not() {
        let rig = Rig::demo(values::Shape::Cylinder);
        let told = |unit: f64, ratio: f64| {
            let made = |first: usize, unit: f64, ratio: f64| -> Vec<Pair> {
                (first..first + 30)
                    .map(|i| {
                        let share = (0.618 * i as f64).fract();
                        let speed = rig.robot.speed.low
                            + share * (rig.robot.speed.high - rig.robot.speed.low);
                        Pair::made(
                            i,
                            [unit * speed, 0.0],
                            Point::new(ratio * unit * speed, 0.0),
                            0.1,
                        )
                    })
                    .collect()
            };
            let own = made(30, unit, ratio);
            let all: Vec<Pair> = made(0, 1.0, 1.2).into_iter().chain(own.clone()).collect();
            log_limits(&rig, &read(&ingest::Seen::default()), &own, &all)
        };
        assert!(matches!(
            told(3.6, 1.2 / 3.6),
            Some(Finding::OutsideLimits {
                log: Some(_),
                limit: Limit::Speed,
                outside: 30,
                others: Some(_),
                ..
            })
        ));
        // Strikes beyond what the rig file states, and slower ones that friction brakes at once.
        assert_eq!(told(3.6, 1.3), None);
        assert_eq!(told(0.3, 0.6), None);
    }

    /// What was seen of thirty strikes at 0.5 m/s that an arm delivered so much of, with this relative spread.
    fn seen_of(share: f64, spread: f64) -> ingest::Seen {
        let meetings = (0..30).map(|i| ingest::Meeting {
            tip: Point::default(),
            velocity: Point::new(0.5, 0.0),
            moved: None,
            object: Point::default(),
            pushed: None,
            earlier: 0.0,
            at: 6.0 * i as f64,
            command: values::Command::new(0.5, 0.0),
            delay: None,
            delivered: Some(share * (1.0 + spread * (3.7 * i as f64).sin())),
        });
        ingest::Seen {
            meetings: meetings.collect(),
            ..ingest::Seen::default()
        }
    }

    #[test]
    fn an_arm_that_moves_at_no_share_of_its_commands_is_told_and_one_of_an_override_is_not() {
        let told = |share: f64, spread: f64| {
            let seen = seen_of(share, spread);
            delivers(&[read(&seen)])
        };
        for unit in [1.0 / 3.6, 3.6] {
            let found = told(unit, 0.02);
            assert!(
                matches!(found, Some(Finding::Delivers { share, strikes: 30, .. }) if (share / unit - 1.0).abs() < 0.02),
                "{found:?}"
            );
        }
        assert_eq!(told(0.5, 0.02), None);
        assert_eq!(told(0.25, 0.5), None);
    }

    #[test]
    fn a_state_that_is_slower_in_one_log_is_told_where_objects_do_not_follow_it() {
        let told = |share: f64, launch: f64| {
            let pairs = |launch: f64| Pairs {
                pairs: (0..20)
                    .map(|i| Pair::made(i, [0.5, 0.0], Point::new(0.7 * launch, 0.0), 0.2))
                    .collect(),
                ..Pairs::default()
            };
            let seen = [1.0, share, 1.0].map(|share| seen_of(share, 0.01));
            let logs = seen.iter().map(read).collect::<Vec<_>>();
            delivers_apart(&logs, &[pairs(1.0), pairs(launch), pairs(1.0)])
        };
        let found = told(0.8, 1.0);
        assert!(
            matches!(&found, Some(Finding::Delivers { share, .. }) if (share - 0.8).abs() < 0.02),
            "{found:?}"
        );
        assert_eq!(told(0.8, 0.8), None);
        assert_eq!(told(0.99, 1.0), None);
    }

    #[test]
    fn of_two_halves_the_first_one_is_usual() {
        assert_eq!(usual(&[0.1]), None);
        assert_eq!(usual(&[0.3, 0.1]), Some(0.3));
        assert_eq!(usual(&[0.1, 0.9, 0.2]), Some(0.2));
        assert_eq!(usual(&[0.1, 0.12, 0.9, 0.8]), Some(0.12));
        assert_eq!(usual(&[0.9, 0.8, 0.1, 0.12]), Some(0.8));
    }
}
