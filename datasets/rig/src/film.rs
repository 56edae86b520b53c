//! The demo's logs with pictures in place of centroids: what a camera over the table would have recorded.

use std::path::Path;
use std::sync::Arc;

use logs::Limits;
use logs::read::{RawChannel, RawMessage, read_raw};
use logs::write::CopyWriter;
use rayon::prelude::*;
use render::{Moment, Optics, Renderer, Scene};
use values::{Colour, ImageTopic, Rig, StampMark};

use crate::slide::Lying;
use crate::strike::{PreparedRig, StrikeOutcome};
use crate::{RigSimError, StrikeTruth, Truth};

/// The demo's camera: 640 × 480 pixels, 2 mm a pixel on the table.
const PIXELS: [usize; 2] = [640, 480];
const FOCAL: f64 = 590.0;
const POSITION: [f64; 3] = [0.55, 0.0, 1.2];
/// It looks straight down; what is far from the robot is up in the picture.
const ORIENTATION: [f64; 4] = [
    -std::f64::consts::FRAC_1_SQRT_2,
    std::f64::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
];
/// A lens of a few per mille at the corners.
const DISTORTION: [f64; 5] = [-0.08, 0.02, 0.0004, -0.0003, 0.0];
const EXPOSURE: f64 = 0.004;
/// JPEG's quality, and the noise of a byte.
const QUALITY: u8 = 90;
const NOISE: f64 = 1.5;
/// The square of this many rays is cast for a pixel.
const RAYS: usize = 4;
/// A strike's recording begins less than this before its impact, and ends more than this before the next impact, in ns.
const BEFORE_IMPACT: u64 = 1_500_000_000;
/// Pictures that are made side by side.
const BATCH: usize = 64;

/// The rig with the demo's camera and the object's colour.
pub fn with_camera(rig: Rig) -> Rig {
    let mut rig = rig;
    let [width, height] = PIXELS.map(|size| size as f64);
    rig.camera.matrix = Some([FOCAL, FOCAL, 0.5 * (width - 1.0), 0.5 * (height - 1.0)]);
    rig.camera.size = Some(PIXELS.map(|size| size as u32));
    rig.camera.distortion = Some(DISTORTION);
    rig.camera.position = Some(POSITION);
    rig.camera.orientation = Some(ORIENTATION);
    rig.camera.exposure = Some(EXPOSURE);
    rig.camera.readout = Some(0.0);
    rig.camera.stamp = StampMark::Middle;
    rig.object.colour = Some(Colour::demo());
    rig.topics.image = Some(ImageTopic::new("/camera/image/compressed"));
    rig
}

/// What films a rig that has a camera ([`with_camera`]).
pub(crate) struct Film {
    renderer: Renderer,
    prepared: PreparedRig,
    topic: String,
}

impl Film {
    /// Prepares to film; none where the rig has no topic of images.
    ///
    /// # Errors
    /// The rig has no lens, pose or size of the object.
    pub(crate) fn of(truth: &Truth) -> Result<Option<Self>, RigSimError> {
        let rig = &truth.rig;
        let Some(topic) = &rig.topics.image else {
            return Ok(None);
        };
        let incomplete = || RigSimError::Film("its camera has no lens or pose".into());
        let optics = Optics::of(rig, PIXELS).ok_or_else(incomplete)?;
        let scene = Scene::laboratory(&rig.object).ok_or_else(incomplete)?;
        Ok(Some(Self {
            renderer: Renderer::new(optics, scene, NOISE, RAYS),
            prepared: PreparedRig::new(truth.clone())?,
            topic: topic.name.clone(),
        }))
    }

