//! Huffman codes of a baseline JPEG: how many bits a symbol takes and how far it leads, for several short symbols at once.
//!
//! Source: ITU-T T.81, annex C and section F.2.2.

/// Bits by which symbols are looked up; longer codes are rare.
const LOOKED_UP: u32 = 12;
const ENTRIES: usize = 1 << LOOKED_UP;
/// Longest code in bits.
const LONGEST: usize = 16;
pub(crate) const BLOCK: u32 = 64;
/// Added to the coefficients passed where the end of a block is among the symbols: more than any block has.
pub(crate) const END: u32 = 128;

/// What the next bits hold: a number of symbols, the bits that they take with their values, and the coefficients that they pass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Step {
    /// Bits of the codes and of the values behind them; 0 where the bits are no code.
    pub(crate) bits: u8,
    /// Coefficients that are passed, with [`END`] where the block ends.
    pub(crate) passed: u8,
}

impl Step {
    /// The step of a symbol of coefficients with a code of so many bits; none where the format has no such symbol.
    fn of(symbol: u8, length: u32) -> Option<Self> {
        /// Zeros that a symbol without a value stands for.
        const SIXTEEN_ZEROS: u8 = 0xf0;
        let (zeros, size) = (symbol >> 4, symbol & 15);
        let passed = match symbol {
            0 => END as u8,
            SIXTEEN_ZEROS => 16,
            _ if size == 0 => return None,
            _ => zeros + 1,
        };
        let bits = length as u8 + size;
        Some(Self { bits, passed })
    }
}

#[derive(Debug)]
pub(crate) struct Codes {
    /// How many codes each length has, their symbols in the order of the codes, and for each length the first code beyond it (left-aligned in 16
    /// bits) and what is added to a code to find its symbol.
    counts: [u8; LONGEST],
    symbols: Vec<u8>,
    beyond: [u32; LONGEST + 1],
    offset: [i32; LONGEST + 1],
    /// For each `LOOKED_UP` bits: the first symbol and its length, the step that it is, and the steps that fit together.
    first: Vec<(u8, u8)>,
    one: Vec<Step>,
    many: Box<[Step; ENTRIES]>,
}

impl Codes {
    /// The table of a DHT segment: how many codes each length has, and their symbols. `None` where these are no code.
    pub(crate) fn new(counts: &[u8; LONGEST], symbols: &[u8]) -> Option<Self> {
        let mut codes = Self {
            counts: *counts,
            symbols: symbols.to_vec(),
            beyond: [0; LONGEST + 1],
            offset: [0; LONGEST + 1],
            first: Vec::with_capacity(ENTRIES),
            one: Vec::with_capacity(ENTRIES),
            many: Box::new([Step::default(); ENTRIES]),
        };
        let (mut code, mut index) = (0u32, 0usize);
        for length in 1..=LONGEST {
            code <<= 1;
            codes.offset[length] = i32::try_from(index).ok()? - i32::try_from(code).ok()?;
            let count = usize::from(counts[length - 1]);
            (code, index) = (code + count as u32, index + count);
            if code > 1 << length {
                return None;
            }
            codes.beyond[length] = code << (LONGEST - length);
        }
        if index != symbols.len() {
            return None;
        }
        codes.look_up(counts);
        Some(codes)
    }

    /// The symbol that 16 bits begin with, and the length of its code.
    fn symbol(&self, sixteen: u32) -> Option<(u8, u32)> {
        let length = (1..=LONGEST).find(|length| sixteen < self.beyond[*length])?;
        let code = (sixteen >> (LONGEST - length)) as i32;
        let index = usize::try_from(code + self.offset[length]).ok()?;
        Some((*self.symbols.get(index)?, length as u32))
    }

    fn look_up(&mut self, counts: &[u8; LONGEST]) {
        let mut symbols = self.symbols.iter();
        for (length, count) in (1..=LOOKED_UP).zip(counts) {
            for symbol in symbols.by_ref().take(usize::from(*count)) {
                let end = self.one.len() + (1 << (LOOKED_UP - length));
                self.first.resize(end, (*symbol, length as u8));
                self.one
                    .resize(end, Step::of(*symbol, length).unwrap_or_default());
            }
        }
        self.first.resize(ENTRIES, (0, 0));
        self.one.resize(ENTRIES, Step::default());
        for bits in 0..ENTRIES {
            self.many[bits] = self.all_within(bits);
        }
    }

    pub(crate) fn is(&self, counts: &[u8; LONGEST], symbols: &[u8]) -> bool {
        self.counts == *counts && self.symbols == symbols
    }

    /// The symbol that the next bits begin with, and the length of its code.
    #[inline]
    pub(crate) fn first(&self, bits: u64) -> Option<(u8, u32)> {
        let (symbol, length) = self.first[(bits >> (u64::BITS - LOOKED_UP)) as usize];
        if length > 0 {
            return Some((symbol, length.into()));
        }
        self.symbol((bits >> (u64::BITS - LONGEST as u32)) as u32)
    }

    /// Step over as many symbols of coefficients as are whole in the bits.
    fn all_within(&self, bits: usize) -> Step {
        let mut all = Step::default();
        while u32::from(all.passed) < BLOCK {
            let rest = (bits << all.bits) & (self.one.len() - 1);
            let step = self.one[rest];
            if step.bits == 0 || u32::from(all.bits + step.bits) > LOOKED_UP {
                break;
            }
            all.bits += step.bits;
            all.passed += step.passed;
        }
        all
    }

