//! Protobuf messages by the file's own descriptor set: the wire is walked once, unwanted fields are skipped.

use prost::bytes::Buf;
use prost::encoding::{DecodeContext, WireType, decode_key, decode_varint, skip_field};
use prost_reflect::{Cardinality, DescriptorPool, FieldDescriptor, Kind, MessageDescriptor, Value};
use values::FieldTopic;

use super::message::{DecodeError, Number, Raw};
use crate::path::{FieldTree, Leaf, first_name};
use crate::{LogError, SchemaText};

/// What to do with the fields of a message, by their tags.
#[derive(Debug)]
pub(super) struct Plan {
    fields: Vec<Field>,
}

#[derive(Debug)]
struct Field {
    tag: u32,
    /// What is wanted, of the field itself (`None`) or of its elements.
    wanted: Vec<(Option<usize>, Part)>,
}

#[derive(Debug)]
enum Part {
    Message(Plan),
    Text,
    Number {
        kind: Scalar,
        leaves: Vec<Leaf>,
        default: Option<Number>,
    },
}

/// How a number is written.
#[derive(Clone, Copy, Debug)]
enum Scalar {
    Double,
    Float,
    Signed,
    Unsigned,
    ZigZag,
    Fixed32,
    Fixed64,
    SignedFixed32,
    SignedFixed64,
}

impl Plan {
    /// The plan for messages of this schema, and whether they have a stamp.
    pub(super) fn compile(
        schema: SchemaText<'_>,
        topic: &FieldTopic,
        further: &[(Leaf, &str)],
    ) -> Result<(Self, bool), LogError> {
        let unusable = |why: String| LogError::Schema {
            topic: topic.name.clone(),
            schema: schema.name.into(),
            why,
        };
        let pool = pool(schema.data)
            .map_err(|why| unusable(format!("it is no FileDescriptorSet: {why}")))?;
        let message = pool
            .get_message_by_name(schema.name)
            .ok_or_else(|| unusable("its descriptor set does not define the message".into()))?;
        let stamped = message
            .get_field_by_name(first_name(&topic.stamp))
            .is_some();
        let want = FieldTree::of(topic, further, stamped)?;
        let plan = plan(&message, &want).map_err(|(leaf, why)| leaf.astray(topic, why))?;
        Ok((plan, stamped))
    }

    pub(super) fn decode(&self, data: &[u8], raw: &mut Raw) -> Result<(), DecodeError> {
        self.walk(data, raw).map_err(|error| {
            DecodeError::Malformed(format!("it is no such protobuf message: {error}"))
        })
    }

    fn walk(&self, mut data: &[u8], raw: &mut Raw) -> Result<(), String> {
        for (_, part) in self.fields.iter().flat_map(|field| &field.wanted) {
            if let Part::Number {
                leaves,
                default: Some(default),
                ..
            } = part
            {
                raw.set(leaves, *default);
            }
        }
        let mut seen = vec![0_usize; self.fields.len()];
        while data.has_remaining() {
            let (tag, wire) = decode_key(&mut data).map_err(|error| error.to_string())?;
            match self.fields.iter().position(|field| field.tag == tag) {
                Some(at) => self.fields[at].read(wire, &mut data, &mut seen[at], raw)?,
                None => {
                    skip_field(wire, tag, &mut data, DecodeContext::default())
                        .map_err(|error| error.to_string())?;
                }
            }
        }
        Ok(())
    }
}

