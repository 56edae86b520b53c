//! The camera: frames at a rate that is not quite even, some lost, each centroid with noise.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use values::Point;

use crate::CameraTruth;

/// One frame: when it was exposed (s) and what centroid was found (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub time: f64,
    pub centroid: Point,
}

/// Films from one time to another (s); `seen` is the centroid without noise at a time.
///
/// The stamp is that of the exposure, jitter included, as of a camera that is triggered by software and stamps in hardware.
pub(crate) fn film(
    camera: &CameraTruth,
    (rate, noise): (f64, f64),
    (from, to): (f64, f64),
    random: &mut ChaCha8Rng,
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
        if !lost {
            frames.push(Frame {
                time,
                centroid: seen(time) + Point::new(x, y) * noise,
            });
        }
    }
    frames
}
