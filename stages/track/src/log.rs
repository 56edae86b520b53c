//! A log with images to a log with centroids.

use std::path::Path;
use std::sync::Arc;

use logs::read::{Extent, RawMessage, read_raw};
use logs::write::{CopyWriter, Received, Stamped};
use logs::{Limits, LogError};
use values::{ImageTopic, Rig};

use crate::camera_info::{CameraMessage, LogLens};
use crate::frame::TrackedFrame;
use crate::learned::Learned;
use crate::message_queue::{FrameTracker, MessageQueue, Processed};
use crate::notes::{Notes, QUALITY_SCHEMA, said_of_height, said_of_marker};
use crate::readout::Readout;
use crate::sequence::{Sequence, SequenceFrame};
use crate::view::{LogFile, View};
use crate::{
    FrameReport, Observation, QUALITY_TOPIC, Reason, SeenMarker, TrackError, TrackOutcome, Tracker,
    is_image,
};

/// The least that an object moves, in m, not to be at rest in two images.
const STILL: f64 = 0.001;

/// Bytes of messages that wait at the most for a frame to be decided.
const MOST_HELD_BYTES: usize = 8 << 20;
/// A larger message waits for none: it is copied as it is read, ahead of those that wait.
const LARGE_MESSAGE: usize = 1 << 20;

/// Reads a log, finds the object in every image of the rig's image topic, and writes a log with all other messages, the
/// centroids, the poses of an object with a marker, and what is said of every frame. Topics of these that the log has already are left
/// out. With `view`, another log is written for viewers: the images with the outline found, and the object's poses.
///
/// Where the rig file has no camera matrix, the lens is that of the log's `CameraInfo`.
///
/// Images are decoded and looked at side by side; the bytes that are written do not depend on the number of threads. Both logs get
/// their names when they are whole: one that was there stays where this fails or is stopped.
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
    let mut outcome = TrackOutcome::default();
    durable::write(out, |file| {
        let mut into = |view: Option<View<'_>>| -> Result<(), TrackError> {
            outcome = track_into(log, rig, file, view)?;
            Ok(())
        };
        match view {
            Some(view) => durable::write(view, |file| into(Some(View::new(file)?))),
            None => into(None),
        }
    })?;
    Ok(outcome)
}

fn track_into(
    log: &Path,
    rig: &Rig,
    file: LogFile<'_>,
    view: Option<View<'_>>,
) -> Result<TrackOutcome, TrackError> {
    let topic = rig.topics.image.as_ref().ok_or(TrackError::NoTopic)?;
    let LogLens { rig, size, note } = LogLens::of(log, rig, &topic.name)?;
    let tracker = Tracker::new(&rig)?;
    let (centroid, pose) = (&rig.topics.centroid.name, &rig.topics.pose.topic.name);
    let has_poses = rig.object.marker.is_some() && pose != centroid;
    let pose = has_poses.then_some(pose.as_str());
    let learned = Learned::of_log(log, &topic.name, &tracker)?;
    let readout = match tracker.camera().readout {
        Some(_) => None,
        None => {
            let seeing = (&tracker, &learned);
            Readout::of_log(log, &topic.name, seeing, 1.0 / rig.camera.rate)?
        }
    };
    let tracker = match readout {
        Some(readout) => tracker.with_readout(readout.seconds),
        None => tracker,
    };
    let frames = FrameTracker::new(&tracker, &learned, view.is_some());
    let (summary, mut outcome) = rayon::scope_fifo(|scope| {
        let mut tracking = Tracking {
            tracker: &tracker,
            learned: &learned,
            topic,
            centroid,
            pose,
            rig: &rig,
            writer: CopyWriter::new(file)?,
            queue: MessageQueue::new(scope, &frames),
            sequence: Sequence::new(STILL.max(3.0 * rig.camera.noise)),
            held: Vec::new(),
            held_bytes: 0,
            outcome: TrackOutcome::default(),
            why: None,
            notes: Notes::of(tracker.camera(), readout, tracker.fastest()),
            size,
            info: None,
            view,
        };
        tracking.writer.points(tracking.centroid)?;
        let summary = read_raw(log, Limits::default(), &mut |message| {
            tracking.take(&message)
        })?;
        Ok::<_, TrackError>((summary, tracking.finish()?))
    })?;
    let log = log.display().to_string();
    if !summary.has(&topic.name) {
        let found = summary.channels.iter();
        let found = found.map(|seen| seen.channel.topic.clone());
        return Err(TrackError::Log(LogError::MissingTopic {
            log,
            topic: topic.name.clone(),
            found: found.collect(),
            images: false,
        }));
    }
    let undecodable = outcome.reasons.get(&Reason::Undecodable);
    if outcome.frames > 0 && undecodable == Some(&outcome.frames) {
        return Err(TrackError::Undecodable {
            log,
            topic: topic.name.clone(),
            images: outcome.frames,
            why: outcome.notes.pop().unwrap_or_default(),
        });
    }
    outcome.notes.splice(0..0, note);
    let damage = summary.damage.iter();
    let damage = damage.filter(|damage| damage.extent != Extent::Index);
    let notes = damage.map(|damage| format!("damaged at byte {}: {}", damage.offset, damage.why));
    outcome.notes.extend(notes);
    Ok(outcome)
}

