//! Smooth maps that would take part of the gap, whatever its cause: of the launch over commands, of friction over the table.

use diagnose::{Diagnosis, MapPoint, SmoothMap};
use maud::{Markup, html};
use plotters::prelude::*;

use super::markup::{PageError, drawing};
use super::plot::{Axes, PlotError, axes, range, svg};

/// Colours of changes below and above none.
const LESS: RGBColor = RGBColor(45, 105, 200);
const MORE: RGBColor = RGBColor(200, 70, 40);
/// Radii of points in pixels: of no change, and beside it of the largest one.
const RADIUS: (f64, f64) = (2.0, 7.0);

/// A quantity of a map: its title, its place in [`MapPoint::change`], and what one unit of it is called.
struct Quantity {
    title: &'static str,
    component: usize,
    scale: f64,
    unit: &'static str,
}

const LAUNCH: [Quantity; 2] = [
    Quantity {
        title: "launch speed beyond the command",
        component: 0,
        scale: 100.0,
        unit: "%",
    },
    Quantity {
        title: "launch angle beyond the command",
        component: 1,
        scale: 180.0 / std::f64::consts::PI,
        unit: "°",
    },
];
const FRICTION: [Quantity; 1] = [Quantity {
    title: "friction beyond its mean",
    component: 0,
    scale: 100.0,
    unit: "%",
}];

/// The maps as pictures, and how much of the gap each would take; empty where there is none.
pub fn maps(diagnosis: &Diagnosis) -> Result<Markup, PageError> {
    let mut plots = Vec::new();
    for map in &diagnosis.maps {
        for quantity in quantities(map) {
            plots.push(picture(map, quantity)?);
        }
    }
    Ok(html! {
        @if !diagnosis.maps.is_empty() {
            h3 { "What smooth maps would take of the gap" }
            table {
                thead { tr { th { "map" } th { "stop error before" } th { "with the map" } th { "share of the squared error" } th { "look at" } } }
                tbody {
                    @for map in &diagnosis.maps {
                        tr {
                            td { (map.name) }
                            td.number { (format!("{:.1} mm", 1e3 * map.before)) }
                            td.number { (format!("{:.1} mm", 1e3 * map.after)) }
                            td.number { (format!("{:.0} %", 100.0 * map.share)) }
                            td { (look_at(map)) }
                        }
                    }
                }
            }
            div.columns { @for plot in &plots { figure { (drawing(plot)) } } }
            p.legend {
                span style=(colour_of(LESS)) { "●" } " less   " span style=(colour_of(MORE)) { "●" } " more; the larger, the more. "
                "Stop errors are of strikes that each map's fit leaves out."
            }
        }
    })
}

fn quantities(map: &SmoothMap) -> &'static [Quantity] {
    if is_launch(map) { &LAUNCH } else { &FRICTION }
}

fn is_launch(map: &SmoothMap) -> bool {
    map.name == "launch"
}

fn look_at(map: &SmoothMap) -> &'static str {
    if is_launch(map) {
        "the arm"
    } else {
        "the table"
    }
}

fn colour_of(colour: RGBColor) -> String {
    format!("color:rgb({},{},{})", colour.0, colour.1, colour.2)
}

fn picture(map: &SmoothMap, quantity: &Quantity) -> Result<String, PlotError> {
    let change = |point: &MapPoint| quantity.scale * point.change[quantity.component];
    let largest = map
        .points
        .iter()
        .map(|p| change(p).abs())
        .fold(0.0, f64::max);
    let title = format!("{} (up to {largest:.1} {})", quantity.title, quantity.unit);
    let [x, y] = if is_launch(map) {
        ["commanded speed in m/s", "commanded angle in rad"]
    } else {
        ["x in m", "y in m"]
    };
    svg((430, 330), |area| {
        let mut chart = axes(
            area,
            &Axes {
                title: &title,
                x,
                y,
                x_range: range(map.points.iter().map(|point| point.at[0])),
                y_range: range(map.points.iter().map(|point| point.at[1])),
            },
        )?;
        for point in &map.points {
            let share = change(point) / largest.max(f64::MIN_POSITIVE);
            let hue = if share < 0.0 { LESS } else { MORE };
            let radius = RADIUS.0 + (RADIUS.1 - RADIUS.0) * share.abs();
            let at = (point.at[0], point.at[1]);
            chart.draw_series([Circle::new(
                at,
                radius.round() as i32,
                hue.mix(0.75).filled(),
            )])?;
        }
        Ok(())
    })
}
