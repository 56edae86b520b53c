//! Lists of numbers that have exactly as many as they must: a longer one is no list with something to spare.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Reads a key that may be missing.
pub(crate) fn deserialize<'de, D, T, const N: usize>(
    deserializer: D,
) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de> + Copy + Default,
{
    Ok(Option::<Exact<T, N>>::deserialize(deserializer)?.map(|exact| exact.0))
}

/// Writes what it is.
pub(crate) fn serialize<S: Serializer, T: Serialize>(
    numbers: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    numbers.serialize(serializer)
}

/// Reads as many as it holds.
pub(crate) struct Exact<T, const N: usize>(pub(crate) [T; N]);

impl<'de, T: Deserialize<'de> + Copy + Default, const N: usize> Deserialize<'de> for Exact<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(N, Numbers(PhantomData))
    }
}

struct Numbers<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Copy + Default, const N: usize> Visitor<'de> for Numbers<T, N> {
    type Value = Exact<T, N>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{N} numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<Self::Value, A::Error> {
        let mut exact = [T::default(); N];
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
