//! The means of a component's blocks, each coded as a difference from the one before.

use super::bits::Bits;
use super::damage::{Damage, NO_CODE, TOO_BRIGHT};
use crate::huffman::Codes;

pub(super) struct Means<'a> {
    pub(super) codes: &'a Codes,
    /// Quantisation step.
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
