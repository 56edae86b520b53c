//! A channel's schema, and what is read of one message, whatever it is encoded in.

use crate::path::Leaf;

/// What is read of one message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fields {
    /// Nanoseconds on the log's clock; `None` where the message has no stamp.
    pub stamp: Option<i64>,
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
}

/// Most numbers that can be asked for beside x and y: a quaternion's, and a height.
pub const MOST_MORE: usize = 5;
/// Further numbers of a message, in the order asked for; NaN where it has none.
pub type More = [f64; MOST_MORE];

/// Why a message could not be decoded; each text says what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum DecodeError {
    #[error("it ends at byte {0}, before what its schema and lengths say is there")]
    Short(usize),
    #[error("its CDR header is {0:#06x}; plain CDR (0x0000, 0x0001, 0x0006, 0x0007) is read")]
    Representation(u16),
    #[error(
        "a wstring lies before the fields that are read, and ROS 2's middlewares do not write those alike"
    )]
    WideText,
    #[error("it has no value for `{0}`")]
    Absent(&'static str),
    #[error("its stamp is out of range")]
    Stamp,
    #[error("{0}")]
    Malformed(String),
}

/// A number as a message holds it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Number {
    Integer(i128),
    Float(f64),
}

/// What has been read of a message so far.
#[derive(Debug, Default)]
pub(super) struct Raw {
    pub(super) seconds: Option<Number>,
    pub(super) nanoseconds: Option<Number>,
    pub(super) stamp: Option<Number>,
    pub(super) x: Option<f64>,
    pub(super) y: Option<f64>,
    pub(super) more: [Option<f64>; MOST_MORE],
    pub(super) text: Option<String>,
}

impl Raw {
    pub(super) fn set(&mut self, leaves: &[Leaf], number: Number) {
        for leaf in leaves {
            match *leaf {
                Leaf::Stamp => self.stamp = Some(number),
                Leaf::Seconds => self.seconds = Some(number),
                Leaf::Nanoseconds => self.nanoseconds = Some(number),
                Leaf::X => self.x = Some(number.float()),
                Leaf::Y => self.y = Some(number.float()),
                Leaf::More(place) => {
                    if let Some(kept) = self.more.get_mut(place) {
                        *kept = Some(number.float());
                    }
                }
                // A number is no text.
                Leaf::Text => {}
            }
        }
    }

    pub(super) fn fields(self) -> Result<Fields, DecodeError> {
        let stamp = match (self.stamp, self.seconds, self.nanoseconds) {
            // A stamp that is one number: whole numbers are nanoseconds, others seconds.
            (Some(Number::Integer(nanoseconds)), _, _) => Some(nanoseconds),
            (Some(seconds @ Number::Float(_)), _, _) => Some(seconds.to_nanoseconds(1e9)?),
            (None, None, None) => None,
            (None, seconds, nanoseconds) => {
                let part = |part: Option<Number>, scale| {
                    part.map_or(Ok(0), |number| number.to_nanoseconds(scale))
                };
                Some(part(seconds, 1e9)? + part(nanoseconds, 1.0)?)
            }
        };
        Ok(Fields {
            stamp: stamp
                .map(i64::try_from)
                .transpose()
                .map_err(|_| DecodeError::Stamp)?,
            x: self.x.ok_or(DecodeError::Absent("x"))?,
            y: self.y.ok_or(DecodeError::Absent("y"))?,
        })
    }
}

impl Number {
    fn float(self) -> f64 {
        match self {
            Self::Integer(integer) => integer as f64,
            Self::Float(float) => float,
        }
    }

    /// This many units of `scale` nanoseconds, which is 1 or 1e9.
    fn to_nanoseconds(self, scale: f64) -> Result<i128, DecodeError> {
        match self {
            Self::Integer(integer) => integer.checked_mul(scale as i128).ok_or(DecodeError::Stamp),
            Self::Float(float) => {
                // Whole and fractional parts apart: a product would lose the nanoseconds of a large stamp.
                let whole = float.trunc();
                let nanoseconds = whole * scale;
                if nanoseconds.is_finite() && nanoseconds.abs() < i64::MAX as f64 {
                    Ok(whole as i128 * scale as i128 + ((float - whole) * scale).round() as i128)
                } else {
                    Err(DecodeError::Stamp)
                }
            }
        }
    }
}

/// A channel's schema as the file holds it.
#[derive(Clone, Copy, Debug)]
pub struct SchemaText<'a> {
    /// Message type, such as `geometry_msgs/msg/PointStamped`.
    pub name: &'a str,
    /// `ros2msg`, `ros1msg`, `protobuf`, `jsonschema` …
    pub encoding: &'a str,
    /// Its text, or a serialized `FileDescriptorSet`.
    pub data: &'a [u8],
}
