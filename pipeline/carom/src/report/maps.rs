//! Smooth maps that would take part of the gap, whatever its cause: of the launch over commands, of friction over the table.

use diagnose::{Diagnosis, MapPoint, SmoothMap};
use maud::{Markup, html};

use super::markup::table;
use super::plot::{Kind, Plot, Series};

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
pub fn maps(diagnosis: &Diagnosis) -> Markup {
    let pairs = diagnosis.maps.iter();
    let plots = pairs.flat_map(|map| {
        quantities(map)
            .iter()
            .map(|quantity| picture(map, quantity))
    });
    html! {
        @if !diagnosis.maps.is_empty() {
            h3 { "What smooth maps would take of the gap" }
            (table(&["map", "stop error before", "with the map", "share of the squared error", "look at"], html! { @for map in &diagnosis.maps {
                tr {
                    td { (map.name) }
                    td.number { (format!("{:.1} mm", 1e3 * map.before)) }
                    td.number { (format!("{:.1} mm", 1e3 * map.after)) }
                    td.number { (format!("{:.0} %", 100.0 * map.share)) }
                    td { @if is_launch(map) { "the arm" } @else { "the table" } }
                }
            } }))
            div.columns { @for plot in plots { (plot.figure(&plot.title)) } }
            p.legend {
                "The larger, the more. Stop errors are of strikes that each map's fit leaves out."
            }
        }
    }
}

fn quantities(map: &SmoothMap) -> &'static [Quantity] {
    if is_launch(map) { &LAUNCH } else { &FRICTION }
}

fn is_launch(map: &SmoothMap) -> bool {
    map.name == "launch"
}

fn picture(map: &SmoothMap, quantity: &Quantity) -> Plot {
    let change = |point: &MapPoint| quantity.scale * point.change[quantity.component];
    let largest = map
        .points
        .iter()
        .map(|p| change(p).abs())
        .fold(0.0, f64::max);
    let [x, y] = if is_launch(map) {
        ["commanded speed in m/s", "commanded angle in rad"]
    } else {
        ["x in m", "y in m"]
    };
    let points = |less: bool| {
        let of = map
            .points
            .iter()
            .filter(move |point| (change(point) < 0.0) == less);
        let at = of.clone().map(|point| (point.at[0], point.at[1]));
        let share = of.map(move |point| change(point).abs() / largest.max(f64::MIN_POSITIVE));
        let radii = share.map(|share| (RADIUS.0 + (RADIUS.1 - RADIUS.0) * share).round());
        (at, radii.collect())
    };
    let ((less, less_radii), (more, more_radii)) = (points(true), points(false));
    Plot::new(
        x,
        y,
        vec![
            Series::new("less", "less", Kind::Dots, less).sized(less_radii),
            Series::new("more", "more", Kind::Dots, more).sized(more_radii),
        ],
    )
    .titled(format!(
        "{} (up to {largest:.1} {})",
        quantity.title, quantity.unit
    ))
}
