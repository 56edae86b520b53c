//! What counts: stop errors on held-out strikes and at targets.

use std::collections::BTreeMap;

use judge::{Evaluation, misses};
use maud::{Markup, html};
use values::{StopErrors, Strike};

use super::markup::{PageError, drawing, fill, legend, model_names, section, swatch, title};
use super::{figure_8, figures};
use crate::results::{Worlds, worse_than_nominal};
use crate::trial::{Outcome, Trial};

pub fn headline(evaluation: &Evaluation) -> Result<Markup, PageError> {
    let mean = |model: &str| evaluation.models.get(model).map(|errors| errors.mean);
    let saved = |model: &str| match (mean("sysid"), mean(model)) {
        (Some(sysid), Some(error)) if sysid > 0.0 => Some(100.0 * (1.0 - error / sysid)),
        _ => None,
    };
    let best = model_names()
        .into_iter()
        .filter_map(|model| Some((model, saved(model)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, saved)| *saved > 0.0);
    let mut by_model: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in &evaluation.predictions {
        by_model.entry(&row.model).or_default().extend(row.error);
    }
    let shown: Vec<(&str, Vec<f64>)> = model_names()
        .iter()
        .filter_map(|model| Some((*model, by_model.remove(model)?)))
        .filter(|(_, errors)| !errors.is_empty())
        .collect();
    let rows: Vec<Row> = model_rows(&evaluation.models)
        .into_iter()
        .chain(evaluation.noise_floor.iter().map(|errors| Row {
            name: "noise_floor",
            numbers: [errors.mean, errors.sd, errors.median, errors.p95],
            n: errors.n,
            left_out: errors.failed,
        }))
        .collect();
    Ok(section(
        "Stop error on held-out strikes",
        html! {
            div.columns {
                div {
                    (errors_table(&rows, "not predicted"))
                    @if let Some(warning) = worse_than_nominal(evaluation) {
                        p { strong { (warning) } }
                    } @else if let Some((model, saved)) = best {
                        p.big style=(fill(model)) { (format!("{saved:.0} %")) }
                        p { "of the identified simulator's mean stop error is taken off by the best model, " (title(model)) "." }
                    }
                    @if let Some(new) = evaluation.differing_sessions() {
                        h3 { "Each of " (new.sessions) " sessions as if it had never been seen" }
                        (errors_table(&model_rows(&new.models), "not predicted"))
                    }
                    p.note {
                        "The distance between where a strike that took no part in fitting stopped and where the model says that it "
                        "would. The noise floor is what repeats of the same command would scatter by."
                    }
                }
                figure {
                    (drawing(&figures::distribution(&shown)?))
                    (legend(&shown.iter().map(|(model, _)| *model).collect::<Vec<_>>(), None))
                }
            }
        },
    ))
}

fn model_rows(errors: &BTreeMap<String, StopErrors>) -> Vec<Row<'_>> {
    let row = |model: &'static str| {
        let errors = errors.get(model)?;
        Some(Row {
            name: model,
            numbers: [errors.mean, errors.sd, errors.median, errors.p95],
            n: errors.n,
            left_out: errors.failed,
        })
    };
    model_names().into_iter().filter_map(row).collect()
}

/// One line of a table of stop errors, in m.
struct Row<'a> {
    name: &'a str,
    numbers: [f64; 4],
    n: usize,
    left_out: usize,
}

fn errors_table(rows: &[Row<'_>], left_out: &str) -> Markup {
    let any = rows.iter().any(|row| row.left_out > 0);
    html! {
        table {
            thead { tr {
                th { "stop error in cm" } th { "mean ± sd" } th { "median" } th { "95 %" } th { "n" }
                @if any { th { (left_out) } }
            } }
            tbody {
                @for row in rows {
                    tr class=[(row.name == "noise_floor").then_some("floor")] {
                        td { (swatch(row.name)) (title(row.name)) }
                        td.number { (format!("{:.2} ± {:.2}", row.numbers[0] * 100.0, row.numbers[1] * 100.0)) }
                        td.number { (format!("{:.2}", row.numbers[2] * 100.0)) }
                        td.number { (format!("{:.2}", row.numbers[3] * 100.0)) }
                        td.number { (row.n) }
                        @if any { td.number { (row.left_out) } }
                    }
                }
            }
        }
    }
}

pub fn trial_section(trial: &Trial) -> Result<Markup, PageError> {
    fn rows<'a>(outcomes: &'a BTreeMap<String, Outcome>, trial: &'a Trial) -> Vec<Row<'a>> {
        model_names()
            .iter()
            .filter_map(|model| {
                let outcome = outcomes.get(*model)?;
                let errors = outcome.errors?;
                Some(Row {
                    name: model,
                    numbers: [errors.mean, errors.sd, errors.median, errors.p95],
                    n: errors.n,
                    left_out: outcome.refusals.len(),
                })
            })
            .chain(trial.noise_floor.iter().map(|errors| Row {
                name: "noise_floor",
                numbers: [errors.mean, errors.sd, errors.median, errors.p95],
                n: errors.n,
                left_out: 0,
            }))
            .collect()
    }
    let models: Vec<&str> = model_names()
        .into_iter()
        .filter(|model| *model != "nominal" && trial.figure_8.contains_key(*model))
        .collect();
    Ok(section(
        "Closed loop: struck at targets",
        html! {
            div.columns {
                figure {
                    (drawing(&figure_8::figure_8(trial, &models)?))
                    (legend(&models, Some("● start   ✕ target   ellipse: mean and standard deviation of the stops")))
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
    ))
}

pub fn predictions_section(
    strikes: &[Strike],
    worlds: &Worlds,
    evaluation: &Evaluation,
) -> Result<Markup, PageError> {
    let (name, used) = worlds.used();
    let used = used.residual().map_or(name, |_| name.with_residual());
    let parts = misses(used.name(), strikes, &evaluation.predictions)?;
    let names = model_names();
    let models = names
        .iter()
        .filter(|model| evaluation.models.contains_key(**model));
    let plots = models
        .map(|model| figures::predictions(model, strikes, &evaluation.predictions))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(section(
        "Simulated against measured stops",
        html! {
            div.three { @for plot in &plots { figure { (drawing(plot)) } } }
            p.legend { "○ measured stop of a held-out strike   ● where the model says that it stops" }
            @if !parts.is_empty() {
                h3 { "Where it misses: " (title(used.name())) }
                table {
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
                }
            }
        },
    ))
}
