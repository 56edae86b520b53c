//! What was identified and learnt.

use judge::Evaluation;
use maud::{Markup, html};
use sysid::Fit;
use train::Learned;
use values::Command;
use world::PARAMETERS;

use super::figures::{self, Places};
use super::markup::{centimetres, section, table, wide};
use super::plot::short;
use crate::results::{CurvePoint, Worlds};

pub fn world_section(fit: &Fit) -> Markup {
    let freed = PARAMETERS
        .iter()
        .filter(|spec| fit.freed.iter().any(|name| name == spec.name));
    section(
        "The identified simulator",
        html! {
            (wide(table(&["parameter", "before", "identified", "95 % interval", "what it is"], html! {
                @for spec in freed {
                    @if let Some(estimate) = fit.world.parameters.get(spec.name) {
                        @let ends = estimate.low.zip(estimate.high);
                        tr {
                            td { code { (spec.name) } }
                            td.number { (short(spec.nominal)) " " (spec.unit) }
                            td.number { strong { (format!("{:.4}", estimate.value)) } " " (spec.unit) }
                            td.number { (ends.map_or("—".into(), |(low, high)| format!("{low:.4} … {high:.4}"))) }
                            td.words { (spec.meaning) }
                        }
                    }
                }
                @let scatter = fit.world.scatter;
                tr { td { "scatter of speed" } td {} td.number { (format!("{:.2} %", scatter.speed * 100.0)) } td {} td { "how launches of one command differ" } }
                tr { td { "scatter of angle" } td {} td.number { (format!("{:.2}°", scatter.angle.to_degrees())) } td {} td { "how launches of one command differ" } }
                tr { td { "noise of a centroid" } td {} td.number { (figures::millimetres(scatter.camera)) } td {} td { "of each coordinate" } }
            })))
            p {
                "Tracks of " (fit.strikes) " strikes: residual " (figures::millimetres(fit.rms_before)) " rms before, "
                strong { (figures::millimetres(fit.rms_after)) } " after, in " (fit.iterations) " iterations and "
                (fit.simulations) " simulations."
            }
            @if !fit.warnings.is_empty() || !fit.notes.is_empty() {
                ul {
                    @for warning in &fit.warnings { li { strong { (warning) } } }
                    @for note in &fit.notes { li { (note) } }
                }
            }
        },
    )
}

pub fn learning_section(worlds: &Worlds, places: &Places<'_>, evaluation: &Evaluation) -> Markup {
    let (name, used) = worlds.used();
    let learned = used.learned.as_ref();
    let (Some(learned), Some(residual), Some(solved)) = (learned, used.residual(), &used.solved)
    else {
        return section(
            "The residual model",
            html! {
                p { "None: what was tried predicts held-out commands no better than the simulator alone, which serves by itself." }
                @if let Some(learned) = learned { (scores(learned)) }
            },
        );
    };
    let (world, model) = (name.name(), name.with_residual().name());
    let rows = &solved.residuals.rows;
    let said: Vec<[f64; 2]> = rows
        .iter()
        .map(|row| {
            let command = |speed, angle| Command { speed, angle };
            let simulated = command(row.speed_sim, row.angle_sim);
            let sent = command(row.speed_sim + row.d_speed, row.angle_sim + row.d_angle);
            residual.added(row.path, simulated, sent)
        })
        .collect();
    let points = worlds.curve.iter();
    let curve: Vec<(usize, f64)> = points
        .filter_map(|point| Some((point.strikes, point.error?)))
        .collect();
    let plain = evaluation.models.get(world);
    let floor = evaluation.noise_floor.as_ref();
    let levels: Vec<(&'static str, f64)> = [(world, plain), ("noise_floor", floor)]
        .into_iter()
        .filter_map(|(name, errors)| Some((name, errors?.mean)))
        .collect();
    section(
        "The residual model",
        html! {
            @if world == "effect" { p { "What the identified simulator with its effects still gets wrong." } }
            div.three {
                (figures::residuals(model, rows, places, &said, 0).figure("residual of speed, measured and learnt"))
                (figures::residuals(model, rows, places, &said, 1).figure("residual of angle, measured and learnt"))
                @if let Some(training) = &learned.training {
                    (figures::history(model, &training.history, training.best_epoch).figure("errors of the network, epoch by epoch"))
                }
            }
            p.legend { "What was commanded, less what the simulator would command; and what the " (learned.kind.name()) " says." }
            div.columns {
                (figures::learning_curve(model, &curve, &levels).figure("stop error by the number of strikes"))
                div { (scores(learned)) (curve_table(&worlds.curve)) }
            }
            @if !solved.residuals.excluded.is_empty() {
                p { (solved.residuals.excluded.len()) " strikes have no residual, for the simulator does not reach their path." }
            }
        },
    )
}

/// What was tried, and how each predicts commands that it did not learn from.
fn scores(learned: &Learned) -> Markup {
    html! {
        (table(&["added to the simulator", "held-out commands", "held-out sessions"], html! { @for score in &learned.scores {
            tr {
                td { (score.kind.name()) @if score.kind == learned.kind { " (used)" } }
                td.number { (centimetres(Some(score.by_setting))) }
                td.number { (centimetres(score.by_session)) }
            }
        } }))
        p.note {
            "Mean distance between measured and predicted stop of the " (learned.strikes) " strikes learnt from, each predicted by what \
             was learnt without it. The plainer one stays unless another is better beyond two standard errors."
            @if let Some(training) = &learned.training {
                " The first network's validation error is " (format!("{:.4}", training.validation.raw)) "; the paper reports 0.015."
            }
        }
    }
}

fn curve_table(curve: &[CurvePoint]) -> Markup {
    table(
        &["strikes", "mean stop error", "held-out commands"],
        html! { @for point in curve {
            tr {
                td.number { (point.strikes) }
                td.number { (centimetres(point.error)) }
                td.number { (centimetres(point.held_out_commands())) }
            }
        } },
    )
}
