//! One decoder for every encoding: a channel's schema and a topic's field paths, compiled once to a plan.

mod json;
mod message;
mod protobuf;
mod ros;
mod ros_schema;

use values::FieldTopic;

use self::message::Raw;
use crate::LogError;
use crate::path::{FieldTree, Leaf};

pub use self::message::{DecodeError, Fields, MOST_MORE, More, SchemaText};

/// Decodes the messages of one channel.
#[derive(Debug)]
pub struct Decoder {
    plan: Plan,
    stamped: bool,
}

#[derive(Debug)]
enum Plan {
    Ros(ros::Plan),
    Json(FieldTree),
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

    /// Compiles the plan with the paths of further numbers (at most [`MOST_MORE`] are read) and of a text. They may be absent: what a schema lacks
    /// is left out.
    pub fn compile_with(
        message_encoding: &str,
        schema: Option<SchemaText<'_>>,
        topic: &FieldTopic,
        more: &[String],
        text: Option<&str>,
    ) -> Result<Self, LogError> {
        let numbers = more.iter().take(MOST_MORE).enumerate();
        let numbers = numbers.map(|(place, path)| (Leaf::More(place), path.as_str()));
        let further: Vec<_> = numbers.chain(text.map(|path| (Leaf::Text, path))).collect();
        let compile = |further: &[(Leaf, &str)]| {
            Self::compile_exactly(message_encoding, schema, topic, further)
        };
        compile(&further).or_else(|_| {
            let mut there = Vec::new();
            for path in further {
                there.push(path);
                if compile(&there).is_err() {
                    there.pop();
                }
            }
            compile(&there)
        })
    }

    fn compile_exactly(
        message_encoding: &str,
        schema: Option<SchemaText<'_>>,
        topic: &FieldTopic,
        further: &[(Leaf, &str)],
    ) -> Result<Self, LogError> {
        let schema_encoding = schema.map_or("", |schema| schema.encoding);
        let (plan, stamped) = match (message_encoding, schema_encoding, schema) {
            ("cdr", "ros2msg", Some(schema)) => ros(ros::Wire::Cdr, schema, topic, further)?,
            ("ros1", "ros1msg", Some(schema)) => ros(ros::Wire::Ros1, schema, topic, further)?,
            ("json", _, _) => (Plan::Json(FieldTree::of(topic, further, true)?), true),
            ("protobuf", "protobuf", Some(schema)) => {
                let (plan, stamped) = protobuf::Plan::compile(schema, topic, further)?;
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
        self.decode_with(data).map(|(fields, ..)| fields)
    }

    /// Reads the fields of one message, the further numbers that were asked for, and the text.
    pub fn decode_with(&self, data: &[u8]) -> Result<(Fields, More, Option<String>), DecodeError> {
        let mut raw = Raw::default();
        match &self.plan {
            Plan::Ros(plan) => plan.decode(data, &mut raw)?,
            Plan::Json(want) => json::decode(want, data, &mut raw)?,
            Plan::Protobuf(plan) => plan.decode(data, &mut raw)?,
        }
        let more = raw.more.map(|number| number.unwrap_or(f64::NAN));
        let text = raw.text.take();
        let fields = raw.fields()?;
        if fields.stamp.is_none() && self.stamped && !matches!(self.plan, Plan::Json(_)) {
            // The schema has a stamp that this message leaves unset: that is the zero stamp.
            let zero = Fields {
                stamp: Some(0),
                ..fields
            };
            return Ok((zero, more, text));
        }
        Ok((fields, more, text))
    }
}

fn ros(
    wire: ros::Wire,
    schema: SchemaText<'_>,
    topic: &FieldTopic,
    further: &[(Leaf, &str)],
) -> Result<(Plan, bool), LogError> {
    let (plan, stamped) = ros::Plan::compile(wire, schema, topic, further)?;
    Ok((Plan::Ros(plan), stamped))
}
