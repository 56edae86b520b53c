//! Answers as bytes: MessagePack with field names.
//!
//! It describes itself, so that values that leave out empty fields (as `world.toml`'s do) read back, and it keeps every
//! bit of a number. One value has one encoding, whose end follows from its content: encodings can be joined and hashed.

use std::io::Write;

use serde::{Serialize, de::DeserializeOwned};

use crate::StageError;

/// Writes a value's encoding; `stage` and `what` are named where it has none.
pub(crate) fn encode_into<T: Serialize + ?Sized>(
    writer: &mut impl Write,
    value: &T,
    stage: &'static str,
    what: &'static str,
) -> Result<(), StageError> {
    let mut serializer = rmp_serde::Serializer::new(writer).with_struct_map();
    value
        .serialize(&mut serializer)
        .map_err(|error| StageError::Encode {
            stage,
            what,
            why: error.to_string(),
        })
}

/// The encoding of a stage's output.
pub(crate) fn encode<T: Serialize>(output: &T, stage: &'static str) -> Result<Vec<u8>, StageError> {
    let mut bytes = Vec::new();
    encode_into(&mut bytes, output, stage, "the output")?;
    Ok(bytes)
}

/// The stage's output with this encoding.
pub(crate) fn decode<T: DeserializeOwned>(
    bytes: &[u8],
    stage: &'static str,
) -> Result<T, StageError> {
    rmp_serde::from_slice(bytes).map_err(|error| StageError::Decode {
        stage,
        why: error.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use derive_more::Display;
    use proptest::prelude::*;
    use serde::Deserialize;
    use values::Sentence;

    use super::*;

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Value {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        low: Option<f64>,
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        list: Vec<Kind>,
        map: BTreeMap<String, (u64, i64)>,
        text: String,
    }

    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    enum Kind {
        Unit,
        New(f32),
        Fields { x: f64, on: bool },
    }

    fn kind() -> impl Strategy<Value = Kind> {
        prop_oneof![
            Just(Kind::Unit),
            any::<f32>().prop_map(Kind::New),
            (any::<f64>(), any::<bool>()).prop_map(|(x, on)| Kind::Fields { x, on }),
        ]
    }

    proptest! {
        #[test]
        fn values_read_back_bit_by_bit(
            low in any::<Option<f64>>(),
            list in prop::collection::vec(kind(), 0..4),
            map in prop::collection::btree_map(any::<String>(), any::<(u64, i64)>(), 0..4),
            text in any::<String>(),
        ) {
            let value = Value { low, list, map, text };
            let bytes = encode(&value, "test").expect("plain data");
            let read: Value = decode(&bytes, "test").expect("own bytes");
            prop_assert_eq!(encode(&read, "test").expect("plain data"), bytes);
        }

        #[test]
        fn strange_bytes_are_an_error_and_no_crash(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let _ = decode::<Value>(&bytes, "test").map_err(|error| error.to_string());
        }
    }

    #[test]
    fn a_sentence_is_kept_as_its_finding_and_read_back_in_the_words_of_today() {
        #[derive(Display, Serialize, Deserialize)]
        #[display("{_0} strikes")]
        struct Before(usize);
        #[derive(Debug, Display, PartialEq, Serialize, Deserialize)]
        #[display("all of {_0} strikes")]
        struct Today(usize);
        let bytes = encode(&Sentence::from(Before(7)), "test").expect("plain data");
        let read: Sentence<Today> = decode(&bytes, "test").expect("own bytes");
        assert_eq!(read.finding(), Some(&Today(7)));
        assert_eq!(&*read, "all of 7 strikes");
        // A file for people has the words alone, and whoever read them keeps them.
        let json = serde_json::to_string(&read).expect("plain data");
        assert_eq!(json, "\"all of 7 strikes\"");
        let of_file: Sentence<Before> = serde_json::from_str(&json).expect("own text");
        let bytes = encode(&of_file, "test").expect("plain data");
        let kept: Sentence<Before> = decode(&bytes, "test").expect("own bytes");
        assert_eq!(
            (&*kept, kept.finding().is_none()),
            ("all of 7 strikes", true)
        );
    }

    #[test]
    fn numbers_that_are_not_finite_survive() {
        for value in [f64::NAN, f64::INFINITY, -0.0] {
            let bytes = encode(&value, "test").expect("plain data");
            assert_eq!(
                decode::<f64>(&bytes, "test").expect("own bytes").to_bits(),
                value.to_bits()
            );
        }
    }
}
