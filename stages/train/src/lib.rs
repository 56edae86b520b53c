//! Learns what to add to a world's command (paper, section 3.4): nothing, a smooth map of launches, or the paper's network.
//!
//! [`learn`] chooses among the three on commands that took no part. A launch map is two Gaussian processes over commanded speed and
//! angle. The paper's multi-layer perceptron 4 → 128 → 64 → 32 → 2 with ReLU, one batch norm and one dropout layer learns
//! \[path_x, path_y, speed_sim, angle_sim\] → \[Δspeed, Δangle\] by mean squared error and Adam ([`fit`]); several of them, each trained
//! on other strikes, answer with their mean, shrunk as far as held-out strikes ask for. Batch norm and standard scaling are folded
//! into plain weights.
//!
//! Initial weights, shuffles, dropout and folds are drawn from the seed in the settings and nothing else, so that the same strikes
//! give the same bytes, whatever runs beside it.

mod adam;
mod candidate;
mod error;
mod example;
mod fit;
mod groups;
mod launch_map;
mod learn;
mod learning_set;
mod map_candidate;
mod miss;
mod model;
mod network_candidate;
mod schedule;
mod settings;
mod stages;

pub use candidate::{Kind, Score};
pub use error::TrainError;
pub use example::{Example, examples};
pub use fit::{Epoch, Mae, Trained, fit};
pub use learn::{Learned, best, curve_sizes, learn};
pub use settings::Settings;
pub use stages::Train;

#[cfg(test)]
mod learn_tests;
#[cfg(test)]
mod tests;
