//! The paper's Figure 8: where strikes at targets stop.

use plotters::prelude::*;
use values::Point;

use super::plot::{Axes, FAINT, MEASURED, PlotError, axes, colour, line, svg, view, xy};
use crate::trial::{Outcome, Trial};

/// The paper's Figure 8: per target the mean of the stops and their deviations as an ellipse.
pub fn figure_8(trial: &Trial, models: &[&str]) -> Result<String, PlotError> {
    let size = (620, 520);
    svg(size, |area| {
        let shown: Vec<(&str, &Outcome)> = models
            .iter()
            .filter_map(|model| Some((*model, trial.figure_8.get(*model)?)))
            .collect();
        let strikes = || shown.iter().flat_map(|(_, outcome)| &outcome.strikes);
        let points = strikes().flat_map(|strike| [strike.from, strike.to, strike.stop]);
        let (x_range, y_range) = view(points, size);
        let mut chart = axes(
            area,
            &Axes {
                title: "",
                x: "x in m",
                y: "y in m",
                x_range,
                y_range,
            },
        )?;
        for strike in strikes() {
            chart.draw_series([line(xy(strike.from), xy(strike.to), FAINT.mix(0.12))])?;
        }
        for strike in strikes() {
            let (start, goal) = (xy(strike.from), xy(strike.to));
            chart.draw_series([Circle::new(start, 5, MEASURED.filled())])?;
            chart.draw_series([Cross::new(goal, 7, MEASURED.stroke_width(1))])?;
        }
        for (model, outcome) in &shown {
            let hue = colour(model);
            for group in outcome
                .strikes
                .chunk_by(|a, b| (a.from, a.to) == (b.from, b.to))
            {
                let stops: Vec<Point> = group.iter().map(|strike| strike.stop).collect();
                let (mean, outline) = ellipse(&stops);
                chart.draw_series([line(xy(group[0].to), xy(mean), hue.mix(0.5))])?;
                chart.draw_series([Polygon::new(outline.clone(), hue.mix(0.25).filled())])?;
                chart.draw_series([PathElement::new(outline, hue.stroke_width(1))])?;
                chart.draw_series([Circle::new(xy(mean), 2, hue.filled())])?;
            }
        }
        Ok(())
    })
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
