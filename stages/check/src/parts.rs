//! Logs of which a part is another set-up's: from some strike on the camera stands elsewhere, speeds are commanded through an override, or commands
//! are in another frame.
//!
//! Where a log is parted best, both parts are asked what a whole log is asked ([`frames`]). What they then only differ in is a step: of an object's
//! heading beside the commanded angle, and of its speed in the commanded one. Both also hang on the angle, the speed and the place, which
//! may come in order, and drift: a step is what none of these explains.

use nalgebra::{DMatrix, DVector};

use crate::finding::{Finding, Severity};
use crate::frames;
use crate::pairs::Pair;
use crate::statistics::{line, median, middle, wrapped};

/// Step of the heading, in rad, and in standard errors, that no arm makes from day to day: the camera, or the arm's base, was moved. A step as great
/// of a speed (relative), or of a time (s), is told as well.
pub(crate) const MOVED: f64 = 0.1;
/// Standard errors of a step at the best of [`PLACES`] places, of each of many logs.
pub(crate) const MOVED_ERRORS: f64 = 6.0;
/// Least number of strikes on each side of a step, and number of places that are tried.
const SIDE: usize = 6;
const PLACES: usize = 60;
/// Number of strikes on each side from which each part is checked as a whole log is.
pub(crate) const PART: usize = 10;
/// Deviations of headings (rad) and of speeds (relative) below which lines are equally good.
const ALIKE: f64 = 0.01;
/// Least number of strikes on each side that are of the same speeds, and of the same angles.
const COMMON: usize = 3;
/// Margin by which a step must explain better than a drift (logarithm of the likelihood).
const BETTER: f64 = 6.0;
/// Speed below which a motion is slower than any strike, and not the command's, in m/s.
const SLOWEST: f64 = 0.02;
/// Part of a step of speeds that must be there as objects begin to move.
const LAUNCHED: f64 = 0.5;
/// Least number of strikes for each term of a fit.
const FOR_A_TERM: usize = 4;

/// The findings that a part of one log is another set-up's.
pub(crate) fn findings(log: &str, pairs: &[Pair], is_logged: bool) -> Vec<Finding> {
    let moves =
        |pair: &&Pair| pair.speed_ratio().ln().is_finite() && pair.motion.velocity.norm() > SLOWEST;
    let pairs: Vec<Pair> = pairs.iter().filter(moves).copied().collect();
    let parts = in_parts(log, &pairs, is_logged);
    if !parts.is_empty() {
        return parts;
    }
    let turns: Vec<f64> = pairs
        .iter()
        .map(|pair| wrapped(pair.heading() - pair.command.angle))
        .collect();
    let usual = middle(&turns).map_or(0.0, |(usual, _)| usual);
    let turns: Vec<f64> = turns.iter().map(|turn| wrapped(turn - usual)).collect();
    let speeds: Vec<f64> = pairs.iter().map(|pair| pair.speed_ratio().ln()).collect();
    let turned = step(&pairs, &turns, MOVED).map(|step| Finding::TurnedWithin {
        log: log.into(),
        strike: step.at + 1,
        by: step.by,
        error: step.error,
    });
    // What brakes them changes the speeds of a tenth of a second, too: a table that was wiped is no other set-up.
    let at_first: Vec<f64> = pairs
        .iter()
        .map(|pair| (pair.motion.at_first / pair.command.speed).ln())
        .collect();
    let is_launched = |step: &Step| {
        let by = by_from(&pairs, &at_first, step.at);
        by.is_none_or(|by| by * step.by.signum() > LAUNCHED * step.by.abs())
    };
    let faster = step(&pairs, &speeds, MOVED).filter(is_launched);
    let faster = faster.map(|step| Finding::SpeedWithin {
        log: log.into(),
        strike: step.at + 1,
        times: step.by.exp(),
        error: step.error * step.by.exp(),
    });
    turned.into_iter().chain(faster).collect()
}

/// The finding that from some strike of a log on the time from command to motion is another.
pub(crate) fn clock_step(log: &str, pairs: &[Pair]) -> Option<Finding> {
    let lags: Vec<f64> = pairs.iter().map(|pair| pair.lag).collect();
    let step = step(pairs, &lags, MOVED)?;
    Some(Finding::ClockStep {
        log: log.into(),
        strike: step.at + 1,
        by: step.by,
        error: step.error,
        untimely: pairs.iter().filter(|pair| !pair.is_timely()).count(),
        by_touch: false,
    })
}

