//! What comes out of a log.

use super::damage::Damage;
use crate::More;

/// A stamped pair of coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Nanoseconds on the log's clock: the message's stamp, or the log time where it has none.
    pub stamp: i64,
    /// First coordinate, in the message's unit.
    pub x: f64,
    /// Second coordinate, in the message's unit.
    pub y: f64,
}

/// What comes out of a log, in the order of the file.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A message of the wanted topic with this index.
    Sample(usize, Sample),
    /// The same of a topic of which further numbers are wanted.
    Extended(usize, Sample, More),
    /// Messages are lost between those before and those after.
    Lost(&'a Damage),
}
