//! JSON messages: one pass over the text, keeping nothing but the wanted numbers.

use std::borrow::Cow;
use std::fmt;

use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::message::{DecodeError, Number, Raw};
use crate::path::{FieldTree, Leaf, stamp_leaf};

/// Reads one message. `null`, and the bare `NaN` and `Infinity` that some writers put out, are read as not finite.
pub(super) fn decode(want: &FieldTree, data: &[u8], raw: &mut Raw) -> Result<(), DecodeError> {
    match parse(want, data, raw) {
        Err(_) if has_bare_words(data) => {
            *raw = Raw::default();
            parse(want, &quote_bare_words(data), raw)
        }
        other => other,
    }
    .map_err(|error| {
        DecodeError::Malformed(format!(
            "it is not the JSON that its fields ask for: {error}"
        ))
    })
}

fn parse(want: &FieldTree, data: &[u8], raw: &mut Raw) -> Result<(), serde_json::Error> {
    let mut deserializer = serde_json::Deserializer::from_slice(data);
    Node { want, raw }.deserialize(&mut deserializer)?;
    deserializer.end()
}

const BARE_WORDS: [&[u8]; 3] = [b"NaN", b"-Infinity", b"Infinity"];

fn has_bare_words(data: &[u8]) -> bool {
    BARE_WORDS
        .iter()
        .any(|word| data.windows(word.len()).any(|window| window == *word))
}

/// The text with `NaN` and `Infinity` outside of strings put in quotes, which makes it JSON.
fn quote_bare_words(data: &[u8]) -> Vec<u8> {
    let mut quoted = Vec::with_capacity(data.len() + 8);
    let (mut at, mut in_string) = (0, false);
    while let Some(&byte) = data.get(at) {
        let word = BARE_WORDS
            .iter()
            .find(|word| !in_string && data[at..].starts_with(word));
        if let Some(word) = word {
            quoted.push(b'"');
            quoted.extend_from_slice(word);
            quoted.push(b'"');
            at += word.len();
            continue;
        }
        quoted.push(byte);
        match byte {
            b'\\' if in_string => {
                quoted.extend(data.get(at + 1));
                at += 1;
            }
            b'"' => in_string = !in_string,
            _ => {}
        }
        at += 1;
    }
    quoted
}

/// A value of which something is wanted.
struct Node<'a> {
    want: &'a FieldTree,
    raw: &'a mut Raw,
}

