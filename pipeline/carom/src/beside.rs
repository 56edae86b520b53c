//! A measured track beside a simulated one.

use values::Strike;
use world::{Simulated, Simulator};

/// A strike as a world simulates it, and how long before its first frame the tip touched the object, in s. A track that ends before rest is simulated
/// up to there, for in that world the object may never rest; none where it does not rest as the measured one did.
pub fn simulate(strike: &Strike, simulator: &Simulator) -> Option<(Simulated, f64)> {
    let until = strike.ends().unwrap_or(f64::INFINITY);
    let mut worker = simulator.worker();
    let simulated = worker.strike_until(strike.initial, strike.command, &strike.conditions, until);
    let simulated = simulated.ok()?;
    let before = since_touch(strike, &simulated);
    Some((simulated, before))
}

/// How long before the first frame the tip touched the object, in s: within one frame, where the simulation comes nearest to the track.
fn since_touch(strike: &Strike, simulated: &Simulated) -> f64 {
    const PARTS: u32 = 8;
    let track = &strike.track;
    let frame = track.t.get(1).map_or(0.0, |second| second - track.t[0]);
    let far = |before: f64| {
        let squares = (0..track.len()).map(|i| {
            let apart = track.point(i).distance(simulated.at(track.t[i] + before));
            apart * apart
        });
        squares.sum::<f64>()
    };
    let tries = (0..=PARTS).map(|part| frame * f64::from(part) / f64::from(PARTS));
    let nearest = tries.min_by(|a, b| far(*a).total_cmp(&far(*b)));
    nearest.unwrap_or(0.0)
}
