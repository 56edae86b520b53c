//! Whether the entropy-coded data of a JPEG are whole: exactly the blocks that its header asks for, and nothing left over.
//!
//! A changed bit, or bytes that are lost, put a decoder out of step; it soon falls into step again, and all that follows is shifted by
//! some blocks: an image that looks well, with the object in a wrong place. The number of blocks then does not fit the data. A brightness
//! that no pixel can have is damage as well. Baseline images are checked; progressive ones, which no camera makes, are not.
//!
//! Source: ITU-T T.81, annexes B and F.

use crate::huffman::{BLOCK, Codes, END};
use crate::standard_codes::STANDARD_CODES;

/// Markers' second bytes.
mod marker {
    pub(super) const BASELINE: u8 = 0xc0;
    pub(super) const EXTENDED: u8 = 0xc1;
    pub(super) const OTHER_FRAMES: std::ops::RangeInclusive<u8> = 0xc2..=0xcf;
    pub(super) const CODES: u8 = 0xc4;
    pub(super) const RESTART: std::ops::RangeInclusive<u8> = 0xd0..=0xd7;
    pub(super) const END: u8 = 0xd9;
    pub(super) const SCAN: u8 = 0xda;
    pub(super) const STEPS: u8 = 0xdb;
    pub(super) const RESTARTS: u8 = 0xdd;
}

/// What is wrong with the data.
type Damage = &'static str;

const CUT: Damage = "its data end before the image does";
const LEFT: Damage = "data are left over behind the image's last block";
const NO_CODE: Damage = "its data hold what is no code";
const TOO_LONG: Damage = "a block of it has more than 64 coefficients";
const TOO_BRIGHT: Damage = "a block of it is brighter or darker than a pixel can be";
const ORDER: Damage = "a restart marker is missing, or one too many";
const HEADER: Damage = "its header is damaged";
const NO_TABLES: Damage = "it has no Huffman tables";

/// A component (luma or a chroma) as the header has it.
#[derive(Clone, Copy, Debug, Default)]
struct Component {
    id: u8,
    /// Blocks across and down in a unit of an interleaved scan.
    sampling: [usize; 2],
    /// Number of its table of quantisation steps.
    steps: usize,
}

/// A component in a scan.
struct InScan<'a> {
    blocks: usize,
    dc: &'a Codes,
    ac: &'a Codes,
    /// Quantisation step of a block's mean.
    step: i32,
    /// Mean of the block before, in those steps.
    mean: i32,
}

/// Checks one JPEG after another in the same memory.
#[derive(Debug, Default)]
pub(crate) struct ScanCheck {
    header: Header,
    bytes: Vec<u8>,
}

/// What the segments before a scan set.
#[derive(Debug, Default)]
struct Header {
    /// Width and height in px.
    size: [usize; 2],
    components: Vec<Component>,
    /// Codes of means and of the other coefficients; those of the image before are kept, for cameras use the same again.
    codes: [[Option<Codes>; 4]; 2],
    /// Whether this image has set them.
    is_set: [[bool; 4]; 2],
    /// Quantisation steps of blocks' means.
    steps: [i32; 4],
    /// Units between restart markers; 0 for none.
    restarts: usize,
}

impl ScanCheck {
    /// Checks all scans of a JPEG.
    pub(crate) fn check(&mut self, data: &[u8]) -> Result<(), Damage> {
        let Self { header, bytes } = self;
        header.begin();
        let mut at = 2;
        loop {
            let (&first, &kind) = data.get(at).zip(data.get(at + 1)).ok_or(CUT)?;
            if first != 0xff {
                return Err(HEADER);
            }
            if kind == 0xff {
                at += 1;
                continue;
            }
            if kind == marker::END {
                return Ok(());
            }
            let length = data.get(at + 2..at + 4).ok_or(CUT)?;
            let length = usize::from(u16::from_be_bytes([length[0], length[1]]));
            let segment = data.get(at + 4..at + 2 + length).ok_or(CUT)?;
            at += 2 + length;
            match kind {
                marker::BASELINE | marker::EXTENDED => header.frame(segment).ok_or(HEADER)?,
                marker::CODES => header.codes(segment).ok_or(HEADER)?,
                marker::STEPS => header.steps(segment).ok_or(HEADER)?,
                marker::RESTARTS => {
                    let [high, low] = *segment.first_chunk::<2>().ok_or(HEADER)?;
                    header.restarts = usize::from(u16::from_be_bytes([high, low]));
                }
                marker::SCAN => {
                    if header.is_set.iter().flatten().all(|is_set| !is_set) {
                        header.codes(STANDARD_CODES).ok_or(HEADER)?;
                    }
                    at = header.scan(segment, data, at, bytes)?;
                }
                // Progressive, or a kind that the decoder refuses.
                kind if marker::OTHER_FRAMES.contains(&kind) => return Ok(()),
                _ => {}
            }
        }
    }
}

