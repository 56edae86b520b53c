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
            let fits = next & BLOCK == 0;
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
    codes: &'a Codes,
    /// The mean before, and the greatest, in quantisation steps.
    mean: i32,
    greatest: i32,
}

impl<'a> Means<'a> {
    /// Means in so large steps.
    pub(super) fn new(codes: &'a Codes, step: i32) -> Self {
        /// The greatest mean of pixels from -128 to 127, in eighths (T.81, A.3.3), to a step.
        const BRIGHTEST: i32 = 8 * 128;
        Self {
            codes,
            mean: 0,
            greatest: BRIGHTEST
                .checked_div(step)
                .map_or(i32::MAX, |most| most + 1),
        }
    }

    /// All begins anew.
    pub(super) fn restart(&mut self) {
        self.mean = 0;
    }

    /// Reads the mean of a block.
    // Within the loop over blocks, the bits stay in registers.
    #[inline(always)]
    pub(super) fn check(&mut self, bits: &mut Bits<'_>) -> Result<(), Damage> {
        /// Most bits of a mean's difference (T.81, F.1.2.1).
        const LARGEST: u8 = 11;
        bits.fill()?;
        let (size, length) = self.codes.first(bits.buffer).ok_or(NO_CODE)?;
        if size > LARGEST {
            return Err(NO_CODE);
        }
        bits.drop(length);
        self.mean += bits.take_signed(size.into());
        if self.mean.abs() > self.greatest {
            return Err(TOO_BRIGHT);
        }
        Ok(())
    }
}
