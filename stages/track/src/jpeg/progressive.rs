//! Blocks of a progressive JPEG: each scan brings a part of all blocks' coefficients, or one more bit of those that are known.
//!
//! Source: ITU-T T.81, annex G.

use super::baseline::Means;
use super::bits::{Bits, Damage, LEFT, NO_CODE, TOO_LONG};
use crate::huffman::Codes;

/// What a scan brings.
pub(super) enum Pass<'a> {
    /// The upper bits of the means of a unit's blocks, so many of each component.
    Means(Vec<(usize, Means<'a>)>),
    /// The next bit of the means of a unit's blocks, of all components together.
    MeansBit(usize),
    Coefficients(Coefficients<'a>),
}

/// Some coefficients of one component's blocks.
pub(super) struct Coefficients<'a> {
    pub(super) codes: &'a Codes,
    /// The first and the last, by their number in the block.
    pub(super) band: [u32; 2],
    /// Whether the scan brings the next bit of those that are known, and others that become known by it.
    pub(super) refines: bool,
    /// For each block, which coefficients are not zero as far as is known, one bit each; those of this scan not yet passed.
    pub(super) known: std::slice::IterMut<'a, u64>,
    /// Blocks to come that have no new coefficients.
    pub(super) empty: u32,
}

impl Pass<'_> {
    pub(super) fn check(&mut self, bits: &mut Bits<'_>) -> Result<(), Damage> {
        match self {
            Self::Means(components) => {
                for (count, means) in components {
                    for _ in 0..*count {
                        means.check(bits)?;
                    }
                }
                Ok(())
            }
            Self::MeansBit(blocks) => {
                for _ in 0..*blocks {
                    bits.fill()?;
                    bits.drop(1);
                }
                Ok(())
            }
            Self::Coefficients(coefficients) => coefficients.check(bits),
        }
    }

    /// Begins anew behind a restart marker, or ends.
    pub(super) fn restart(&mut self) -> Result<(), Damage> {
        match self {
            Self::Means(components) => {
                for (_, means) in components {
                    means.restart();
                }
                Ok(())
            }
            Self::Coefficients(Coefficients { empty: 1.., .. }) => Err(LEFT),
            Self::Coefficients(_) | Self::MeansBit(_) => Ok(()),
        }
    }
}

impl Coefficients<'_> {
    fn check(&mut self, bits: &mut Bits<'_>) -> Result<(), Damage> {
        let known = self.known.next().ok_or(LEFT)?;
        let [mut at, last] = self.band;
        if self.empty == 0 {
            while at <= last {
                bits.fill()?;
                let (symbol, length) = self.codes.first(bits.buffer).ok_or(NO_CODE)?;
                bits.drop(length);
                let (zeros, size) = (u32::from(symbol >> 4), u32::from(symbol & 15));
                if size == 0 && zeros < ZEROS {
                    self.empty = 1 << zeros;
                    if zeros > 0 {
                        self.empty += bits.take(zeros).cast_unsigned();
                    }
                    break;
                }
                if size > 0 {
                    if self.refines && size != 1 {
                        return Err(NO_CODE);
                    }
                    bits.drop(size);
                }
                at = if self.refines {
                    pass(*known, [at, last], zeros, bits)?
                } else {
                    at + zeros
                };
                if at > last {
                    return Err(TOO_LONG);
                }
                if size > 0 {
                    *known |= 1 << at;
                }
                at += 1;
            }
        }
        if self.empty > 0 {
            self.empty -= 1;
            if self.refines {
                pass(*known, [at, last], u32::MAX, bits)?;
            }
        }
        Ok(())
    }
}

/// Zeros of the symbol that stands for sixteen of them; with fewer and no value, it stands for blocks without new coefficients.
const ZEROS: u32 = 15;

/// Passes so many zeros and the known coefficients between them, each of which has a bit; gives where the next zero is.
fn pass(
    known: u64,
    [mut at, last]: [u32; 2],
    mut zeros: u32,
    bits: &mut Bits<'_>,
) -> Result<u32, Damage> {
    while at <= last {
        if (known >> at) & 1 == 1 {
            bits.fill()?;
            bits.drop(1);
        } else if zeros == 0 {
            break;
        } else {
            zeros -= 1;
        }
        at += 1;
    }
    Ok(at)
}
