//! What is asked of a log, and how much memory it may take.

use values::FieldTopic;

/// A topic that is to be read.
#[derive(Clone, Copy, Debug)]
pub struct TopicRequest<'a> {
    /// Its name and field paths.
    pub topic: &'a FieldTopic,
    /// Paths of further numbers, at most [`MOST_MORE`](crate::MOST_MORE); a message need not have them.
    pub more: &'a [String],
    /// Whether a log without it is an error.
    pub required: bool,
}

impl<'a> TopicRequest<'a> {
    /// A topic without which a log is an error.
    pub fn required(topic: &'a FieldTopic) -> Self {
        Self {
            topic,
            more: &[],
            required: true,
        }
    }
}

/// How large a file's parts may be, in bytes. One record is held at a time, and no chunk.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// A record as it stands in the file, chunks included.
    pub record: usize,
    /// A chunk when unpacked.
    pub chunk: usize,
    /// All schemas and channels together.
    pub schemas: usize,
    /// Damaged places that are listed.
    pub damage: usize,
}

impl Default for Limits {
    /// 64 MB for a record and for an unpacked chunk.
    fn default() -> Self {
        Self {
            record: 64 << 20,
            chunk: 64 << 20,
            schemas: 16 << 20,
            damage: 1000,
        }
    }
}
