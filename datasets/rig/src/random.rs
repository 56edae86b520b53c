//! Streams of random numbers.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What random numbers are for: each strike has a stream of its own for each purpose, so that order changes nothing.
///
/// A plan is drawn at order 0 alone, so that its streams of later orders serve the random walk.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    Plan,
    Walk,
    Launch,
    Camera,
    Noise,
}

impl Purpose {
    fn number(self) -> u64 {
        match self {
            Self::Plan | Self::Walk => 0,
            Self::Launch => 1,
            Self::Camera => 2,
            Self::Noise => 3,
        }
    }
}

/// The stream of a purpose, for the strike after so many.
pub(crate) fn random(seed: u64, purpose: Purpose, order: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(order as u64 * 4 + purpose.number());
    random
}

/// Which strike it is: what effects that wear or differ by session depend on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StrikeIndex {
    /// Number of the session (log), from 0.
    pub session: usize,
    /// Number of strikes made before it in all sessions.
    pub order: usize,
}
