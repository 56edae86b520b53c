//! What a diagnosis is made from.

use serde::{Deserialize, Serialize};
use values::{Rig, Strike};
use world::World;

/// The strikes, and the world that they are held against.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Input {
    /// The rig.
    pub rig: Rig,
    /// The identified world, without effects.
    pub world: World,
    /// Strikes in order of time; those of [`Split::Test`] judge the gap and take no other part.
    pub strikes: Vec<Strike>,
}
