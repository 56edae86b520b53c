//! The paper's Figure 8: where strikes at targets stop.

use values::Point;

use super::markup::{in_colours, title};
use super::plot::{Kind, Plot, Series, xy};
use crate::trial::{Outcome, TargetStrike, Trial};

/// The paper's Figure 8: per target the mean of the stops and their deviations as an ellipse.
pub fn figure_8(trial: &Trial, models: &[&'static str]) -> Plot {
    let shown: Vec<(&'static str, &Outcome)> = models
        .iter()
        .filter_map(|model| Some((*model, trial.figure_8.get(*model)?)))
        .collect();
    let strikes = || shown.iter().flat_map(|(_, outcome)| &outcome.strikes);
    let unique = |point: fn(&TargetStrike) -> Point| {
        let mut points: Vec<(f64, f64)> = strikes().map(|strike| xy(point(strike))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        points.dedup();
        points
    };
    let mut series = vec![
        Series::new(
            "start",
            "measured",
            Kind::Dots,
            unique(|strike| strike.from),
        ),
        Series::new(
            "target",
            "measured",
            Kind::Crosses,
            unique(|strike| strike.to),
        ),
    ];
    for (model, outcome) in &shown {
        let groups = outcome
            .strikes
            .chunk_by(|a, b| (a.from, a.to) == (b.from, b.to));
        let mut outlines = Vec::new();
        let mut means = Vec::new();
        for group in groups {
            let stops: Vec<Point> = group.iter().map(|strike| strike.stop).collect();
            let (mean, outline) = ellipse(&stops);
            means.push(xy(mean));
            outlines.extend(outline);
            outlines.push((f64::NAN, f64::NAN));
        }
        let hue = in_colours(model);
        series.push(Series::new(None, hue, Kind::Line, outlines).named(title(model)));
        series.push(Series::new(None, hue, Kind::Dots, means));
    }
    Plot::map(series)
}

/// Mean of the stops, and the outline of the ellipse whose half axes are their standard deviations along its principal
/// directions.
fn ellipse(stops: &[Point]) -> (Point, Vec<(f64, f64)>) {
    let n = stops.len() as f64;
    let mean = stops.iter().fold(Point::default(), |sum, stop| sum + *stop) * (1.0 / n);
    let sum = |term: fn(Point) -> f64| {
        stops.iter().map(|stop| term(*stop - mean)).sum::<f64>() / (n - 1.0).max(1.0)
    };
    let (xx, xy, yy) = (sum(|d| d.x * d.x), sum(|d| d.x * d.y), sum(|d| d.y * d.y));
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (middle, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let (long, wide) = ((middle + half).sqrt(), (middle - half).max(0.0).sqrt());
    let outline = (0..=48)
        .map(|step| {
            let angle = std::f64::consts::TAU * f64::from(step) / 48.0;
            let at = mean + Point::new(long * angle.cos(), wide * angle.sin()).rotated(turn);
            (at.x, at.y)
        })
        .collect();
    (mean, outline)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipse_has_the_deviations_of_its_points() {
        let stops = [(0.0, 1.0), (0.0, -1.0), (3.0, 0.0), (-3.0, 0.0)]
            .map(|(x, y)| Point::new(x, y).rotated(0.4));
        let (mean, outline) = ellipse(&stops);
        assert!(mean.norm() < 1e-12);
        let longest = outline.iter().map(|(x, y)| x.hypot(*y)).fold(0.0, f64::max);
        let shortest = outline.iter().map(|(x, y)| x.hypot(*y)).fold(9.0, f64::min);
        assert!((longest - (18.0f64 / 3.0).sqrt()).abs() < 1e-9);
        assert!((shortest - (2.0f64 / 3.0).sqrt()).abs() < 1e-9);
    }
}
