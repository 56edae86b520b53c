//! A strike that is requested of a collection.

use std::time::Duration;

use values::{Command, Point};

use crate::Refusal;

/// From where the object is to be struck, and with what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrikeRequest {
    /// Where the object is to lie, in m.
    pub from: Point,
    /// What it is to be struck with.
    pub command: Command,
}

/// Progress of a collection, for its operator.
#[derive(Clone, Debug)]
pub enum CollectEvent {
    /// Where the object is to be put, in m.
    Put(StrikeRequest),
    /// What is waited for until the object lies ready.
    Waiting(String),
    /// The arm moves after this time: a person is told to step back, whatever else is not shown.
    StepBack(Duration),
    /// A strike that an earlier call began and kept no record of.
    Lost(String),
    /// A requested command that cannot be struck from where the object lies: it is left out.
    LeftOut(Refusal),
    /// A strike that can be used.
    Kept {
        /// Usable strikes so far.
        strikes: usize,
        /// A warning for the operator.
        warning: Option<String>,
    },
    /// A strike whose log cannot be used, and why.
    Useless(String),
}
