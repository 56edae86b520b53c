//! `report.html`: one page that holds all it shows; `fleet.html` of several rigs.

mod answer;
mod delivered;
mod diagnosis;
mod explorer;
mod figure_8;
mod figures;
mod fleet;
mod input;
mod maps;
mod markup;
mod models;
mod page;
mod plot;
mod provenance;
mod residual_plots;
mod stops;
#[cfg(test)]
mod testing;
mod trend;
mod write;

pub use fleet::write_fleet;
#[cfg(test)]
pub use testing::found_tilt;
pub use write::{FILE, write};
