//! Image messages on the wire: ROS 2's and ROS 1's `sensor_msgs`, Foxglove's protobuf.
//!
//! Sources: `sensor_msgs/msg/Image.msg`, `CompressedImage.msg`; `foxglove/CompressedImage.proto`, `CompressedVideo.proto`,
//! `RawImage.proto`. Their fields are fixed by these definitions, so that no schema is read.

use crate::ImageError;
use crate::wire::{Value, Wire, each_field, timestamp};

/// The pixels of a message, not yet decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Payload<'a> {
    /// Rows of pixels.
    Raw {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Bytes from one row to the next.
        step: u32,
        /// ROS's name of the pixel format.
        encoding: &'a str,
        /// Whether numbers of two bytes have the greater one first.
        is_big_endian: bool,
        /// The bytes.
        data: &'a [u8],
    },
    /// A whole JPEG or PNG file; its first bytes show which.
    Compressed(&'a [u8]),
    /// One access unit of a video, and the name of its format.
    Video(&'a str, &'a [u8]),
}

impl<'a> Payload<'a> {
    /// Its bytes, as they came.
    pub fn bytes(&self) -> &'a [u8] {
        match self {
            Self::Raw { data, .. } | Self::Compressed(data) | Self::Video(_, data) => data,
        }
    }
}

/// One image message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageMessage<'a> {
    /// Its stamp in ns.
    pub stamp: i64,
    /// Its pixels.
    pub payload: Payload<'a>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    RosRaw,
    RosCompressed,
    FoxgloveRaw,
    FoxgloveCompressed,
    FoxgloveVideo,
    RosVideo,
}

fn kind(schema: &str) -> Option<Kind> {
    Some(match schema {
        "sensor_msgs/msg/Image" | "sensor_msgs/Image" => Kind::RosRaw,
        "sensor_msgs/msg/CompressedImage" | "sensor_msgs/CompressedImage" => Kind::RosCompressed,
        "foxglove.RawImage" => Kind::FoxgloveRaw,
        "foxglove.CompressedImage" => Kind::FoxgloveCompressed,
        "foxglove.CompressedVideo" => Kind::FoxgloveVideo,
        "foxglove_msgs/msg/CompressedVideo" => Kind::RosVideo,
        _ => return None,
    })
}

/// Whether messages of this type are images of a video, each of which builds on those before it.
pub(crate) fn is_video(schema: &str) -> bool {
    matches!(kind(schema), Some(Kind::FoxgloveVideo | Kind::RosVideo))
}

/// Whether messages of this type hold images that are read.
pub fn is_image(schema: &str) -> bool {
    kind(schema).is_some()
}

impl<'a> ImageMessage<'a> {
    /// Reads a message by the name of its type and its encoding (`cdr`, `ros1` or `protobuf`). No pixel is copied.
    pub fn parse(schema: &str, encoding: &str, data: &'a [u8]) -> Result<Self, ImageError> {
        let kind = kind(schema).ok_or(ImageError::Message("its type is no image"))?;
        match (kind, encoding) {
            (Kind::RosRaw | Kind::RosCompressed | Kind::RosVideo, "cdr") => {
                ros(kind, Wire::cdr(data)?)
            }
            (Kind::RosRaw | Kind::RosCompressed, "ros1") => ros(kind, Wire::ros1(data)?),
            (Kind::FoxgloveRaw | Kind::FoxgloveCompressed | Kind::FoxgloveVideo, "protobuf") => {
                foxglove(kind, data)
            }
            _ => Err(ImageError::Message(
                "its encoding is neither cdr, ros1 nor protobuf",
            )),
        }
    }
}

fn ros<'a>(kind: Kind, mut wire: Wire<'a>) -> Result<ImageMessage<'a>, ImageError> {
    let seconds = i64::from(wire.u32()?.cast_signed());
    let stamp = seconds * 1_000_000_000 + i64::from(wire.u32()?);
    wire.text()?; // frame_id
    let payload = if kind == Kind::RosVideo {
        let data = wire.bytes()?;
        Payload::Video(wire.text()?, data)
    } else if kind == Kind::RosRaw {
        let (height, width) = (wire.u32()?, wire.u32()?);
        let encoding = wire.text()?;
        let is_big_endian = wire.take(1)? != [0];
        Payload::Raw {
            width,
            height,
            encoding,
            is_big_endian,
            step: wire.u32()?,
            data: wire.bytes()?,
        }
    } else {
        wire.text()?; // format
        Payload::Compressed(wire.bytes()?)
    };
    Ok(ImageMessage { stamp, payload })
}

/// Field numbers of Foxglove's definitions.
mod field {
    pub(super) const TIMESTAMP: u64 = 1;
    /// `CompressedImage`: data 2, format 3; `CompressedVideo`: data 3, format 4.
    pub(super) const IMAGE_DATA: u64 = 2;
    pub(super) const VIDEO_DATA: u64 = 3;
    pub(super) const VIDEO_FORMAT: u64 = 4;
    /// `RawImage`: width 2, height 3, encoding 4, step 5, data 6.
    pub(super) const WIDTH: u64 = 2;
    pub(super) const HEIGHT: u64 = 3;
    pub(super) const ENCODING: u64 = 4;
    pub(super) const STEP: u64 = 5;
    pub(super) const RAW_DATA: u64 = 6;
}

fn foxglove(kind: Kind, data: &[u8]) -> Result<ImageMessage<'_>, ImageError> {
    let (mut stamp, mut bytes, mut text) = (0, &data[..0], "");
    let (mut width, mut height, mut step) = (0, 0, 0);
    each_field(data, &mut |number, value| {
        match (kind, number, value) {
            (_, field::TIMESTAMP, Value::Bytes(inner)) => stamp = timestamp(inner)?,
            (Kind::FoxgloveCompressed, field::IMAGE_DATA, Value::Bytes(inner))
            | (Kind::FoxgloveVideo, field::VIDEO_DATA, Value::Bytes(inner))
            | (Kind::FoxgloveRaw, field::RAW_DATA, Value::Bytes(inner)) => bytes = inner,
            (Kind::FoxgloveVideo, field::VIDEO_FORMAT, Value::Bytes(inner))
            | (Kind::FoxgloveRaw, field::ENCODING, Value::Bytes(inner)) => {
                text = std::str::from_utf8(inner)
                    .map_err(|_| ImageError::Message("a text is not UTF-8"))?;
            }
            (Kind::FoxgloveRaw, field::WIDTH, Value::Number(number)) => width = number as u32,
            (Kind::FoxgloveRaw, field::HEIGHT, Value::Number(number)) => height = number as u32,
            (Kind::FoxgloveRaw, field::STEP, Value::Number(number)) => step = number as u32,
            _ => {}
        }
        Ok(())
    })?;
    let payload = match kind {
        Kind::FoxgloveRaw => Payload::Raw {
            width,
            height,
            step,
            encoding: text,
            is_big_endian: false,
            data: bytes,
        },
        Kind::FoxgloveVideo => Payload::Video(text, bytes),
        _ => Payload::Compressed(bytes),
    };
    Ok(ImageMessage { stamp, payload })
}