/// What is wrong with the strikes before and after the place at which lines through headings and speeds part best.
fn in_parts(log: &str, pairs: &[Pair], is_logged: bool) -> Vec<Finding> {
    let misfit = |at: &usize| {
        let (before, after) = pairs.split_at(*at);
        Some((*at, misfit(before)? + misfit(after)?))
    };
    let best = |places: &mut dyn Iterator<Item = usize>| {
        let all = places.filter_map(|at| misfit(&at));
        all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
    };
    let (first, last) = (PART, (pairs.len() + 1).saturating_sub(PART));
    let every = last.saturating_sub(first).div_ceil(PLACES).max(1);
    let found = best(&mut (first..last).step_by(every));
    let found = found.and_then(|at| {
        let near = at.saturating_sub(every).max(first)..(at + every).min(last);
        best(&mut near.into_iter())
    });
    let Some(at) = found else {
        return Vec::new();
    };
    let of = |from: usize, to: usize| {
        let wrong = frames::findings(&pairs[from..to], None, is_logged).into_iter();
        // What is vague may be chance, at the best of many places; a turn is a step.
        let is_told = |finding: &Finding| {
            let is_other = matches!(
                finding,
                Finding::Unrelated { .. }
                    | Finding::Turned {
                        mirrored: false,
                        ..
                    }
            );
            finding.severity() == Severity::Meaningless && !is_other
        };
        let wrong = wrong.filter(is_told);
        wrong.map(move |finding| Finding::InPart {
            log: log.into(),
            first: from + 1,
            last: to,
            what: Box::new(finding),
        })
    };
    of(0, at).chain(of(at, pairs.len())).collect()
}

/// The logarithm of the likelihood, but for its sign, of headings and speeds about lines through them, whose deviations are as they are there.
fn misfit(pairs: &[Pair]) -> Option<f64> {
    let headings: Vec<f64> = pairs.iter().map(Pair::heading).collect();
    let (usual, _) = middle(&headings)?;
    let headings = pairs.iter().zip(headings);
    let headings = headings.map(|(pair, one)| (pair.command.angle, wrapped(one - usual)));
    let speeds = pairs
        .iter()
        .map(|p| (p.command.speed.ln(), p.motion.velocity.norm().ln()));
    let left = |points: Vec<(f64, f64)>| {
        let values = |of: fn(&(f64, f64)) -> f64| points.iter().map(of);
        let usual = median(values(|p| p.0))?;
        // One strike among many of one command tells no slope.
        let varies = median(values(|p| p.0).map(|x| (x - usual).abs()))? > ALIKE;
        let through = line(&points).filter(|_| varies);
        let (at_zero, slope) = match through {
            Some(line) => (line.at_zero, line.slope),
            None => (median(values(|p| p.1))?, 0.0),
        };
        let left = points.iter().map(|p| (p.1 - at_zero - slope * p.0).abs());
        Some((left.sum::<f64>() / points.len() as f64).max(ALIKE).ln())
    };
    Some(pairs.len() as f64 * (left(headings.collect())? + left(speeds.collect())?))
}

/// A step: by how much values are greater from this strike on (the first one is 0), with its standard error, and what strikes scatter by beside it.
pub(crate) struct Step {
    pub(crate) at: usize,
    pub(crate) by: f64,
    pub(crate) error: f64,
    deviation: f64,
}

impl Step {
    /// How far it stands out of the scatter.
    pub(crate) fn clearness(&self) -> f64 {
        self.by.abs() / self.deviation
    }
}

/// The step by at least so much that explains these values best, where it surely is one, and greater than the strikes' own scatter.
pub(crate) fn step(pairs: &[Pair], values: &[f64], least: f64) -> Option<Step> {
    let places = SIDE..(values.len() + 1).saturating_sub(SIDE);
    let every = places.len().div_ceil(PLACES).max(1);
    let stepped = places.step_by(every).filter_map(|at| {
        let fit = Fit::through(pairs, values, |i| f64::from(u8::from(i >= at)))?;
        Some((at, fit.deviation))
    });
    let (at, _) = stepped.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let found = step_at(pairs, values, at, least)?;
    let drifts = Fit::through(pairs, values, |i| i as f64)?;
    let better = values.len() as f64 * (drifts.deviation / found.deviation).ln();
    (better > BETTER).then_some(found)
}

/// The step at this place, where it surely is one or the other: a drift may be it, too.
pub(crate) fn step_at(pairs: &[Pair], values: &[f64], at: usize, least: f64) -> Option<Step> {
    let fit = Fit::through(pairs, values, |i| f64::from(u8::from(i >= at)))?;
    let by = fit.by.abs();
    let is_step = by > least.max(MOVED_ERRORS * fit.error) && by > fit.deviation;
    let is_step = is_step && are_alike(pairs, at);
    is_step.then_some(Step {
        at,
        by: fit.by,
        error: fit.error,
        deviation: fit.deviation,
    })
}

