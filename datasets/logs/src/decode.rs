//! One decoder for every encoding: a channel's schema and a topic's field paths, compiled once to a plan.

mod json;
mod protobuf;
mod ros;
mod ros_schema;

use values::FieldTopic;

use crate::LogError;
use crate::path::{Leaf, Want};

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

/// Most numbers that can be asked for beside x and y: a quaternion's.
pub const MOST_MORE: usize = 4;
/// Further numbers of a message, in the order asked for; NaN where it has none.
pub type More = [f64; MOST_MORE];

/// Why a message could not be decoded; each text says what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// It ends before all that its schema, or its own lengths, say is there.
    #[error("it ends at byte {0}, before what its schema and lengths say is there")]
    Short(usize),
    /// Its encapsulation header names a representation that is not read.
    #[error("its CDR header is {0:#06x}; plain CDR (0x0000, 0x0001, 0x0006, 0x0007) is read")]
    Representation(u16),
    /// A wstring lies before a wanted field, and its length on the wire cannot be told.
    #[error(
        "a wstring lies before the fields that are read, and ROS 2's middlewares do not write those alike"
    )]
    WideText,
    /// A field is not there.
    #[error("it has no value for `{0}`")]
    Absent(&'static str),
    /// A stamp does not fit 64 bits of nanoseconds.
    #[error("its stamp is out of range")]
    Stamp,
    /// It is not what its encoding allows.
    #[error("{0}")]
    Malformed(String),
}

/// Decodes the messages of one channel.
#[derive(Debug)]
pub struct Decoder {
    plan: Plan,
    stamped: bool,
}

#[derive(Debug)]
enum Plan {
    Ros(ros::Plan),
    Json(Want),
    Protobuf(protobuf::Plan),
}

impl Decoder {
    /// Compiles the plan for a channel with this message encoding and schema.
    ///
    /// A schema without even the first name of the stamp's path has messages without stamp; x and y must be there.
    pub fn compile(
        message_encoding: &str,
        schema: Option<SchemaText<'_>>,
        topic: &FieldTopic,
    ) -> Result<Self, LogError> {
        Self::compile_exactly(message_encoding, schema, topic, &[])
    }

    /// The same with the paths of further numbers (at most [`MOST_MORE`] are read). They may be absent: a schema that lacks one of
    /// them gives none.
    pub fn compile_with(
        message_encoding: &str,
        schema: Option<SchemaText<'_>>,
        topic: &FieldTopic,
        more: &[String],
    ) -> Result<Self, LogError> {
        let more = &more[..more.len().min(MOST_MORE)];
        Self::compile_exactly(message_encoding, schema, topic, more)
            .or_else(|_| Self::compile(message_encoding, schema, topic))
    }

    fn compile_exactly(
        message_encoding: &str,
        schema: Option<SchemaText<'_>>,
        topic: &FieldTopic,
        more: &[String],
    ) -> Result<Self, LogError> {
        let schema_encoding = schema.map_or("", |schema| schema.encoding);
        let (plan, stamped) = match (message_encoding, schema_encoding, schema) {
            ("cdr", "ros2msg", Some(schema)) => ros(ros::Wire::Cdr, schema, topic, more)?,
            ("ros1", "ros1msg", Some(schema)) => ros(ros::Wire::Ros1, schema, topic, more)?,
            ("json", _, _) => (Plan::Json(Want::of(topic, more, true)?), true),
            ("protobuf", "protobuf", Some(schema)) => {
                let (plan, stamped) = protobuf::Plan::compile(schema, topic, more)?;
                (Plan::Protobuf(plan), stamped)
            }
            _ => {
                return Err(LogError::Encoding {
                    topic: topic.name.clone(),
                    message: message_encoding.into(),
                    schema: schema_encoding.into(),
                });
            }
        };
        Ok(Self { plan, stamped })
    }

    /// Whether the schema has the stamp that the topic's path names; JSON, which has no schema, may have it.
    pub fn stamped(&self) -> bool {
        self.stamped
    }

    /// Reads the fields of one message; never more memory than the message itself takes.
    pub fn decode(&self, data: &[u8]) -> Result<Fields, DecodeError> {
        self.decode_with(data).map(|(fields, _)| fields)
    }

    /// The same with the further numbers that were asked for.
    pub fn decode_with(&self, data: &[u8]) -> Result<(Fields, More), DecodeError> {
        let mut raw = Raw::default();
        match &self.plan {
            Plan::Ros(plan) => plan.decode(data, &mut raw)?,
            Plan::Json(want) => json::decode(want, data, &mut raw)?,
            Plan::Protobuf(plan) => plan.decode(data, &mut raw)?,
        }
        let more = raw.more.map(|number| number.unwrap_or(f64::NAN));
        let fields = raw.fields()?;
        if fields.stamp.is_none() && self.stamped && !matches!(self.plan, Plan::Json(_)) {
            // The schema has a stamp that this message leaves unset: that is the zero stamp.
            let zero = Fields {
                stamp: Some(0),
                ..fields
            };
            return Ok((zero, more));
        }
        Ok((fields, more))
    }
}

fn ros(
    wire: ros::Wire,
    schema: SchemaText<'_>,
    topic: &FieldTopic,
    more: &[String],
) -> Result<(Plan, bool), LogError> {
    let (plan, stamped) = ros::Plan::compile(wire, schema, topic, more)?;
    Ok((Plan::Ros(plan), stamped))
}

/// A number as a message holds it.
#[derive(Clone, Copy, Debug)]
enum Number {
    Integer(i128),
    Float(f64),
}

/// What has been read of a message so far.
#[derive(Debug, Default)]
struct Raw {
    seconds: Option<Number>,
    nanoseconds: Option<Number>,
    stamp: Option<Number>,
    x: Option<f64>,
    y: Option<f64>,
    more: [Option<f64>; MOST_MORE],
}

impl Raw {
    fn set(&mut self, leaf: Leaf, number: Number) {
        match leaf {
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
        }
    }

    fn fields(self) -> Result<Fields, DecodeError> {
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
    #[expect(
        clippy::cast_precision_loss,
        reason = "coordinates that are whole numbers are small"
    )]
    fn float(self) -> f64 {
        match self {
            Self::Integer(integer) => integer as f64,
            Self::Float(float) => float,
        }
    }

    /// This many units of `scale` nanoseconds, which is 1 or 1e9.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "checked to be finite and within the range of i64 before"
    )]
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