impl Header {
    /// Forgets all but the codes of the image before.
    fn begin(&mut self) {
        *self = Self {
            codes: std::mem::take(&mut self.codes),
            ..Self::default()
        };
    }

    fn frame(&mut self, segment: &[u8]) -> Option<()> {
        let (head, components) = segment.split_at_checked(6)?;
        let pixels = |at: usize| usize::from(u16::from_be_bytes([head[at], head[at + 1]]));
        self.size = [pixels(3), pixels(1)];
        self.components.clear();
        for component in components.as_chunks::<3>().0 {
            let [id, sampling, steps] = *component;
            let sampling = [usize::from(sampling >> 4), usize::from(sampling & 15)];
            if sampling.contains(&0) || sampling.iter().any(|sampling| *sampling > 4) {
                return None;
            }
            let steps = usize::from(steps);
            self.components.push(Component {
                id,
                sampling,
                steps,
            });
        }
        Some(())
    }

    fn codes(&mut self, mut segment: &[u8]) -> Option<()> {
        while let Some((head, rest)) = segment.split_first_chunk::<17>() {
            let [place, counts @ ..] = head;
            let count = counts.iter().map(|count| usize::from(*count)).sum();
            let (symbols, rest) = rest.split_at_checked(count)?;
            let (kind, number) = (usize::from(place >> 4), usize::from(place & 15));
            let codes = self.codes.get_mut(kind)?.get_mut(number)?;
            if !codes
                .as_ref()
                .is_some_and(|codes| codes.is(counts, symbols))
            {
                *codes = Some(Codes::new(counts, symbols)?);
            }
            self.is_set[kind][number] = true;
            segment = rest;
        }
        segment.is_empty().then_some(())
    }

    fn steps(&mut self, mut segment: &[u8]) -> Option<()> {
        while let [place, rest @ ..] = segment {
            let to = self.steps.get_mut(usize::from(place & 15))?;
            let bytes = 1 + usize::from(place >> 4);
            let (steps, rest) = rest.split_at_checked(bytes * BLOCK as usize)?;
            let step = &steps[..bytes.min(2)];
            *to = step
                .iter()
                .fold(0, |sum, byte| 256 * sum + i32::from(*byte));
            if *to == 0 {
                return None;
            }
            segment = rest;
        }
        Some(())
    }

    /// Checks a scan whose data begin at `at`, and gives where they end.
    fn scan(
        &self,
        segment: &[u8],
        data: &[u8],
        at: usize,
        bytes: &mut Vec<u8>,
    ) -> Result<usize, Damage> {
        let (count, rest) = segment.split_first().ok_or(HEADER)?;
        let selectors = rest.get(..2 * usize::from(*count)).ok_or(HEADER)?;
        let mut parts = Vec::with_capacity(selectors.len() / 2);
        let mut units = [0; 2];
        for [id, tables] in selectors.as_chunks::<2>().0 {
            let mut components = self.components.iter();
            let component = components
                .find(|component| component.id == *id)
                .ok_or(HEADER)?;
            let table = |kind: usize, number: u8| {
                let number = usize::from(number);
                let is_set = self.is_set[kind].get(number).is_some_and(|is_set| *is_set);
                let codes = self.codes[kind].get(number).filter(|_| is_set);
                codes.and_then(Option::as_ref).ok_or(NO_TABLES)
            };
            parts.push(InScan {
                blocks: if *count == 1 {
                    1
                } else {
                    component.sampling.iter().product()
                },
                dc: table(0, tables >> 4)?,
                ac: table(1, tables & 15)?,
                step: *self.steps.get(component.steps).ok_or(HEADER)?,
                mean: 0,
            });
            units = [0, 1].map(|side| self.units(component, side, *count == 1));
        }
        let mut left = units[0] * units[1];
        let (mut at, mut expected) = (at, *marker::RESTART.start());
        loop {
            let end = gather(data, at, bytes).ok_or(CUT)?;
            let units = if self.restarts > 0 {
                left.min(self.restarts)
            } else {
                left
            };
            check_units(&mut parts, units, bytes)?;
            left -= units;
            let found = data.get(end + 1).copied().unwrap_or_default();
            match (left, marker::RESTART.contains(&found)) {
                (0, false) => return Ok(end),
                (1.., true) if found == expected => {}
                (1.., false) => return Err(CUT),
                _ => return Err(ORDER),
            }
            at = end + 2;
            let last = *marker::RESTART.end();
            expected = if found == last {
                *marker::RESTART.start()
            } else {
                found + 1
            };
            for part in &mut parts {
                part.mean = 0;
            }
        }
    }

