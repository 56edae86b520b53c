//! Fields of protobuf messages.

use crate::ImageError;

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
