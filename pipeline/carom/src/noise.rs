//! How repeats of one command scatter, for the noise floor.
//!
//! Identification explains the tracks by parameters, a mean turn and launch scatter: what these cannot absorb (a gain of
//! the speed, a slope of the table) counts as scatter there, though it repeats. The residual model takes that away, so that what it
//! leaves (on strikes that it did not learn from, where there are enough) is the better estimate.

use evaluate::Noise;
use values::Rig;
use world::World;

use crate::results::WorldResults;

/// Seconds of rest over which ingestion averages a position, about.
const REST: f64 = 0.3;
/// Fewer strikes give no estimate of scatter.
const LEAST_STRIKES: usize = 10;

/// From what the residual model leaves of commands that it did not learn from, where these are enough; else as identified.
pub fn noise(rig: &Rig, of_world: &WorldResults) -> Noise {
    let identified = identified(rig, &of_world.world);
    let learned = of_world.learned.as_ref();
    let Some(learned) = learned.filter(|learned| learned.strikes >= LEAST_STRIKES) else {
        return identified;
    };
    let [speed, angle] = learned.scatter;
    Noise {
        speed: speed.min(identified.speed),
        angle: angle.min(identified.angle),
        // The error of a measured position is in the two above: each path is measured.
        position: 0.0,
    }
}

/// From the identified scatter.
pub fn identified(rig: &Rig, world: &World) -> Noise {
    Noise::of(&world.scatter, rig.camera.rate * REST)
}