/// By how much values are greater from this strike on, sure or not.
pub(crate) fn by_from(pairs: &[Pair], values: &[f64], at: usize) -> Option<f64> {
    Fit::through(pairs, values, |i| f64::from(u8::from(i >= at))).map(|fit| fit.by)
}

/// Whether strikes of the same speeds and angles lie on both sides: else it may be what the arm makes of them.
fn are_alike(pairs: &[Pair], at: usize) -> bool {
    let (before, after) = pairs.split_at(at);
    let of: [fn(&Pair) -> f64; 2] = [|p| p.command.speed, |p| p.command.angle];
    of.into_iter().all(|of| {
        let range = |side: &[Pair]| {
            let values = side.iter().map(of);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            (low, values.fold(f64::NEG_INFINITY, f64::max))
        };
        let (one, other) = (range(before), range(after));
        let both = one.0.max(other.0)..=one.1.min(other.1);
        let common = |side: &[Pair]| side.iter().filter(|p| both.contains(&of(p))).count();
        common(before).min(common(after)) >= COMMON
    })
}

/// Values by a term that is asked for, beside what angle, speed and place make of them.
struct Fit {
    /// Coefficient of the term, with its standard error.
    by: f64,
    error: f64,
    /// Mean absolute deviation about the fit.
    deviation: f64,
}

impl Fit {
    /// The fit by least absolute deviations, which single wrong pairs do not move far.
    fn through(pairs: &[Pair], values: &[f64], term: impl Fn(usize) -> f64) -> Option<Self> {
        const ROUNDS: usize = 12;
        const RIDGE: f64 = 1e-6;
        let n = values.len();
        let beside: [fn(&Pair) -> f64; 6] = [
            |p| p.command.angle,
            |p| p.command.speed,
            |p| p.motion.from.x,
            |p| p.motion.from.y,
            |p| p.command.angle.powi(2),
            |p| p.command.speed.powi(2),
        ];
        let count = beside.len().min((n / FOR_A_TERM).saturating_sub(2));
        let mut columns: Vec<Vec<f64>> = vec![vec![1.0; n], (0..n).map(term).collect()];
        columns.extend(
            beside[..count]
                .iter()
                .map(|of| scaled(pairs.iter().map(of).collect())),
        );
        let terms = columns.len();
        let rows = DMatrix::from_fn(n, terms, |i, j| columns[j][i]);
        let values = DVector::from_column_slice(values);
        let ridge = DMatrix::identity(terms, terms) * (RIDGE * n as f64);
        let mut weights = DVector::from_element(n, 1.0);
        let (mut fitted, mut left) = (DVector::zeros(terms), values.clone());
        for _ in 0..ROUNDS {
            let weighted = DMatrix::from_fn(n, terms, |i, j| rows[(i, j)] * weights[i]);
            let normal = weighted.transpose() * &rows + &ridge;
            fitted = normal.cholesky()?.solve(&(weighted.transpose() * &values));
            left = &values - &rows * &fitted;
            let least = 0.1 * left.iter().map(|v| v.abs()).sum::<f64>() / n as f64;
            weights = left.map(|v| least / v.abs().max(least).max(f64::MIN_POSITIVE));
        }
        let deviation = left.iter().map(|v| v.abs()).sum::<f64>() / n as f64;
        let inverse = (rows.transpose() * &rows + ridge).cholesky()?.inverse();
        let freedom = (n as f64 / (n.checked_sub(terms)? as f64).max(1.0)).sqrt();
        let spread = 1.2533 * deviation.max(f64::MIN_POSITIVE) * freedom;
        Some(Self {
            by: fitted[1],
            error: 1.2533 * spread * inverse[(1, 1)].sqrt(),
            deviation,
        })
    }
}

