//! The bits of a scan's entropy-coded data, and what can be wrong with them.

/// Bytes behind the data, so that bits can be read eight bytes at a time. Their ones are no code.
const MARGIN: usize = 16;

/// Copies the entropy-coded bytes up to the next marker, without the zeros stuffed in behind 255, and a margin. Gives the marker's place.
pub(super) fn gather(data: &[u8], mut at: usize, bytes: &mut Vec<u8>) -> Option<usize> {
    bytes.clear();
    bytes.reserve_exact(data.len().saturating_sub(at) + MARGIN);
    loop {
        let rest = data.get(at..)?;
        let stop = memchr::memchr(0xff, rest)?;
        bytes.extend_from_slice(&rest[..stop]);
        at += stop;
        match data.get(at + 1)? {
            0 => bytes.push(0xff),
            // Fill bytes may stand before a marker.
            0xff => {
                at += 1;
                continue;
            }
            _ => break,
        }
        at += 2;
    }
    bytes.extend_from_slice(&[0xff; MARGIN]);
    Some(at)
}

/// Bits, taken from eight bytes at a time.
pub(super) struct Bits<'a> {
    bytes: &'a [u8],
    next: usize,
    /// The next bits, left-aligned, and how many of them are counted; behind those are some of the bytes from `next` on.
    pub(super) buffer: u64,
    count: u32,
}

impl Bits<'_> {
    /// At least 56 bits, or damage: no symbol and value have more than 32.
    #[inline]
    pub(super) fn fill(&mut self) -> Result<(), Damage> {
        let rest = self.bytes.get(self.next..).ok_or(CUT)?;
        let eight = u64::from_be_bytes(*rest.first_chunk().ok_or(CUT)?);
        self.buffer |= eight >> self.count;
        self.next += ((63 - self.count) >> 3) as usize;
        self.count |= 56;
        Ok(())
    }

    #[inline]
    pub(super) fn drop(&mut self, count: u32) {
        self.buffer <<= count;
        self.count -= count;
    }

    /// The next so many bits, of those that were filled, as a value of JPEG: 0 to 16. One that begins with 0 is below zero (T.81, F.2.2.1).
    #[inline]
    pub(super) fn take_signed(&mut self, count: u32) -> i32 {
        let value = ((self.buffer >> 1) >> (u64::BITS - 1 - count)) as i32;
        let below = 1 - (self.buffer >> (u64::BITS - 1)) as i32;
        self.drop(count);
        value - below * ((1 << count) - 1)
    }

    /// The next so many bits, of those that were filled, as a number: 1 to 16.
    #[inline]
    pub(super) fn take(&mut self, count: u32) -> i32 {
        let value = (self.buffer >> (u64::BITS - count)) as i32;
        self.drop(count);
        value
    }
}

/// Checks that exactly so many units, each checked by `unit`, lie in the bytes of [`gather`].
pub(super) fn check_units(
    bytes: &[u8],
    units: usize,
    mut unit: impl FnMut(&mut Bits<'_>) -> Result<(), Damage>,
) -> Result<(), Damage> {
    let end = bytes.len() - MARGIN;
    let mut bits = Bits {
        bytes,
        next: 0,
        buffer: 0,
        count: 0,
    };
    for _ in 0..units {
        unit(&mut bits).map_err(|why| if bits.next > end { CUT } else { why })?;
    }
    let used = 8 * bits.next - bits.count as usize;
    if used > 8 * end {
        return Err(CUT);
    }
    // Encoders fill the last byte with ones, some with zeros, and some add such bytes.
    let rest = &bytes[used / 8..end];
    let is_filled = |with: u8| {
        let differs = |(index, byte): (usize, &u8)| {
            let mask = if index == 0 { 0xff >> (used % 8) } else { 0xff };
            (byte ^ with) & mask != 0
        };
        !rest.iter().enumerate().any(differs)
    };
    if is_filled(0xff) || is_filled(0) {
        Ok(())
    } else {
        Err(LEFT)
    }
}

pub(super) type Damage = &'static str;

pub(super) const CUT: Damage = "its data end before the image does";
pub(super) const LEFT: Damage = "data are left over behind the image's last block";
pub(super) const NO_CODE: Damage = "its data hold what is no code";
pub(super) const TOO_LONG: Damage = "a block of it has more than 64 coefficients";
pub(super) const TOO_BRIGHT: Damage = "a block of it is brighter or darker than a pixel can be";
pub(super) const ORDER: Damage = "a restart marker is missing, or one too many";
pub(super) const HEADER: Damage = "its header is damaged";
pub(super) const NO_TABLES: Damage = "it has no Huffman tables";
