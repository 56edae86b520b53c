//! Versions over nights.

use maud::{Markup, html};
use store::{Model, Store};
use values::StopErrors;

use super::markup::{section, table, title};
use super::plot::{Kind, Plot, Series};

/// The latest so many are shown.
const MOST: usize = 200;

/// What a version was published with.
#[derive(Clone, Debug)]
pub struct VersionErrors {
    name: String,
    is_latest: bool,
    model: Model,
    plain: Option<StopErrors>,
    used: Option<StopErrors>,
    floor: Option<StopErrors>,
}

/// The versions of a store, oldest first; what cannot be read is left out, for `carom artifacts list` tells of it.
pub fn versions(store: &Store) -> Vec<VersionErrors> {
    let mut versions: Vec<VersionErrors> = store
        .list()
        .unwrap_or_default()
        .into_iter()
        .filter_map(|listing| {
            let provenance = listing.manifest.ok()?.provenance;
            let model = provenance.default_model;
            Some(VersionErrors {
                name: listing.version,
                is_latest: listing.is_latest,
                model,
                plain: provenance.metrics.get(&Model::Sysid).copied(),
                used: provenance.metrics.get(&model).copied(),
                floor: provenance.noise_floor,
            })
        })
        .collect();
    versions.split_off(versions.len().saturating_sub(MOST))
}

/// The section; none where there are fewer than two versions.
pub fn trend_section(versions: &[VersionErrors]) -> Option<Markup> {
    if versions.len() < 2 {
        return None;
    }
    let line = |name, colour, of: fn(&VersionErrors) -> Option<StopErrors>| {
        let points = versions
            .iter()
            .enumerate()
            .filter_map(move |(place, version)| {
                Some((place as f64 + 1.0, of(version)?.mean * 100.0))
            });
        Series::new(name, colour, Kind::Line, points)
    };
    let dots = versions
        .iter()
        .enumerate()
        .filter_map(|(place, version)| Some((place as f64 + 1.0, version.used?.mean * 100.0)));
    let top = versions
        .iter()
        .flat_map(|version| [version.plain, version.used]);
    let top = top
        .flatten()
        .map(|errors| errors.mean * 100.0)
        .fold(0.0, f64::max);
    let plot = Plot {
        counts_x: true,
        x_range: Some([0.5, versions.len() as f64 + 0.5]),
        y_range: Some([0.0, 1.1 * top.max(0.1)]),
        ..Plot::new(
            "version, in order of publishing",
            "mean stop error in cm",
            vec![
                line("repeats of one command", "faint", |version| version.floor),
                line("identified simulator", "sysid", |version| version.plain),
                line("model in use", "effect_residual", |version| version.used),
                Series::new(None, "effect_residual", Kind::Dots, dots),
            ],
        )
    };
    let recent = versions.iter().rev().take(8);
    Some(section(
        "Versions over nights",
        html! {
            div.columns {
                (plot.figure("mean stop error of each version, on its own held-out strikes"))
                (table(&["version", "model", "cm", "n"], html! { @for version in recent {
                    tr {
                        td { (version.name) @if version.is_latest { " (in use)" } }
                        td { (title(version.model.name())) }
                        td.number { (version.used.map_or("—".into(), |errors| format!("{:.2}", errors.mean * 100.0))) }
                        td.number { @if let Some(errors) = version.used { (errors.n) } }
                    }
                } }))
            }
            p.note { "Each on its own held-out strikes: the strikes differ from version to version, and so may their difficulty." }
        },
    ))
}
