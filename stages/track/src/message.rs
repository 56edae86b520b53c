//! Image messages on the wire: ROS 2's and ROS 1's `sensor_msgs`, Foxglove's protobuf.
//!
//! Sources: `sensor_msgs/msg/Image.msg`, `CompressedImage.msg`; `foxglove/CompressedImage.proto`, `CompressedVideo.proto`,
//! `RawImage.proto`. Their fields are fixed by these definitions, so that no schema is read.

use crate::ImageError;

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
        /// The bytes.
        data: &'a [u8],
    },
    /// A whole JPEG or PNG file; its first bytes tell which.
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
}

fn kind(schema: &str) -> Option<Kind> {
    Some(match schema {
        "sensor_msgs/msg/Image" | "sensor_msgs/Image" => Kind::RosRaw,
        "sensor_msgs/msg/CompressedImage" | "sensor_msgs/CompressedImage" => Kind::RosCompressed,
        "foxglove.RawImage" => Kind::FoxgloveRaw,
        "foxglove.CompressedImage" => Kind::FoxgloveCompressed,
        "foxglove.CompressedVideo" => Kind::FoxgloveVideo,
        _ => return None,
    })
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
            (Kind::RosRaw | Kind::RosCompressed, "cdr") => ros(kind, Wire::cdr(data)?),
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
    let payload = if kind == Kind::RosRaw {
        let (height, width) = (wire.u32()?, wire.u32()?);
        let encoding = wire.text()?;
        wire.take(1)?; // is_bigendian
        Payload::Raw {
            width,
            height,
            encoding,
            step: wire.u32()?,
            data: wire.bytes()?,
        }
    } else {
        wire.text()?; // format
        Payload::Compressed(wire.bytes()?)
    };
    Ok(ImageMessage { stamp, payload })
}

/// Little- or big-endian fields one after another; CDR aligns numbers to their size, ROS 1 does not.
struct Wire<'a> {
    data: &'a [u8],
    at: usize,
    aligned: bool,
    big: bool,
}

impl<'a> Wire<'a> {
    fn cdr(data: &'a [u8]) -> Result<Self, ImageError> {
        let (header, data) = data
            .split_first_chunk::<4>()
            .ok_or(ImageError::Short(data.len()))?;
        let big = match header[..2] {
            [0, 1 | 7] => false,
            [0, 0 | 6] => true,
            _ => {
                return Err(ImageError::Message(
                    "its CDR header is not that of plain CDR",
                ));
            }
        };
        Ok(Self {
            data,
            at: 0,
            aligned: true,
            big,
        })
    }

    fn ros1(data: &'a [u8]) -> Result<Self, ImageError> {
        let mut wire = Self {
            data,
            at: 0,
            aligned: false,
            big: false,
        };
        wire.u32()?; // seq
        Ok(wire)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], ImageError> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.data.get(self.at..end));
        let taken = taken.ok_or(ImageError::Short(self.data.len()))?;
        self.at += count;
        Ok(taken)
    }

    fn u32(&mut self) -> Result<u32, ImageError> {
        if self.aligned {
            self.at = self.at.next_multiple_of(4);
        }
        let bytes = self.take(4)?;
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        Ok(if self.big {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        })
    }

    fn bytes(&mut self) -> Result<&'a [u8], ImageError> {
        let count = self.u32()? as usize;
        self.take(count)
    }

    fn text(&mut self) -> Result<&'a str, ImageError> {
        let bytes = self.bytes()?;
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        std::str::from_utf8(bytes).map_err(|_| ImageError::Message("a text is not UTF-8"))
    }
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
            data: bytes,
        },
        Kind::FoxgloveVideo => Payload::Video(text, bytes),
        _ => Payload::Compressed(bytes),
    };
    Ok(ImageMessage { stamp, payload })
}

/// `google.protobuf.Timestamp`: seconds 1, nanos 2.
fn timestamp(data: &[u8]) -> Result<i64, ImageError> {
    let (mut seconds, mut nanoseconds) = (0, 0);
    each_field(data, &mut |number, value| {
        match (number, value) {
            (1, Value::Number(number)) => seconds = number.cast_signed(),
            (2, Value::Number(number)) => nanoseconds = number.cast_signed(),
            _ => {}
        }
        Ok(())
    })?;
    seconds
        .checked_mul(1_000_000_000)
        .and_then(|whole| whole.checked_add(nanoseconds))
        .ok_or(ImageError::Message("its stamp is out of range"))
}

enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

type EachField<'f, 'a> = &'f mut dyn FnMut(u64, Value<'a>) -> Result<(), ImageError>;

/// Calls `each` with the fields of a protobuf message.
fn each_field<'a>(data: &'a [u8], each: EachField<'_, 'a>) -> Result<(), ImageError> {
    let short = || ImageError::Short(data.len());
    let mut rest = data;
    while !rest.is_empty() {
        let key = varint(&mut rest).ok_or_else(short)?;
        let value = match key & 7 {
            0 => Value::Number(varint(&mut rest).ok_or_else(short)?),
            2 => {
                let count = varint(&mut rest).ok_or_else(short)?;
                let count = usize::try_from(count).map_err(|_| short())?;
                Value::Bytes(split(&mut rest, count).ok_or_else(short)?)
            }
            // Fixed numbers: a little-endian stamp may be one, nothing else that is read.
            1 => Value::Bytes(split(&mut rest, 8).ok_or_else(short)?),
            5 => {
                let bytes = split(&mut rest, 4).ok_or_else(short)?;
                let bytes = bytes.try_into().map_err(|_| short())?;
                Value::Number(u64::from(u32::from_le_bytes(bytes)))
            }
            _ => return Err(ImageError::Message("it holds a protobuf group")),
        };
        each(key >> 3, value)?;
    }
    Ok(())
}

fn split<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(taken)
}

fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let (byte, after) = rest.split_first()?;
        *rest = after;
        number |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}
