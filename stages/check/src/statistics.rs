//! A few statistics that single wrong pairs do not move far.

use std::f64::consts::{PI, TAU};

/// Median of the finite values; none where there is none.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    values::median(
        values
            .into_iter()
            .filter(|value| value.is_finite())
            .collect(),
    )
}

/// Median of values, and the standard deviation about it, by the median of deviations.
pub fn median_spread(values: &[f64]) -> Option<(f64, f64)> {
    let middle = median(values.iter().copied())?;
    let spread = 1.4826 * median(values.iter().map(|one| (one - middle).abs()))?;
    Some((middle, spread))
}

/// Standard error of the median of so many normal values of this standard deviation.
pub fn median_error(spread: f64, count: usize) -> f64 {
    1.2533 * spread / (count as f64).sqrt()
}

/// An angle within ±π.
pub fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// Median of angles (rad), about the direction of their mean, and the standard deviation about it, by the median of deviations.
pub fn middle(angles: &[f64]) -> Option<(f64, f64)> {
    let (x, y) = angles.iter().fold((0.0, 0.0), |(x, y), angle| {
        (x + angle.cos(), y + angle.sin())
    });
    let mean = f64::atan2(y, x);
    let about = median(angles.iter().map(|angle| wrapped(angle - mean)))?;
    let middle = wrapped(mean + about);
    let spread = 1.4826 * median(angles.iter().map(|angle| wrapped(angle - middle).abs()))?;
    Some((middle, spread))
}

/// A line through points.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Slope, and its standard error.
    pub slope: f64,
    pub slope_error: f64,
    /// Value at x = 0, and its standard error.
    pub at_zero: f64,
    pub at_zero_error: f64,
    /// Correlation of x and y.
    pub correlation: f64,
}

/// Least squares, once more without the points farther than three robust deviations from the first line; none for fewer than four
/// points, or where x does not vary.
pub fn line(points: &[(f64, f64)]) -> Option<Line> {
    let first = least_squares(points)?;
    let residual = |line: &Line, p: &(f64, f64)| p.1 - line.at_zero - line.slope * p.0;
    let spread = 1.4826 * median(points.iter().map(|p| residual(&first, p).abs()))?;
    let near: Vec<(f64, f64)> = points
        .iter()
        .filter(|p| residual(&first, p).abs() <= 3.0 * spread)
        .copied()
        .collect();
    // Most points near a line that few lie far from: those are astray.
    if near.len() < points.len() && 5 * near.len() >= 4 * points.len() {
        least_squares(&near)
    } else {
        Some(first)
    }
}

fn least_squares(points: &[(f64, f64)]) -> Option<Line> {
    let n = points.len() as f64;
    if points.len() < 4 {
        return None;
    }
    let (mx, my) = points
        .iter()
        .fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in points {
        xx += (x - mx).powi(2);
        xy += (x - mx) * (y - my);
        yy += (y - my).powi(2);
    }
    let scale = points.iter().map(|p| p.0.abs()).fold(0.0, f64::max);
    if xx <= 1e-18 * n * scale * scale {
        return None;
    }
    let slope = xy / xx;
    let variance = ((yy - slope * xy) / (n - 2.0)).max(0.0);
    Some(Line {
        slope,
        slope_error: (variance / xx).sqrt(),
        at_zero: my - slope * mx,
        at_zero_error: (variance * (1.0 / n + mx * mx / xx)).sqrt(),
        correlation: if yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 },
    })
}

/// The upper end of a correlation's interval at this many standard deviations (Fisher's z).
pub fn at_most(correlation: f64, points: usize, deviations: f64) -> f64 {
    if points < 5 {
        return 1.0;
    }
    let error = 1.0 / (points as f64 - 3.0).sqrt();
    (correlation.clamp(-0.999_999, 0.999_999).atanh() + deviations * error).tanh()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_passes_by_points_that_are_astray() {
        let mut points: Vec<(f64, f64)> = (0..20)
            .map(|i| f64::from(i) / 10.0)
            .map(|x| (x, 0.5 + 2.0 * x + 0.01 * (9.0 * x).sin()))
            .collect();
        points[7].1 = -40.0;
        let line = line(&points).expect("a line");
        assert!((line.slope - 2.0).abs() < 0.01 && (line.at_zero - 0.5).abs() < 0.01);
        assert!(line.correlation > 0.99 && line.slope_error < 0.01);
    }

    #[test]
    fn the_middle_of_angles_is_found_across_the_half_circle() {
        let (middle, spread) = middle(&[3.1, -3.1, 3.13, -3.12, 3.12]).expect("angles");
        assert!(
            wrapped(middle - 3.15).abs() < 0.05 && spread < 0.1,
            "{middle} {spread}"
        );
        assert!(at_most(0.0, 30, 3.0) < 0.6 && at_most(0.9, 30, 3.0) > 0.9);
    }
}
