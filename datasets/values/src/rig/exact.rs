//! Lists of numbers that have exactly as many as they must: a longer one is no list with something to spare.

use std::fmt;

use serde::de::{Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// Reads a key that may be missing.
pub(super) fn optional<'de, D: Deserializer<'de>, const N: usize>(
    deserializer: D,
) -> Result<Option<[f64; N]>, D::Error> {
    Ok(Option::<Exact<N>>::deserialize(deserializer)?.map(|exact| exact.0))
}

struct Exact<const N: usize>([f64; N]);

impl<'de, const N: usize> Deserialize<'de> for Exact<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(N, Numbers)
    }
}

struct Numbers<const N: usize>;

impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
    type Value = Exact<N>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{N} numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<Exact<N>, A::Error> {
        let mut exact = [0.0; N];
        for (index, number) in exact.iter_mut().enumerate() {
            *number = numbers
                .next_element()?
                .ok_or_else(|| A::Error::invalid_length(index, &self))?;
        }
        let mut count = N;
        while numbers.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        if count == N {
            Ok(Exact(exact))
        } else {
            Err(A::Error::invalid_length(count, &self))
        }
    }
}
