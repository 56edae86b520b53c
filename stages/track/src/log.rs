//! A log with images to a log with centroids.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use logs::read::{Extent, RawChannel, RawMessage, read_raw};
use logs::write::{CopyWriter, Stamped};
use logs::{Limits, LogError};
use rayon::prelude::*;
use values::{ImageTopic, Rig};

use crate::camera_info::{CameraInfo, CameraMessage};
use crate::frame::{TrackedFrame, track_frame};
use crate::message::is_video;
use crate::report::QUALITY_SCHEMA;
use crate::sequence::{Sequence, SequenceFrame};
use crate::view::View;
use crate::{
    Decoder, FrameReport, QUALITY_TOPIC, Reason, TrackError, TrackOutcome, Tracker, is_image,
};

/// The least that an object moves, in m, not to be at rest in two images.
const STILL: f64 = 0.001;
/// Bytes and messages that are looked at side by side: enough for the threads, and little memory.
const BATCH_BYTES: usize = 24 << 20;
const BATCH_MESSAGES: usize = 4096;
const BATCH_IMAGES: usize = 32;

/// Reads a log, finds the object in every image of the rig's image topic, and writes a log with all other messages, the
/// centroids and what is said of every frame. A topic of centroids that the log has already is left out. With `view`, another log
/// is written for viewers: the images with the outline found, and the object's poses.
///
/// Where the rig file has no camera matrix, the lens is that of the log's `CameraInfo`.
///
/// Images are decoded and looked at side by side; the bytes that are written do not depend on the number of threads.
///
/// # Errors
/// The rig file lacks what images need; the log cannot be read; the topic is not there, is no image, or not one of its images can be
/// decoded; the file cannot be written.
pub fn track_log(
    log: &Path,
    rig: &Rig,
    out: &Path,
    view: Option<&Path>,
) -> Result<TrackOutcome, TrackError> {
    let topic = rig.topics.image.as_ref().ok_or(TrackError::NoTopic)?;
    let info = match rig.camera.matrix {
        Some(_) => None,
        None => CameraInfo::of_log(log, &topic.name)?,
    };
    let mut rig = rig.clone();
    if let Some(CameraInfo { lens, .. }) = info {
        rig.camera.matrix = Some(lens.matrix);
        rig.camera.distortion = Some(lens.distortion);
    }
    let tracker = Tracker::new(&rig)?;
    let writer = CopyWriter::create(out)?;
    let mut tracking = Tracking::new(&tracker, &rig, topic, writer)?;
    let of_rig = rig
        .camera
        .size
        .map(|size| size.map(|pixels| pixels as usize));
    tracking.size = info.map_or(of_rig, |info| Some(info.size));
    tracking.view = view.map(View::create).transpose()?;
    let summary = read_raw(log, Limits::default(), &mut |message| {
        tracking.take(&message)
    })?;
    tracking.flush()?;
    let log = log.display().to_string();
    if !summary
        .channels
        .iter()
        .any(|channel| channel.topic == topic.name)
    {
        let found = summary.channels.iter().map(|channel| channel.topic.clone());
        return Err(TrackError::Log(LogError::MissingTopic {
            log,
            topic: topic.name.clone(),
            found: found.collect(),
            images: false,
        }));
    }
    let mut outcome = tracking.finish()?;
    let undecodable = outcome.reasons.get(&Reason::Undecodable);
    if outcome.frames > 0 && undecodable == Some(&outcome.frames) {
        return Err(TrackError::Undecodable {
            log,
            topic: topic.name.clone(),
            images: outcome.frames,
            why: outcome.notes.pop().unwrap_or_default(),
        });
    }
    let damage = summary.damage.iter();
    let damage = damage.filter(|damage| damage.extent != Extent::Index);
    let notes = damage.map(|damage| format!("damaged at byte {}: {}", damage.offset, damage.why));
    outcome.notes.extend(notes);
    Ok(outcome)
}

/// A message that waits for its turn.
enum Item {
    Copy(Arc<RawChannel>, u64, Vec<u8>),
    Image(Arc<RawChannel>, u64, Vec<u8>),
}

