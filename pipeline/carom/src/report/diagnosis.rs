//! Where simulation and strikes disagree, what is missing, and how far the gap shrinks with it.

use diagnose::{Diagnosed, Diagnosis, Gap, NamedEffect, NextStrike, Noise, Verdict};
use maud::{Markup, html};

use super::figures::Places;
use super::input::ReportInput;
use super::maps::maps;
use super::markup::{in_colours, section, swatch, table, title, wide};
use super::plot::short;
use super::residual_plots::{COVARIATES, ResidualOf, StrikeResidual, against, magnification, map};
use crate::outputs::NEXT_STRIKES;
use crate::summary::diagnosis::{gap, numbers, probability, to_two_figures_of};

/// Candidates of the ranking that are shown.
const RANKED: usize = 12;

pub fn diagnosis_section(
    shown: &ReportInput<'_>,
    places: &Places<'_>,
    found: &Diagnosed,
) -> Markup {
    let diagnosis = &found.diagnosis;
    section(
        "Where simulation and strikes disagree",
        html! {
            p.verdict { strong { (verdict(diagnosis.verdict)) ":" } " " (diagnosis.summary.trim_end_matches('.')) "." }
            @if found.used().is_some() && shown.results.worlds.as_ref().is_some_and(|worlds| worlds.effect.is_none()) {
                p { "As asked, it is not added to the world that is used." }
            }
            (effects_table(&diagnosis.effects))
            div.columns {
                div { (gap_bars(&diagnosis.gap, &diagnosis.effects)) (where_table(diagnosis)) }
                div { (ranking_bars(diagnosis)) }
            }
            (maps(diagnosis))
            (pictures(shown, places, found))
            (noise_table(&diagnosis.noise))
            (next_strikes(&diagnosis.next_strikes))
            (details(diagnosis))
        },
    )
}

pub fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Named => "Named",
        Verdict::Consistent => "Consistent",
        Verdict::Unexplained => "Unexplained",
    }
}

fn effects_table(effects: &[NamedEffect]) -> Markup {
    html! {
        @if !effects.is_empty() {
            (wide(table(&["effect", "what it says", "parameter", "value", "95 % interval", "evidence"], html! { @for effect in effects {
                @for (place, (name, parameter)) in effect.parameters.iter().enumerate() {
                    tr {
                        td { @if place == 0 { code { (effect.name) } } }
                        td.words { @if place == 0 {
                            (effect.statement)
                            @if !effect.equivalent.is_empty() {
                                br; span.note { "These strikes cannot distinguish it from " (effect.equivalent.join(", ")) "." }
                            }
                        } }
                        td { code { (name) } }
                        @let [value, low, high] = numbers(parameter);
                        td.number { strong { (value) } " " (parameter.unit) }
                        td.number { @if low == high { "fixed" } @else { (low) " … " (high) } }
                        td.number { @if place == 0 { (format!("{:.1}", effect.evidence)) } }
                    }
                }
            } })))
        }
    }
}

/// A line of a chart of bars: name, colour's model, length, and what is written behind.
struct Bar<'a> {
    name: &'a str,
    model: &'a str,
    length: f64,
    text: String,
}

fn bars(bars: &[Bar<'_>]) -> Markup {
    let longest = bars.iter().map(|bar| bar.length).fold(0.0, f64::max);
    let width = |length: f64| match longest > 0.0 {
        true => 100.0 * length.max(0.0) / longest,
        false => 0.0,
    };
    html! {
        table.bars { tbody {
            @for bar in bars {
                tr {
                    td { (bar.name) }
                    td.bar { div style=(format!("width:{:.1}%;background:var(--{})", width(bar.length), in_colours(bar.model))) {} }
                    td.number { (bar.text) }
                }
            }
        } }
    }
}

fn gap_bars(measured: &Gap, effects: &[NamedEffect]) -> Markup {
    let bar = |name, model, length: f64| Bar {
        name,
        model,
        length,
        text: format!("{:.2} mm", length * 1e3),
    };
    let mut lines = vec![bar("before", "sysid", measured.before)];
    if !effects.is_empty() {
        lines.push(bar("with the effects", "effect", measured.after));
    }
    let floor = measured.noise_floor;
    lines.push(bar("repeats of one command", "noise_floor", floor));
    html! {
        h3 { "The gap" }
        (bars(&lines))
        p.note { (gap(measured)) "." }
    }
}

fn ranking_bars(diagnosis: &Diagnosis) -> Markup {
    let is_named = |name: &str| diagnosis.effects.iter().any(|effect| effect.name == name);
    let lines: Vec<Bar<'_>> = diagnosis
        .ranking
        .iter()
        .take(RANKED)
        .map(|ranked| Bar {
            name: &ranked.name,
            model: if is_named(&ranked.name) {
                "effect"
            } else {
                "noise_floor"
            },
            length: ranked.evidence,
            text: format!("{:.1}", ranked.evidence),
        })
        .collect();
    html! {
        @if !lines.is_empty() {
            h3 { "Candidates, each alone" }
            (bars(&lines))
            p.note {
                "Evidence: the gain in log-likelihood over the identified simulator, less what the candidate's parameters would gain "
                "by chance."
            }
        }
    }
}

fn where_table(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.r#where.is_empty() {
            h3 { "What the gap depends on" }
            (table(&["covariate", "how", "p", "share"], html! { @for place in &diagnosis.r#where {
                tr {
                    td { (place.covariate) } td.words { (place.description) }
                    td.number { (probability(place.p_value, diagnosis.replicates)) }
                    td.number { (format!("{:.0} %", 100.0 * place.share)) }
                }
            } }))
        }
    }
}

