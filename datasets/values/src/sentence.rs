//! What was found, as a stage hands it on, and as a person reads it.

use std::borrow::Borrow;
use std::fmt::{self, Display, Formatter};
use std::ops::Deref;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A finding and the sentence that says it. Caches hold the finding, files that people read (JSON) the sentence: to reword one changes no
/// cached answer. One that was read from such a file has its words alone.
#[derive(Clone, Debug)]
pub struct Sentence<F> {
    finding: Option<F>,
    words: String,
}

impl<F> Sentence<F> {
    /// The finding; none where the sentence was read from a file.
    pub fn finding(&self) -> Option<&F> {
        self.finding.as_ref()
    }
}

impl<F: Display> From<F> for Sentence<F> {
    fn from(finding: F) -> Self {
        Self {
            words: finding.to_string(),
            finding: Some(finding),
        }
    }
}

impl<F> Deref for Sentence<F> {
    type Target = str;

    fn deref(&self) -> &str {
        &self.words
    }
}

impl<F> Borrow<str> for Sentence<F> {
    fn borrow(&self) -> &str {
        &self.words
    }
}

impl<F> Display for Sentence<F> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.pad(&self.words)
    }
}

/// Two sentences are equal where they read the same.
impl<F> PartialEq for Sentence<F> {
    fn eq(&self, other: &Self) -> bool {
        self.words == other.words
    }
}

impl<F: Serialize> Serialize for Sentence<F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match serializer.is_human_readable() {
            true => serializer.serialize_str(&self.words),
            false => {
                let words = self.finding.is_none().then_some(&self.words);
                (&self.finding, words).serialize(serializer)
            }
        }
    }
}

impl<'de, F: Display + Deserialize<'de>> Deserialize<'de> for Sentence<F> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            let words = String::deserialize(deserializer)?;
            return Ok(Self {
                finding: None,
                words,
            });
        }
        let (finding, words): (Option<F>, Option<String>) = Deserialize::deserialize(deserializer)?;
        let words = words
            .or_else(|| finding.as_ref().map(F::to_string))
            .unwrap_or_default();
        Ok(Self { finding, words })
    }
}
