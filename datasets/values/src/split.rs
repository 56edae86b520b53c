//! Which strikes learn and which judge.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

crate::named! {
    /// The part a strike plays; the paper's 90:10, twice.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Split {
        /// Fits parameters and weights (81 %).
        Train = "train",
        /// Chooses when to stop training (9 %).
        Validation = "validation",
        /// Judges, and takes no other part (10 %).
        Test = "test",
    }
}

impl Split {
    /// The split of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|split| split.name() == name)
    }
}

/// The split of a strike, from its id and the seed alone: it never changes sides as data grows.
pub fn split_of(strike_id: &str, seed: u64) -> Split {
    let digest = Sha256::new()
        .chain_update(seed.to_le_bytes())
        .chain_update(strike_id)
        .finalize();
    let per_mille =
        |bytes: &[u8]| (u32::from(bytes[0]) * 256 + u32::from(bytes[1])) * 1000 / 65_536;
    if per_mille(&digest[0..2]) < 100 {
        Split::Test
    } else if per_mille(&digest[2..4]) < 100 {
        Split::Validation
    } else {
        Split::Train
    }
}

/// How often a strike stays where strikes are halved by lot: 0 for half of all, 1 for a quarter, and so on. By its id alone: what it was
/// made for, or when, has no part.
pub fn halvings(strike_id: &str) -> u32 {
    let digest = Sha256::new()
        .chain_update("halvings")
        .chain_update(strike_id)
        .finalize();
    let lot = digest
        .iter()
        .take(8)
        .fold(0, |lot, byte| lot << 8 | u64::from(*byte));
    lot.trailing_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_are_ninety_to_ten_twice() {
        let count = |split| {
            (0..20_000)
                .filter(|i| split_of(&format!("{i:x}"), 7) == split)
                .count()
        };
        assert!((1_850..2_150).contains(&count(Split::Test)));
        assert!((1_650..1_950).contains(&count(Split::Validation)));
    }

    #[test]
    fn a_strike_keeps_its_side_and_another_seed_deals_anew() {
        assert_eq!(split_of("a1", 1), split_of("a1", 1));
        assert!((0..100).any(|i| split_of(&i.to_string(), 1) != split_of(&i.to_string(), 2)));
    }
}
