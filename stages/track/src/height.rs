//! How tall the object is seen: by how far its outline reaches away from the point below the camera, all over the table.
//!
//! Outlines of objects that are lower and higher than the rig file's are laid onto the images from which the log is learned as well; where they
//! miss the edges least, the height is right.

use rayon::prelude::*;

use crate::background::{FEWEST_PILOTS, Pilot};
use crate::change::BandSums;
use crate::edges::{Side, SideSums};
use crate::learned::{Learned, SeenHeight};
use crate::tracker::{Looked, Tracker};

/// The heights that are tried are lower and higher by this share.
const STEP: f64 = 0.3;

/// The height that these images show; none of an object that has none of its own, or where they do not tell it.
pub(crate) fn seen_height(
    pilots: &[Pilot],
    learned: &Learned,
    tracker: &Tracker,
) -> Option<SeenHeight> {
    let looked: Vec<Vec<Looked>> = [-STEP, 0.0, STEP]
        .into_iter()
        .map(|step| Some(looked(pilots, learned, &tracker.of_height(1.0 + step)?)))
        .collect::<Option<_>>()?;
    let [lower, right, higher] = looked.as_slice() else {
        return None;
    };
    let (mut curve, mut slope, mut parts) = (0.0, 0.0, Vec::new());
    let mut moved = Vec::new();
    for ((lower, right), higher) in lower.iter().zip(right).zip(higher) {
        let (Some(low), Some(middle), Some(high)) = (lower.misfit, right.misfit, higher.misfit)
        else {
            continue;
        };
        let (curved, tilted) = (0.5 * (low + high) - middle, 0.5 * (high - low));
        curve += curved;
        slope += tilted;
        parts.push([curved, tilted]);
        let [low, high] = [lower, higher].map(|looked| looked.observation.centre.ok());
        if let (Some(low), Some(high)) = (low, high) {
            moved.push(0.5 * low.distance(high));
        }
    }
    if parts.len() < FEWEST_PILOTS || curve <= 0.0 {
        return None;
    }
    let steps = -0.5 * slope / curve;
    let scatter = parts.iter().map(|[c, t]| (t + 2.0 * c * steps).powi(2));
    let farthest = moved.into_iter().fold(0.0, f64::max);
    Some(SeenHeight {
        share: 1.0 + STEP * steps,
        deviation: STEP * 0.5 * scatter.sum::<f64>().sqrt() / curve,
        off: steps.abs() * farthest,
    })
}

/// The images as a tracker sees them that has learned the object's side anew: it is as wide as the height makes it.
fn looked(pilots: &[Pilot], learned: &Learned, tracker: &Tracker) -> Vec<Looked> {
    let look = |learned: &Learned| -> Vec<Looked> {
        let images = pilots.par_iter();
        images
            .map(|(image, _)| tracker.study(image, learned))
            .collect()
    };
    let mut own = Learned {
        side: None,
        ..learned.clone()
    };
    let is_found = |looked: &&Looked| looked.observation.centre.is_ok();
    let first = look(&own);
    let sums = first.iter().filter(is_found);
    let Side(mut side) = sums
        .fold(SideSums::default(), |sums, looked| sums.plus(&looked.side))
        .fit();
    own.side = Some(Side(side));
    let second = look(&own);
    let sums = second.iter().filter(is_found);
    let more = sums
        .fold(BandSums::default(), |sums, looked| sums.plus(&looked.band))
        .fit();
    for (part, more) in side.iter_mut().zip(more) {
        *part += more;
    }
    own.side = Some(Side(side));
    look(&own)
}
