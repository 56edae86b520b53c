//! What an arm delivers in place of a command, where strikes showed it and no effect explains it.

use values::Command;

/// A correction of what the arm delivers, learnt from strikes: it acts after the world's effects and before the impact.
pub trait Delivery: Send + Sync {
    /// What is delivered (m/s, rad) for the command that was sent; `by_effects` gives what the world's effects alone would deliver for
    /// a command.
    fn deliver(&self, commanded: Command, by_effects: &dyn Fn(Command) -> Command) -> Command;
}

/// The arm delivers what it is commanded, whatever the world's effects make of a command: a solve then answers with the launch that a
/// path needs.
#[derive(Clone, Copy, Debug, Default)]
pub struct AsCommanded;

impl Delivery for AsCommanded {
    fn deliver(&self, commanded: Command, _by_effects: &dyn Fn(Command) -> Command) -> Command {
        commanded
    }
}
