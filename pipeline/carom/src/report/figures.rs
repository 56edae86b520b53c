//! The report's plots, each from plain values to the text of an SVG.

use judge::Prediction;
use plotters::prelude::*;
use train::Epoch;
use values::{Point, Residual, Rig, Split, Strike};

use super::plot::{
    Axes, FAINT, LABEL_SIZE, MEASURED, PlotError, X_LABELS, Y_LABELS, axes, colour, line, range,
    shade_table, short, svg, view, xy,
};

const CM: f64 = 100.0;
const MM: f64 = 1000.0;
/// Tracks drawn on the table at the most, and points of each: more make the page heavy and no clearer.
const TRACKS: usize = 250;
const TRACK_POINTS: usize = 8;

/// Every kept strike on the table: where it started, its way, where it stopped.
pub fn table(rig: &Rig, strikes: &[Strike]) -> Result<String, PlotError> {
    let size = (620, 560);
    svg(size, |area| {
        let ends = strikes
            .iter()
            .flat_map(|strike| [strike.initial, strike.stop]);
        let (x_range, y_range) = view(ends, size);
        let mut chart = axes(
            area,
            &Axes {
                title: "",
                x: "x in m, away from the robot",
                y: "y in m, to its left",
                x_range,
                y_range,
            },
        )?;
        shade_table(&mut chart, rig)?;
        let every = strikes.len().div_ceil(TRACKS).max(1);
        for strike in strikes.iter().step_by(every) {
            let track = &strike.track;
            let step = track.len().div_ceil(TRACK_POINTS).max(1);
            let way = (0..track.len())
                .step_by(step)
                .map(|frame| xy(track.point(frame)));
            let way: Vec<_> = way.chain([xy(strike.stop)]).collect();
            chart.draw_series([PathElement::new(way, FAINT.mix(0.6))])?;
        }
        let starts = strikes.iter().step_by(every);
        chart.draw_series(
            starts
                .clone()
                .map(|strike| Circle::new(xy(strike.initial), 2, MEASURED.mix(0.6))),
        )?;
        chart.draw_series(starts.map(|strike| {
            let learnt = strike.split == Split::Train;
            let colour = colour(if learnt { "sysid_residual" } else { "sysid" });
            Circle::new(xy(strike.stop), 2, colour.mix(0.8).filled())
        }))?;
        Ok(())
    })
}

/// Measured stops of held-out strikes, and where a model says that they are.
pub fn predictions(
    model: &str,
    strikes: &[Strike],
    predictions: &[Prediction],
) -> Result<String, PlotError> {
    let size = (400, 380);
    let title = super::markup::title(model);
    let pairs: Vec<(Point, Point)> = predictions
        .iter()
        .filter(|row| row.model == model)
        .filter_map(|row| {
            let strike = strikes.iter().find(|strike| strike.id == row.strike_id)?;
            Some((strike.stop, row.stop?))
        })
        .collect();
    // One view for all models, so that they can be compared.
    let everything = predictions.iter().filter_map(|row| row.stop);
    svg(size, |area| {
        let (x_range, y_range) = view(everything.chain(pairs.iter().map(|pair| pair.0)), size);
        let mut chart = axes(
            area,
            &Axes {
                title: &title,
                x: "x in m",
                y: "y in m",
                x_range,
                y_range,
            },
        )?;
        let hue = colour(model);
        chart.draw_series(pairs.iter().map(|(measured, said)| {
            line(xy(*measured), xy(*said), hue.mix(0.6).stroke_width(2))
        }))?;
        chart.draw_series(
            pairs
                .iter()
                .map(|(_, said)| Circle::new(xy(*said), 3, hue.filled())),
        )?;
        chart.draw_series(
            pairs
                .iter()
                .map(|(measured, _)| Circle::new(xy(*measured), 3, MEASURED.stroke_width(1))),
        )?;
        Ok(())
    })
}

/// Distance travelled against time, measured and by each world.
pub fn slide(
    title: &str,
    measured: &[(f64, f64)],
    worlds: &[(&str, Vec<(f64, f64)>)],
) -> Result<String, PlotError> {
    svg((400, 260), |area| {
        let all = || worlds.iter().flat_map(|world| &world.1).chain(measured);
        let mut chart = axes(
            area,
            &Axes {
                title,
                x: "s since the strike",
                y: "m travelled",
                x_range: range(all().map(|point| point.0)),
                y_range: range(all().map(|point| point.1)),
            },
        )?;
        for (model, track) in worlds {
            chart.draw_series([PathElement::new(
                track.clone(),
                colour(model).stroke_width(2),
            )])?;
        }
        chart.draw_series(
            measured
                .iter()
                .map(|point| Circle::new(*point, 2, MEASURED.mix(0.7))),
        )?;
        Ok(())
    })
}

