//! Fields of ROS messages: plain CDR of both versions, and ROS 1's serialisation.

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
