//! How repeats of one command scatter, for the noise floor: as far as the diagnosis measured, or as identified where there is none.

use judge::Noise;
use values::Rig;
use world::World;

use crate::results::Worlds;

/// Seconds of rest over which ingestion averages a position, about.
const REST: f64 = 0.3;

/// Beside the world that will be used.
pub fn noise(rig: &Rig, worlds: &Worlds) -> Noise {
    let gap = worlds.found().map(|found| &found.diagnosis.gap);
    Noise {
        measured: gap.map(|gap| gap.noise_floor),
        sessions: gap.map_or(0.0, |gap| gap.sessions),
        ..identified(rig, &worlds.used().1.world)
    }
}

pub fn identified(rig: &Rig, world: &World) -> Noise {
    Noise::of(&world.scatter, rig.camera.rate * REST)
}
