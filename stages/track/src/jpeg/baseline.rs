//! Blocks of a baseline JPEG: a mean, coded as a difference from the one before, and the other coefficients up to the block's end.

use super::bits::{Bits, Damage, NO_CODE, TOO_BRIGHT, TOO_LONG};
use crate::huffman::{BLOCK, Codes, END};

pub(super) struct Blocks<'a> {
    pub(super) count: usize,
    pub(super) means: Means<'a>,
    pub(super) codes: &'a Codes,
}

impl Blocks<'_> {
    #[inline]
    pub(super) fn check(&mut self, bits: &mut Bits<'_>) -> Result<(), Damage> {
        for _ in 0..self.count {
            self.means.check(bits)?;
            self.coefficients(bits)?;
        }
        Ok(())
    }

    #[inline]
    fn coefficients(&self, bits: &mut Bits<'_>) -> Result<(), Damage> {
        let mut passed = 1;
        while passed < BLOCK {
            bits.fill()?;
            let many = self.codes.many(bits.buffer);
            let next = passed + u32::from(many.passed);
            // Where a symbol in them may end the block by filling it, they are gone through one by one.
            let fits = next < BLOCK || (END..END + BLOCK).contains(&next);
            if many.bits > 0 && fits {
                bits.drop(many.bits.into());
                passed = next;
                continue;
            }
            let one = self.codes.one(bits.buffer).ok_or(NO_CODE)?;
            bits.drop(one.bits.into());
            passed += u32::from(one.passed);
            if BLOCK < passed && passed < END {
                return Err(TOO_LONG);
            }
        }
        Ok(())
    }
}

pub(super) struct Means<'a> {
    pub(super) codes: &'a Codes,
    pub(super) step: i32,
    /// The mean before, in those steps.
    pub(super) mean: i32,
}

impl Means<'_> {
    /// Reads the mean of a block.
    #[inline]
    pub(super) fn check(&mut self, bits: &mut Bits<'_>) -> Result<(), Damage> {
        /// Most bits of a mean's difference, and the greatest mean of pixels from -128 to 127, in eighths (T.81, F.1.2.1 and A.3.3).
        const LARGEST: u8 = 11;
        const BRIGHTEST: i32 = 8 * 128;
        bits.fill()?;
        let (size, length) = self.codes.first(bits.buffer).ok_or(NO_CODE)?;
        if size > LARGEST {
            return Err(NO_CODE);
        }
        bits.drop(length);
        if size > 0 {
            let value = bits.take(size.into());
            let is_negative = value < 1 << (size - 1);
            self.mean += value - if is_negative { (1 << size) - 1 } else { 0 };
            if self.mean.abs().saturating_mul(self.step) > BRIGHTEST + self.step {
                return Err(TOO_BRIGHT);
            }
        }
        Ok(())
    }
}
