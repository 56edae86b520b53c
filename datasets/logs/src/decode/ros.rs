//! ROS messages on the wire: OMG CDR (ROS 2) and ROS 1's serialization.
//!
//! CDR (OMG DDSI-RTPS 10.5, XTypes 7.4): a 4-byte header names the endianness; each number is aligned to its own size,
//! counted from behind that header, at most to 8 bytes (4 in the second version); text and sequences begin with a 32-bit
//! count. ROS 1 is little-endian, without header or alignment.

mod compile;

use super::message::{DecodeError, Number, Raw};
use super::ros_schema::Primitive;
use crate::path::Leaf;

/// How numbers are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wire {
    /// ROS 2.
    Cdr,
    /// ROS 1.
    Ros1,
}

/// What to do with a message's bytes, in order, up to the last field that is wanted.
#[derive(Debug)]
pub(super) struct Plan {
    wire: Wire,
    steps: Vec<Step>,
    /// How to pass over a value of each type.
    passes: Vec<Vec<Step>>,
}

#[derive(Clone, Debug)]
enum Step {
    Take(Primitive, Vec<Leaf>),
    /// Read the text that is wanted.
    TakeText,
    Pass(Primitive, usize),
    PassText(usize),
    /// Pass over this many wide texts, which is not possible unless there are none.
    PassWideText(usize),
    /// Pass over this many values of a type, by its index.
    PassType(usize, usize),
    PassSequence(Element),
    /// Go through an array (of a fixed count) or a counted sequence, and into some of its elements.
    Elements {
        count: Option<usize>,
        wanted: Vec<(usize, Vec<Step>)>,
        element: Element,
    },
}

#[derive(Clone, Copy, Debug)]
enum Element {
    Number(Primitive),
    Text,
    WideText,
    Type(usize),
}

impl Element {
    fn pass(self, count: usize) -> Step {
        match self {
            Self::Number(primitive) => Step::Pass(primitive, count),
            Self::Text => Step::PassText(count),
            Self::WideText => Step::PassWideText(count),
            Self::Type(index) => Step::PassType(index, count),
        }
    }
}

impl Plan {
    pub(super) fn decode(&self, data: &[u8], raw: &mut Raw) -> Result<(), DecodeError> {
        let mut cursor = Cursor::new(self.wire, data)?;
        self.run(&self.steps, &mut cursor, raw)
    }

    /// Every step that runs takes a byte at least, so lying counts end with the message.
    fn run(
        &self,
        steps: &[Step],
        cursor: &mut Cursor<'_>,
        raw: &mut Raw,
    ) -> Result<(), DecodeError> {
        for step in steps {
            match step {
                Step::Take(primitive, leaves) => {
                    raw.set(leaves, cursor.number(*primitive)?);
                }
                Step::TakeText => {
                    let bytes = cursor.count()?;
                    let text = String::from_utf8_lossy(cursor.take(bytes)?);
                    // CDR counts the zero at its end.
                    raw.text = Some(text.trim_end_matches('\0').into());
                }
                Step::Pass(primitive, count) => cursor.pass(*primitive, *count)?,
                Step::PassText(count) => {
                    for _ in 0..*count {
                        let bytes = cursor.count()?;
                        cursor.take(bytes)?;
                    }
                }
                Step::PassWideText(0) => {}
                Step::PassWideText(_) => return Err(DecodeError::WideText),
                Step::PassType(index, count) => {
                    for _ in 0..*count {
                        self.run(&self.passes[*index], cursor, raw)?;
                    }
                }
                Step::PassSequence(element) => {
                    let count = cursor.count()?;
                    self.run(&[element.pass(count)], cursor, raw)?;
                }
                Step::Elements {
                    count,
                    wanted,
                    element,
                } => {
                    let count = count.map_or_else(|| cursor.count(), Ok)?;
                    let mut passed = 0;
                    for (index, steps) in wanted.iter().filter(|(index, _)| *index < count) {
                        self.run(&[element.pass(index - passed)], cursor, raw)?;
                        self.run(steps, cursor, raw)?;
                        passed = index + 1;
                    }
                    self.run(&[element.pass(count - passed)], cursor, raw)?;
                }
            }
        }
        Ok(())
    }
}

struct Cursor<'a> {
    data: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Largest alignment; 1 for none.
    alignment: usize,
}

impl<'a> Cursor<'a> {
    fn new(wire: Wire, data: &'a [u8]) -> Result<Self, DecodeError> {
        let (data, (big_endian, alignment)) = match wire {
            Wire::Ros1 => (data, (false, 1)),
            Wire::Cdr => {
                let header = data.split_first_chunk::<4>();
                let (header, data) = header.ok_or(DecodeError::Short(data.len()))?;
                let layout = match u16::from_be_bytes([header[0], header[1]]) {
                    0x0000 => (true, 8),
                    0x0001 => (false, 8),
                    0x0006 => (true, 4),
                    0x0007 => (false, 4),
                    other => return Err(DecodeError::Representation(other)),
                };
                (data, layout)
            }
        };
        Ok(Self {
            data,
            at: 0,
            big_endian,
            alignment,
        })
    }

    fn take(&mut self, bytes: usize) -> Result<&'a [u8], DecodeError> {
        let end = self
            .at
            .checked_add(bytes)
            .filter(|end| *end <= self.data.len());
        let end = end.ok_or(DecodeError::Short(self.data.len()))?;
        let taken = &self.data[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn align(&mut self, size: usize) {
        self.at = self.at.next_multiple_of(size.min(self.alignment));
    }

    fn count(&mut self) -> Result<usize, DecodeError> {
        self.align(4);
        let bytes = self.array()?;
        Ok(match self.big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        } as usize)
    }

    /// Nothing is aligned for an empty sequence.
    fn pass(&mut self, primitive: Primitive, count: usize) -> Result<(), DecodeError> {
        if count > 0 {
            self.align(primitive.size());
            let bytes = primitive
                .size()
                .checked_mul(count)
                .ok_or(DecodeError::Short(self.data.len()))?;
            self.take(bytes)?;
        }
        Ok(())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], DecodeError> {
        let short = DecodeError::Short(self.data.len());
        self.take(N)?.try_into().map_err(|_| short)
    }

    fn number(&mut self, primitive: Primitive) -> Result<Number, DecodeError> {
        macro_rules! number {
            ($kind:ty, $variant:ident) => {{
                let bytes = self.array()?;
                let value = if self.big_endian {
                    <$kind>::from_be_bytes(bytes)
                } else {
                    <$kind>::from_le_bytes(bytes)
                };
                Number::$variant(value.into())
            }};
        }
        self.align(primitive.size());
        Ok(match primitive {
            Primitive::Bool | Primitive::U8 => number!(u8, Integer),
            Primitive::I8 => number!(i8, Integer),
            Primitive::I16 => number!(i16, Integer),
            Primitive::U16 => number!(u16, Integer),
            Primitive::I32 => number!(i32, Integer),
            Primitive::U32 => number!(u32, Integer),
            Primitive::I64 => number!(i64, Integer),
            Primitive::U64 => number!(u64, Integer),
            Primitive::F32 => number!(f32, Float),
            Primitive::F64 => number!(f64, Float),
        })
    }
}

#[cfg(test)]
mod tests;
