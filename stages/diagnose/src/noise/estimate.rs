//! ρ and κ by maximum likelihood, all else at its best: Nelder and Mead's simplex (1965) over (atanh ρ, ln κ).

use super::FrameNoise;

/// Where the search begins, and how many evaluations it has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    evaluations: usize,
    size: f64,
}

/// The first search, and one that goes on from where an earlier one ended.
pub(crate) const FIRST_SEARCH: Search = Search {
    evaluations: 45,
    size: 0.5,
};
pub(crate) const REFINEMENT: Search = Search {
    evaluations: 22,
    size: 0.25,
};
/// ρ and κ (s/m) from which the first search begins.
const START: (f64, f64) = (0.3, 0.8);
/// Greatest correlation: beyond it errors and a strike's nuisances cannot be distinguished.
const MOST_CORRELATED: f64 = 0.97;
/// Least and greatest κ in s/m: with 1 mm of camera noise, stamps that are off by 10 µs, and by 100 ms.
const JITTER: (f64, f64) = (0.01, 100.0);

/// The noise under which `log_likelihood` is greatest, from `start` where one is given.
pub(crate) fn estimate(
    start: Option<FrameNoise>,
    search: Search,
    mut log_likelihood: impl FnMut(FrameNoise) -> f64,
) -> FrameNoise {
    let start = start.map_or(START, |noise| (noise.correlation, noise.jitter));
    let at = [
        start.0.clamp(0.0, MOST_CORRELATED).atanh(),
        start.1.clamp(JITTER.0, JITTER.1).ln(),
    ];
    let noise = |at: [f64; 2]| FrameNoise {
        correlation: at[0].tanh().clamp(0.0, MOST_CORRELATED),
        jitter: at[1].exp().clamp(JITTER.0, JITTER.1),
    };
    let best = minimum(at, search, |at| {
        let value = -log_likelihood(noise(at));
        if value.is_finite() { value } else { f64::MAX }
    });
    noise(best)
}

/// Nelder and Mead's simplex in the plane.
fn minimum(start: [f64; 2], search: Search, mut f: impl FnMut([f64; 2]) -> f64) -> [f64; 2] {
    let mut evaluations = 0;
    let mut value = |at: [f64; 2]| {
        evaluations += 1;
        (f(at), evaluations)
    };
    let corners = [[0.0, 0.0], [search.size, 0.0], [0.0, search.size]];
    let mut simplex = corners
        .map(|[x, y]| [start[0] + x, start[1] + y])
        .map(|at| (at, value(at).0));
    let mut used = simplex.len();
    while used < search.evaluations {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let [best, middle, worst] = simplex;
        let centre = [0, 1].map(|i| 0.5 * (best.0[i] + middle.0[i]));
        let away = |factor: f64| [0, 1].map(|i| centre[i] + factor * (centre[i] - worst.0[i]));
        let mut tried = |factor: f64| {
            let at = away(factor);
            let (found, count) = value(at);
            used = count;
            (at, found)
        };
        let reflected = tried(1.0);
        simplex[2] = if reflected.1 < best.1 {
            let expanded = tried(2.0);
            if expanded.1 < reflected.1 {
                expanded
            } else {
                reflected
            }
        } else if reflected.1 < middle.1 {
            reflected
        } else {
            let contracted = tried(if reflected.1 < worst.1 { 0.5 } else { -0.5 });
            if contracted.1 < worst.1.min(reflected.1) {
                contracted
            } else {
                for corner in [1, 2] {
                    let at = [0, 1].map(|i| 0.5 * (simplex[corner].0[i] + best.0[i]));
                    let (found, count) = value(at);
                    used = count;
                    simplex[corner] = (at, found);
                }
                continue;
            }
        };
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0].0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_of_a_likelihood_is_found() {
        let found = estimate(None, FIRST_SEARCH, |noise| {
            let away = [
                noise.correlation.atanh() - 0.9f64.atanh(),
                noise.jitter.ln() - 3f64.ln(),
            ];
            -(4.0 * away[0].powi(2) + away[1].powi(2) + away[0] * away[1])
        });
        assert!((found.correlation - 0.9).abs() < 0.02, "{found:?}");
        assert!((found.jitter - 3.0).abs() < 0.3, "{found:?}");
    }

    #[test]
    fn an_estimate_stays_within_its_bounds() {
        let found = estimate(None, FIRST_SEARCH, |noise| {
            noise.correlation + noise.jitter.ln()
        });
        assert!(found.correlation <= MOST_CORRELATED && found.jitter <= JITTER.1);
        let none = estimate(None, FIRST_SEARCH, |_| f64::NAN);
        assert!(none.correlation.is_finite() && none.jitter.is_finite());
    }
}