impl Field {
    fn read(
        &self,
        wire: WireType,
        data: &mut &[u8],
        seen: &mut usize,
        raw: &mut Raw,
    ) -> Result<(), String> {
        let number = self.wanted.iter().find_map(|(_, part)| match part {
            Part::Number { kind, .. } => Some(*kind),
            Part::Message(_) | Part::Text => None,
        });
        match (number, wire) {
            (None, WireType::LengthDelimited) => {
                let inner = delimited(data)?;
                for (index, part) in &self.wanted {
                    if index.is_some_and(|index| index != *seen) {
                        continue;
                    }
                    match part {
                        Part::Message(plan) => plan.walk(inner, raw)?,
                        Part::Text => raw.text = Some(String::from_utf8_lossy(inner).into()),
                        Part::Number { .. } => {}
                    }
                }
                *seen += 1;
            }
            // Repeated numbers come packed.
            (Some(kind), WireType::LengthDelimited) => {
                let mut packed = delimited(data)?;
                while packed.has_remaining() {
                    self.number(kind, kind.wire(), &mut packed, seen, raw)?;
                }
            }
            (Some(kind), wire) => self.number(kind, wire, data, seen, raw)?,
            (None, _) => return Err("a number stands where a message is wanted".into()),
        }
        Ok(())
    }

    fn number(
        &self,
        kind: Scalar,
        wire: WireType,
        data: &mut &[u8],
        seen: &mut usize,
        raw: &mut Raw,
    ) -> Result<(), String> {
        let number = kind.read(wire, data)?;
        for (index, part) in &self.wanted {
            if let Part::Number { leaves, .. } = part
                && index.is_none_or(|index| index == *seen)
            {
                raw.set(leaves, number);
            }
        }
        *seen += 1;
        Ok(())
    }
}

fn pool(data: &[u8]) -> Result<DescriptorPool, String> {
    // prost-reflect 0.16.5 indexes out of bounds when it words its error for some sets that contradict themselves.
    std::panic::catch_unwind(|| DescriptorPool::decode(data))
        .map_err(|_| "it contradicts itself".to_string())?
        .map_err(|error| error.to_string())
}

fn delimited<'a>(data: &mut &'a [u8]) -> Result<&'a [u8], String> {
    let length = decode_varint(data).map_err(|error| error.to_string())?;
    let length = usize::try_from(length)
        .ok()
        .filter(|length| *length <= data.len());
    let (inner, rest) = data.split_at(length.ok_or("a length goes beyond its end")?);
    *data = rest;
    Ok(inner)
}

impl Scalar {
    fn of(kind: &Kind) -> Option<Self> {
        Some(match kind {
            Kind::Double => Self::Double,
            Kind::Float => Self::Float,
            Kind::Int32 | Kind::Int64 | Kind::Enum(_) => Self::Signed,
            Kind::Uint32 | Kind::Uint64 | Kind::Bool => Self::Unsigned,
            Kind::Sint32 | Kind::Sint64 => Self::ZigZag,
            Kind::Fixed32 => Self::Fixed32,
            Kind::Fixed64 => Self::Fixed64,
            Kind::Sfixed32 => Self::SignedFixed32,
            Kind::Sfixed64 => Self::SignedFixed64,
            Kind::String | Kind::Bytes | Kind::Message(_) => return None,
        })
    }

    fn wire(self) -> WireType {
        match self {
            Self::Double | Self::Fixed64 | Self::SignedFixed64 => WireType::SixtyFourBit,
            Self::Float | Self::Fixed32 | Self::SignedFixed32 => WireType::ThirtyTwoBit,
            Self::Signed | Self::Unsigned | Self::ZigZag => WireType::Varint,
        }
    }

    fn read(self, wire: WireType, data: &mut &[u8]) -> Result<Number, String> {
        if wire != self.wire() {
            return Err(format!(
                "a {wire:?} stands where a {:?} is wanted",
                self.wire()
            ));
        }
        let short = |error: prost::bytes::TryGetError| error.to_string();
        Ok(match self {
            Self::Double => Number::Float(data.try_get_f64_le().map_err(short)?),
            Self::Float => Number::Float(data.try_get_f32_le().map_err(short)?.into()),
            Self::Fixed32 => Number::Integer(data.try_get_u32_le().map_err(short)?.into()),
            Self::Fixed64 => Number::Integer(data.try_get_u64_le().map_err(short)?.into()),
            Self::SignedFixed32 => Number::Integer(data.try_get_i32_le().map_err(short)?.into()),
            Self::SignedFixed64 => Number::Integer(data.try_get_i64_le().map_err(short)?.into()),
            Self::Signed | Self::Unsigned | Self::ZigZag => {
                let bits = decode_varint(data).map_err(|error| error.to_string())?;
                Number::Integer(match self {
                    Self::Signed => (bits as i64).into(),
                    Self::ZigZag => ((bits >> 1) as i64 ^ -((bits & 1) as i64)).into(),
                    _ => bits.into(),
                })
            }
        })
    }
}

