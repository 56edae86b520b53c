//! Messages as they are written, and the numbers that viewers plot.

use std::fmt::Display;
use std::io::{Seek, Write};

use foxglove::messages::Timestamp;
use foxglove::{Encode, Schema};
use logs::write::CopyWriter;

use crate::Error;

/// The frame in which everything lies.
pub const TABLE: &str = "table";
/// Seconds shown before a strike's first motion, and after the last object rests.
pub const BEFORE: f64 = 0.5;
pub const AFTER: f64 = 1.0;
/// Nanoseconds of a second.
const NANOSECONDS: u64 = 1_000_000_000;

/// What is known of a strike; protobuf, in SI units. Its schema follows from the fields: new ones come last.
#[derive(Encode)]
pub struct Strike {
    pub strike_id: String,
    pub log: String,
    pub index: u32,
    pub session: String,
    pub split: String,
    /// Stamp of first motion in the log, in s.
    pub t_start: f64,
    pub speed: f64,
    pub angle: f64,
    pub x0: f64,
    pub y0: f64,
    /// Where it stopped; where its track ends otherwise, that end.
    pub xf: f64,
    pub yf: f64,
    pub end: String,
    /// How far from there each world ends, in m.
    pub sysid_error: Option<f64>,
    pub effect_error: Option<f64>,
}

/// One frame of a strike; protobuf, in SI units.
#[derive(Encode)]
pub struct Motion {
    /// Seconds since first motion.
    pub t: f64,
    /// Speeds, by the places one frame before and after.
    pub measured_speed: Option<f64>,
    pub sysid_speed: Option<f64>,
    pub effect_speed: Option<f64>,
    /// Distances from the measured place, in m.
    pub sysid_residual: Option<f64>,
    pub effect_residual: Option<f64>,
}

/// A message on its topic.
pub struct Message {
    topic: String,
    schema: fn() -> Option<Schema>,
    stamp: u64,
    data: Vec<u8>,
}

impl Message {
    /// A message of `stamp` (ns).
    pub fn new<M: Encode>(
        topic: impl Into<String>,
        stamp: u64,
        message: &M,
    ) -> Result<Self, Error> {
        let mut data = Vec::with_capacity(message.encoded_len().unwrap_or_default());
        message.encode(&mut data).map_err(failed)?;
        Ok(Self {
            topic: topic.into(),
            schema: M::get_schema,
            stamp,
            data,
        })
    }

    /// Its stamp in ns.
    pub fn stamp(&self) -> u64 {
        self.stamp
    }

    /// Writes it.
    pub fn write<W: Write + Seek>(&self, file: &mut CopyWriter<W>) -> Result<(), Error> {
        let Some(schema) = (self.schema)() else {
            return Err(failed("a message without a schema"));
        };
        let text = (&*schema.name, &*schema.encoding, &*schema.data);
        let written = file.add(&self.topic, text, "protobuf", self.stamp, &self.data);
        written.map_err(Error::failed)
    }
}

fn failed(error: impl Display) -> Error {
    Error::failed(format!("write the view: {error}"))
}

/// A stamp in ns, as the schemas have it.
pub fn timestamp(stamp: u64) -> Option<Timestamp> {
    let second = u32::try_from(stamp / NANOSECONDS).unwrap_or(u32::MAX);
    Some(Timestamp::new(second, (stamp % NANOSECONDS) as u32))
}

/// Seconds in ns.
pub fn nanoseconds(seconds: f64) -> u64 {
    (seconds * NANOSECONDS as f64).round() as u64
}
