//! How repeats of one command scatter, for the noise floor: as far as the diagnosis measured, or as identified where there is none.

use judge::Noise;
use values::Rig;
use world::World;

use crate::results::Worlds;

/// Seconds of rest over which ingestion averages a position, about.
const REST: f64 = 0.3;

/// Difference of sessions, in m, below which they are alike.
const LEAST: f64 = 1e-4;

/// Beside the world that will be used.
pub fn noise(rig: &Rig, worlds: &Worlds) -> Noise {
    let gap = worlds.found().map(|found| &found.diagnosis.gap);
    Noise {
        measured: gap.map(|gap| gap.noise_floor),
        // Where they may differ by nothing, that is no estimate to widen claims by.
        sessions: gap.map_or(0.0, |gap| {
            let is_sure = gap.sessions_95[0] > LEAST;
            if is_sure { gap.sessions } else { 0.0 }
        }),
        ..identified(rig, &worlds.used().1.world)
    }
}

pub fn identified(rig: &Rig, world: &World) -> Noise {
    Noise::of(&world.scatter, rig.camera.rate * REST)
}
