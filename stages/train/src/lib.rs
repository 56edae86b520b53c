//! Trains the residual model: what to add to the simulated speed and angle (paper, section 3.4).
//!
//! A multi-layer perceptron 4 → 128 → 64 → 32 → 2 with ReLU, one batch norm and one dropout layer learns
//! \[path_x, path_y, speed_sim, angle_sim\] → \[Δspeed, Δangle\] by mean squared error and Adam; the rate halves when
//! the validation error stands still, and training ends when it stays so. The rows' own [`Split`](values::Split)
//! says who learns, who stops and who judges. What comes out is a [`Network`](store::network::Network) with batch
//! norm and standard scaling folded into its weights.
//!
//! Initial weights, shuffles and dropout are drawn from the seed in the settings and nothing else, so that the same
//! rows give the same bytes, whatever runs beside it.

mod curve;
mod error;
mod fit;
mod model;
mod scaling;
mod schedule;
mod settings;
mod stages;

pub use curve::{CurvePoint, curve_sizes};
pub use error::TrainError;
pub use fit::{Epoch, Mae, Trained, fit};
pub use settings::Settings;
pub use stages::Train;

#[cfg(test)]
mod tests;
