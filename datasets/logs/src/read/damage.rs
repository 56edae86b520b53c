//! Places where a file is not whole.

/// A place where a file is not whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Byte of the file.
    pub offset: u64,
    /// How much it takes.
    pub extent: Extent,
    /// What was found.
    pub why: String,
}

/// How much of a file a damage takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// One chunk or record.
    Part,
    /// Everything after: the file is cut off or cannot be followed further.
    Rest,
    /// Some bytes of the messages that no chunk's CRC covers; which ones is not known.
    Unlocated,
    /// Nothing but the index and statistics behind the messages.
    Index,
}