/// Values about their mean, in their spread; nothing where they do not vary.
fn scaled(values: Vec<f64>) -> Vec<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    let least = 1e-6 * mean.abs().max(1e-3);
    let of = |v: f64| {
        if spread > least {
            (v - mean) / spread
        } else {
            0.0
        }
    };
    values.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::*;

    /// Forty strikes of an arm that are made by this function of the strike's number and of what it was told (m/s, rad): what is logged, and how the
    /// object leaves.
    fn found(made: impl Fn(usize, [f64; 2]) -> ([f64; 2], [f64; 2])) -> Vec<Finding> {
        let pairs: Vec<Pair> = (0..40)
            .map(|i| {
                let part = |k: f64| (k * i as f64).fract();
                let told = [0.4 + 0.6 * part(0.414), -0.7 + 1.4 * part(0.618)];
                let (logged, [speed, heading]) = made(i, told);
                let noise = |k: f64| 0.05 * (k * i as f64).sin();
                let left = Point::polar(1.3 * speed * (1.0 + noise(3.3)), heading + noise(5.1));
                Pair::made(i, logged, left, 0.2)
            })
            .collect();
        findings("one.mcap", &pairs, true)
    }

    #[test]
    fn a_table_that_brakes_less_from_some_strike_on_is_no_other_set_up() {
        let pairs = |launches_too: bool| -> Vec<Pair> {
            let of = |i: usize| {
                let part = |k: f64| (k * i as f64).fract();
                let (speed, angle) = (0.4 + 0.6 * part(0.414), -0.7 + 1.4 * part(0.618));
                let launched = 1.3 * speed * (1.0 + 0.05 * (3.3 * i as f64).sin());
                let times = if i < 20 { 0.8 } else { 1.0 };
                let mut pair = Pair::made(i, [speed, angle], Point::polar(launched, angle), 0.2);
                pair.motion.velocity = pair.motion.velocity * times;
                if launches_too {
                    pair.motion.at_first *= times;
                }
                pair
            };
            (0..40).map(of).collect()
        };
        let is_found = |launches_too| {
            let found = findings("one.mcap", &pairs(launches_too), true);
            let mut found = found.iter();
            found.any(|one| matches!(one, Finding::SpeedWithin { .. }))
        };
        assert!(is_found(true) && !is_found(false));
    }

    #[test]
    fn a_part_that_is_commanded_in_another_way_is_found_by_what_it_is() {
        let tool = found(|i, told| (if i < 23 { told } else { [told[0], 0.0] }, told));
        assert!(
            matches!(&tool[..], [Finding::InPart { first: 23..=25, last: 40, what, .. }]
                if matches!(**what, Finding::ConstantHeading { .. })),
            "{tool:?}"
        );
        let speed = found(|i, told| {
            (
                if i < 13 {
                    [0.7 * told[0], told[1]]
                } else {
                    told
                },
                told,
            )
        });
        assert!(
            matches!(&speed[..], [Finding::SpeedWithin { strike: 12..=16, times, .. }]
                if (times - 0.7).abs() < 0.06),
            "{speed:?}"
        );
        let turned = found(|i, told| (told, [told[0], told[1] + if i < 30 { 0.0 } else { 0.3 }]));
        assert!(
            matches!(&turned[..], [Finding::TurnedWithin { strike: 29..=33, by, .. }]
                if (by - 0.3).abs() < 0.06),
            "{turned:?}"
        );
    }

    #[test]
    fn a_clock_that_is_set_is_told_and_a_longer_ramp_is_none() {
        let told = |late: &dyn Fn(usize) -> f64| {
            let pairs: Vec<Pair> = (0..40)
                .map(|i| {
                    let speed = 0.4 + 0.6 * (0.618 * i as f64).fract();
                    let lag = 0.1 + speed / 2.0 + 0.01 * (5.1 * i as f64).sin() + late(i);
                    Pair::made(i, [speed, 0.0], Point::new(speed, 0.0), lag)
                })
                .collect();
            clock_step("one.mcap", &pairs)
        };
        let set = told(&|i| if i < 28 { 0.0 } else { 2.0 });
        assert!(
            matches!(set, Some(Finding::ClockStep { strike: 29, by, untimely: 12, .. })
                if (by - 2.0).abs() < 0.05),
            "{set:?}"
        );
        assert_eq!(told(&|_| 0.0), None);
        assert_eq!(told(&|i| 0.02 * i as f64), None);
    }

    #[test]
    fn an_arm_that_errs_by_what_comes_in_order_and_what_drifts_is_one() {
        // A cap on the speed, angles that follow the half, commands in order of their speed, a tip that wears.
        let sorted = |i: usize| 0.4 + 0.6 * i as f64 / 40.0;
        let none: [Vec<Finding>; 5] = [
            found(|_, told| (told, told)),
            found(|i, told| {
                let delivered = sorted(i).min(0.7) - 0.15;
                ([sorted(i), told[1]], [delivered, told[1]])
            }),
            found(|i, told| ([sorted(i), told[1]], [sorted(i).min(0.75), told[1]])),
            found(|i, told| ([told[0], sorted(i)], [told[0], 0.6 * sorted(i)])),
            found(|i, told| (told, [told[0] * (1.0 - 0.008 * i as f64), told[1]])),
        ];
        for (case, found) in none.iter().enumerate() {
            assert_eq!(found[..], [], "{case}");
        }
    }
}
