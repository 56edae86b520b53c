//! Friction that wanders over the strikes: what it may have been over those that were not used.
//!
//! Friction of strikes near in time is then alike. Its steps are estimated from how the squared difference of two strikes' frictions grows
//! with the number of strikes between them (a variogram; Matheron 1963).

/// Least correlation of one strike's friction with the next one's, in standard errors, from which friction counts as wandering: one-sided 1 %.
const WANDERS: f64 = 2.33;

/// Variance of friction's mean over `all` strikes less that over those `used`, relative to friction, where it wanders; 0 where it
/// does not. `used`: order of each strike and its own friction (logarithm), in order, as likely as its track makes it where friction scatters by
/// `scatter`; `all`: orders of all strikes.
pub(crate) fn unseen(used: &[(f64, f64)], scatter: f64, all: &[f64]) -> f64 {
    let n = used.len() as f64;
    if used.len() < 3 {
        return 0.0;
    }
    // What is likely is shrunk towards the mean of all, by as much as the likely ones scatter less than frictions do.
    let squares: f64 = used.iter().map(|(_, own)| own * own).sum();
    let kept = (squares / n / scatter.max(1e-12).powi(2)).min(1.0);
    let mean = used.iter().map(|(_, own)| own).sum::<f64>() / n;
    let square: f64 = used.iter().map(|(_, own)| (own - mean).powi(2)).sum();
    let product: f64 = used
        .windows(2)
        .map(|pair| (pair[0].1 - mean) * (pair[1].1 - mean))
        .sum();
    if product < WANDERS / n.sqrt() * square {
        return 0.0;
    }
    step_variance(used) / kept.powi(2) * spread(used, all)
}

/// Variance of one step of the walk: twice the slope of the variogram.
fn step_variance(used: &[(f64, f64)]) -> f64 {
    let (mut count, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, (first, one)) in used.iter().enumerate() {
        for (second, other) in &used[i + 1..] {
            let (lag, half) = (second - first, 0.5 * (other - one).powi(2));
            count += 1.0;
            x += lag;
            y += half;
            xx += lag * lag;
            xy += lag * half;
        }
    }
    let slope = (xy - x * y / count) / (xx - x * x / count).max(1e-12);
    2.0 * slope.max(0.0)
}

/// Variance of the difference of both means, of a walk whose steps have a variance of 1: each step moves all strikes after it.
fn spread(used: &[(f64, f64)], all: &[f64]) -> f64 {
    let mut orders = all.to_vec();
    orders.sort_by(f64::total_cmp);
    let share = |later: usize, of: usize| later as f64 / of.max(1) as f64;
    orders
        .windows(2)
        .map(|pair| {
            let later = |order: &f64| *order > pair[0];
            let used_later = used.iter().filter(|(order, _)| later(order)).count();
            let all_later = orders.iter().filter(|order| later(order)).count();
            let moved = share(used_later, used.len()) - share(all_later, orders.len());
            moved * moved * (pair[1] - pair[0])
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Frictions are seen with this standard error, and shrunk as is most likely.
    fn walks(step: f64, scatter: f64, error: f64) -> Vec<(f64, f64)> {
        // The uncertainty of the unseen strikes beside what they did, of many walks of 160 strikes whose first 100 are used.
        (0..60)
            .map(|seed| {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let mut at = 0.0;
                let walk: Vec<f64> = (0..160)
                    .map(|_| {
                        at += step * normal();
                        at
                    })
                    .collect();
                let own: Vec<f64> = (0..100).map(|i| walk[i] + scatter * normal()).collect();
                let of_all = own.iter().sum::<f64>() / 100.0;
                let square = own.iter().map(|own| (own - of_all).powi(2)).sum::<f64>() / 100.0;
                let kept = square / (square + error * error);
                let likely = |own: f64| kept * (own - of_all + error * normal());
                let own = own.into_iter().map(likely).enumerate();
                let used: Vec<(f64, f64)> = own.map(|(i, own)| (i as f64, own)).collect();
                let all: Vec<f64> = (0..160).map(f64::from).collect();
                let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
                (
                    unseen(&used, square.sqrt(), &all),
                    mean(&walk) - mean(&walk[..100]),
                )
            })
            .collect()
    }

    #[test]
    fn the_uncertainty_of_unseen_strikes_is_how_far_they_go() {
        for (scatter, error) in [(0.0, 0.0), (0.02, 0.0), (0.01, 0.03)] {
            let walks = walks(0.006, scatter, error);
            let estimated: f64 = walks.iter().map(|(variance, _)| variance).sum();
            let did: f64 = walks.iter().map(|(_, did)| did * did).sum();
            assert!((0.6..1.6).contains(&(estimated / did)), "{estimated} {did}");
        }
    }

    #[test]
    fn friction_that_only_scatters_does_not_wander() {
        let walks = walks(0.0, 0.02, 0.02);
        let wandering = walks.iter().filter(|(variance, _)| *variance > 0.0).count();
        assert!(wandering <= 3, "{wandering} of {}", walks.len());
    }
}
