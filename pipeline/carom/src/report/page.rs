//! The page: sections in the order in which a person asks.

use std::collections::BTreeMap;

use evaluate::Evaluation;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sysid::Fit;
use train::Trained;
use values::{Conditions, Reject, Split, Strike};
use world::{PARAMETERS, Simulator, World, WorldError};

use super::plot::{PlotError, colour};
use super::{Shown, figures};
use crate::trial::{Outcome, Trial};

const STYLE: &str = include_str!("style.css");
/// Models in the order of tables and plots.
pub const MODELS: [&str; 5] = [
    "nominal",
    "sysid",
    "sysid_residual",
    "effect",
    "effect_residual",
];
/// Slides that are shown in full.
const SLIDES: usize = 3;
/// Rejected strikes listed at the most; the table holds all.
const REJECTS: usize = 50;

/// Why the page could not be made. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A plot failed.
    #[error("draw the report: {0}")]
    Plot(#[from] PlotError),
    /// A slide could not be simulated.
    #[error("simulate a slide for the report: {0}")]
    World(#[from] WorldError),
}

/// The whole page as text.
pub fn page(shown: &Shown<'_>) -> Result<String, PageError> {
    let results = shown.results;
    let title = match &shown.provenance.version {
        Some(version) => format!("carom report · {version}"),
        None => "carom report".to_string(),
    };
    let body = html! {
        h1 { "From strike logs to a robot that strikes" }
        p.lead {
            (results.strikes.len()) " strikes of a " (shown.inputs.rig.object.shape.name()) " from "
            (shown.inputs.logs.len()) " log" (plural(shown.inputs.logs.len()))
            @if let Some(version) = &shown.provenance.version { ", published as " strong { (version) } }
            "."
        }
        @if let Some(evaluation) = &results.evaluation { (headline(evaluation)?) }
        @if let Some(trial) = shown.trial { (trial_section(trial)?) }
        (strikes_section(shown)?)
        @if let Some(fit) = &results.fit { (world_section(shown, fit)?) }
        @if let Some(evaluation) = &results.evaluation { (predictions_section(&results.strikes, evaluation)?) }
        (learning_section(shown)?)
        (rejects_section(&results.rejects))
        (provenance_section(shown))
    };
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { main { (body) } }
        }
    }
    .into_string())
}

