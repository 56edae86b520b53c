//! Parts of the page that every section uses.

use judge::JudgeError;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use store::Model;
use world::WorldError;

const STYLE: &str = include_str!("style.css");
/// The browser itself keeps the page from fetching anything.
const NOTHING_FETCHED: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:";

/// Why the page could not be made. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A track could not be simulated.
    #[error("simulate a track for the report: {0}")]
    World(#[from] WorldError),
    /// Errors could not be told apart by what strikes differ in.
    #[error("{0}")]
    Misses(#[from] JudgeError),
}

/// A whole page as text; `head` and `foot` are what it needs beside the style of all.
pub fn document(title: &str, head: &Markup, body: &Markup, foot: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(NOTHING_FETCHED);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                (head)
                style { (PreEscaped(STYLE)) }
            }
            body {
                a.skip href="#main" { "To the content" }
                main id="main" { (body) }
                (foot)
            }
        }
    }
    .into_string()
}

pub fn section(title: &str, content: Markup) -> Markup {
    let id: String = title
        .to_lowercase()
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join("-");
    html! { section aria-labelledby=(id) { h2 id=(id) { (title) } (content) } }
}

/// A table under these headings.
pub fn table(headings: &[&str], rows: Markup) -> Markup {
    html! {
        table {
            thead { tr { @for heading in headings { th { (heading) } } } }
            tbody { (rows) }
        }
    }
}

/// An error in cm; a dash where there is none.
pub fn centimetres(error: Option<f64>) -> String {
    error.map_or("—".into(), |error| format!("{:.2} cm", error * 100.0))
}

/// A table that scrolls by itself where a page is narrow.
pub fn wide(table: Markup) -> Markup {
    html! { div.wide tabindex="0" role="region" aria-label="table" { (table) } }
}

/// A patch of a model's colour.
pub fn swatch(model: &str) -> Markup {
    html! { span.swatch style=(format!("background:var(--{})", in_colours(model))) {} }
}

/// The name that a model's colour has in the style sheet, the same in every plot.
pub fn in_colours(model: &str) -> &'static str {
    match Model::from_name(model) {
        Some(model) => model.name(),
        None => "faint",
    }
}

/// Names of the models in the order of tables and plots.
pub fn model_names() -> [&'static str; 5] {
    Model::ALL.map(Model::name)
}

/// A model's name for a person.
pub fn title(model: &str) -> String {
    match model {
        "nominal" => "nominal simulator".into(),
        "sysid" => "identified simulator".into(),
        "sysid_residual" => "identified + residual".into(),
        "effect" => "identified + effect".into(),
        "effect_residual" => "identified + effect + residual".into(),
        other => other.replace('_', " "),
    }
}
