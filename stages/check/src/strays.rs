//! Objects that leave quite elsewhere than the others of their log do: no strikes, though each follows a command.
//!
//! A command that was given up, or that came while the object was carried, is followed by what a hand does; after a clock was set, or where
//! some commands are another robot's, every motion is another strike's. Headings of one log agree to far less than this.

use crate::finding::Finding;
use crate::pairs::{Pair, are_astray};

/// Number of strays, and share of all strikes, from which they are told; and the share that makes a model meaningless.
const FEWEST: usize = 4;
const TOLD: f64 = 0.08;
const MANY: f64 = 0.2;

/// The finding of one log's strays; none where there are too few.
pub(crate) fn findings(pairs: &[Pair], log: &str) -> Option<Finding> {
    let rises: Vec<f64> = pairs
        .iter()
        .zip(are_astray(pairs))
        .filter(|(_, is_astray)| *is_astray)
        .map(|(pair, _)| pair.command.rise)
        .collect();
    let share = rises.len() as f64 / pairs.len() as f64;
    (rises.len() >= FEWEST && share > TOLD).then(|| Finding::Strays {
        log: log.into(),
        strays: rises.len(),
        strikes: pairs.len(),
        from: rises[0] - pairs[0].command.rise,
        until: rises[rises.len() - 1] - pairs[0].command.rise,
        certain: share > MANY,
    })
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::*;

    /// Forty strikes, of which so many in a row lead where a hand went; others scatter by 2°, and leave at 0.6 times the angle.
    fn found(strays: std::ops::Range<usize>) -> Option<Finding> {
        let pairs: Vec<Pair> = (0..40)
            .map(|i| {
                let part = |k: f64| (k * i as f64).fract();
                let angle = -0.8 + 1.6 * part(0.618);
                let heading = if strays.contains(&i) {
                    1.2 + 3.5 * part(0.41)
                } else {
                    0.6 * angle + 0.035 * (5.1 * i as f64).sin()
                };
                Pair::made(i, [0.7, angle], Point::polar(0.8, heading), 0.2)
            })
            .collect();
        findings(&pairs, "one.mcap")
    }

    #[test]
    fn some_strays_are_told_and_many_make_a_model_meaningless() {
        assert_eq!(found(0..0), None);
        assert_eq!(found(10..12), None);
        assert!(matches!(
            found(10..15),
            Some(Finding::Strays { certain: false, .. })
        ));
        assert!(matches!(
            found(20..36),
            Some(Finding::Strays { certain: true, from, .. }) if from == 120.0
        ));
    }
}
