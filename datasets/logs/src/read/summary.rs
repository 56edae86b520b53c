//! What was in a log.

use super::damage::{Damage, Extent};

/// Messages of one topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicCount {
    /// Its name.
    pub name: String,
    /// Its schema's name, empty for none.
    pub schema: String,
    /// Messages seen.
    pub messages: u64,
}

/// What was in a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Summary {
    /// SHA-256 of the whole file, in hex.
    pub sha256: String,
    /// Messages seen, over all topics.
    pub messages: u64,
    /// Every topic that the file has, by name.
    pub topics: Vec<TopicCount>,
    /// For each wanted topic, messages that could not be decoded and why the first could not.
    pub undecodable: Vec<(u64, String)>,
    /// For each wanted topic, whether its schema lacks the stamp, so that log times were taken.
    pub unstamped: Vec<bool>,
    /// Where the file is not whole; empty for a whole one, and of very many places the first ones and the end.
    pub damage: Vec<Damage>,
}

impl Summary {
    /// Whether messages after some place are missing.
    pub fn truncated(&self) -> bool {
        self.damage
            .iter()
            .any(|damage| damage.extent == Extent::Rest)
    }
}
