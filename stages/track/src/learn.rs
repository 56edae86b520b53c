//! What a log's own images teach before each is looked at: the table without the object, how bright the object's sides are, how much
//! larger than it is the object is seen, and how well its centre is known.

use std::path::Path;
use std::sync::Arc;

use logs::read::{RawChannel, RawMessage, read_raw};
use logs::{Limits, LogError};
use rayon::prelude::*;

use crate::background::{FEWEST_PILOTS, Pilot};
use crate::change::BandSums;
use crate::decode::size;
use crate::edges::{Side, SideSums};
use crate::height::Profiles;
use crate::learned::Learned;
use crate::message::is_video;
use crate::tracker::Looked;
use crate::{Decoder, Image, ImageMessage, Reason, Tracker};

/// How well a log's own images tell that, at the best.
const LEAST_LARGER: f64 = 0.08;
/// Images that are looked at, and bytes that their pixels and their messages take at the most.
const PILOTS: usize = 20;
const MOST_PIXEL_BYTES: usize = 44 << 20;
const MOST_MESSAGE_BYTES: usize = 32 << 20;
/// A table that is seen elsewhere by so many px in another image has moved, or its light has; an object that moved by less than this share of it
/// stayed, and one that is so near to it moved with it.
const MOVED: f64 = 0.7;
const STAYS: f64 = 0.4;
/// The object's picture with its shadow reaches so far beyond its outline, of its size.
const AROUND: f64 = 0.5;

/// One message that waits.
struct Kept {
    channel: Arc<RawChannel>,
    data: Vec<u8>,
}

impl Learned {
    /// What the images of a log's topic teach, some taken evenly over all of it. Images of a video build on one another: of one nothing is
    /// learned.
    ///
    /// # Errors
    /// The log cannot be read.
    pub(crate) fn of_log(log: &Path, topic: &str, tracker: &Tracker) -> Result<Self, LogError> {
        let (mut kept, mut every, mut number, mut bytes) = (Vec::<Kept>::new(), 1, 0usize, 0);
        let mut size = None;
        read_raw(log, Limits::default(), &mut |message: RawMessage<'_>| {
            let channel = message.channel;
            if channel.topic != topic || is_video(&channel.schema) {
                return Ok::<_, LogError>(());
            }
            // Of larger images too few are held for a background.
            size = size.or_else(|| pixel_bytes(channel, message.data));
            let most = MOST_PIXEL_BYTES / FEWEST_PILOTS;
            if message.data.len() > most || size.is_none_or(|size| size > most) {
                return Ok(());
            }
            if number % every == 0 {
                bytes += message.data.len();
                kept.push(Kept {
                    channel: Arc::clone(channel),
                    data: message.data.to_vec(),
                });
            }
            number += 1;
            // Every second one goes where there are too many: those that stay are even over the log.
            while kept.len() > 2 * PILOTS
                || (bytes > MOST_MESSAGE_BYTES && kept.len() > FEWEST_PILOTS)
            {
                let mut is_even = false;
                kept.retain(|_| {
                    is_even = !is_even;
                    is_even
                });
                bytes = kept.iter().map(|kept| kept.data.len()).sum();
                every *= 2;
            }
            Ok(())
        })?;
        Ok(size.map_or_else(Self::default, |size| Self::of(kept, size, tracker)))
    }

    /// Learns from messages of images whose pixels take so many bytes each.
    fn of(kept: Vec<Kept>, size: usize, tracker: &Tracker) -> Self {
        let most = (MOST_PIXEL_BYTES / size).min(PILOTS);
        if most < FEWEST_PILOTS {
            return Self::default();
        }
        let step = kept.len().div_ceil(most).max(1);
        let some: Vec<Kept> = kept.into_iter().step_by(step).collect();
        // Each message goes as its image comes.
        let images = some.into_par_iter().filter_map(|kept| decoded(&kept));
        let images: Vec<Image> = images.collect();
        let look = |image: &Image, learned: &Self| tracker.study(image, learned);
        let mut learned = Self::default();
        let mut first: Vec<Looked> = images
            .par_iter()
            .map(|image| look(image, &learned))
            .collect();
        let found = |looked: &[Looked]| -> Vec<Looked> {
            let found = looked
                .iter()
                .filter(|looked| looked.observation.centre.is_ok());
            found.cloned().collect()
        };
        let parts: Vec<_> = first.iter().map(hidden).collect();
        let mut pilots: Vec<Pilot> = images.into_iter().zip(parts).collect();
        let all = |pilots: &[Pilot], learned: &Self| -> Vec<Looked> {
            let looked = pilots.par_iter().map(|(image, _)| look(image, learned));
            looked.collect()
        };
        learned.background = tracker.background(&pilots);
        if found(&first).len() < FEWEST_PILOTS {
            // What always lies there is known by now: it is no other object.
            first = all(&pilots, &learned);
            for ((_, part), looked) in pilots.iter_mut().zip(&first) {
                *part = hidden(looked);
            }
            learned.background = tracker.background(&pilots);
        }
        // How bright its pixels show the side, and then what the edges say of it, with the table known.
        let sums = found(&first)
            .iter()
            .fold(SideSums::default(), |sums, looked| sums.plus(&looked.side));
        let Side(mut side) = sums.fit();
        learned.side = Some(Side(side));
        let mut again = all(&pilots, &learned);
        let observations = again.iter().map(|looked| &looked.observation);
        let seen = observations.filter(|seen| seen.centre.is_ok());
        let seen: Vec<Seen> = seen
            .filter_map(|seen| Some((seen.pixel?, seen.shift)))
            .collect();
        if is_light(&seen) {
            learned.background = tracker.background_at_rest(&pilots);
            again = all(&pilots, &learned);
        }
        let again = found(&again);
        if again.len() < FEWEST_PILOTS {
            learned.side = None;
            return learned;
        }
        let sums = again
            .iter()
            .fold(BandSums::default(), |sums, looked| sums.plus(&looked.band));
        for (part, more) in side.iter_mut().zip(sums.fit()) {
            *part += more;
        }
        learned.side = Some(Side(side));
        let mut larger: Vec<f64> = again.iter().map(|looked| looked.larger).collect();
        larger.sort_by(f64::total_cmp);
        let at = |share: f64| larger[(share * (larger.len() - 1) as f64).round() as usize];
        // Half of the distance between the quartiles, as a deviation.
        let deviation = 0.5 * (at(0.75) - at(0.25)) / 0.6745;
        learned.larger = [at(0.5), deviation.max(LEAST_LARGER)];
        // With all of that known, each tells how well its centre is.
        let last = all(&pilots, &learned);
        let seen = pilots.iter().zip(&last);
        let profiles = seen.filter_map(|((image, _), looked)| {
            tracker.profiles(image, &looked.observation, &learned)
        });
        let profiles: Vec<Profiles> = profiles.collect();
        learned.height = tracker.height_off(&profiles);
        let last = found(&last);
        let squares = last
            .iter()
            .map(|looked| looked.observation.deviation.powi(2));
        learned.variance =
            (last.len() >= FEWEST_PILOTS).then(|| squares.sum::<f64>() / last.len() as f64);
        learned
    }
}

