//! What counts: stop errors on held-out strikes and at targets.

use std::collections::BTreeMap;

use judge::{Evaluation, misses};
use maud::{Markup, html};
use values::{Point, StopErrors, Strike};

use super::figures::{self, Places};
use super::markup::{PageError, in_colours, model_names, section, swatch, table, title, wide};
use super::plot::{Kind, Plot, Series, xy};
use crate::publishing::best_model;
use crate::results::Worlds;
use crate::trial::{Outcome, TargetStrike, Trial};

pub fn errors_section(evaluation: &Evaluation) -> Markup {
    let mut by_model: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in &evaluation.predictions {
        by_model.entry(&row.model).or_default().extend(row.error);
    }
    let shown: Vec<(&'static str, Vec<f64>)> = model_names()
        .into_iter()
        .filter_map(|model| Some((model, by_model.remove(model)?)))
        .filter(|(_, errors)| !errors.is_empty())
        .collect();
    let rows: Vec<Row<'_>> = model_rows(&evaluation.models)
        .into_iter()
        .chain(
            evaluation
                .noise_floor
                .map(|errors| Row::of("noise_floor", errors)),
        )
        .collect();
    section(
        "Stop error on held-out strikes",
        html! {
            div.columns {
                div {
                    @if let Some(new) = evaluation.differing_sessions() {
                        h3 { "In a session that was never seen: each of " (new.sessions) " left out in turn" }
                        (errors_table(&model_rows(&new.models), "not predicted"))
                        h3 { "In the sessions that were learnt from" }
                    }
                    (errors_table(&rows, "not predicted"))
                    p.note {
                        "The distance between where a strike that took no part in fitting, in naming effects or in choosing a model "
                        "stopped and where the model says that it would. The noise floor is what repeats of the same command would "
                        "scatter by."
                    }
                }
                (figures::distribution(&shown).figure("share of held-out strikes below a stop error, model by model"))
            }
        },
    )
}

fn model_rows(errors: &BTreeMap<String, StopErrors>) -> Vec<Row<'_>> {
    let row = |model: &'static str| Some(Row::of(model, *errors.get(model)?));
    model_names().into_iter().filter_map(row).collect()
}

/// One line of a table of stop errors, in m.
struct Row<'a> {
    name: &'a str,
    errors: StopErrors,
    left_out: usize,
}

impl<'a> Row<'a> {
    fn of(name: &'a str, errors: StopErrors) -> Self {
        Self {
            name,
            errors,
            left_out: errors.failed,
        }
    }
}

fn errors_table(rows: &[Row<'_>], left_out: &str) -> Markup {
    let any = rows.iter().any(|row| row.left_out > 0);
    let mut headings = vec!["stop error in cm", "mean ± sd", "median", "95 %", "n"];
    headings.extend(any.then_some(left_out));
    wide(table(
        &headings,
        html! { @for row in rows {
            tr class=[(row.name == "noise_floor").then_some("floor")] {
                td { (swatch(row.name)) (title(row.name)) }
                td.number { (format!("{:.2} ± {:.2}", row.errors.mean * 100.0, row.errors.sd * 100.0)) }
                td.number { (format!("{:.2}", row.errors.median * 100.0)) }
                td.number { (format!("{:.2}", row.errors.p95 * 100.0)) }
                td.number { (row.errors.n) }
                @if any { td.number { (row.left_out) } }
            }
        } },
    ))
}

pub fn trial_section(trial: &Trial) -> Markup {
    fn rows<'a>(outcomes: &'a BTreeMap<String, Outcome>, trial: &'a Trial) -> Vec<Row<'a>> {
        model_names()
            .iter()
            .filter_map(|model| {
                let outcome = outcomes.get(*model)?;
                Some(Row {
                    left_out: outcome.refusals.len(),
                    ..Row::of(model, outcome.errors?)
                })
            })
            .chain(trial.noise_floor.map(|errors| Row {
                left_out: 0,
                ..Row::of("noise_floor", errors)
            }))
            .collect()
    }
    let models: Vec<&'static str> = model_names()
        .into_iter()
        .filter(|model| *model != "nominal" && trial.figure_8.contains_key(*model))
        .collect();
    section(
        "Closed loop: struck at targets",
        html! {
            div.columns {
                div {
                    (figure_8(trial, &models).figure("starts, targets, and mean and standard deviation of the stops"))
                    p.legend { "ellipse: mean and standard deviation of the stops" }
                }
                div {
                    h3 { "Two starts, four targets each, repeated" }
                    (errors_table(&rows(&trial.figure_8, trial), "refused"))
                    h3 { "Random targets" }
                    (errors_table(&rows(&trial.models, trial), "refused"))
                    @if let Some(new) = &trial.new_sessions {
                        h3 { "The same targets in " (new.sessions) " new sessions" }
                        (errors_table(&rows(&new.models, trial), "refused"))
                    }
                    p.note {
                        "Version " (trial.artifact) " struck " (trial.robot) ". "
                        (trial.drawn) " random targets were drawn; those that the default model refused to strike at are not struck at "
                        "by any model. Every model met the same launches. The floor is the scatter of repeats of one command."
                    }
                }
            }
        },
    )
}

pub fn predictions_section(
    strikes: &[Strike],
    places: &Places<'_>,
    worlds: &Worlds,
    evaluation: &Evaluation,
) -> Result<Markup, PageError> {
    let used = best_model(worlds).name();
    let parts = misses(used, strikes, &evaluation.predictions)?;
    let models = model_names().into_iter();
    let models = models.filter(|model| evaluation.models.contains_key(*model));
    Ok(section(
        "Simulated against measured stops",
        html! {
            div.three { @for model in models {
                @let plot = figures::predictions(model, strikes, places, &evaluation.predictions);
                (plot.figure(&format!("stops of held-out strikes, measured and by the {}", plot.title)))
            } }
            @if !parts.is_empty() {
                h3 { "Where it misses: " (title(used)) }
                (wide(table(&["stop error in cm", "mean", "95 %", "n"], html! { @for part in &parts {
                    tr {
                        td { (part.part()) }
                        td.number { (format!("{:.2}", part.errors.mean * 100.0)) }
                        td.number { (format!("{:.2}", part.errors.p95 * 100.0)) }
                        td.number { (part.errors.n) }
                    }
                } })))
            }
        },
    ))
}

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
