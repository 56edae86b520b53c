//! How the error falls with the number of strikes.

use residual::Residual;
use serde::{Deserialize, Serialize};
use values::Split;

use crate::{Settings, TrainError, Trained, fit};

/// The model trained on the first strikes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Number of strikes made, of all splits.
    pub strikes: usize,
    /// What came of them. Its test error is measured on the test rows of the whole set, whatever the size.
    pub trained: Trained,
}

/// Trains on the first 25, 50, … rows, as given; each set holds the one before. Sizes that exceed the rows are cut to
/// all of them, once; sizes too small to train on ([`TrainError::TooFewRows`]) are left out.
///
/// Rows must come in the order in which the strikes were made. `on_point` sees every point as it is done.
pub fn learning_curve(
    rows: &[Residual],
    sizes: &[usize],
    settings: &Settings,
    on_point: &mut dyn FnMut(&CurvePoint),
) -> Result<Vec<CurvePoint>, TrainError> {
    let mut sizes: Vec<usize> = sizes.iter().map(|size| (*size).min(rows.len())).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let mut points = Vec::new();
    for strikes in sizes {
        let (first, later) = rows.split_at(strikes);
        let judges = later.iter().filter(|row| row.split == Split::Test);
        let subset: Vec<Residual> = first.iter().chain(judges).cloned().collect();
        match fit(&subset, settings, &mut |_| {}) {
            Ok(trained) => {
                points.push(CurvePoint { strikes, trained });
                on_point(&points[points.len() - 1]);
            }
            Err(TrainError::TooFewRows { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(points)
}
