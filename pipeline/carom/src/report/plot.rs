//! Plots as data: what is drawn is said here, `page.js` draws it with uPlot in the page.

use maud::{Markup, PreEscaped, html};
use serde::Serialize;
use values::Point;

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// From point to point; a point that is no number interrupts it.
    Line,
    /// Filled circles.
    Dots,
    /// Open circles.
    Rings,
    /// Crosses.
    Crosses,
    /// Two points each: from the first to the second, with a head.
    Arrows,
}

/// Points of one kind.
#[derive(Debug, Serialize)]
pub struct Series {
    /// In the legend; none for what the text explains.
    pub name: Option<String>,
    /// Whose colour it has: a model's name, `measured`, `faint`, `less` or `more`.
    pub colour: &'static str,
    /// How it is drawn.
    pub kind: Kind,
    #[serde(serialize_with = "short_numbers")]
    x: Vec<f64>,
    #[serde(serialize_with = "short_numbers")]
    y: Vec<f64>,
    /// For each point (for each two of arrows) its strike's place among the strikes of the run; empty where points are of no strike.
    strikes: Vec<usize>,
    /// Radius of each point in pixels; empty for the usual one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    radii: Vec<f64>,
    /// Pale where it matters less.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    is_pale: bool,
}

/// Axes and what is between them.
#[derive(Debug, Serialize)]
pub struct Plot {
    /// Above the plot; empty for none.
    pub title: String,
    /// Below the horizontal axis.
    pub x: &'static str,
    /// Beside the vertical axis.
    pub y: &'static str,
    /// Whether a metre is as long along x as along y.
    pub is_map: bool,
    /// Whether x is logarithmic.
    pub log_x: bool,
    /// Whether x counts: whole numbers are beside the axis, and no others.
    pub counts_x: bool,
    /// Ends of the vertical axis, where they are not those of the points.
    pub y_range: Option<[f64; 2]>,
    /// Ends of the horizontal axis, where they are not those of the points.
    pub x_range: Option<[f64; 2]>,
    /// A rectangle that is shaded, x from and to, y from and to: the table.
    pub shaded: Option<[f64; 4]>,
    /// What is drawn, the first below.
    pub series: Vec<Series>,
}

impl Series {
    /// Points of no strike.
    pub fn new(
        name: impl Into<Option<&'static str>>,
        colour: &'static str,
        kind: Kind,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let (x, y) = points.into_iter().unzip();
        Self {
            name: name.into().map(String::from),
            colour,
            kind,
            x,
            y,
            strikes: Vec::new(),
            radii: Vec::new(),
            is_pale: false,
        }
    }

    /// Points of strikes, by their places.
    pub fn of_strikes(
        name: impl Into<Option<&'static str>>,
        colour: &'static str,
        kind: Kind,
        points: impl IntoIterator<Item = (usize, (f64, f64))>,
    ) -> Self {
        let (strikes, points): (_, Vec<_>) = points.into_iter().unzip();
        Self {
            strikes,
            ..Self::new(name, colour, kind, points)
        }
    }

    /// Arrows of strikes.
    pub fn arrows(
        name: impl Into<Option<&'static str>>,
        colour: &'static str,
        arrows: impl IntoIterator<Item = (usize, [Point; 2])>,
    ) -> Self {
        let (strikes, ends): (_, Vec<_>) = arrows.into_iter().unzip();
        let ends = ends.into_iter().flat_map(|ends| ends.map(xy));
        Self {
            strikes,
            ..Self::new(name, colour, Kind::Arrows, ends)
        }
    }

    /// This series, named at run time.
    pub fn named(self, name: String) -> Self {
        Self {
            name: Some(name),
            ..self
        }
    }

    /// This series, paler.
    pub fn pale(self) -> Self {
        Self {
            is_pale: true,
            ..self
        }
    }

    /// This series with these radii, in pixels.
    pub fn sized(self, radii: Vec<f64>) -> Self {
        Self { radii, ..self }
    }
}

impl Plot {
    /// Plain axes.
    pub fn new(x: &'static str, y: &'static str, series: Vec<Series>) -> Self {
        Self {
            title: String::new(),
            x,
            y,
            is_map: false,
            log_x: false,
            counts_x: false,
            y_range: None,
            x_range: None,
            shaded: None,
            series,
        }
    }

    /// The table from above.
    pub fn map(series: Vec<Series>) -> Self {
        Self {
            is_map: true,
            ..Self::new("x in m, away from the robot", "y in m", series)
        }
    }

    /// This plot with a title.
    pub fn titled(self, title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            ..self
        }
    }

    /// The plot's place in the page, and its data; `said` is what it shows, for whom a picture says nothing.
    pub fn figure(&self, said: &str) -> Markup {
        html! {
            figure.plot aria-label=(said) {
                @if !self.title.is_empty() { figcaption { (self.title) } }
                (data(self, None))
            }
        }
    }
}

/// A value as JSON within the page.
pub fn data<T: Serialize>(value: &T, id: Option<&str>) -> Markup {
    // Plain data: what cannot be written is a defect of this module. Nothing within may end the element.
    let text = serde_json::to_string(value)
        .expect("plain data")
        .replace('<', "\\u003c");
    html! { script type="application/json" id=[id] { (PreEscaped(text)) } }
}

/// Numbers to five figures: a page is read by people. What is no number is null.
fn short_numbers<S: serde::Serializer>(values: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(values.iter().map(|value| Short(*value)))
}

/// A number to five figures.
#[derive(Clone, Copy, Debug)]
pub struct Short(pub f64);

impl Serialize for Short {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(value) = *self;
        if !value.is_finite() {
            return serializer.serialize_none();
        }
        if value == 0.0 {
            return serializer.serialize_u8(0);
        }
        let scale = 10f64.powf(4.0 - value.abs().log10().floor());
        let rounded = (value * scale).round() / scale;
        match rounded.fract() == 0.0 && rounded.abs() < 1e15 {
            true => serializer.serialize_i64(rounded as i64),
            false => serializer.serialize_f64(rounded),
        }
    }
}

/// A number as short as it can be said.
pub fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.into()
}

/// A point's coordinates.
pub fn xy(point: Point) -> (f64, f64) {
    (point.x, point.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_what_is_none_is_null() {
        assert_eq!(
            [0.5, -0.0, 12.0, 0.012_34].map(short),
            ["0.5", "0", "12", "0.0123"]
        );
        let text = |value| serde_json::to_string(&Short(value)).expect("a number");
        assert_eq!(
            [0.123_456_78, 12.0, -0.0, f64::NAN].map(text),
            ["0.12346", "12", "0", "null"]
        );
    }

    #[test]
    fn what_is_told_to_the_page_cannot_leave_its_element() {
        let text = data(&"</script><b>", None).into_string();
        assert_eq!(text.matches("</script>").count(), 1, "{text}");
    }
}
