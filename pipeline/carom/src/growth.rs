//! Which of strikes that grow night by night are learnt from, and which judge.

use values::{Strike, halvings};

/// Up to twice as many strikes each one counts; beyond, they count in steps of one to two in this many.
const FINE: usize = 50;

/// How many of `count` strikes, the earliest, diagnosis and training look at: all of up to 100, beyond in steps of 1 to 2 %. A few
/// new strikes among thousands then move neither world nor network, and what was computed still answers; the next step takes
/// them in.
pub fn learning_count(count: usize) -> usize {
    let step = (count / FINE).checked_ilog2().map_or(1, |log| 1 << log);
    count - count % step
}

/// No more strikes than these are solved and learnt from, so that time does not grow without end. What a map's 67 weights are uncertain by
/// is then √(67/4000) of what a strike scatters by at the most, and adds less than 1 % to it.
const MOST_LEARNT: usize = 8000;

/// The places of the strikes that are solved and learnt from: all of up to [`MOST_LEARNT`], of more so few by lot, in their order. Each
/// strike keeps its lot: what was chosen stays chosen until the strikes have doubled, and then half of it does.
pub fn learnt(strikes: &[Strike]) -> Vec<usize> {
    let shares = strikes.len().div_ceil(MOST_LEARNT).next_power_of_two();
    let least = shares.trailing_zeros();
    (0..strikes.len())
        .filter(|place| least == 0 || halvings(&strikes[*place].id) >= least)
        .collect()
}

/// The latest so many strikes judge a model: they give its mean error to a twentieth, and older ones say less of the table.
const MOST_JUDGES: usize = 500;

/// The latest of strikes that judge, in their order.
pub fn latest<T>(mut strikes: Vec<T>) -> Vec<T> {
    strikes.split_off(strikes.len().saturating_sub(MOST_JUDGES))
}

#[cfg(test)]
mod tests {
    use values::{Command, Point};

    use super::*;

    #[test]
    fn of_very_many_strikes_a_share_is_learnt_from_that_hardly_changes_as_they_grow() {
        let strike = |index: usize| Strike {
            id: index.to_string(),
            t_start: index as f64,
            ..Strike::bare(Command::new(1.0, 0.0), Point::default(), Point::default())
        };
        let strikes: Vec<Strike> = (0..5 * MOST_LEARNT).map(strike).collect();
        let all = learnt(&strikes[..MOST_LEARNT]);
        assert_eq!(all, (0..MOST_LEARNT).collect::<Vec<_>>());
        let [few, more, many] = [3, 4, 5].map(|times| learnt(&strikes[..times * MOST_LEARNT]));
        assert!(few.len() < 4 * MOST_LEARNT / 5, "{}", few.len());
        assert!(more.starts_with(&few), "a strike that learnt is kept");
        let kept = many.iter().filter(|place| more.contains(place)).count();
        let older = many
            .iter()
            .filter(|place| **place < 4 * MOST_LEARNT)
            .count();
        assert_eq!(kept, older);
    }

    #[test]
    fn every_strike_of_a_hundred_counts_and_of_more_all_but_two_in_a_hundred() {
        for count in 0..=100 {
            assert_eq!(learning_count(count), count);
        }
        let mut taken = 0;
        for count in 1..100_000 {
            let now = learning_count(count);
            assert!(
                now <= count && count - now < count.div_ceil(50),
                "{count}: {now}"
            );
            assert!(taken <= now, "what learnt is never forgotten");
            taken = now;
        }
        let steps = |from: usize, to: usize| {
            (from..to)
                .filter(|n| learning_count(*n) != learning_count(n - 1))
                .count()
        };
        assert!(steps(5000, 5100) <= 2);
    }
}
