//! The object in one message of an image topic.

use std::hash::{DefaultHasher, Hash, Hasher};

use logs::read::RawChannel;

use crate::change::PatternSums;
use crate::draw::drawn;
use crate::learned::Learned;
use crate::{Decoder, ImageMessage, Observation, Reason, Tracker};

/// One image message after tracking.
pub(crate) struct TrackedFrame {
    /// Middle of the exposure of the object's rows, in ns.
    pub(crate) stamp: i64,
    /// Hash of the image's bytes as they came; none where they could not be read.
    pub(crate) hash: Option<u64>,
    /// Width and height, where it was decoded.
    pub(crate) size: Option<[usize; 2]>,
    pub(crate) observation: Observation,
    pub(crate) shear: PatternSums<2>,
    pub(crate) why: Option<String>,
    /// The image with what was found drawn in, as JPEG, where that is wanted.
    pub(crate) drawn: Option<Vec<u8>>,
}

/// Decodes a message and finds the object in it.
pub(crate) fn track_frame(
    (tracker, learned): (&Tracker, &Learned),
    decoder: &mut Decoder,
    channel: &RawChannel,
    (log_time, data): (u64, &[u8]),
    is_drawn: bool,
) -> TrackedFrame {
    let parsed = ImageMessage::parse(&channel.schema, &channel.encoding, data);
    let log_stamp = i64::try_from(log_time).unwrap_or(i64::MAX);
    let stamp = parsed.as_ref().map_or(log_stamp, |message| message.stamp);
    // Of a video as well: an encoder sends an image again in other bytes, and one of an object at rest may have the same pixels.
    let hash = parsed.as_ref().ok().map(|message| {
        let mut hasher = DefaultHasher::new();
        message.payload.bytes().hash(&mut hasher);
        hasher.finish()
    });
    match parsed.and_then(|message| decoder.decode(&message)) {
        Ok(image) => {
            let looked = tracker.look(image, learned);
            let observation = looked.observation;
            let middle = 0.5 * image.height as f64;
            let row = observation.pixel.map_or(middle, |[_, row]| row);
            let delay = tracker.camera().delay(row, image.height);
            TrackedFrame {
                stamp: stamp.saturating_add((1e9 * delay).round() as i64),
                hash,
                size: Some([image.width, image.height]),
                drawn: is_drawn.then(|| drawn(image, &observation)).flatten(),
                observation,
                shear: looked.shear,
                why: None,
            }
        }
        Err(error) => TrackedFrame::undecodable(stamp, error.to_string()),
    }
}

impl TrackedFrame {
    /// A message whose image is of no use.
    pub(crate) fn undecodable(stamp: i64, why: String) -> Self {
        Self {
            stamp,
            hash: None,
            size: None,
            observation: Observation::none(Reason::Undecodable),
            shear: PatternSums::default(),
            why: Some(why),
            drawn: None,
        }
    }
}
