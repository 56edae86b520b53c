//! Images of the logs at the strikes' times: small, and of many strikes a few each.

use std::collections::BTreeMap;
use std::path::Path;

use foxglove::messages::CompressedImage;
use rayon::prelude::*;
use track::{Excerpt, SmallImage, TrackError, Window, excerpt};
use values::Strike;

use super::messages::{Message, nanoseconds, timestamp};
use super::show::{AFTER, BEFORE};
use crate::Error;
use crate::reading::Read;

/// Images of a topic in all, and of a strike, at the most. Each takes some tens of kilobytes.
const MOST: usize = 4000;
const MOST_OF_STRIKE: usize = 120;
/// The frame that images are in; nothing says where it is.
const CAMERA: &str = "camera";

/// Images of strikes.
#[derive(Debug, Default)]
pub struct Images {
    /// Each strike's, by its id.
    of_strikes: BTreeMap<String, Vec<SmallImage>>,
    /// What is not shown, in sentences.
    pub notes: Vec<String>,
}

/// Images of these strikes, from the logs that they were read from.
pub fn images(read: &Read, strikes: &[&Strike]) -> Result<Images, Error> {
    let most = (MOST / strikes.len().max(1)).min(MOST_OF_STRIKE) as u32;
    let mut of_logs: BTreeMap<&str, Vec<&Strike>> = BTreeMap::new();
    for strike in strikes {
        of_logs.entry(&strike.log).or_default().push(strike);
    }
    let topic = read.rig.topics.image.as_ref();
    let topic = topic.map(|topic| topic.name.as_str());
    let found = of_logs.par_iter().map(|(name, strikes)| {
        let Some(log) = read.logs.iter().find(|log| log.name == *name) else {
            return Ok(Excerpt::default());
        };
        let log: &Path = read.images.get(&log.path).unwrap_or(&log.path);
        let windows: Vec<Window> = strikes.iter().map(|strike| window(strike, most)).collect();
        excerpt(log, topic, &windows)
    });
    let found = found.collect::<Result<Vec<_>, TrackError>>();
    let found = found.map_err(Error::input)?;
    let mut images = Images::default();
    for ((log, strikes), excerpt) in of_logs.iter().zip(found) {
        let notes = excerpt.notes.into_iter();
        images
            .notes
            .extend(notes.map(|note| format!("{log}: {note}")));
        for image in excerpt.images {
            let id = &strikes[image.window].id;
            let of_strike = images.of_strikes.entry(id.clone()).or_default();
            of_strike.push(image);
        }
    }
    Ok(images)
}

/// The time in which a strike is shown.
fn window(strike: &Strike, most: u32) -> Window {
    let last = strike.track.t.last().copied().unwrap_or(0.0);
    let stamp = |t: f64| i64::try_from(nanoseconds(strike.t_start + t)).unwrap_or(i64::MAX);
    Window {
        from: stamp(-BEFORE),
        to: stamp(last + AFTER),
        most,
    }
}

impl Images {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.of_strikes.values().map(Vec::len).sum()
    }

    /// A strike's, whose first motion is at `at` (ns), on the topics that they have in its log.
    pub fn messages(&self, strike: &Strike, at: u64) -> Result<Vec<Message>, Error> {
        let start = i128::from(nanoseconds(strike.t_start));
        let of_strike = self.of_strikes.get(&strike.id);
        let messages = of_strike.into_iter().flatten().map(|image| {
            let moved = i128::from(image.stamp) - start + i128::from(at);
            let stamp = u64::try_from(moved).unwrap_or(at);
            let message = CompressedImage {
                timestamp: timestamp(stamp),
                frame_id: CAMERA.into(),
                data: image.data.clone().into(),
                format: image.format.into(),
            };
            Message::new(image.topic.as_str(), stamp, &message)
        });
        messages.collect()
    }
}
