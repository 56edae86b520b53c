//! Friction that wanders: Brownian motion over the order of strikes, by the first terms of its Karhunen–Loève expansion.
//!
//! W(t) = σ_w·Σ γ_k·√2/((k − ½)·π)·sin((k − ½)·π·t), γ_k ~ N(0, 1), t the strike's place between the first and the last, 0 to 1.
//! What the terms that are left out would add scatters from strike to strike like friction of each strike's own. The mean over
//! the strikes is friction itself, so a path has none.

use std::f64::consts::PI;

use nalgebra::SVector;

/// Terms that are kept: those left out hold less than 1 % of the variance.
pub(crate) const PATHS: usize = 12;

/// How far each term moves a strike's friction.
pub(crate) type Path = SVector<f64, PATHS>;

/// The path of each strike, by its order.
pub(crate) fn paths(orders: &[f64]) -> Vec<Path> {
    let low = orders.iter().copied().fold(f64::INFINITY, f64::min);
    let high = orders.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let range = (high - low).max(1.0);
    let mut paths: Vec<Path> = orders
        .iter()
        .map(|order| {
            let t = (order - low) / range;
            Path::from_fn(|k, _| {
                let rate = (k as f64 + 0.5) * PI;
                2f64.sqrt() / rate * (rate * t).sin()
            })
        })
        .collect();
    let mean = paths.iter().sum::<Path>() / paths.len().max(1) as f64;
    for path in &mut paths {
        *path -= mean;
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_have_the_covariance_of_brownian_motion_about_its_mean() {
        let n = 200;
        let orders: Vec<f64> = (0..n).map(f64::from).collect();
        let paths = paths(&orders);
        let covariance =
            |s: f64, t: f64| s.min(t) - (s - 0.5 * s * s) - (t - 0.5 * t * t) + 1.0 / 3.0;
        for (i, j) in [(0, 199), (40, 50), (100, 100), (20, 180)] {
            let (s, t) = (i as f64 / 199.0, j as f64 / 199.0);
            let found = paths[i].dot(&paths[j]);
            assert!((found - covariance(s, t)).abs() < 0.02, "{found}");
        }
    }
}
