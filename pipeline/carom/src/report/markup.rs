//! Parts of the page that every section uses.

use judge::JudgeError;
use maud::{Markup, PreEscaped, html};
use store::Model;
use world::WorldError;

use super::plot::{PlotError, colour};

/// Why the page could not be made. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A plot failed.
    #[error("draw the report: {0}")]
    Plot(#[from] PlotError),
    /// A slide could not be simulated.
    #[error("simulate a slide for the report: {0}")]
    World(#[from] WorldError),
    /// Errors could not be told apart by what strikes differ in.
    #[error("{0}")]
    Misses(#[from] JudgeError),
}

pub fn section(title: &str, content: Markup) -> Markup {
    html! { section { h2 { (title) } (content) } }
}

pub fn drawing(svg: &str) -> Markup {
    html! { (PreEscaped(svg)) }
}

pub fn legend(models: &[&str], more: Option<&str>) -> Markup {
    html! {
        p.legend {
            @for model in models { span.entry { (swatch(model)) (title(model)) } "   " }
            @if let Some(more) = more { (more) }
        }
    }
}

pub fn swatch(model: &str) -> Markup {
    html! { span.swatch style=(fill(model).replace("color", "background")) {} }
}

pub fn fill(model: &str) -> String {
    let hue = colour(model);
    format!("color:rgb({},{},{})", hue.0, hue.1, hue.2)
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