/// The messages that came after a frame, until it is decided.
type After = Vec<(Arc<RawChannel>, u64, Vec<u8>)>;

struct Tracking<'a> {
    tracker: &'a Tracker,
    topic: &'a ImageTopic,
    centroid: &'a str,
    writer: CopyWriter<BufWriter<File>>,
    batch: Vec<Item>,
    bytes: usize,
    images: usize,
    /// Of a video, whose images build on one another.
    decoder: Decoder,
    sequence: Sequence<(u64, f64)>,
    /// What waits behind each frame that is held back.
    held: Vec<After>,
    outcome: TrackOutcome,
    why: Option<String>,
    /// Width and height that all images have: the camera's matrix holds for no other.
    size: Option<[usize; 2]>,
    /// What the log says of the camera.
    info: Option<CameraMessage>,
    view: Option<View>,
}

impl<'a> Tracking<'a> {
    fn new(
        tracker: &'a Tracker,
        rig: &'a Rig,
        topic: &'a ImageTopic,
        mut writer: CopyWriter<BufWriter<File>>,
    ) -> Result<Self, TrackError> {
        let centroid = rig.topics.centroid.name.as_str();
        writer.points(centroid)?;
        Ok(Self {
            tracker,
            topic,
            centroid,
            writer,
            batch: Vec::new(),
            bytes: 0,
            images: 0,
            decoder: Decoder::default(),
            sequence: Sequence::new(STILL.max(3.0 * rig.camera.noise)),
            held: Vec::new(),
            outcome: TrackOutcome::default(),
            why: None,
            size: None,
            info: None,
            view: None,
        })
    }

    fn take(&mut self, message: &RawMessage<'_>) -> Result<(), TrackError> {
        let channel = message.channel;
        if channel.topic == self.centroid || channel.topic == QUALITY_TOPIC {
            return Ok(());
        }
        if self.info.is_none() {
            self.info = CameraMessage::beside(message, &self.topic.name);
        }
        let parts = (channel.clone(), message.log_time, message.data.to_vec());
        self.bytes += message.data.len();
        if channel.topic == self.topic.name {
            if !is_image(&channel.schema) {
                return Err(TrackError::NoImages {
                    topic: channel.topic.clone(),
                    schema: channel.schema.clone(),
                });
            }
            self.images += 1;
            self.batch.push(Item::Image(parts.0, parts.1, parts.2));
        } else if !is_image(&channel.schema) {
            // Another camera's images are not needed, and would fill the disk again.
            self.batch.push(Item::Copy(parts.0, parts.1, parts.2));
        }
        let is_full = self.bytes > BATCH_BYTES
            || self.batch.len() > BATCH_MESSAGES
            || self.images >= BATCH_IMAGES;
        if is_full { self.flush() } else { Ok(()) }
    }

    /// Looks at the images of a batch side by side, those of a video one after another, then goes through it in order.
    fn flush(&mut self) -> Result<(), TrackError> {
        let batch = std::mem::take(&mut self.batch);
        (self.bytes, self.images) = (0, 0);
        let is_drawn = self.view.is_some();
        let tracker = self.tracker;
        let track = |decoder: &mut Decoder, item: &Item| match item {
            Item::Copy(..) => None,
            Item::Image(channel, log_time, data) => {
                let message = (*log_time, data.as_slice());
                Some(track_frame(tracker, decoder, channel, message, is_drawn))
            }
        };
        let is_of_video =
            |item: &Item| matches!(item, Item::Image(channel, ..) if is_video(&channel.schema));
        let tracked: Vec<Option<TrackedFrame>> = if batch.iter().any(is_of_video) {
            let items = batch.iter();
            items.map(|item| track(&mut self.decoder, item)).collect()
        } else {
            let items = batch.par_iter();
            items.map_init(Decoder::default, track).collect()
        };
        for (item, tracked) in batch.into_iter().zip(tracked) {
            match (item, tracked) {
                (Item::Image(_, log_time, _), Some(tracked)) => self.frame(log_time, tracked)?,
                (Item::Image(..), None) => {}
                (Item::Copy(channel, log_time, data), _) => {
                    // Behind a frame that waits, all wait.
                    match self.held.last_mut() {
                        Some(after) => after.push((channel, log_time, data)),
                        None => self.copy(&channel, log_time, &data)?,
                    }
                }
            }
        }
        Ok(())
    }

