//! Fields of messages: ROS's plain CDR of both versions, ROS 1's serialisation, and protobuf.

use crate::ImageError;

/// Little- or big-endian fields one after another; CDR aligns numbers to their size, ROS 1 does not.
pub(crate) struct Wire<'a> {
    data: &'a [u8],
    at: usize,
    /// Numbers are aligned to their size, up to this.
    most: usize,
    big: bool,
}

impl<'a> Wire<'a> {
    pub(crate) fn cdr(data: &'a [u8]) -> Result<Self, ImageError> {
        let (header, data) = data
            .split_first_chunk::<4>()
            .ok_or(ImageError::Short(data.len()))?;
        // Version 2 aligns to 4 bytes at the most.
        let (big, most) = match header[..2] {
            [0, 1] => (false, 8),
            [0, 0] => (true, 8),
            [0, 7] => (false, 4),
            [0, 6] => (true, 4),
            _ => {
                return Err(ImageError::Message(
                    "its CDR header is not that of plain CDR",
                ));
            }
        };
        Ok(Self {
            data,
            at: 0,
            most,
            big,
        })
    }

    pub(crate) fn ros1(data: &'a [u8]) -> Result<Self, ImageError> {
        let mut wire = Self {
            data,
            at: 0,
            most: 1,
            big: false,
        };
        wire.u32()?; // seq
        Ok(wire)
    }

    pub(crate) fn take(&mut self, count: usize) -> Result<&'a [u8], ImageError> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.data.get(self.at..end));
        let taken = taken.ok_or(ImageError::Short(self.data.len()))?;
        self.at += count;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], ImageError> {
        self.at = self.at.next_multiple_of(N.min(self.most));
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        if self.big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    pub(crate) fn u32(&mut self) -> Result<u32, ImageError> {
        Ok(u32::from_le_bytes(self.number()?))
    }

    pub(crate) fn f64(&mut self) -> Result<f64, ImageError> {
        Ok(f64::from_le_bytes(self.number()?))
    }

    pub(crate) fn bytes(&mut self) -> Result<&'a [u8], ImageError> {
        let count = self.u32()? as usize;
        self.take(count)
    }

    pub(crate) fn text(&mut self) -> Result<&'a str, ImageError> {
        let bytes = self.bytes()?;
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        std::str::from_utf8(bytes).map_err(|_| ImageError::Message("a text is not UTF-8"))
    }
}

/// `google.protobuf.Timestamp`: seconds 1, nanos 2.
pub(crate) fn timestamp(data: &[u8]) -> Result<i64, ImageError> {
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

pub(crate) enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

pub(crate) type EachField<'f, 'a> = &'f mut dyn FnMut(u64, Value<'a>) -> Result<(), ImageError>;

/// Calls `each` with the fields of a protobuf message.
pub(crate) fn each_field<'a>(data: &'a [u8], each: EachField<'_, 'a>) -> Result<(), ImageError> {
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