fn headline(evaluation: &Evaluation) -> Result<Markup, PageError> {
    let mean = |model: &str| evaluation.models.get(model).map(|errors| errors.mean);
    let saved = match (mean("sysid"), mean("sysid_residual")) {
        (Some(sysid), Some(residual)) if sysid > 0.0 => Some(100.0 * (1.0 - residual / sysid)),
        _ => None,
    };
    let mut by_model: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for row in &evaluation.predictions {
        by_model.entry(&row.model).or_default().extend(row.error);
    }
    let shown: Vec<(&str, Vec<f64>)> = MODELS
        .iter()
        .filter_map(|model| Some((*model, by_model.remove(model)?)))
        .filter(|(_, errors)| !errors.is_empty())
        .collect();
    let rows: Vec<Row> = MODELS
        .iter()
        .filter_map(|model| {
            let errors = evaluation.models.get(*model)?;
            Some(Row {
                name: model,
                numbers: [errors.mean, errors.sd, errors.median, errors.p95],
                n: errors.n,
                left_out: errors.failed,
            })
        })
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
                    @if let Some(saved) = saved {
                        p.big { (format!("{saved:.0} %")) }
                        p { "of the identified simulator's mean stop error is taken off by the residual model." }
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

fn trial_section(trial: &Trial) -> Result<Markup, PageError> {
    fn rows<'a>(outcomes: &'a BTreeMap<String, Outcome>, trial: &'a Trial) -> Vec<Row<'a>> {
        MODELS
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
    let models = ["sysid", "sysid_residual"];
    Ok(section(
        "Closed loop: struck at targets",
        html! {
            div.columns {
                figure {
                    (drawing(&figures::figure_8(trial, &models)?))
                    (legend(&models, Some("● start   ✕ target   ellipse: mean and standard deviation of the stops")))
                }
                div {
                    h3 { "Two starts, four targets each, repeated" }
                    (errors_table(&rows(&trial.figure_8, trial), "refused"))
                    h3 { "Random targets" }
                    (errors_table(&rows(&trial.models, trial), "refused"))
                    p.note {
                        "Version " (trial.artifact) " struck the embedded rig (" (trial.robot) "). "
                        (trial.drawn) " random targets were drawn; those that the default model refused to strike at are not struck at "
                        "by any model. Every model met the same launches. The floor is the scatter of repeats of one command."
                    }
                }
            }
        },
    ))
}

fn strikes_section(shown: &Shown<'_>) -> Result<Markup, PageError> {
    let strikes = &shown.results.strikes;
    let count = |split| {
        strikes
            .iter()
            .filter(|strike| strike.split == split)
            .count()
    };
    let (train, validation, test) = (
        count(Split::Train),
        count(Split::Validation),
        count(Split::Test),
    );
    let rejected = shown.results.rejects.len();
    Ok(section(
        "Strikes on the table",
        html! {
            div.columns {
                figure {
                    (drawing(&figures::table(&shown.inputs.rig, strikes)?))
                    p.legend {
                        "○ start   " span style=(fill("sysid_residual")) { "●" } " stop, learnt from   "
                        span style=(fill("sysid")) { "●" } " stop, held out"
                    }
                }
                table {
                    tbody {
                        tr { td { "kept" } td.number { (strikes.len()) } }
                        tr { td { "rejected" } td.number { (rejected) } }
                        tr { td { "learnt from" } td.number { (train) } }
                        tr { td { "to stop training by" } td.number { (validation) } }
                        tr { td { "held out" } td.number { (test) } }
                        tr { td { "speeds" } td.number { (span(strikes, |s| s.command.speed, "m/s")) } }
                        tr { td { "angles" } td.number { (span(strikes, |s| s.command.angle, "rad")) } }
                        tr { td { "distances" } td.number { (span(strikes, |s| s.path().norm(), "m")) } }
                        tr { td { "frames of a track" } td.number { (span(strikes, |s| s.track.len() as f64, "")) } }
                    }
                }
            }
        },
    ))
}

fn span(strikes: &[Strike], value: fn(&Strike) -> f64, unit: &str) -> String {
    let (low, high) = strikes
        .iter()
        .map(value)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    let [low, high] =
        [low, high].map(|value| super::plot::short(&((value * 100.0).round() / 100.0)));
    format!("{low} … {high} {unit}")
}

fn world_section(shown: &Shown<'_>, fit: &Fit) -> Result<Markup, PageError> {
    let rig = &shown.inputs.rig;
    let nominal = World::nominal(rig);
    let freed = PARAMETERS
        .iter()
        .filter(|spec| fit.freed.iter().any(|name| name == spec.name));
    let slides = slides(shown, &nominal, &fit.world)?;
    Ok(section(
        "The identified simulator",
        html! {
            table {
                thead { tr {
                    th { "parameter" } th { "before" } th { "identified" } th { "95 % interval" } th { "what it is" }
                } }
                tbody {
                    @for spec in freed {
                        @if let Some(estimate) = fit.world.parameters.get(spec.name) {
                            tr {
                                td { code { (spec.name) } }
                                td.number { (super::plot::short(&spec.nominal)) " " (spec.unit) }
                                td.number { strong { (format!("{:.4}", estimate.value)) } " " (spec.unit) }
                                td.number {
                                    @match (estimate.low, estimate.high) {
                                        (Some(low), Some(high)) => { (format!("{low:.4} … {high:.4}")) },
                                        _ => { "—" },
                                    }
                                }
                                td { (spec.meaning) }
                            }
                        }
                    }
                    @let scatter = fit.world.scatter;
                    tr { td { "scatter of speed" } td {} td.number { (format!("{:.2} %", scatter.speed * 100.0)) } td {} td { "how launches of one command differ" } }
                    tr { td { "scatter of angle" } td {} td.number { (format!("{:.2}°", scatter.angle.to_degrees())) } td {} td { "how launches of one command differ" } }
                    tr { td { "noise of a centroid" } td {} td.number { (figures::millimetres(scatter.camera)) } td {} td { "of each coordinate" } }
                }
            }
            p {
                "Tracks of " (fit.strikes) " strikes: residual " (figures::millimetres(fit.rms_before)) " rms before, "
                strong { (figures::millimetres(fit.rms_after)) } " after, in " (fit.iterations) " iterations and "
                (fit.simulations) " simulations."
            }
            @if !fit.notes.is_empty() {
                ul { @for note in &fit.notes { li { (note) } } }
            }
            div.three { @for slide in &slides { figure { (drawing(slide)) } } }
            (legend(&["nominal", "sysid"], Some("● measured")))
        },
    ))
}

/// The way of a few held-out strikes, slow to fast, measured and simulated before and after identification.
fn slides(
    shown: &Shown<'_>,
    nominal: &World,
    identified: &World,
) -> Result<Vec<String>, PageError> {
    let mut held_out: Vec<&Strike> = shown
        .results
        .strikes
        .iter()
        .filter(|strike| strike.split == Split::Test && !strike.track.is_empty())
        .collect();
    held_out.sort_by(|a, b| a.command.speed.total_cmp(&b.command.speed));
    let worlds = [("nominal", nominal), ("sysid", identified)];
    let simulators = worlds
        .iter()
        .map(|(model, world)| Ok((*model, Simulator::new(&shown.inputs.rig, world)?)))
        .collect::<Result<Vec<_>, WorldError>>()?;
    let mut drawn = Vec::new();
    for place in 0..SLIDES.min(held_out.len()) {
        let strike = held_out[(2 * place + 1) * held_out.len() / (2 * SLIDES.min(held_out.len()))];
        let mut tracks = Vec::new();
        for (model, simulator) in &simulators {
            let mut worker = simulator.worker();
            // A world that does not come to rest has no track to show.
            if let Ok(simulated) =
                worker.strike(strike.initial, strike.command, &Conditions::default())
            {
                tracks.push((*model, way(strike, &simulated.track)));
            }
        }
        let name = format!(
            "{:.2} m/s at {:.2} rad",
            strike.command.speed, strike.command.angle
        );
        drawn.push(figures::slide(&name, &way(strike, &strike.track), &tracks)?);
    }
    Ok(drawn)
}

/// Seconds and metres from where the object rested; at most a hundred points.
fn way(strike: &Strike, track: &values::Track) -> Vec<(f64, f64)> {
    let step = track.len().div_ceil(100).max(1);
    let last = track.len() - 1;
    (0..track.len())
        .step_by(step)
        .chain([last])
        .map(|frame| (track.t[frame], track.point(frame).distance(strike.initial)))
        .collect()
}

fn predictions_section(strikes: &[Strike], evaluation: &Evaluation) -> Result<Markup, PageError> {
    let models = MODELS
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
        },
    ))
}