    /// Writes the log `from` as `to`, with pictures in place of its centroids, and removes it. `truth` knows the log's strikes.
    ///
    /// Every centroid's stamp becomes that of a picture of the object where it was then. Pictures have the noise of a sensor in place
    /// of the centroids' noise. Boxes are not turned in them, and the arm is not seen.
    ///
    /// # Errors
    /// A log cannot be read or written.
    pub(crate) fn film(&self, truth: &Truth, from: &Path, to: &Path) -> Result<(), RigSimError> {
        let new = to.with_extension("filmed");
        let mut camera = Camera {
            eye: FrameRenderer {
                truth,
                prepared: &self.prepared,
                renderer: &self.renderer,
            },
            topic: &self.topic,
            writer: CopyWriter::create(&new)?,
            batch: Vec::new(),
        };
        read_raw(from, Limits::default(), &mut |message| {
            camera.take(&message)
        })?;
        camera.flush()?;
        camera.writer.finish()?;
        let file_error = |source| RigSimError::File {
            doing: "write",
            path: to.display().to_string(),
            source,
        };
        std::fs::rename(&new, to).map_err(file_error)?;
        std::fs::remove_file(from).map_err(file_error)
    }
}

/// What a picture is made from.
#[derive(Clone, Copy)]
struct FrameRenderer<'a> {
    truth: &'a Truth,
    prepared: &'a PreparedRig,
    renderer: &'a Renderer,
}

struct Camera<'a> {
    eye: FrameRenderer<'a>,
    topic: &'a str,
    writer: CopyWriter<std::io::BufWriter<std::fs::File>>,
    /// Messages in order, and how many of them become pictures.
    batch: Vec<(Arc<RawChannel>, u64, Vec<u8>)>,
}

impl Camera<'_> {
    fn take(&mut self, message: &RawMessage<'_>) -> Result<(), RigSimError> {
        let data = message.data.to_vec();
        self.batch
            .push((message.channel.clone(), message.log_time, data));
        let is_centroid =
            |channel: &RawChannel| channel.topic == self.eye.truth.rig.topics.centroid.name;
        let pictures = self
            .batch
            .iter()
            .filter(|(channel, ..)| is_centroid(channel));
        if pictures.count() >= BATCH {
            self.flush()
        } else {
            Ok(())
        }
    }

    fn flush(&mut self) -> Result<(), RigSimError> {
        let (batch, eye) = (std::mem::take(&mut self.batch), self.eye);
        let centroid = &self.eye.truth.rig.topics.centroid.name;
        let made: Vec<_> = batch
            .par_iter()
            .map(|(channel, stamp, _)| {
                (channel.topic == *centroid)
                    .then(|| eye.picture(*stamp))
                    .transpose()
            })
            .collect();
        for ((channel, log_time, data), picture) in batch.into_iter().zip(made) {
            match picture? {
                Some(picture) => {
                    self.writer.jpeg(self.topic, log_time, log_time, &picture)?;
                }
                None => self.writer.copy(&RawMessage {
                    channel: &channel,
                    log_time,
                    data: &data,
                })?,
            }
        }
        Ok(())
    }
}

impl FrameRenderer<'_> {
    /// The JPEG of a picture that is exposed about this stamp, which is the log time of the demo's centroids.
    fn picture(&self, stamp: u64) -> Result<Vec<u8>, RigSimError> {
        let strikes = &self.truth.strikes;
        let is_begun = |strike: &StrikeTruth| strike.impact < stamp.saturating_add(BEFORE_IMPACT);
        let count = strikes.partition_point(is_begun).max(1);
        let Some(strike) = strikes.get(count - 1) else {
            let why = "no strike of the truth is as early as the log".into();
            return Err(RigSimError::Film(why));
        };
        let outcome = self.outcome(strike);
        let since = 1e-9 * (stamp as f64 - strike.impact as f64);
        let (hidden, centre) = (&self.truth.hidden, self.truth.rig.camera.centre);
        let path = |time: f64| {
            let seen = hidden.see(outcome.at(since + time), centre, strike.index());
            Moment {
                x: seen.x,
                y: seen.y,
                yaw: 0.0,
            }
        };
        let rendered = self.renderer.render(&path, stamp ^ self.truth.seed);
        let jpeg = rendered.picture.jpeg(QUALITY);
        jpeg.map_err(|error| RigSimError::Film(error.to_string()))
    }

    fn outcome(&self, strike: &StrikeTruth) -> StrikeOutcome {
        let from = Lying {
            at: strike.initial,
            yaw: strike.yaw.unwrap_or(0.0),
        };
        let friction = strike.friction.unwrap_or(1.0);
        self.prepared
            .strike(from, strike.delivered, strike.index(), friction)
    }
}
