//! `fleet.html`: a night over several rigs, and where each one's report is.

use std::path::Path;

use maud::{Markup, html};

use super::FILE;
use super::markup::{document, section};
use crate::Error;
use crate::nightly::{FleetNight, RigNight};

/// Writes the page of a fleet's night into its folder.
pub fn write_fleet(dir: &Path, night: &FleetNight) -> Result<(), Error> {
    let body = html! {
        h1 { "A night over a fleet" }
        p.lead { (night.headline()) "." }
        @for rig in &night.rigs { (of_rig(dir, rig)) }
        (in_common(night))
    };
    let page = document("carom fleet", &html! {}, &body, &html! {});
    Ok(durable::write_bytes(
        &dir.join("fleet.html"),
        page.as_bytes(),
    )?)
}

fn of_rig(dir: &Path, rig: &RigNight) -> Markup {
    let report = Path::new(&rig.name).join(FILE);
    let is_written = dir.join(&report).is_file();
    section(
        &rig.name,
        html! {
            p { strong { (rig.headline()) } "." }
            ul { @for line in rig.lines() { li { (line) } } }
            @if is_written { p { a href=(report.display()) { "its report" } } }
        },
    )
}

fn in_common(night: &FleetNight) -> Markup {
    let said = |title: &str| match title {
        "common" => "In common: intervals agree",
        "differs" => "Of one object, and different from rig to rig",
        _ => "Each rig's own",
    };
    section(
        "What the rigs share",
        html! {
            @for (title, sentences) in night.shown() {
                @if !sentences.is_empty() {
                    h3 { (said(title)) }
                    ul { @for sentence in sentences { li { (sentence) } } }
                }
            }
            @if night.known.is_empty() { p { "No version is in use yet." } }
        },
    )
}