fn learning_section(shown: &Shown<'_>) -> Result<Markup, PageError> {
    let results = shown.results;
    let Some(trained) = &results.trained else {
        return Ok(section(
            "The residual model",
            html! {
                p { "None: there are too few strikes to train on. The identified simulator serves alone." }
            },
        ));
    };
    let said: Vec<[f64; 2]> = results
        .residuals
        .rows
        .iter()
        .map(|row| {
            trained
                .network
                .predict([row.path.x, row.path.y, row.speed_sim, row.angle_sim])
        })
        .collect();
    let mut levels = Vec::new();
    if let Some(evaluation) = &results.evaluation {
        levels.extend(
            evaluation
                .models
                .get("sysid")
                .map(|errors| ("sysid", errors.mean)),
        );
        levels.extend(
            evaluation
                .noise_floor
                .map(|errors| ("noise_floor", errors.mean)),
        );
    }
    let rows = &results.residuals.rows;
    Ok(section(
        "The residual model",
        html! {
            div.three {
                figure { (drawing(&figures::residuals(rows, &said, 0)?)) }
                figure { (drawing(&figures::residuals(rows, &said, 1)?)) }
                figure { (drawing(&figures::history(&trained.history, trained.best_epoch)?)) }
            }
            p.legend {
                "● what was commanded, less what the simulator would command   "
                span style=(fill("sysid_residual")) { "●" } " what the network says   ― training   "
                span style=(fill("sysid_residual")) { "―" } " validation"
            }
            div.columns {
                figure {
                    (drawing(&figures::learning_curve(&results.curve_errors, &levels)?))
                    (legend(&["sysid_residual", "sysid", "noise_floor"], None))
                }
                div { (errors_of_training(trained)) (curve_table(shown)) }
            }
            @if !results.residuals.excluded.is_empty() {
                p { (results.residuals.excluded.len()) " strikes have no residual, for the simulator does not reach their path." }
            }
        },
    ))
}

