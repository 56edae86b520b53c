//! Pictures of the real strikes.

use std::path::Path;

use diagnose::Diagnosed;
use plotters::prelude::*;
use values::Strike;

/// Seconds over which a launch's speed is taken.
const LAUNCH: f64 = 0.08;

/// Speed of the object right after the impact, in m/s.
fn launch(strike: &Strike) -> Option<f64> {
    let track = &strike.track;
    let from = track.t.iter().position(|t| *t > 0.02)?;
    let to = track.t.iter().position(|t| *t > 0.02 + LAUNCH)?;
    Some(track.point(to).distance(track.point(from)) / (track.t[to] - track.t[from]))
}

/// Points of one session each in its colour, over the commanded speed.
fn picture(
    strikes: &[(&Strike, f64)],
    what: &str,
    is_straight: bool,
    path: &Path,
) -> anyhow::Result<()> {
    let area = SVGBackend::new(path, (560, 360)).into_drawing_area();
    area.fill(&WHITE)?;
    let (low, high) = strikes
        .iter()
        .fold((0.0f64, 0.0f64), |(l, h), (_, y)| (l.min(*y), h.max(*y)));
    let pad = 0.08 * (high - low);
    let mut chart = ChartBuilder::on(&area)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..3.0, low - pad..high + pad)?;
    chart
        .configure_mesh()
        .x_desc("commanded speed (m/s)")
        .y_desc(what)
        .max_light_lines(0)
        .draw()?;
    if is_straight {
        let line = LineSeries::new([(0.0, 0.0), (high, high)], BLACK.mix(0.4));
        chart
            .draw_series(line)?
            .label("as commanded")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 14, y)], BLACK.mix(0.4)));
    }
    for (session, colour) in [("session_a", BLUE), ("session_b", RED)] {
        let mine = strikes
            .iter()
            .filter(|(strike, _)| strike.conditions.session.starts_with(session));
        chart
            .draw_series(mine.map(|(s, y)| Circle::new((s.command.speed, *y), 3, colour.filled())))?
            .label(session)
            .legend(move |(x, y)| Circle::new((x + 7, y), 3, colour.filled()));
    }
    chart
        .configure_series_labels()
        .border_style(BLACK.mix(0.2))
        .background_style(WHITE)
        .position(SeriesLabelPosition::UpperLeft)
        .draw()?;
    area.present()?;
    Ok(())
}

/// Speeds after the impact over commanded speeds.
pub fn launches(strikes: &[Strike], path: &Path) -> anyhow::Result<()> {
    let seen: Vec<(&Strike, f64)> = strikes
        .iter()
        .filter_map(|s| Some((s, launch(s)?)))
        .collect();
    picture(&seen, "speed after the impact (m/s)", true, path)
}

/// What the identified world leaves of the stops, along the path, over commanded speeds.
pub fn gaps(strikes: &[Strike], found: &Diagnosed, path: &Path) -> anyhow::Result<()> {
    let along = |strike: &Strike| {
        let residual = found
            .residuals
            .iter()
            .find(|residual| residual.strike_id == strike.id);
        residual.map(|residual| residual.before[0])
    };
    let seen: Vec<(&Strike, f64)> = strikes
        .iter()
        .filter_map(|s| Some((s, along(s)?)))
        .collect();
    picture(&seen, "stops further than simulated (m)", false, path)
}