    /// Step over as many symbols of coefficients as the next bits hold, looked up.
    #[inline]
    pub(crate) fn many(&self, bits: u64) -> Step {
        self.many[(bits >> (u64::BITS - LOOKED_UP)) as usize]
    }

    /// The next symbol of coefficients.
    #[inline]
    pub(crate) fn one(&self, bits: u64) -> Option<Step> {
        let step = self.one[(bits >> (u64::BITS - LOOKED_UP)) as usize];
        if step.bits > 0 {
            return Some(step);
        }
        let (symbol, length) = self.symbol((bits >> (u64::BITS - LONGEST as u32)) as u32)?;
        Step::of(symbol, length)
    }
}

/// A segment of codes: of luma's means, chroma's means, luma's coefficients, chroma's coefficients.
#[rustfmt::skip]
pub(crate) const STANDARD_CODES: &[u8] = &[
    0x00, 0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0,
    0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0a, 0x0b,
    0x01, 0, 3, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0,
    0x00, 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0a, 0x0b,
    0x10, 0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 125,
    0x01, 0x02, 0x03, 0x00, 0x04, 0x11, 0x05, 0x12, 0x21, 0x31, 0x41, 0x06, 0x13, 0x51, 0x61, 0x07, 0x22, 0x71, 0x14, 0x32, 0x81, 0x91, 0xa1, 0x08,
    0x23, 0x42, 0xb1, 0xc1, 0x15, 0x52, 0xd1, 0xf0, 0x24, 0x33, 0x62, 0x72, 0x82, 0x09, 0x0a, 0x16, 0x17, 0x18, 0x19, 0x1a, 0x25, 0x26, 0x27, 0x28,
    0x29, 0x2a, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58, 0x59,
    0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x79, 0x7a, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88, 0x89,
    0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4, 0xb5, 0xb6,
    0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda, 0xe1, 0xe2,
    0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf1, 0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa,
    0x11, 0, 2, 1, 2, 4, 4, 3, 4, 7, 5, 4, 4, 0, 1, 2, 119,
    0x00, 0x01, 0x02, 0x03, 0x11, 0x04, 0x05, 0x21, 0x31, 0x06, 0x12, 0x41, 0x51, 0x07, 0x61, 0x71, 0x13, 0x22, 0x32, 0x81, 0x08, 0x14, 0x42, 0x91,
    0xa1, 0xb1, 0xc1, 0x09, 0x23, 0x33, 0x52, 0xf0, 0x15, 0x62, 0x72, 0xd1, 0x0a, 0x16, 0x24, 0x34, 0xe1, 0x25, 0xf1, 0x17, 0x18, 0x19, 0x1a, 0x26,
    0x27, 0x28, 0x29, 0x2a, 0x35, 0x36, 0x37, 0x38, 0x39, 0x3a, 0x43, 0x44, 0x45, 0x46, 0x47, 0x48, 0x49, 0x4a, 0x53, 0x54, 0x55, 0x56, 0x57, 0x58,
    0x59, 0x5a, 0x63, 0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6a, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78, 0x79, 0x7a, 0x82, 0x83, 0x84, 0x85, 0x86, 0x87,
    0x88, 0x89, 0x8a, 0x92, 0x93, 0x94, 0x95, 0x96, 0x97, 0x98, 0x99, 0x9a, 0xa2, 0xa3, 0xa4, 0xa5, 0xa6, 0xa7, 0xa8, 0xa9, 0xaa, 0xb2, 0xb3, 0xb4,
    0xb5, 0xb6, 0xb7, 0xb8, 0xb9, 0xba, 0xc2, 0xc3, 0xc4, 0xc5, 0xc6, 0xc7, 0xc8, 0xc9, 0xca, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0xd9, 0xda,
    0xe2, 0xe3, 0xe4, 0xe5, 0xe6, 0xe7, 0xe8, 0xe9, 0xea, 0xf2, 0xf3, 0xf4, 0xf5, 0xf6, 0xf7, 0xf8, 0xf9, 0xfa,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Codes 0 (end of block), 10 (one zero passed, a value of 2 bits), 110 (sixteen zeros).
    fn codes() -> Codes {
        let mut counts = [0; LONGEST];
        counts[..3].fill(1);
        Codes::new(&counts, &[0x00, 0x12, 0xf0]).expect("a code")
    }

    #[test]
    fn symbols_are_found_one_by_one_and_together() {
        let codes = codes();
        // 10 11 | 110 | 0 and more.
        let bits = 0b1011_1100_1111_1111_u64 << 48;
        let one = codes.one(bits).expect("a symbol");
        assert_eq!((one.bits, one.passed), (4, 2));
        let many = codes.many(bits);
        assert_eq!((many.bits, u32::from(many.passed)), (8, 2 + 16 + END));
        assert!(codes.one(u64::MAX).is_none(), "ones are no code");
        assert_eq!(codes.many(u64::MAX).bits, 0);
    }

    #[test]
    fn what_is_no_code_is_refused() {
        let mut counts = [0; LONGEST];
        counts[0] = 3;
        assert!(Codes::new(&counts, &[0, 1, 2]).is_none(), "three of 1 bit");
        counts[0] = 1;
        assert!(Codes::new(&counts, &[0, 1]).is_none(), "a symbol too many");
    }
}
