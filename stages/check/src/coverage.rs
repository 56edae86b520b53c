//! What strikes cover: speeds, angles, places, repeats. What they do not cover they cannot tell.

use crate::finding::{Coverage, Finding};
use crate::pairs::Pair;

/// Number of strikes below which they are few: of many, 81 % are learnt from, and eight must be held out to judge.
const FEW: usize = 60;
/// Relative difference of speeds, difference of angles (rad) and distance of places (m) within which they count as one.
const ONE_SPEED: f64 = 0.1;
const ONE_ANGLE: f64 = 0.05;
const ONE_PLACE: f64 = 0.03;
/// Relative difference of speeds, difference of angles (rad) and distance of starts (m) within which strikes are repeats.
const SAME_SPEED: f64 = 0.01;
const SAME_ANGLE: f64 = 0.01;
const SAME_PLACE: f64 = 0.01;

impl Coverage {
    /// The coverage of pairs.
    pub(crate) fn of(pairs: &[Pair]) -> Self {
        if pairs.is_empty() {
            return Self::default();
        }
        let range = |value: &dyn Fn(&Pair) -> f64| {
            pairs
                .iter()
                .map(value)
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                    [low.min(v), high.max(v)]
                })
        };
        let is_repeat = |one: &Pair, other: &Pair| {
            (one.command.speed - other.command.speed).abs() < SAME_SPEED * one.command.speed
                && (one.command.angle - other.command.angle).abs() < SAME_ANGLE
                && one.motion.from.distance(other.motion.from) < SAME_PLACE
        };
        // By speed, so that each is compared with few.
        let mut sorted: Vec<&Pair> = pairs.iter().collect();
        sorted.sort_by(|a, b| a.command.speed.total_cmp(&b.command.speed));
        let repeats = (1..sorted.len())
            .filter(|at| {
                let one = sorted[*at];
                sorted[..*at]
                    .iter()
                    .rev()
                    .take_while(|other| {
                        one.command.speed - other.command.speed < SAME_SPEED * one.command.speed
                    })
                    .any(|other| is_repeat(one, other))
            })
            .count();
        Self {
            strikes: pairs.len(),
            speed: range(&|pair| pair.command.speed),
            angle: range(&|pair| pair.command.angle),
            x: range(&|pair| pair.motion.from.x),
            y: range(&|pair| pair.motion.from.y),
            repeats,
        }
    }

    /// A finding for each quantity that the strikes do not cover.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let width = |[low, high]: [f64; 2]| high - low;
        let extent = width(self.x).hypot(width(self.y));
        if self.strikes == 0 {
            return Vec::new();
        }
        [
            (self.strikes < FEW).then_some(Finding::FewStrikes {
                strikes: self.strikes,
            }),
            (width(self.speed) < ONE_SPEED * self.speed[1]).then_some(Finding::OneSpeed {
                speed: self.speed[1],
            }),
            (width(self.angle) < ONE_ANGLE).then_some(Finding::OneAngle {
                angle: self.angle[1],
            }),
            (extent < ONE_PLACE).then_some(Finding::OnePlace { extent }),
            (self.repeats == 0).then_some(Finding::NoRepeats),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}
