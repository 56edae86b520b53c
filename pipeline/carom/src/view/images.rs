//! Images of the logs at the strikes' times: small, and of many strikes a few each.

use std::collections::BTreeMap;
use std::path::Path;

use foxglove::messages::{
    CameraCalibration, CompressedImage, FrameTransform, FrameTransforms, Quaternion,
};
use rayon::prelude::*;
use track::{Excerpt, SmallImage, TrackError, Window, averaged_by, excerpt};
use values::{Rig, Strike};

use super::draw::vector;
use super::messages::{AFTER, BEFORE, Message, TABLE, nanoseconds, timestamp};
use crate::Error;
use crate::reading::Read;

/// Images of a topic in all, and of a strike, at the most. Each takes some tens of kilobytes.
const MOST: usize = 4000;
const MOST_OF_STRIKE: usize = 120;
/// The frame of the rig's camera.
const CAMERA: &str = "camera";

#[derive(Debug, Default)]
pub struct Images {
    /// Each strike's, by its id.
    of_strikes: BTreeMap<String, Vec<SmallImage>>,
    camera: Option<Camera>,
    /// What is not shown, in sentences.
    pub notes: Vec<String>,
}

/// The rig's camera, of which lens and pose are known.
#[derive(Clone, Debug)]
struct Camera {
    topic: String,
    /// Width and height of its small images, in px.
    size: [u32; 2],
    /// Focal lengths and principal point in such an image, in px.
    matrix: [f64; 4],
    distortion: [f64; 5],
    position: [f64; 3],
    orientation: [f64; 4],
}

impl Camera {
    fn of(rig: &Rig) -> Option<Self> {
        let (camera, size) = (&rig.camera, rig.camera.size?);
        let by = averaged_by(size);
        let scale = f64::from(by);
        let [fx, fy, cx, cy] = camera.matrix?;
        // Pixel centres are whole numbers.
        let centre = |place: f64| (place + 0.5) / scale - 0.5;
        Some(Self {
            topic: rig.topics.image.as_ref()?.name.clone(),
            size: size.map(|side| side / by),
            matrix: [fx / scale, fy / scale, centre(cx), centre(cy)],
            distortion: camera.distortion.unwrap_or_default(),
            position: camera.position?,
            orientation: camera.orientation?,
        })
    }

    /// Where it is, and its lens on a topic beside its images.
    fn messages(&self, stamp: u64) -> Result<[Message; 2], Error> {
        let [x, y, z, w] = self.orientation;
        let transform = FrameTransform {
            timestamp: timestamp(stamp),
            parent_frame_id: TABLE.into(),
            child_frame_id: CAMERA.into(),
            translation: vector(self.position),
            rotation: Some(Quaternion { x, y, z, w }),
        };
        let transforms = FrameTransforms {
            transforms: vec![transform],
        };
        let [fx, fy, cx, cy] = self.matrix;
        let [width, height] = self.size;
        let calibration = CameraCalibration {
            timestamp: timestamp(stamp),
            frame_id: CAMERA.into(),
            width,
            height,
            distortion_model: "plumb_bob".into(),
            d: self.distortion.to_vec(),
            k: vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            r: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p: vec![fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        };
        let (beside, _) = self.topic.rsplit_once('/').unwrap_or_default();
        Ok([
            Message::new("/carom/camera", stamp, &transforms)?,
            Message::new(format!("{beside}/camera_info"), stamp, &calibration)?,
        ])
    }
}

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
    let mut images = Images {
        camera: Camera::of(&read.rig),
        ..Images::default()
    };
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
    pub fn count(&self) -> usize {
        self.of_strikes.values().map(Vec::len).sum()
    }

    /// The camera, where it is known and its images are shown.
    pub fn camera(&self, stamp: u64) -> Result<Vec<Message>, Error> {
        let mut all = self.of_strikes.values().flatten();
        let camera = self.camera.as_ref();
        let camera = camera.filter(|camera| all.any(|image| image.topic == camera.topic));
        match camera {
            Some(camera) => Ok(camera.messages(stamp)?.into()),
            None => Ok(Vec::new()),
        }
    }

    /// The frame of a topic's images. A camera of which nobody knows where it is has the table's: beside a frame that is joined to no other, viewers
    /// draw nothing.
    fn frame(&self, topic: &str) -> &'static str {
        match &self.camera {
            Some(camera) if camera.topic == topic => CAMERA,
            _ => TABLE,
        }
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
                frame_id: self.frame(&image.topic).into(),
                data: image.data.clone().into(),
                format: image.format.into(),
            };
            Message::new(image.topic.as_str(), stamp, &message)
        });
        messages.collect()
    }
}
