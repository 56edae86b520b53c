//! Which strike it is.

/// Which strike it is: what effects that wear or differ by session depend on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StrikeIndex {
    /// Number of the session (log), from 0.
    pub session: usize,
    /// Number of strikes made before it in all sessions.
    pub order: usize,
}
