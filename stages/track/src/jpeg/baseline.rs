//! Blocks of a baseline JPEG: a mean, and the other coefficients up to the block's end.

use super::bits::Bits;
use super::damage::{Damage, NO_CODE, TOO_LONG};
use super::means::Means;
use crate::huffman::{BLOCK, Codes, END};

/// A component in a scan.
pub(super) struct Blocks<'a> {
    /// In a unit.
    pub(super) count: usize,
    pub(super) means: Means<'a>,
    pub(super) codes: &'a Codes,
}

impl Blocks<'_> {
    /// Checks the blocks of a unit.
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
