//! A scan's data, from one restart marker to the next.

use super::baseline::Blocks;
use super::bits::{CUT, Damage, ORDER, check_units, gather};
use super::progressive::Pass;

/// The first and the last restart marker's second byte; they follow one another in a circle.
const RESTARTS: [u8; 2] = [0xd0, 0xd7];

/// What a scan's units are made of.
pub(super) enum Scan<'a> {
    /// All coefficients, for each component.
    Baseline(Vec<Blocks<'a>>),
    Progressive(Pass<'a>),
}

impl Scan<'_> {
    /// Checks data that begin at `at` and hold so many units, with a marker behind each `restarts` of them (0 for none), and gives where they
    /// end. `bytes` is memory to work in.
    pub(super) fn check(
        mut self,
        data: &[u8],
        mut at: usize,
        mut left: usize,
        restarts: usize,
        bytes: &mut Vec<u8>,
    ) -> Result<usize, Damage> {
        let [first, last] = RESTARTS;
        let mut expected = first;
        loop {
            let end = gather(data, at, bytes).ok_or(CUT)?;
            let units = if restarts > 0 {
                left.min(restarts)
            } else {
                left
            };
            self.check_units(units, bytes)?;
            left -= units;
            let found = data.get(end + 1).copied().unwrap_or_default();
            match (left, (first..=last).contains(&found)) {
                (0, false) => return Ok(end),
                (1.., true) if found == expected => {}
                (1.., false) => return Err(CUT),
                _ => return Err(ORDER),
            }
            at = end + 2;
            expected = if found == last { first } else { found + 1 };
        }
    }

    /// Checks the units up to a marker, from which on all begins anew.
    fn check_units(&mut self, units: usize, bytes: &[u8]) -> Result<(), Damage> {
        match self {
            Self::Baseline(components) => {
                check_units(bytes, units, |bits| {
                    components
                        .iter_mut()
                        .try_for_each(|blocks| blocks.check(bits))
                })?;
                for blocks in components {
                    blocks.means.restart();
                }
                Ok(())
            }
            Self::Progressive(pass) => {
                check_units(bytes, units, |bits| pass.check(bits))?;
                pass.restart()
            }
        }
    }
}