/// What was learnt: the residual of every strike, and what the network says for it.
pub fn residuals(
    model: &str,
    rows: &[Residual],
    said: &[[f64; 2]],
    quantity: usize,
) -> Result<String, PlotError> {
    let of = |row: &Residual| [row.d_speed, row.d_angle][quantity];
    let against = |row: &Residual| [row.speed_sim, row.angle_sim][quantity];
    let (x, y) = [
        ("simulated speed in m/s", "residual of speed in m/s"),
        ("simulated angle in rad", "residual of angle in rad"),
    ][quantity];
    svg((400, 300), |area| {
        let values = rows
            .iter()
            .map(of)
            .chain(said.iter().map(|row| row[quantity]));
        let mut chart = axes(
            area,
            &Axes {
                title: "",
                x,
                y,
                x_range: range(rows.iter().map(against)),
                y_range: range(values),
            },
        )?;
        chart.draw_series(
            rows.iter()
                .map(|row| Circle::new((against(row), of(row)), 2, MEASURED.mix(0.35).filled())),
        )?;
        chart.draw_series(rows.iter().zip(said).map(|(row, said)| {
            let hue = colour(model).mix(0.7);
            Circle::new((against(row), said[quantity]), 2, hue.filled())
        }))?;
        Ok(())
    })
}

/// Errors epoch by epoch.
pub fn history(model: &str, epochs: &[Epoch], best: usize) -> Result<String, PlotError> {
    svg((400, 300), |area| {
        let points = |value: fn(&Epoch) -> f64| -> Vec<(f64, f64)> {
            epochs
                .iter()
                .map(|epoch| (epoch.epoch as f64, value(epoch)))
                .collect()
        };
        let train = points(|epoch| epoch.train_loss.sqrt());
        let validation = points(|epoch| epoch.validation_mae);
        let top = train.iter().chain(&validation).map(|point| point.1);
        let y_range = (0.0, range(top).1);
        let mut chart = axes(
            area,
            &Axes {
                title: "",
                x: "epoch",
                y: "error, in deviations",
                x_range: (0.0, epochs.len() as f64 + 1.0),
                y_range,
            },
        )?;
        let at = best as f64;
        chart.draw_series([line((at, 0.0), (at, y_range.1), FAINT)])?;
        chart.draw_series([PathElement::new(train, MEASURED.mix(0.6))])?;
        chart.draw_series([PathElement::new(validation, colour(model).stroke_width(2))])?;
        Ok(())
    })
}

/// Mean stop error on held-out strikes, in m, by the number of strikes learnt from; `levels` are drawn across.
pub fn learning_curve(
    model: &str,
    points: &[(usize, f64)],
    levels: &[(&str, f64)],
) -> Result<String, PlotError> {
    svg((400, 300), |area| {
        let errors = points.iter().map(|point| point.1);
        let highest = errors
            .chain(levels.iter().map(|level| level.1))
            .fold(0.0, f64::max);
        let (first, last) = match (points.first(), points.last()) {
            (Some(first), Some(last)) => (first.0 as f64, last.0 as f64),
            _ => (25.0, 500.0),
        };
        let ends = (first * 0.85, last * 1.18);
        let mut chart = ChartBuilder::on(area)
            .margin(8)
            .x_label_area_size(X_LABELS)
            .y_label_area_size(Y_LABELS)
            .build_cartesian_2d(
                (ends.0..ends.1)
                    .log_scale()
                    .with_key_points(points.iter().map(|point| point.0 as f64).collect()),
                0.0..(1.1 * highest * CM).max(0.1),
            )?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT.mix(0.35))
            .axis_style(FAINT)
            .x_desc("strikes")
            .y_desc("mean stop error in cm")
            .x_label_formatter(&short)
            .y_label_formatter(&short)
            .label_style(("sans-serif", LABEL_SIZE).into_font().color(&MEASURED))
            .draw()?;
        for (name, level) in levels {
            let across = [(ends.0, level * CM), (ends.1, level * CM)];
            chart.draw_series([PathElement::new(across, colour(name).stroke_width(2))])?;
        }
        let curve: Vec<_> = points
            .iter()
            .map(|(strikes, error)| (*strikes as f64, error * CM))
            .collect();
        let hue = colour(model);
        chart.draw_series([PathElement::new(curve.clone(), hue.stroke_width(2))])?;
        chart.draw_series(
            curve
                .into_iter()
                .map(|point| Circle::new(point, 4, hue.filled())),
        )?;
        Ok(())
    })
}

/// How stop errors are distributed: the share of strikes below an error, model by model.
pub fn distribution(models: &[(&str, Vec<f64>)]) -> Result<String, PlotError> {
    svg((620, 300), |area| {
        // A few strikes of the worst model would squeeze the others into the corner.
        let far = models
            .iter()
            .filter(|(model, _)| *model != "nominal" || models.len() == 1)
            .flat_map(|(_, errors)| errors)
            .copied()
            .fold(0.0, f64::max);
        let end = (1.05 * far * CM).max(0.1);
        let mut chart = axes(
            area,
            &Axes {
                title: "",
                x: "stop error in cm",
                y: "share of strikes",
                x_range: (0.0, end),
                y_range: (0.0, 1.02),
            },
        )?;
        for (model, errors) in models {
            let mut sorted = errors.clone();
            sorted.sort_by(f64::total_cmp);
            let share = |place: usize| place as f64 / sorted.len() as f64;
            let mut steps = vec![(0.0, 0.0)];
            let within = sorted.iter().take_while(|error| **error * CM <= end);
            for (place, error) in within.enumerate() {
                let at = error * CM;
                steps.extend([(at, share(place)), (at, share(place + 1))]);
            }
            if let Some((at, share)) = steps.last().copied()
                && at < end
            {
                steps.push((end, share));
            }
            chart.draw_series([PathElement::new(steps, colour(model).stroke_width(2))])?;
        }
        Ok(())
    })
}

/// A length for a person, in mm.
pub fn millimetres(length: f64) -> String {
    format!("{:.2} mm", length * MM)
}
