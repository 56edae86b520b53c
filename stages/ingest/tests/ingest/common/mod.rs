//! A made-up session: an arm that strikes, an object that slides to rest, a camera that watches.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use ingest::{Ingest, LogOutcome, ingest_log};
use logs::write::{RecordingWriter, Samples, Stamped};
use values::{Point, Reject, Rig, Shape};

/// When the session begins on the log's clock, in ns.
pub const EPOCH: u64 = 1_700_000_000_000_000_000;
/// Seconds from the rise of a command to the impact.
pub const IMPACT: f64 = 0.2;

pub fn rig() -> Rig {
    Rig::demo(Shape::Cylinder)
}

/// One strike as it really was.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// Seconds of the session at which the command rises.
    pub start: f64,
    pub initial: Point,
    pub speed: f64,
    pub angle: f64,
    /// Speed after the impact, in m/s.
    pub release: f64,
    /// Deceleration of the slide, in m/s².
    pub deceleration: f64,
}

impl Truth {
    pub fn stop(&self) -> Point {
        self.initial
            + Point::polar(
                self.release * self.release / (2.0 * self.deceleration),
                self.angle,
            )
    }

    fn place(&self, t: f64) -> Point {
        let t = (t - self.start - IMPACT).clamp(0.0, self.release / self.deceleration);
        self.initial
            + Point::polar(
                self.release * t - 0.5 * self.deceleration * t * t,
                self.angle,
            )
    }
}

/// A few strikes, the object carried back in the middle of each pause.
pub fn truths(count: usize) -> Vec<Truth> {
    (0..count)
        .map(|i| {
            let i = i as f64;
            Truth {
                start: 2.0 + 6.0 * i,
                initial: Point::new(0.3 + 0.01 * i, -0.1 + 0.03 * i),
                speed: 0.5 + 0.1 * (i % 4.0),
                angle: -0.3 + 0.15 * (i % 5.0),
                release: 0.6 + 0.12 * (i % 4.0),
                deceleration: 2.5,
            }
        })
        .collect()
}

fn stamp(t: f64) -> u64 {
    EPOCH + (t * 1e9).round() as u64
}

/// Numbers that look random and are always the same: normal, deviation 1.
pub fn noise(seed: u64) -> f64 {
    let uniform = |n: u64| {
        let mut x = n.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (-2.0 * uniform(2 * seed).max(1e-300).ln()).sqrt() * (TAU * uniform(2 * seed + 1)).cos()
}

/// What the arm is commanded at a time of the session: rise in 0.15 s, plateau until 0.25 s, fall in 0.15 s.
pub fn velocity(truths: &[Truth], t: f64) -> Point {
    truths.iter().fold(Point::default(), |velocity, truth| {
        let s = t - truth.start;
        let part = (s / 0.15).min((0.4 - s) / 0.15).clamp(0.0, 1.0);
        velocity + Point::polar(part * truth.speed, truth.angle)
    })
}

/// Where the object is at a time of the session: it stands for a strike from 1.5 s before its command.
pub fn place(truths: &[Truth], t: f64) -> Point {
    truths
        .iter()
        .rev()
        .find(|truth| truth.start - 1.5 <= t)
        .or(truths.first())
        .map_or(Point::default(), |truth| truth.place(t))
}

/// What is logged of these strikes: commands at 200 Hz, centroids at the camera's rate with its noise, frames that come up to
/// 2 ms late, and 3 % of them dropped.
pub fn session(truths: &[Truth]) -> Samples {
    let rig = rig();
    let end = truths.last().map_or(3.0, |truth| truth.start + 4.0);
    let mut samples = Samples::default();
    for i in 0..(end * 200.0) as u64 {
        let t = i as f64 / 200.0;
        let velocity = velocity(truths, t);
        samples.commands.push(Stamped::at(stamp(t), velocity));
    }
    for i in 0..(end * rig.camera.rate) as u64 {
        if noise(7_000_000 + i).abs() > 2.17 {
            continue;
        }
        let t = i as f64 / rig.camera.rate + 0.001 * noise(9_000_000 + i).clamp(-2.0, 2.0).abs();
        let place =
            place(truths, t) + Point::new(noise(2 * i), noise(2 * i + 1)) * rig.camera.noise;
        samples.centroids.push(Stamped::at(stamp(t), place));
    }
    samples
}

/// A folder for logs that goes when it is dropped.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a session's log.
    pub fn write(&self, name: &str, samples: &Samples) -> PathBuf {
        self.write_parts(name, &[samples])
    }

    /// Writes a log of parts that were received one after another, whatever their stamps.
    pub fn write_parts(&self, name: &str, parts: &[&Samples]) -> PathBuf {
        let path = self.path(name);
        let mut writer = RecordingWriter::create(&path, &rig().topics).expect("creates");
        for samples in parts {
            writer.write(samples).expect("writes");
        }
        writer.finish().expect("finishes");
        path
    }
}

/// A message in JSON: topic, stamp and body.
pub type JsonMessage = (&'static str, u64, String);

pub fn point(sample: &Stamped) -> JsonMessage {
    let body = format!(r#""point":{{"x":{:?},"y":{:?}}}"#, sample.x, sample.y);
    ("/object/centroid", sample.stamp, body)
}

pub fn twist(sample: &Stamped) -> JsonMessage {
    let body = format!(
        r#""twist":{{"linear":{{"x":{:?},"y":{:?}}}}}"#,
        sample.x, sample.y
    );
    ("/striker/command", sample.stamp, body)
}

/// A log of messages in JSON, in this order, received `late` ns after their stamps: uncompressed, in small chunks.
pub fn json_log(messages: &[JsonMessage], late: u64) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(5_000))
        .create(&mut file)
        .expect("writes");
    for (sequence, (topic, stamp, body)) in (0..).zip(messages) {
        let channel_id = writer
            .add_channel(0, topic, "json", &Default::default())
            .expect("writes");
        let (sec, nanosec) = (stamp / 1_000_000_000, stamp % 1_000_000_000);
        let text =
            format!(r#"{{"header":{{"stamp":{{"sec":{sec},"nanosec":{nanosec}}}}},{body}}}"#);
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence,
            log_time: stamp + late,
            publish_time: stamp + late,
        };
        writer
            .write_to_known_channel(&header, text.as_bytes())
            .expect("writes");
    }
    writer.finish().expect("writes");
    drop(writer);
    file.into_inner()
}

pub fn ingest(path: &Path) -> LogOutcome {
    ingest_log(path, &rig(), &Ingest { seed: 1 }).expect("the log is read")
}

/// Ingests a session that one of the faults was put into.
pub fn ingest_samples(samples: &Samples) -> LogOutcome {
    let folder = Folder::new();
    ingest(&folder.write("session.mcap", samples))
}

/// Seconds of the session at which a sample was taken.
pub fn time(sample: &Stamped) -> f64 {
    (sample.stamp - EPOCH) as f64 * 1e-9
}

/// Checks that a note holds these words.
#[track_caller]
pub fn noted(outcome: &LogOutcome, words: &str) {
    let mut notes = outcome.notes.iter();
    assert!(
        notes.any(|note| note.contains(words)),
        "{:?}",
        outcome.notes
    );
}

/// Reasons by index.
pub fn reasons<D>(rejects: &[Reject<D>]) -> Vec<(u32, &'static str)> {
    rejects
        .iter()
        .map(|reject| (reject.index, reject.reason.name()))
        .collect()
}