/// Where the object is seen, and how far the table from where it was, in px.
type Seen = ([f64; 2], [f64; 2]);

/// Whether it is light that moves over the table, in these images of a log, and not the camera: where the table is seen elsewhere, an object
/// that rests must be seen elsewhere with it.
fn is_light(seen: &[Seen]) -> bool {
    let (mut with_it, mut alone) = (0, 0);
    for (index, before) in seen.iter().enumerate() {
        for behind in &seen[index + 1..] {
            let moved = |of: fn(&Seen) -> [f64; 2]| {
                let (before, behind) = (of(before), of(behind));
                [0, 1].map(|i| behind[i] - before[i])
            };
            let (object, table) = (moved(|seen| seen.0), moved(|seen| seen.1));
            let far = table[0].hypot(table[1]);
            if far < MOVED {
                continue;
            }
            if (object[0] - table[0]).hypot(object[1] - table[1]) < STAYS * far {
                with_it += 1;
            } else if object[0].hypot(object[1]) < STAYS * far {
                alone += 1;
            }
        }
    }
    alone > 1 && alone > with_it
}

/// The part of an image (`[[x, y], [x, y]]`, px) that the object found there and its shadow take: none where it may be one of two.
fn hidden(looked: &Looked) -> [[f64; 2]; 2] {
    let seen = &looked.observation;
    let outline = match seen.centre {
        Err(Reason::TwoObjects) => &[],
        _ => seen.outline.as_slice(),
    };
    let nowhere = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    let [low, high] = outline.iter().fold(nowhere, |[low, high], at| {
        [
            [0, 1].map(|i| low[i].min(at[i])),
            [0, 1].map(|i| high[i].max(at[i])),
        ]
    });
    let around = [0, 1].map(|i| AROUND * (high[i] - low[i]).max(0.0));
    [
        [0, 1].map(|i| low[i] - around[i]),
        [0, 1].map(|i| high[i] + around[i]),
    ]
}

/// Bytes that an image's pixels take.
fn pixel_bytes(channel: &RawChannel, data: &[u8]) -> Option<usize> {
    let message = ImageMessage::parse(&channel.schema, &channel.encoding, data).ok()?;
    let [width, height] = size(&message)?;
    Some(3 * width * height)
}

fn decoded(kept: &Kept) -> Option<Image> {
    let Kept { channel, data } = kept;
    let message = ImageMessage::parse(&channel.schema, &channel.encoding, data).ok()?;
    let mut decoder = Decoder::default();
    decoder.decode(&message).ok()?;
    Some(decoder.into_image())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_over_a_table_without_the_object_on_it_is_light() {
        let stays = [300.0, 200.0];
        let light = [0.0, 1.5, 3.0].map(|far| (stays, [far, 0.0]));
        assert!(is_light(&light));
        let push = [0.0, 1.5, 3.0].map(|far| ([stays[0] + far, stays[1]], [far, 0.0]));
        assert!(!is_light(&push));
        // An object that was struck in between tells nothing.
        let struck = [0.0, 40.0, 90.0].map(|far| ([stays[0] + far, stays[1]], [0.05 * far, 0.0]));
        assert!(!is_light(&struck));
    }
}
