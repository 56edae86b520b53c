//! Statistics that a few wrong frames do not move.

use values::Point;

/// The middle value; NaN for none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 {
        values[middle]
    } else {
        (values[middle - 1] + values[middle]) / 2.0
    }
}

/// Median of each coordinate.
pub(crate) fn median_point(points: &[Point]) -> Point {
    Point::new(
        median(points.iter().map(|point| point.x)),
        median(points.iter().map(|point| point.y)),
    )
}

/// Standard deviation of a coordinate, from the median absolute deviation over both coordinates.
pub(crate) fn spread(points: &[Point]) -> f64 {
    /// Median absolute deviation of a normal distribution, inverted.
    const MAD_TO_SD: f64 = 1.4826;
    let centre = median_point(points);
    let deviations = points
        .iter()
        .flat_map(|point| [(point.x - centre.x).abs(), (point.y - centre.y).abs()]);
    MAD_TO_SD * median(deviations)
}

/// Mean of the points that lie within `reach` of the median point.
pub(crate) fn mean_near_median(points: &[Point], reach: f64) -> Point {
    let centre = median_point(points);
    let near: Vec<Point> = points
        .iter()
        .copied()
        .filter(|point| point.distance(centre) <= reach)
        .collect();
    if near.is_empty() {
        return centre;
    }
    let sum = near
        .iter()
        .fold(Point::default(), |sum, point| sum + *point);
    sum * (1.0 / near.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_wrong_points_moves_nothing_far() {
        let mut points: Vec<Point> = (0..20)
            .map(|i| Point::new(0.001 * f64::from(i % 5), 0.5))
            .collect();
        points.extend((0..9).map(|_| Point::new(3.0, -7.0)));
        assert!(mean_near_median(&points, 0.01).distance(Point::new(0.002, 0.5)) < 1e-9);
        assert!(spread(&points) < 0.003);
    }

    #[test]
    fn the_median_of_none_is_not_a_number() {
        assert!(median([]).is_nan());
        assert!((median([3.0, 1.0, 2.0, 10.0]) - 2.5).abs() < 1e-12);
    }
}