impl Node<'_> {
    fn set<E: Error>(self, number: Number) -> Result<(), E> {
        if self.want.leaves.is_empty() {
            return Err(E::custom("a number stands where fields are wanted"));
        }
        self.raw.set(&self.want.leaves, number);
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Node<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Node<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the wanted fields")
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<(), E> {
        self.set(Number::Integer(number.into()))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<(), E> {
        self.set(Number::Integer(number.into()))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<(), E> {
        self.set(Number::Float(number))
    }

    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.set(Number::Float(f64::NAN))
    }

    /// Protobuf's JSON writes 64-bit integers and NaN as text.
    fn visit_str<E: Error>(self, text: &str) -> Result<(), E> {
        if self.want.is_text() {
            self.raw.text = Some(text.into());
            return Ok(());
        }
        let integer = text
            .parse::<i64>()
            .map(|integer| Number::Integer(integer.into()));
        let number = integer.or_else(|_| text.parse::<f64>().map(Number::Float));
        self.set(number.map_err(|_| E::custom("a text stands where a number is wanted"))?)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let is_stamp = self.want.leaves.contains(&Leaf::Stamp);
        if self.want.fields.is_empty() && !is_stamp {
            return Err(A::Error::custom(
                "an object stands where a number is wanted",
            ));
        }
        while let Some(Key(key)) = map.next_key()? {
            let part = stamp_leaf(&key).filter(|_| is_stamp).map(FieldTree::leaf);
            let named = self.want.fields.iter().find(|(name, _)| *name == key);
            let named = named.map(|(_, want)| want);
            match part.as_ref().or(named) {
                Some(want) => map.next_value_seed(Node {
                    want,
                    raw: self.raw,
                })?,
                None => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<(), A::Error> {
        if self.want.elements.is_empty() {
            return Err(A::Error::custom(
                "an array stands where a number or object is wanted",
            ));
        }
        for index in 0.. {
            let mut elements_wanted = self.want.elements.iter();
            let more = match elements_wanted.find(|(wanted, _)| *wanted == index) {
                Some((_, want)) => elements
                    .next_element_seed(Node {
                        want,
                        raw: self.raw,
                    })?
                    .is_some(),
                None => elements.next_element::<IgnoredAny>()?.is_some(),
            };
            if !more {
                break;
            }
        }
        Ok(())
    }
}

/// A key, borrowed where it holds no escape.
#[derive(Deserialize)]
struct Key<'a>(#[serde(borrow)] Cow<'a, str>);

#[cfg(test)]
mod tests {
    use values::FieldTopic;

    use super::super::{Decoder, Fields};
    use super::*;

    fn topic(x: &str) -> FieldTopic {
        FieldTopic {
            name: "/t".into(),
            stamp: "header.stamp".into(),
            x: x.into(),
            y: "point.y".into(),
        }
    }

    fn read(x: &str, text: &str) -> Result<Fields, DecodeError> {
        Decoder::compile("json", None, &topic(x))
            .expect("compiles")
            .decode(text.as_bytes())
    }

    #[test]
    fn stamps_come_in_many_forms() {
        for (stamp, nanoseconds) in [
            (r#"{"sec": 12, "nanosec": 5}"#, 12_000_000_005),
            (r#"{"nsecs": 5, "secs": 12}"#, 12_000_000_005),
            (r#"{"seconds": "12", "nanos": 5}"#, 12_000_000_005),
            ("12000000005", 12_000_000_005),
            ("12.5", 12_500_000_000),
            ("-1.5", -1_500_000_000),
        ] {
            let text = format!(
                r#"{{"header": {{"frame": ["{{"], "stamp": {stamp}}}, "point": {{"x": 1, "y": -2.5}}}}"#
            );
            let expected = Fields {
                stamp: Some(nanoseconds),
                x: 1.0,
                y: -2.5,
            };
            assert_eq!(read("point.x", &text), Ok(expected), "{stamp}");
        }
        let unstamped = read("point.x", r#"{"point": {"x": 1, "y": 2}}"#).expect("decodes");
        assert_eq!(unstamped.stamp, None);
    }

    #[test]
    fn a_text_is_read_where_it_is_one() {
        let (topic, more) = (topic("point.x"), ["point.z".to_owned()]);
        let decoder = Decoder::compile_with("json", None, &topic, &more, Some("header.frame_id"));
        let decoder = decoder.expect("compiles");
        for (header, z, text) in [
            (r#"{"frame_id": "table"}"#, "0.02", Some("table")),
            (r#"{"frame_id": ""}"#, "0.02", Some("")),
            (r#"{"frame_id": 7}"#, "0.02", None),
            (r#"{"frame_id": null}"#, "0.02", None),
            ("{}", "null", None),
        ] {
            let message =
                format!(r#"{{"header": {header}, "point": {{"x": 1, "y": 2, "z": {z}}}}}"#);
            let (_, more, read) = decoder.decode_with(message.as_bytes()).expect("is read");
            assert_eq!(read.as_deref(), text, "{message}");
            assert!(
                more[0] == 0.02 || z == "null" && more[0].is_nan(),
                "{message}"
            );
        }
    }

    #[test]
    fn elements_of_arrays_can_be_wanted() {
        let text = r#"{"poses": [[7], {"p": [1, 2.5, 3]}, 4], "point": {"y": 0}}"#;
        assert_eq!(read("poses[1].p[1]", text).map(|fields| fields.x), Ok(2.5));
        assert_eq!(read("poses[9].p[1]", text), Err(DecodeError::Absent("x")));
    }

    #[test]
    fn what_is_not_finite_is_read_as_such() {
        for (x, negative) in [
            ("NaN", false),
            ("null", false),
            ("-Infinity", true),
            (r#""NaN""#, false),
        ] {
            let text = format!(r#"{{"note": "a \" NaN", "point": {{"x": {x}, "y": 0}}}}"#);
            let x = read("point.x", &text).expect("decodes").x;
            assert!(!x.is_finite() && (x < 0.0) == negative, "{text}");
        }
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let deep = format!(
            r#"{{"point": {}1{}}}"#,
            "[".repeat(100_000),
            "]".repeat(100_000)
        );
        for text in [
            "",
            "{",
            "[1]",
            "3",
            r#"{"point": 3}"#,
            r#"{"point": {"x": {}, "y": 1}}"#,
            r#"{"point": {"x": "a"}}"#,
            &deep,
        ] {
            assert!(
                read("point.x", text).is_err(),
                "{}",
                &text[..text.len().min(40)]
            );
        }
    }
}