/// How repeats of one command differ, as estimated.
fn noise_table(noise: &Noise) -> Markup {
    html! {
        details {
            summary { "How repeats of one command differ, as estimated" }
            table { tbody {
                tr { td { "speed of a launch" } td.number { (format!("{:.2} %", 100.0 * noise.speed)) } }
                tr { td { "angle of a launch" } td.number { (format!("{:.2}°", noise.angle.to_degrees())) } }
                tr { td { "friction of a strike" } td.number { (format!("{:.2} %", 100.0 * noise.friction)) } }
                tr { td { "a centroid" } td.number { (format!("{:.2} mm", 1e3 * noise.camera)) } }
                tr { td { "correlation of a centroid's error with the frame before" } td.number { (format!("{:.2}", noise.camera_correlation)) } }
                tr { td { "a frame's stamp" } td.number { (format!("{:.1} ms", 1e3 * noise.stamp_jitter)) } }
                tr { td { "frames left out, far from where their strike was" } td.number { (noise.frames_left_out) } }
            } }
            p.note { "Standard deviations, but for the correlation and the count. They are part of the model and no effect." }
        }
    }
}

/// Maps of the table and small multiples against each covariate, before and with the effects.
fn pictures(shown: &ReportInput<'_>, places: &Places<'_>, found: &Diagnosed) -> Markup {
    let seen: Vec<StrikeResidual<'_>> = found
        .residuals
        .iter()
        .filter_map(|look| {
            let place = *places.get(look.strike_id.as_str())?;
            Some((place, &shown.results.strikes[place], look))
        })
        .collect();
    if seen.is_empty() {
        return html! {};
    }
    let mut models: Vec<(&'static str, ResidualOf)> = vec![("sysid", |look| look.before)];
    if !found.diagnosis.effects.is_empty() {
        models.push(("effect", |look| look.after));
    }
    let magnification = magnification(&seen);
    let maps = models
        .iter()
        .map(|(model, residual)| map(&shown.inputs.rig, model, &seen, *residual, magnification));
    let multiples = [0, 1].into_iter().flat_map(|component| {
        let seen = &seen;
        let models = &models;
        COVARIATES
            .into_iter()
            .map(move |covariate| against(covariate, component, seen, models))
    });
    html! {
        h3 { "On the table" }
        div.columns { @for map in maps {
            (map.figure(&format!("residuals of stops on the table, {}", map.title)))
        } }
        p.legend {
            "from where the simulator says that a strike stops to where it stopped, drawn "
            @if magnification > 1.0 { (short(magnification)) " times as long" } @else { "to scale" }
        }
        h3 { "Stops, measured less simulated, along and across the way" }
        div.multiples { @for plot in multiples { (plot.figure(&format!("residuals {} against {}", plot.y, plot.x))) } }
        p.legend {
            @for (model, _) in &models { span.entry { (swatch(model)) (title(model)) } " " }
        }
    }
}

fn next_strikes(strikes: &[NextStrike]) -> Markup {
    html! {
        @if !strikes.is_empty() {
            h3 { "The most informative next strikes" }
            (table(&["from", "speed", "angle", "why"], html! { @for strike in strikes {
                tr {
                    td.number { (format!("({:.3}, {:.3}) m", strike.x0, strike.y0)) }
                    td.number { (format!("{:.2} m/s", strike.speed)) }
                    td.number { (format!("{:.3} rad", strike.angle)) }
                    td.words { (strike.why) }
                }
            } }))
            p.note { "Ready for the rig in " code { (NEXT_STRIKES) } "." }
        }
    }
}

/// What these strikes could have shown, and what is to be known of the search.
fn details(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.detectable.is_empty() {
            details {
                summary { "The least sizes that these " (diagnosis.strikes) " strikes would show" }
                (table(&["effect", "parameter", "least size"], html! { @for least in &diagnosis.detectable {
                    tr {
                        td { code { (least.name) } } td { code { (least.parameter) } }
                        td.number { (to_two_figures_of(least.least, least.least)) " " (least.unit) }
                    }
                } }))
            }
        }
        @if !diagnosis.notes.is_empty() {
            ul { @for note in &diagnosis.notes { li { (note) } } }
        }
        p.note {
            "Looked at " (diagnosis.strikes) " strikes; a gap like this one, or a larger, would come by chance with probability "
            (probability(diagnosis.least_p_value(), diagnosis.replicates)) "."
        }
    }
}
