//! Which of strikes that grow night by night are learnt from.

/// Up to twice as many strikes each one counts; beyond, they count in steps of one to two in this many.
const FINE: usize = 50;

/// How many of `count` strikes, the earliest, diagnosis and training look at: all of up to 100, beyond in steps of 1 to 2 %. A few
/// new strikes among thousands then move neither world nor network, and what was computed still answers; the next step takes
/// them in.
pub fn learning_count(count: usize) -> usize {
    let step = (count / FINE).checked_ilog2().map_or(1, |log| 1 << log);
    count - count % step
}

#[cfg(test)]
mod tests {
    use super::*;

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