fn plan(message: &MessageDescriptor, want: &FieldTree) -> Result<Plan, (Leaf, String)> {
    let members = message.fields().map(|field| field.name().to_string());
    let stamp = want.of_stamp(members);
    let want = stamp.as_ref().unwrap_or(want);
    if want.fields.is_empty() || !want.leaves.is_empty() {
        return Err((
            want.any_leaf(),
            format!("it is a {}, not a number", message.full_name()),
        ));
    }
    let fields = want.fields.iter().map(|(name, want)| {
        let descriptor = message.get_field_by_name(name).ok_or_else(|| {
            let names: Vec<_> = message
                .fields()
                .map(|field| field.name().to_string())
                .collect();
            (
                want.any_leaf(),
                format!(
                    "{} has no `{name}` but {}",
                    message.full_name(),
                    names.join(", ")
                ),
            )
        })?;
        field(&descriptor, want)
    });
    Ok(Plan {
        fields: fields.collect::<Result<_, _>>()?,
    })
}

fn field(descriptor: &FieldDescriptor, want: &FieldTree) -> Result<Field, (Leaf, String)> {
    let name = descriptor.name();
    let repeated = descriptor.cardinality() == Cardinality::Repeated;
    if descriptor.is_map() {
        return Err((
            want.any_leaf(),
            format!("`{name}` is a map, and maps are not gone into"),
        ));
    }
    if descriptor.is_group() {
        return Err((
            want.any_leaf(),
            format!("`{name}` is a group, and groups are not gone into"),
        ));
    }
    if repeated == want.elements.is_empty() {
        let why = if repeated {
            "an array; take an element, as in `[0]`"
        } else {
            "no array"
        };
        return Err((want.any_leaf(), format!("`{name}` is {why}")));
    }
    let part = |want: &FieldTree| match (descriptor.kind(), Scalar::of(&descriptor.kind())) {
        (Kind::Message(message), _) => Ok(Part::Message(plan(&message, want)?)),
        (Kind::String, _) if want.is_text() => Ok(Part::Text),
        (_, Some(kind)) if want.fields.is_empty() && want.elements.is_empty() => Ok(Part::Number {
            kind,
            leaves: want.leaves.clone(),
            default: default(descriptor),
        }),
        _ => Err((
            want.any_leaf(),
            format!("`{name}` is neither a number nor a message"),
        )),
    };
    let mut wanted = Vec::new();
    if repeated {
        for (index, want) in &want.elements {
            wanted.push((Some(*index), part(want)?));
        }
    } else {
        wanted.push((None, part(want)?));
    }
    Ok(Field {
        tag: descriptor.number(),
        wanted,
    })
}

/// What a number that is not written stands for; fields with explicit presence stand for nothing then.
fn default(descriptor: &FieldDescriptor) -> Option<Number> {
    if descriptor.supports_presence() || descriptor.cardinality() == Cardinality::Repeated {
        return None;
    }
    Some(match descriptor.default_value() {
        Value::F64(number) => Number::Float(number),
        Value::F32(number) => Number::Float(number.into()),
        Value::I32(number) | Value::EnumNumber(number) => Number::Integer(number.into()),
        Value::I64(number) => Number::Integer(number.into()),
        Value::U32(number) => Number::Integer(number.into()),
        Value::U64(number) => Number::Integer(number.into()),
        Value::Bool(truth) => Number::Integer(truth.into()),
        _ => return None,
    })
}
