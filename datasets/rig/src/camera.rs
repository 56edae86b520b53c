//! The camera: frames at a rate that is not quite even, some lost, each centroid with noise.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use values::Point;

use crate::CameraTruth;
use crate::disturbance::Disturbance;

/// Two stamps are at least this far apart, in s.
const SHORTEST_INTERVAL: f64 = 1e-4;

/// One frame: its stamp (s), when it was exposed (s), and what centroid was found (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub time: f64,
    pub exposed: f64,
    pub centroid: Point,
}

/// Films from one time to another (s); `seen` is the centroid without noise at a time.
///
/// The stamp is that of the exposure, jitter included, as of a camera that is triggered by software and stamps in hardware.
/// Errors of stamps and noise of other kinds come from `disturbance`; stamps stay in order, as a driver gives them.
pub(crate) fn film(
    camera: &CameraTruth,
    (rate, noise): (f64, f64),
    (from, to): (f64, f64),
    random: &mut ChaCha8Rng,
    disturbance: &mut Disturbance,
    seen: impl Fn(f64) -> Point,
) -> Vec<Frame> {
    let period = 1.0 / rate;
    let phase: f64 = random.random();
    let count = ((to - from) / period - phase).max(0.0) as usize;
    let mut frames = Vec::with_capacity(count + 1);
    for k in 0..=count {
        // Every frame draws the same numbers whether or not it is lost, so that losing one changes no other.
        let [jitter, x, y]: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(random));
        let lost = random.random::<f64>() < camera.dropped;
        // Within half a period, lest two frames swap.
        let jitter = (jitter * camera.jitter).clamp(-0.45 * period, 0.45 * period);
        let time = from + (phase + k as f64) * period + jitter;
        let error = disturbance.frame(Point::new(x, y), noise, time);
        let late = disturbance.stamp_error();
        let exposed = time + disturbance.readout(seen(time));
        let there = seen(exposed);
        if lost || disturbance.loses(there, time) {
            continue;
        }
        let mut stamp = time;
        if disturbance.has_stamp_errors() {
            let last = frames.last().map_or(0.0, |frame: &Frame| frame.time);
            stamp = disturbance
                .reported_stamp(time + late)
                .max(last + SHORTEST_INTERVAL);
        }
        frames.push(Frame {
            time: stamp,
            exposed,
            centroid: disturbance.reported(there + error),
        });
    }
    frames
}