fn errors_of_training(trained: &Trained) -> Markup {
    let errors = [
        ("validation", Some(trained.validation)),
        ("held out", trained.test),
    ];
    html! {
        table {
            thead { tr { th { "mean absolute error" } th { "both outputs" } th { "Δ speed" } th { "Δ angle" } th { "rows" } } }
            tbody {
                @for (name, mae) in errors {
                    @if let Some(mae) = mae {
                        tr {
                            td { (name) }
                            td.number { (format!("{:.4}", mae.raw)) }
                            td.number { (format!("{:.4} m/s", mae.d_speed)) }
                            td.number { (format!("{:.4} rad", mae.d_angle)) }
                            td.number { (mae.rows) }
                        }
                    }
                }
            }
        }
        p.note {
            "The paper reports a validation error of 0.015. Trained on " (trained.train_rows) " strikes; the weights are those of epoch "
            (trained.best_epoch) " of " (trained.history.len()) "."
        }
    }
}

fn curve_table(shown: &Shown<'_>) -> Markup {
    let results = shown.results;
    html! {
        table {
            thead { tr { th { "strikes" } th { "mean stop error" } th { "validation error" } } }
            tbody {
                @for (strikes, mae) in figures::mae_points(&results.curve) {
                    tr {
                        td.number { (strikes) }
                        td.number {
                            @match results.curve_errors.iter().find(|point| point.0 == strikes) {
                                Some((_, error)) => { (format!("{:.2} cm", error * 100.0)) },
                                None => { "—" },
                            }
                        }
                        td.number { (format!("{mae:.4}")) }
                    }
                }
            }
        }
    }
}

fn rejects_section(rejects: &[Reject]) -> Markup {
    section(
        "Rejected strikes",
        html! {
            @if rejects.is_empty() { p { "None." } }
            @else {
                table {
                    thead { tr { th { "log" } th { "strike" } th { "reason" } th { "what was seen" } } }
                    tbody {
                        @for reject in rejects.iter().take(REJECTS) {
                            tr {
                                td { (reject.log) } td.number { (reject.index) }
                                td { code { (reject.reason.name()) } } td { (reject.detail) }
                            }
                        }
                    }
                }
                @if rejects.len() > REJECTS { p { "And " (rejects.len() - REJECTS) " more in rejects.parquet." } }
            }
        },
    )
}

fn provenance_section(shown: &Shown<'_>) -> Markup {
    let provenance = shown.provenance;
    section(
        "Provenance",
        html! {
            div.columns {
                table { tbody {
                    @for (name, value) in &provenance.made_by { tr { td { (name) } td { (value) } } }
                    tr { td { "seed" } td { (shown.inputs.seed) } }
                } }
                table.hashes { tbody {
                    @for (name, hash) in &provenance.hashes { tr { td { (name) } td { code { (hash) } } } }
                } }
            }
        },
    )
}

fn section(title: &str, content: Markup) -> Markup {
    html! { section { h2 { (title) } (content) } }
}

fn drawing(svg: &str) -> Markup {
    html! { (PreEscaped(svg)) }
}

fn legend(models: &[&str], more: Option<&str>) -> Markup {
    html! {
        p.legend {
            @for model in models { (swatch(model)) (title(model)) "   " }
            @if let Some(more) = more { (more) }
        }
    }
}

fn swatch(model: &str) -> Markup {
    html! { span.swatch style=(fill(model).replace("color", "background")) {} }
}

fn fill(model: &str) -> String {
    let hue = colour(model);
    format!("color:rgb({},{},{})", hue.0, hue.1, hue.2)
}

/// A model's name for a person.
pub fn title(model: &str) -> String {
    match model {
        "nominal" => "nominal simulator".into(),
        "sysid" => "identified simulator".into(),
        "sysid_residual" => "identified + residual".into(),
        other => other.replace('_', " "),
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
