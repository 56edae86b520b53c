//! The report's plots, each from plain values.

use std::collections::{BTreeSet, HashMap};

use judge::Prediction;
use train::Epoch;
use values::{Residual, Rig, Split, Strike};

use super::markup::{in_colours, title};
use super::plot::{Kind, Plot, Series, xy};

const CM: f64 = 100.0;
const MM: f64 = 1000.0;

/// The place among the run's of each strike that the page lists, by its name.
pub type Places<'a> = HashMap<&'a str, usize>;

/// The table's rectangle, for [`Plot::shaded`].
pub fn table_of(rig: &Rig) -> Option<[f64; 4]> {
    let (x, y) = (rig.table.x, rig.table.y);
    Some([x.low, x.high, y.low, y.high])
}

/// Where the listed strikes stopped; a click opens one.
pub fn table(rig: &Rig, strikes: &[Strike], listed: &BTreeSet<usize>) -> Plot {
    let listed = || listed.iter().map(|place| (*place, &strikes[*place]));
    let stops = |learnt: bool| {
        let of = move |(_, strike): &(usize, &Strike)| (strike.split == Split::Train) == learnt;
        listed()
            .filter(|(_, strike)| strike.has_stop())
            .filter(of)
            .map(|(place, strike)| (place, xy(strike.stop)))
    };
    let starts = listed().map(|(place, strike)| (place, xy(strike.initial)));
    Plot {
        shaded: table_of(rig),
        ..Plot::map(vec![
            Series::of_strikes("start", "measured", Kind::Rings, starts).pale(),
            Series::of_strikes(
                "stop, learnt from",
                "sysid_residual",
                Kind::Dots,
                stops(true),
            ),
            Series::of_strikes("stop, held out", "sysid", Kind::Dots, stops(false)),
        ])
    }
}

/// Measured stops of held-out strikes, and where a model says that they are.
pub fn predictions(
    model: &'static str,
    strikes: &[Strike],
    places: &Places<'_>,
    predictions: &[Prediction],
) -> Plot {
    let pairs: Vec<_> = predictions
        .iter()
        .filter(|row| row.model == model)
        .filter_map(|row| {
            let place = *places.get(row.strike_id.as_str())?;
            Some((place, [row.stop?, strikes[place].stop]))
        })
        .collect();
    let measured = pairs.iter().map(|(place, [_, stop])| (*place, xy(*stop)));
    let measured = Series::of_strikes("measured", "measured", Kind::Rings, measured);
    let arrows = Series::arrows(
        "from where the model says",
        in_colours(model),
        pairs.iter().copied(),
    );
    Plot::map(vec![arrows, measured]).titled(title(model))
}

/// What was learnt: the residual of every strike, and what the network says for it.
pub fn residuals(
    model: &'static str,
    rows: &[Residual],
    places: &Places<'_>,
    said: &[[f64; 2]],
    quantity: usize,
) -> Plot {
    let of = |row: &Residual| [row.d_speed, row.d_angle][quantity];
    let against = |row: &Residual| [row.speed_sim, row.angle_sim][quantity];
    let [x, y] = [
        ["simulated speed in m/s", "residual of speed in m/s"],
        ["simulated angle in rad", "residual of angle in rad"],
    ][quantity];
    let place = |row: &Residual| places.get(row.strike_id.as_str()).copied();
    let measured = rows
        .iter()
        .filter_map(|row| Some((place(row)?, (against(row), of(row)))));
    let learnt = rows
        .iter()
        .zip(said)
        .filter_map(|(row, said)| Some((place(row)?, (against(row), said[quantity]))));
    Plot::new(
        x,
        y,
        vec![
            Series::of_strikes("commanded less simulated", "measured", Kind::Dots, measured).pale(),
            Series::of_strikes("learnt", in_colours(model), Kind::Dots, learnt),
        ],
    )
}

/// Errors epoch by epoch.
pub fn history(model: &'static str, epochs: &[Epoch], best: usize) -> Plot {
    let points = |value: fn(&Epoch) -> f64| {
        let all = epochs.iter();
        all.map(move |epoch| (epoch.epoch as f64, value(epoch)))
    };
    let validation = points(|epoch| epoch.validation_mae);
    let at_best = epochs.iter().find(|epoch| epoch.epoch == best);
    let at_best = at_best.map(|epoch| (best as f64, epoch.validation_mae));
    let train = points(|epoch| epoch.train_loss.sqrt());
    let top = train.clone().chain(validation.clone()).map(|point| point.1);
    let top = top.fold(0.0, f64::max);
    Plot {
        y_range: Some([0.0, 1.05 * top]),
        ..Plot::new(
            "epoch",
            "error, in deviations",
            vec![
                Series::new("training", "measured", Kind::Line, train).pale(),
                Series::new("validation", in_colours(model), Kind::Line, validation),
                Series::new("used", in_colours(model), Kind::Dots, at_best),
            ],
        )
    }
}

/// Mean stop error on held-out strikes, in m, by the number of strikes learnt from; `levels` are drawn across.
pub fn learning_curve(
    model: &'static str,
    points: &[(usize, f64)],
    levels: &[(&'static str, f64)],
) -> Plot {
    let (first, last) = match (points.first(), points.last()) {
        (Some(first), Some(last)) => (first.0 as f64, last.0 as f64),
        _ => (25.0, 500.0),
    };
    let ends = [first * 0.85, last * 1.18];
    let highest = points.iter().map(|point| point.1);
    let highest = highest
        .chain(levels.iter().map(|level| level.1))
        .fold(0.0, f64::max);
    let across = levels.iter().map(|(name, level)| {
        let points = ends.map(|at| (at, level * CM));
        Series::new(None, in_colours(name), Kind::Line, points).named(title(name))
    });
    let curve = || points.iter().map(|(n, error)| (*n as f64, error * CM));
    let hue = in_colours(model);
    let mut series: Vec<Series> = across.collect();
    series.push(Series::new(None, hue, Kind::Line, curve()).named(title(model)));
    series.push(Series::new(None, hue, Kind::Dots, curve()));
    Plot {
        log_x: true,
        x_range: Some(ends),
        y_range: Some([0.0, (1.1 * highest * CM).max(0.1)]),
        ..Plot::new("strikes learnt from", "mean stop error in cm", series)
    }
}

/// How stop errors are distributed: the share of strikes below an error, model by model.
pub fn distribution(models: &[(&'static str, Vec<f64>)]) -> Plot {
    // A few strikes of the worst model would squeeze the others into the corner.
    let far = models
        .iter()
        .filter(|(model, _)| *model != "nominal" || models.len() == 1)
        .flat_map(|(_, errors)| errors)
        .copied()
        .fold(0.0, f64::max);
    let end = (1.05 * far * CM).max(0.1);
    let series = models.iter().map(|(model, errors)| {
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
        Series::new(None, in_colours(model), Kind::Line, steps).named(title(model))
    });
    Plot {
        x_range: Some([0.0, end]),
        y_range: Some([0.0, 1.02]),
        ..Plot::new("stop error in cm", "share of strikes", series.collect())
    }
}

/// A length for a person, in mm.
pub fn millimetres(length: f64) -> String {
    format!("{:.2} mm", length * MM)
}
