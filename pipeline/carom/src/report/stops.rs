//! What counts: stop errors on held-out strikes and at targets.

use std::collections::BTreeMap;

use judge::{Evaluation, misses};
use maud::{Markup, html};
use values::{StopErrors, Strike};

use super::figure_8::figure_8;
use super::figures::{self, Places};
use super::markup::{PageError, model_names, section, swatch, title, wide};
use crate::publishing::best_model;
use crate::results::Worlds;
use crate::trial::{Outcome, Trial};

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
    wide(html! {
        table {
            thead { tr {
                th { "stop error in cm" } th { "mean ± sd" } th { "median" } th { "95 %" } th { "n" }
                @if any { th { (left_out) } }
            } }
            tbody {
                @for row in rows {
                    tr class=[(row.name == "noise_floor").then_some("floor")] {
                        td { (swatch(row.name)) (title(row.name)) }
                        td.number { (format!("{:.2} ± {:.2}", row.errors.mean * 100.0, row.errors.sd * 100.0)) }
                        td.number { (format!("{:.2}", row.errors.median * 100.0)) }
                        td.number { (format!("{:.2}", row.errors.p95 * 100.0)) }
                        td.number { (row.errors.n) }
                        @if any { td.number { (row.left_out) } }
                    }
                }
            }
        }
    })
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
                (wide(html! { table {
                    thead { tr { th { "stop error in cm" } th { "mean" } th { "95 %" } th { "n" } } }
                    tbody {
                        @for part in &parts {
                            tr {
                                td { (part.part()) }
                                td.number { (format!("{:.2}", part.errors.mean * 100.0)) }
                                td.number { (format!("{:.2}", part.errors.p95 * 100.0)) }
                                td.number { (part.errors.n) }
                            }
                        }
                    }
                } }))
            }
        },
    ))
}
