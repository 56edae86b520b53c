//! Parts of the page that every section uses.

use judge::JudgeError;
use maud::{Markup, html};
use store::Model;
use world::WorldError;

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

pub fn section(title: &str, content: Markup) -> Markup {
    let id: String = title
        .to_lowercase()
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join("-");
    html! { section aria-labelledby=(id) { h2 id=(id) { (title) } (content) } }
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
