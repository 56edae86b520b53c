//! The page and its sections.

use std::collections::BTreeSet;

use maud::{Markup, PreEscaped, html};
use values::{Reject, Split, Strike};

use super::figures::{self, Places};
use super::input::ReportInput;
use super::markup::{PageError, document, section, table, wide};
use super::plot::short;
use super::{answer, delivered, diagnosis, explorer, models, stops, trend};
use crate::results::Worlds;
use crate::words;

const SCRIPT: &str = include_str!("page.js");
/// uPlot 1.6.32, as npm has it, with its licence: it draws in the page, and fetches nothing.
const UPLOT: &str = include_str!("uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("uplot/uPlot.min.css");
const UPLOT_LICENCE: &str = include_str!("uplot/LICENSE");
/// Rejected strikes listed at the most; the table holds all.
const REJECTS: usize = 50;

/// More hashes than these are folded away.
const HASHES: usize = 20;
/// Hashes in the page, at the most.
const MOST_HASHES: usize = 500;

/// The whole page as text.
pub fn page(shown: &ReportInput<'_>) -> Result<String, PageError> {
    let results = shown.results;
    let title = match &shown.provenance.version {
        Some(version) => format!("carom report · {version}"),
        None => "carom report".to_string(),
    };
    let listed = explorer::listed(results);
    let id = |place: &usize| results.strikes[*place].id.as_str();
    let places: Places<'_> = listed.iter().map(|place| (id(place), *place)).collect();
    let body = html! {
        h1 { "From strike logs to a robot that strikes" }
        p.lead {
            (results.strikes.len()) " strikes of a " (shown.inputs.rig.object.shape().name()) " from "
            (shown.inputs.logs.len()) " log" (plural(shown.inputs.logs.len()))
            @if let Some(version) = &shown.provenance.version {
                (if shown.provenance.is_unused { ", kept as a candidate that is not in use, " } else { ", published as " })
                strong { (version) }
            }
            @if let Some(version) = &shown.provenance.in_use { ", not in use: " strong { (version) } " is" }
            "."
        }
        (answer::answers(shown))
        @if let Some(night) = shown.night {
            (section("The last night", html! {
                p { strong { (night.headline()) } "." }
                ul { @for line in night.lines() { li { (line) } } }
            }))
        }
        @if let Some(section) = trend::trend_section(&shown.versions) { (section) }
        (check_section(shown))
        (strikes_section(shown, &listed))
        (explorer::explorer_section(shown, &listed)?)
        @if let Some(evaluation) = results.evaluation() { (stops::errors_section(evaluation)) }
        @if let Some(found) = results.found() { (diagnosis::diagnosis_section(shown, &places, found)) }
        @if let Some(why) = results.worlds.as_ref().and_then(Worlds::no_diagnosis) {
            (section("Where simulation and strikes disagree", html! { p { "No diagnosis: " (why) "." } }))
        }
        @if let Some(trial) = shown.trial { (stops::trial_section(trial)) }
        @if let Some(worlds) = &results.worlds { (models::world_section(&worlds.fit)) }
        @if let Some(section) = delivered::delivered_section(&results.strikes, &listed) { (section) }
        @if let Some(worlds) = &results.worlds && let Some(evaluation) = &worlds.evaluation {
            (stops::predictions_section(&results.strikes, &places, worlds, evaluation)?)
            (models::learning_section(worlds, &places, evaluation))
        }
        (rejects_section(&results.read.rejects))
        (provenance_section(shown))
    };
    let head = html! { style { (PreEscaped(UPLOT_STYLE)) } };
    let foot = html! {
        script { (PreEscaped(format!("/* uPlot\n{UPLOT_LICENCE}*/\n{UPLOT}"))) }
        script { (PreEscaped(SCRIPT)) }
    };
    Ok(document(&title, &head, &body, &foot))
}

/// What a check of the logs found; empty where it found nothing.
fn check_section(shown: &ReportInput<'_>) -> Markup {
    let check = &shown.results.read.check;
    if check.findings.is_empty() {
        return html! {};
    }
    section(
        "Before anything is fitted",
        html! {
            @if check.is_meaningless() { p { strong { "A model of these logs would be meaningless: nothing was fitted." } } }
            (wide(table(&["", "seen", "most likely", "what mends it"], html! { @for finding in &check.findings {
                @let said = words::say(finding, &shown.inputs.rig);
                tr {
                    td { (words::severity(finding.severity())) } td.words { (said.seen) }
                    td.words { (said.likely) } td.words { (said.mend) }
                }
            } })))
        },
    )
}

fn strikes_section(shown: &ReportInput<'_>, listed: &BTreeSet<usize>) -> Markup {
    let strikes = &shown.results.strikes;
    let count = |split| strikes.iter().filter(|s| s.split == split).count();
    let rejected = shown.results.read.rejects.len();
    section(
        "Strikes on the table",
        html! {
            div.columns {
                (figures::table(&shown.inputs.rig, strikes, listed).figure("where strikes began and stopped on the table"))
                table {
                    tbody {
                        tr { td { "kept" } td.number { (strikes.len()) } }
                        tr { td { "rejected" } td.number { (rejected) } }
                        tr { td { "learnt from" } td.number { (count(Split::Train)) } }
                        tr { td { "to stop training by" } td.number { (count(Split::Validation)) } }
                        tr { td { "held out" } td.number { (count(Split::Test)) } }
                        tr { td { "speeds" } td.number { (span(strikes, |s| s.command.speed, "m/s")) } }
                        tr { td { "angles" } td.number { (span(strikes, |s| s.command.angle, "rad")) } }
                        tr { td { "distances" } td.number { (span(strikes, |s| s.path().norm(), "m")) } }
                        tr { td { "frames of a track" } td.number { (span(strikes, |s| s.track.len() as f64, "")) } }
                    }
                }
            }
        },
    )
}

fn span(strikes: &[Strike], value: fn(&Strike) -> f64, unit: &str) -> String {
    let (low, high) = strikes
        .iter()
        .map(value)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
    let [low, high] = [low, high].map(|value| short((value * 100.0).round() / 100.0));
    format!("{low} … {high} {unit}")
}

fn rejects_section(rejects: &[Reject]) -> Markup {
    section(
        "Rejected strikes",
        html! {
            @if rejects.is_empty() { p { "None." } }
            @else {
                (wide(table(&["log", "strike", "reason", "what was seen"], html! { @for reject in rejects.iter().take(REJECTS) {
                    tr {
                        td { (reject.log) } td.number { (reject.index) }
                        td { code { (reject.reason.name()) } } td { (reject.detail) }
                    }
                } })))
                @if rejects.len() > REJECTS { p { "And " (rejects.len() - REJECTS) " more in rejects.parquet." } }
            }
        },
    )
}

fn provenance_section(shown: &ReportInput<'_>) -> Markup {
    let provenance = shown.provenance;
    section(
        "Provenance",
        html! {
            div.columns {
                table { tbody {
                    @for (name, value) in &provenance.made_by { tr { td { (name) } td { (value) } } }
                    tr { td { "seed" } td { (shown.inputs.seed) } }
                } }
                details open[provenance.hashes.len() <= HASHES] {
                    summary { "SHA-256 of " (provenance.hashes.len()) " files and logs" }
                    table.hashes { tbody {
                        @for (name, hash) in provenance.hashes.iter().take(MOST_HASHES) { tr { td { (name) } td { code { (hash) } } } }
                    } }
                    @if provenance.hashes.len() > MOST_HASHES { p { "And " (provenance.hashes.len() - MOST_HASHES) " more in the version's manifest.json." } }
                }
            }
        },
    )
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
