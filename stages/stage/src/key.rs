//! What an answer depends on, as one hash.

use std::fmt;
use std::io::{self, Write};

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::{StageError, codec};

/// SHA-256 of all that an answer depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Key(pub [u8; 32]);

/// Raised when what goes into a key changes.
const SCHEMA: u32 = 1;

impl Key {
    /// The key of a stage's answer: name, version, engine, settings and input.
    pub fn of<S: Serialize, I: Serialize + ?Sized>(
        name: &'static str,
        version: u32,
        engine: &str,
        settings: &S,
        input: &I,
    ) -> Result<Self, StageError> {
        let mut hash = Hashing(Sha256::new());
        codec::encode_into(
            &mut hash,
            &(SCHEMA, name, version, engine),
            name,
            "the version",
        )?;
        codec::encode_into(&mut hash, settings, name, "the settings")?;
        codec::encode_into(&mut hash, input, name, "the input")?;
        Ok(hash.key())
    }

    /// The key of one item among those of one stage, its settings and what is shared.
    pub fn of_item<I: Serialize>(name: &'static str, item: &I) -> Result<Self, StageError> {
        let mut hash = Hashing(Sha256::new());
        codec::encode_into(&mut hash, item, name, "an item")?;
        Ok(hash.key())
    }

    /// The key of plain bytes.
    pub fn of_bytes(parts: &[&[u8]]) -> Self {
        let mut hash = Sha256::new();
        for part in parts {
            hash.update(part);
        }
        Self(hash.finalize().into())
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&durable::hex(&self.0))
    }
}

struct Hashing(Sha256);

impl Hashing {
    fn key(self) -> Key {
        Key(self.0.finalize().into())
    }
}

impl Write for Hashing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_changes_with_each_thing_it_depends_on() {
        let key = |name, version, engine: &str, settings: f64, input: &[f64]| {
            Key::of(name, version, engine, &settings, input)
                .expect("plain data")
                .to_string()
        };
        let keys = [
            key("a", 1, "e", 0.5, &[1.0, 2.0]),
            key("b", 1, "e", 0.5, &[1.0, 2.0]),
            key("a", 2, "e", 0.5, &[1.0, 2.0]),
            key("a", 1, "f", 0.5, &[1.0, 2.0]),
            key("a", 1, "e", 0.25, &[1.0, 2.0]),
            key("a", 1, "e", 0.5, &[1.0, 2.5]),
            key("a", 1, "e", 0.5, &[1.0]),
        ];
        let distinct: std::collections::BTreeSet<_> = keys.iter().collect();
        assert_eq!(distinct.len(), keys.len());
        assert_eq!(keys[0], key("a", 1, "e", 0.5, &[1.0, 2.0]));
        assert_eq!(keys[0].len(), 64);
    }
}