/// What is said of a frame beside its centre.
#[derive(Clone, Copy, Debug)]
struct Seen {
    quality: f64,
    deviation: f64,
    shift: [f64; 2],
    /// The yaw that the marker shows (rad), and the marker.
    turned: Option<(f64, SeenMarker)>,
}

struct Tracking<'a, 's, 'scope> {
    tracker: &'a Tracker,
    learned: &'a Learned,
    topic: &'a ImageTopic,
    rig: &'a Rig,
    centroid: &'a str,
    /// Topic of poses, where the object has a marker.
    pose: Option<&'a str>,
    writer: CopyWriter<LogFile<'a>>,
    queue: MessageQueue<'s, 'scope>,
    sequence: Sequence<(u64, Seen)>,
    /// The messages that came after each frame that is held back, which wait until it is decided.
    held: Vec<Vec<Received>>,
    held_bytes: usize,
    outcome: TrackOutcome,
    why: Option<String>,
    notes: Notes,
    /// Width and height that all images have: the camera's matrix holds for no other.
    size: Option<[usize; 2]>,
    /// What the log says of the camera.
    info: Option<CameraMessage>,
    view: Option<View<'a>>,
}

impl Tracking<'_, '_, '_> {
    fn take(&mut self, message: &RawMessage<'_>) -> Result<(), TrackError> {
        let channel = message.channel;
        let is_made = channel.topic == self.centroid || self.pose == Some(channel.topic.as_str());
        if is_made || channel.topic == QUALITY_TOPIC {
            return Ok(());
        }
        if self.info.is_none() {
            self.info = CameraMessage::beside(message, &self.topic.name);
        }
        let is_wanted = channel.topic == self.topic.name;
        if is_wanted && !is_image(&channel.schema) {
            return Err(TrackError::NoImages {
                topic: channel.topic.clone(),
                schema: channel.schema.clone(),
            });
        }
        if is_wanted {
            self.queue.add_image(message);
        } else if !is_image(&channel.schema) {
            // Another camera's images are not needed, and would fill the disk again.
            if message.data.len() > LARGE_MESSAGE {
                self.writer.copy(message)?;
            } else {
                self.queue.add_message(Received {
                    channel: Arc::clone(channel),
                    log_time: message.log_time,
                    data: message.data.to_vec(),
                });
            }
        }
        while let Some(processed) = self.queue.next_if_full() {
            self.write_processed(processed)?;
        }
        Ok(())
    }

    fn write_processed(&mut self, processed: Processed) -> Result<(), TrackError> {
        match processed {
            Processed::Frame(log_time, tracked) => self.frame(log_time, *tracked),
            // Behind a frame that waits, all wait.
            Processed::Message(message) => match self.held.last_mut() {
                Some(after) => {
                    self.held_bytes += message.data.len();
                    after.push(message);
                    if self.held_bytes < MOST_HELD_BYTES {
                        return Ok(());
                    }
                    let mut decided = Vec::new();
                    self.sequence.give_up(&mut |frame| decided.push(frame));
                    self.write(decided)
                }
                None => self.copy(&message),
            },
        }
    }

    fn frame(&mut self, log_time: u64, tracked: TrackedFrame) -> Result<(), TrackError> {
        self.outcome.frames += 1;
        let tracked = self.of_size(tracked);
        if let Some(view) = &mut self.view {
            view.add(log_time, &tracked)?;
        }
        if let (None, Some(why)) = (&self.why, tracked.why) {
            let seconds = 1e-9 * tracked.stamp as f64;
            let number = self.outcome.frames;
            self.why = Some(format!("image {number}, of {seconds:.3} s: {why}"));
        }
        let Observation {
            quality,
            deviation,
            shift,
            yaw,
            marker,
            ..
        } = tracked.observation;
        let seen = Seen {
            quality,
            deviation,
            shift,
            turned: marker.map(|marker| (yaw, marker)),
        };
        self.held.push(Vec::new());
        let frame = SequenceFrame {
            stamp: tracked.stamp,
            hash: tracked.hash,
            centre: tracked.observation.centre,
            with: (log_time, seen),
        };
        let mut decided = Vec::new();
        self.sequence.push(frame, &mut |frame| decided.push(frame));
        self.write(decided)
    }

    /// The frame as tracked, unless its size is another than that of the images before.
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
    fn write(&mut self, decided: Vec<SequenceFrame<(u64, Seen)>>) -> Result<(), TrackError> {
        let waiting: Vec<_> = self.held.drain(..decided.len()).collect();
        for (frame, after) in decided.into_iter().zip(waiting) {
            let point = frame.centre.ok();
            let (log_time, seen) = frame.with;
            self.notes.add(frame.stamp, point, seen.shift);
            let unsure = self.notes.late().hypot(self.notes.started(seen.deviation));
            let reason = frame.centre.err();
            let turned = seen.turned.filter(|_| point.is_some());
            let report = FrameReport {
                stamp: frame.stamp,
                x: point.map(|point| point.x),
                y: point.map(|point| point.y),
                deviation: point.map(|_| seen.deviation.hypot(unsure)),
                yaw: turned.map(|(yaw, _)| yaw),
                yaw_deviation: turned.map(|(_, marker)| marker.yaw_deviation),
                shift: seen.shift,
                quality: seen.quality,
                reason,
            };
            if let (Some(point), Ok(stamp)) = (point, u64::try_from(frame.stamp)) {
                self.outcome.centroids += 1;
                let (x, y) = (point.x, point.y);
                let at = Stamped { stamp, x, y };
                self.writer.point(self.centroid, log_time, &at)?;
                if let (Some(pose), Some((yaw, marker))) = (self.pose, turned) {
                    self.outcome.poses += 1;
                    self.notes.add_marker(marker.scale);
                    self.writer.pose(pose, log_time, &at, yaw)?;
                }
            }
            if let Some(reason) = reason {
                *self.outcome.reasons.entry(reason).or_insert(0) += 1;
            }
            let data = serde_json::to_vec(&report).unwrap_or_default();
            let schema = ("carom.FrameReport", "jsonschema", QUALITY_SCHEMA.as_bytes());
            self.writer
                .add(QUALITY_TOPIC, schema, "json", log_time, &data)?;
            for message in after {
                self.held_bytes -= message.data.len();
                self.copy(&message)?;
            }
        }
        Ok(())
    }

    fn copy(&mut self, message: &Received) -> Result<(), TrackError> {
        Ok(self.writer.copy(&RawMessage {
            channel: &message.channel,
            log_time: message.log_time,
            data: &message.data,
        })?)
    }

    fn finish(mut self) -> Result<TrackOutcome, TrackError> {
        while let Some(processed) = self.queue.next() {
            self.write_processed(processed)?;
        }
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
        outcome.notes.extend(self.notes.said(self.tracker.camera()));
        let height = self.learned.height.as_ref().zip(self.notes.outermost());
        outcome.notes.extend(height.and_then(|(height, place)| {
            let off = self.tracker.put_off_by(height, place);
            let seen = height.seen(self.tracker.height()?);
            Some(said_of_height(seen, &self.rig.object, (place, off)))
        }));
        let marker = self.notes.marker().and_then(|scale| {
            let height = 2.0 * self.rig.object.solid.half_height();
            said_of_marker(scale, height, self.tracker.camera())
        });
        outcome.notes.extend(marker);
        outcome.notes.extend(self.why);
        Ok(outcome)
    }
}
