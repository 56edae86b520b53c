//! Which of several worlds, each with what was learnt on top of it, predicts best what it did not learn from.

use std::collections::HashSet;

use crate::Learned;

/// The place of the one with the least mean distance between measured and predicted stop, over the strikes that all of them predict;
/// the first of equals, none of none. No strike that judges a version takes part.
pub fn best(learned: &[&Learned]) -> Option<usize> {
    let ids = |learned: &'_ Learned| -> HashSet<String> {
        learned.misses.iter().map(|(id, _)| id.clone()).collect()
    };
    let common = learned
        .iter()
        .map(|learned| ids(learned))
        .reduce(|all, more| all.intersection(&more).cloned().collect())?;
    let mean = |learned: &Learned| {
        let misses = learned.misses.iter().filter(|(id, _)| common.contains(id));
        crate::miss::mean(misses.map(|(_, miss)| *miss)).unwrap_or(f64::INFINITY)
    };
    let means = learned.iter().map(|learned| mean(learned)).enumerate();
    means
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(place, _)| place)
}
