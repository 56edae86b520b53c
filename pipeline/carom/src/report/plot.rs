//! Axes and colours that every plot shares. Plotters draws; text is SVG text, so no font is needed.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use values::{Point, Rig};

/// Failures of the SVG backend, which writes to a string.
pub type PlotError = DrawingAreaErrorKind<std::io::Error>;
/// A drawing area.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// A plot with linear axes.
pub type Chart<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// What was measured.
pub const MEASURED: RGBColor = RGBColor(38, 44, 54);
/// What carries no meaning of its own.
pub const FAINT: RGBColor = RGBColor(170, 178, 188);
const NOMINAL: RGBColor = RGBColor(150, 120, 190);
const SYSID: RGBColor = RGBColor(222, 120, 40);
const RESIDUAL: RGBColor = RGBColor(20, 125, 120);
const EFFECT: RGBColor = RGBColor(45, 105, 200);
const EFFECT_RESIDUAL: RGBColor = RGBColor(165, 35, 80);

/// The colour of a model, the same in every plot.
pub fn colour(model: &str) -> RGBColor {
    match model {
        "nominal" => NOMINAL,
        "sysid" => SYSID,
        "sysid_residual" => RESIDUAL,
        "effect" => EFFECT,
        "effect_residual" => EFFECT_RESIDUAL,
        _ => FAINT,
    }
}

/// Where a plot lies and what its axes say.
pub struct Axes<'t> {
    /// Above the plot; empty for none.
    pub title: &'t str,
    /// Below the horizontal axis.
    pub x: &'t str,
    /// Beside the vertical axis.
    pub y: &'t str,
    /// Ends of the horizontal axis.
    pub x_range: (f64, f64),
    /// Ends of the vertical axis.
    pub y_range: (f64, f64),
}

/// Draws into an SVG of this size, in pixels, and gives its text.
pub fn svg(
    size: (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&area)?;
        area.present()?;
    }
    Ok(text)
}

const MARGIN: i32 = 8;
const TITLE_SIZE: i32 = 16;
/// Size of the text beside axes; SVG text is a fifth smaller.
pub const LABEL_SIZE: i32 = 14;
pub const X_LABELS: u32 = 42;
pub const Y_LABELS: u32 = 58;

/// Linear axes in an area.
pub fn axes<'a, 'b>(area: &'a Area<'b>, axes: &Axes<'_>) -> Result<Chart<'a, 'b>, PlotError> {
    let mut builder = ChartBuilder::on(area);
    builder
        .margin(MARGIN)
        .x_label_area_size(X_LABELS)
        .y_label_area_size(Y_LABELS);
    if !axes.title.is_empty() {
        builder.caption(
            axes.title,
            ("sans-serif", TITLE_SIZE).into_font().color(&MEASURED),
        );
    }
    let mut chart = builder.build_cartesian_2d(
        axes.x_range.0..axes.x_range.1,
        axes.y_range.0..axes.y_range.1,
    )?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT.mix(0.35))
        .axis_style(FAINT)
        .x_desc(axes.x)
        .y_desc(axes.y)
        .x_labels(6)
        .y_labels(6)
        .x_label_formatter(&short)
        .y_label_formatter(&short)
        .label_style(("sans-serif", LABEL_SIZE).into_font().color(&MEASURED))
        .draw()?;
    Ok(chart)
}

/// Shades the table.
pub fn shade_table(chart: &mut Chart<'_, '_>, rig: &Rig) -> Result<(), PlotError> {
    let corners = [
        (rig.table.x.low, rig.table.y.low),
        (rig.table.x.high, rig.table.y.high),
    ];
    chart.draw_series([Rectangle::new(corners, FAINT.mix(0.10).filled())])?;
    Ok(())
}

/// A number as short as it can be said.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature that plotters calls"
)]
pub fn short(value: &f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}

/// A view of the table in which a metre is as long along x as along y; `size` is that of the whole area in pixels.
pub fn view(points: impl Iterator<Item = Point>, size: (u32, u32)) -> ((f64, f64), (f64, f64)) {
    let (mut x, mut y) = (EMPTY, EMPTY);
    for point in points.filter(|point| point.is_finite()) {
        x = (x.0.min(point.x), x.1.max(point.x));
        y = (y.0.min(point.y), y.1.max(point.y));
    }
    if x.0 > x.1 {
        return ((0.0, 1.0), (0.0, 1.0));
    }
    let plot = |pixels: u32, labels: u32| f64::from(pixels - labels) - 2.0 * f64::from(MARGIN);
    let width = plot(size.0, Y_LABELS);
    let height = plot(size.1, X_LABELS) - 1.6 * f64::from(TITLE_SIZE);
    // Metres a pixel, with a twentieth of free space on each side.
    let scale = 1.1 * ((x.1 - x.0) / width).max((y.1 - y.0) / height).max(1e-6);
    let around = |(low, high): (f64, f64), pixels: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * scale * pixels);
        (middle - half, middle + half)
    };
    (around(x, width), around(y, height))
}

const EMPTY: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// A range that holds all values, with some free space; never empty.
pub fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold(EMPTY, |(low, high), value| {
            (low.min(value), high.max(value))
        });
    if low > high {
        return (0.0, 1.0);
    }
    let space = (0.06 * (high - low)).max(1e-9);
    (low - space, high + space)
}

/// A straight line.
pub fn line(
    from: (f64, f64),
    to: (f64, f64),
    style: impl Into<ShapeStyle>,
) -> PathElement<(f64, f64)> {
    PathElement::new([from, to], style)
}

/// A point's coordinates.
pub fn xy(point: Point) -> (f64, f64) {
    (point.x, point.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_keeps_circles_round() {
        let ((x0, x1), (y0, y1)) = view(
            [Point::new(0.1, -0.2), Point::new(0.9, 0.2)].into_iter(),
            (460, 400),
        );
        assert!(x0 < 0.1 && x1 > 0.9 && y0 < -0.2 && y1 > 0.2);
        let (width, height) = (460.0 - 58.0 - 16.0, 400.0 - 42.0 - 16.0 - 1.6 * 16.0);
        assert!(((x1 - x0) / width - (y1 - y0) / height).abs() < 1e-12);
    }

    #[test]
    fn labels_are_short() {
        assert_eq!(
            [0.5, -0.0, 12.0, 0.012_34].map(|v| short(&v)),
            ["0.5", "0", "12", "0.0123"]
        );
    }
}