    /// Units of a scan along a side: the blocks of its only component, or all components' blocks of a square together.
    fn units(&self, component: &Component, side: usize, is_alone: bool) -> usize {
        let samplings = self
            .components
            .iter()
            .map(|component| component.sampling[side]);
        let most = samplings.max().unwrap_or(1);
        let own = if is_alone {
            component.sampling[side]
        } else {
            1
        };
        (self.size[side] * own).div_ceil(8 * most)
    }
}

/// Bytes behind the data, so that bits can be read four bytes at a time. Their ones are no code.
const MARGIN: usize = 16;

/// Copies the entropy-coded bytes up to the next marker, without the zeros stuffed in behind 255, and a margin. Gives the marker's place.
fn gather(data: &[u8], mut at: usize, bytes: &mut Vec<u8>) -> Option<usize> {
    bytes.clear();
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

/// Bits, taken from four bytes at a time.
struct Bits<'a> {
    bytes: &'a [u8],
    next: usize,
    /// The next bits, left-aligned, and how many there are.
    buffer: u64,
    count: u32,
}

impl Bits<'_> {
    /// At least 32 bits, or damage: no symbol and value have more.
    fn fill(&mut self) -> Result<(), Damage> {
        if self.count < 32 {
            let four = self.bytes.get(self.next..self.next + 4).ok_or(CUT)?;
            let four = u32::from_be_bytes([four[0], four[1], four[2], four[3]]);
            self.buffer |= u64::from(four) << (32 - self.count);
            self.next += 4;
            self.count += 32;
        }
        Ok(())
    }

    fn drop(&mut self, count: u32) {
        self.buffer <<= count;
        self.count -= count;
    }
}

fn check_units(parts: &mut [InScan<'_>], units: usize, bytes: &[u8]) -> Result<(), Damage> {
    let end = bytes.len() - MARGIN;
    let mut bits = Bits {
        bytes,
        next: 0,
        buffer: 0,
        count: 0,
    };
    for _ in 0..units {
        for part in &mut *parts {
            for _ in 0..part.blocks {
                let checked = part.check_block(&mut bits);
                checked.map_err(|why| if bits.next > end { CUT } else { why })?;
            }
        }
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

impl InScan<'_> {
    #[inline]
    fn check_block(&mut self, bits: &mut Bits<'_>) -> Result<(), Damage> {
        /// Most bits of a mean's difference, and the greatest mean of pixels from -128 to 127, in eighths (T.81, F.1.2.1 and A.3.3).
        const LARGEST: u8 = 11;
        const BRIGHTEST: i32 = 8 * 128;
        bits.fill()?;
        let (size, length) = self.dc.first(bits.buffer).ok_or(NO_CODE)?;
        if size > LARGEST {
            return Err(NO_CODE);
        }
        bits.drop(length);
        if size > 0 {
            let value = (bits.buffer >> (64 - u32::from(size))) as i32;
            bits.drop(size.into());
            let is_negative = value < 1 << (size - 1);
            self.mean += value - if is_negative { (1 << size) - 1 } else { 0 };
            if self.mean.abs() * self.step > BRIGHTEST + self.step {
                return Err(TOO_BRIGHT);
            }
        }
        let mut passed = 1;
        while passed < BLOCK {
            bits.fill()?;
            let many = self.ac.many(bits.buffer);
            let next = passed + u32::from(many.passed);
            // Where a symbol in them may end the block by filling it, they are gone through one by one.
            let fits = next < BLOCK || (END..END + BLOCK).contains(&next);
            if many.bits > 0 && fits {
                bits.drop(many.bits.into());
                passed = next;
                continue;
            }
            let one = self.ac.one(bits.buffer).ok_or(NO_CODE)?;
            bits.drop(one.bits.into());
            passed += u32::from(one.passed);
            if BLOCK < passed && passed < END {
                return Err(TOO_LONG);
            }
        }
        Ok(())
    }
}