    fn frame(&mut self, log_time: u64, tracked: TrackedFrame) -> Result<(), TrackError> {
        self.outcome.frames += 1;
        let tracked = self.of_size(tracked);
        if let Some(view) = &mut self.view {
            view.add(log_time, &tracked)?;
        }
        if self.why.is_none() {
            self.why = tracked.why;
        }
        let quality = tracked.observation.quality;
        self.held.push(Vec::new());
        let frame = SequenceFrame {
            stamp: tracked.stamp,
            hash: tracked.hash,
            centre: tracked.observation.centre,
            with: (log_time, quality),
        };
        let mut decided = Vec::new();
        self.sequence.push(frame, &mut |frame| decided.push(frame));
        self.write(decided)
    }

    /// The same, unless its size is another than that of the images before.
    fn of_size(&mut self, tracked: TrackedFrame) -> TrackedFrame {
        match (tracked.size, self.size) {
            (Some(size), Some(first)) if size != first => {
                let [[width, height], [first_width, first_height]] = [size, first];
                let why = format!(
                    "it is {width} × {height} pixels and the camera's are {first_width} × {first_height}"
                );
                TrackedFrame::undecodable(tracked.stamp, why)
            }
            (Some(size), None) => {
                self.size = Some(size);
                tracked
            }
            _ => tracked,
        }
    }

    /// Writes frames that are decided, each with what waited behind it.
    fn write(&mut self, decided: Vec<SequenceFrame<(u64, f64)>>) -> Result<(), TrackError> {
        let waiting: Vec<After> = self.held.drain(..decided.len()).collect();
        for (frame, after) in decided.into_iter().zip(waiting) {
            let point = frame.centre.ok();
            let (log_time, quality) = frame.with;
            let reason = frame.centre.err();
            let report = FrameReport {
                stamp: frame.stamp,
                x: point.map(|point| point.x),
                y: point.map(|point| point.y),
                quality,
                reason,
            };
            if let (Some(point), Ok(stamp)) = (point, u64::try_from(frame.stamp)) {
                self.outcome.centroids += 1;
                let (x, y) = (point.x, point.y);
                self.writer
                    .point(self.centroid, log_time, &Stamped { stamp, x, y })?;
            }
            if let Some(reason) = reason {
                *self.outcome.reasons.entry(reason).or_insert(0) += 1;
            }
            let data = serde_json::to_vec(&report).unwrap_or_default();
            let schema = ("carom.FrameReport", "jsonschema", QUALITY_SCHEMA);
            self.writer
                .add(QUALITY_TOPIC, schema, "json", log_time, &data)?;
            for (channel, log_time, data) in after {
                self.copy(&channel, log_time, &data)?;
            }
        }
        Ok(())
    }

    fn copy(
        &mut self,
        channel: &Arc<RawChannel>,
        log_time: u64,
        data: &[u8],
    ) -> Result<(), TrackError> {
        let message = RawMessage {
            channel,
            log_time,
            data,
        };
        Ok(self.writer.copy(&message)?)
    }

    fn finish(mut self) -> Result<TrackOutcome, TrackError> {
        let mut decided = Vec::new();
        self.sequence.finish(&mut |frame| decided.push(frame));
        self.write(decided)?;
        self.writer.finish()?;
        if let Some(view) = self.view {
            view.finish()?;
        }
        let mut outcome = self.outcome;
        if let Some(info) = &self.info {
            let lens = &self.tracker.camera().lens;
            outcome.notes.extend(info.contradictions(lens, self.size));
        }
        outcome.notes.extend(self.why);
        Ok(outcome)
    }
}
