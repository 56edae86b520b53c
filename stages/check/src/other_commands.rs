//! Objects that leave as the command before or after their own says: one message of commands was lost, doubled or queued, and from there on each strike
//! has another's.
//!
//! Headings alone are compared, and no gain of them is taken for granted: over the stretch of strikes that gains most, a line through the other
//! commands leaves at most a fifth of the headings' variance, and at most a fourth of what a line through their own leaves.

use crate::finding::Finding;
use crate::pairs::Pair;
use crate::statistics::{middle, wrapped};

/// Offsets of the other command that are tried, in the order of strikes.
const PLACES: [isize; 4] = [1, -1, 2, -2];
/// Number of strikes in a row from which it is told.
const FEWEST: usize = 10;
/// Greatest part of the headings' variance that the other commands may leave, and greatest ratio of it to what their own leave.
const LEFT: f64 = 0.2;
const LESS: f64 = 0.25;
/// Greatest difference of a heading, in rad, that counts.
const FARTHEST: f64 = 0.6;

/// The finding that a log's objects leave as other commands say; none where they do not.
pub(crate) fn findings(pairs: &[Pair], log: &str) -> Option<Finding> {
    let angles: Vec<f64> = pairs.iter().map(|pair| pair.command.angle).collect();
    let headings: Vec<f64> = pairs.iter().map(Pair::heading).collect();
    let turned = |by: isize| {
        let each = (0..angles.len()).filter_map(|i| {
            let of = i.checked_add_signed(by)?;
            Some(wrapped(headings[i] - angles.get(of)?))
        });
        middle(&each.collect::<Vec<f64>>())
    };
    let own = turned(0)?;
    let found = PLACES.into_iter().filter_map(|by| {
        // All are turned alike, as those commands show that most objects follow.
        let others = turned(by)?;
        let (usual, _) = if others.1 < own.1 { others } else { own };
        let off = |i: usize, of: usize| {
            let off = wrapped(headings[i] - usual - angles[of]);
            off.abs().min(FARTHEST).powi(2)
        };
        let other = |i: usize| {
            i.checked_add_signed(by)
                .filter(|other| *other < angles.len())
        };
        let gains = (0..angles.len()).map(|i| other(i).map_or(0.0, |of| off(i, i) - off(i, of)));
        let (from, until, gain) = best_stretch(gains);
        let stretch: Vec<usize> = (from..until).filter(|i| other(*i).is_some()).collect();
        let left = |of: &dyn Fn(usize) -> usize| {
            let points = stretch
                .iter()
                .map(|i| (angles[of(*i)], headings[*i] - usual));
            unexplained(points)
        };
        let by_own = left(&|i| i);
        let by_others = left(&|i| i.saturating_add_signed(by));
        let is_other = stretch.len() >= FEWEST && by_others < LEFT && by_others < LESS * by_own;
        is_other.then_some((gain, by, from, stretch.len()))
    });
    let (_, by, from, count) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Finding::OtherCommands {
        log: log.into(),
        by,
        others: count,
        strikes: pairs.len(),
        first: from + 1,
    })
}

/// The stretch with the greatest sum, and the sum.
fn best_stretch(gains: impl Iterator<Item = f64>) -> (usize, usize, f64) {
    let (mut best, mut from, mut sum) = ((0, 0, 0.0), 0, 0.0);
    for (i, gain) in gains.enumerate() {
        if sum <= 0.0 {
            (from, sum) = (i, 0.0);
        }
        sum += gain;
        if sum > best.2 {
            best = (from, i + 1, sum);
        }
    }
    best
}

/// Part of the variance of y that no line through x with a slope above 0 explains; all where x does not vary.
fn unexplained(points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let n = points.clone().count() as f64;
    let (x, y) = points
        .clone()
        .fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + wrapped(p.1) / n));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for p in points {
        let (x, y) = (p.0 - x, wrapped(p.1) - y);
        (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
    }
    match xx > 0.0 && xy > 0.0 && yy > 0.0 {
        true => 1.0 - xy * xy / (xx * yy),
        false => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::*;

    /// Sixty strikes at scattered angles, or at angles that rise, of which those from here on were struck by the command `by` places on; a box leaves
    /// at 0.6 times its angle.
    fn found(from: usize, by: isize, gain: f64, is_sorted: bool) -> Option<Finding> {
        let angle = |i: usize| match is_sorted {
            true => -0.8 + 1.6 * i as f64 / 60.0,
            false => -0.8 + 1.6 * (0.618 * i as f64).fract(),
        };
        let pairs: Vec<Pair> = (0..60)
            .map(|i| {
                let of = if i >= from {
                    i.saturating_add_signed(by)
                } else {
                    i
                };
                let heading = 0.1 + gain * angle(of) + 0.035 * (5.1 * i as f64).sin();
                Pair::made(i, [0.7, angle(i)], Point::polar(0.8, heading), 0.2)
            })
            .collect();
        findings(&pairs, "one.mcap")
    }

    #[test]
    fn commands_of_the_strike_before_or_after_are_told_from_where_they_begin() {
        for gain in [1.0, 0.6] {
            for (from, place) in [(0, 1), (33, 1), (20, -1), (45, -2)] {
                let told = found(from, place, gain, false);
                let Some(Finding::OtherCommands {
                    by, others, first, ..
                }) = told
                else {
                    panic!("{told:?} from {from} by {place}");
                };
                let affected = 60 - from - place.unsigned_abs().min(if place > 0 { 2 } else { 0 });
                assert_eq!(by, place);
                assert!(
                    others.abs_diff(affected) <= 2 && first.abs_diff(from + 1) <= 2,
                    "{told:?}"
                );
            }
            assert_eq!(found(60, 1, gain, false), None);
        }
    }

    #[test]
    fn neighbours_that_are_nearly_the_same_say_nothing_and_few_are_no_stretch() {
        assert_eq!(found(30, 1, 1.0, true), None);
        assert_eq!(found(54, -1, 1.0, false), None);
    }
}
