//! A strike that is requested of a collection.

use values::{Command, Point};

/// From where the object is to be struck, and with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrikeRequest {
    /// Where the object is to lie, in m.
    pub from: Point,
    /// What it is to be struck with.
    pub command: Command,
}
