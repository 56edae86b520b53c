//! What the arm was commanded against what it delivered, where `/striker/state` was logged.

use std::collections::BTreeSet;

use maud::{Markup, html};
use values::{Delivered, Strike, wrap_angle};

use super::markup::section;
use super::plot::{Kind, Plot, Series};

/// A strike and what the arm delivered.
type Pair<'a> = (&'a Strike, &'a Delivered);

/// The section; none where no strike has a measured delivery.
pub fn delivered_section(strikes: &[Strike], listed: &BTreeSet<usize>) -> Option<Markup> {
    let pairs: Vec<Pair<'_>> = strikes
        .iter()
        .filter_map(|strike| Some((strike, strike.delivered.as_ref()?)))
        .collect();
    if pairs.is_empty() {
        return None;
    }
    let drawn = listed.iter().filter_map(|place| {
        let strike = &strikes[*place];
        Some((*place, (strike, strike.delivered.as_ref()?)))
    });
    let (places, drawn): (Vec<usize>, Vec<Pair<'_>>) = drawn.unzip();
    let plots = [speeds(&places, &drawn), angles(&places, &drawn)];
    let (speed, speed_sd) = mean_and_sd(&pairs.iter().map(relative_speed).collect::<Vec<_>>());
    let turns: Vec<f64> = pairs.iter().map(turn).collect();
    let (angle, angle_sd) = mean_and_sd(&turns);
    let pushed_again = pairs.iter().filter(|(_, d)| d.pushed_again).count();
    Some(section(
        "What the arm delivered",
        html! {
            div.columns { @for plot in &plots { (plot.figure(plot.y)) } }
            table { tbody {
                tr { td { "strikes with a measured delivery" } td.number { (pairs.len()) " of " (strikes.len()) } }
                tr { td { "speed at contact, relative to the command" } td.number { (format!("{:+.1} ± {:.1} %", 100.0 * speed, 100.0 * speed_sd)) } }
                tr { td { "direction at contact, beside the command" } td.number { (format!("{angle:+.2} ± {angle_sd:.2}°")) } }
                tr { td { "arm reached the object a second time" } td.number { (pushed_again) } }
            } }
            p.note { "Mean ± standard deviation over strikes. On the line the arm delivers what was commanded." }
        },
    ))
}

/// Delivered speed beyond the command, relative.
fn relative_speed((strike, delivered): &Pair<'_>) -> f64 {
    delivered.tip_speed / strike.command.speed - 1.0
}

/// Delivered angle beyond the command, in degrees.
fn turn((strike, delivered): &Pair<'_>) -> f64 {
    wrap_angle(delivered.tip_angle - strike.command.angle).to_degrees()
}

/// Standard deviation 0 of a single value.
fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0).max(1.0)).sqrt())
}

fn speeds(places: &[usize], pairs: &[Pair<'_>]) -> Plot {
    let speeds = pairs
        .iter()
        .map(|(strike, delivered)| (strike.command.speed, delivered.tip_speed));
    let ends = ends(pairs.iter().map(|(strike, _)| strike.command.speed));
    let diagonal = ends.map(|end| (end, end));
    scatter(
        "commanded speed in m/s",
        "delivered in m/s",
        places,
        speeds,
        diagonal,
    )
}

fn angles(places: &[usize], pairs: &[Pair<'_>]) -> Plot {
    let angle = |strike: &Strike| strike.command.angle.to_degrees();
    let turns = pairs.iter().map(|pair| (angle(pair.0), turn(pair)));
    let level = ends(pairs.iter().map(|pair| angle(pair.0))).map(|end| (end, 0.0));
    scatter(
        "commanded angle in °",
        "delivered beside it in °",
        places,
        turns,
        level,
    )
}

/// The least and the greatest.
fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

/// Points, and the line on which what is delivered is what was commanded.
fn scatter(
    x: &'static str,
    y: &'static str,
    places: &[usize],
    points: impl Iterator<Item = (f64, f64)>,
    commanded: [(f64, f64); 2],
) -> Plot {
    let points = places.iter().copied().zip(points);
    Plot::new(
        x,
        y,
        vec![
            Series::new("as commanded", "measured", Kind::Line, commanded).pale(),
            Series::of_strikes("delivered", "effect", Kind::Dots, points),
        ],
    )
}

#[cfg(test)]
mod tests {
    use values::{Command, Point};

    use super::*;

    fn strike(delivered: Option<Delivered>) -> Strike {
        Strike {
            id: "a".into(),
            log: "a.mcap".into(),
            delivered,
            ..Strike::bare(
                Command::new(0.8, 0.1),
                Point::default(),
                Point::new(0.3, 0.0),
            )
        }
    }

    #[test]
    fn only_a_measured_delivery_is_shown_with_its_difference_from_the_command() {
        assert!(delivered_section(&[strike(None)], &[0].into()).is_none());
        let delivered = Delivered {
            tip_speed: 0.76,
            tip_angle: 0.1 + 2f64.to_radians(),
            contact: 0.0,
            pushed_again: true,
        };
        let strikes = [strike(None), strike(Some(delivered))];
        let section = delivered_section(&strikes, &[0, 1].into()).expect("shown");
        let text = section.into_string();
        for shown in ["1 of 2", "-5.0 ± 0.0 %", "+2.00 ± 0.00°"] {
            assert!(text.contains(shown), "{shown}: {text}");
        }
    }
}
