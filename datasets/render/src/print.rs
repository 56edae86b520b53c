//! A flat print on the table, as a camera sees it.

use crate::light::byte;
use crate::noise::{bells, noisy};
use crate::optics::Rays;
use crate::{Optics, Picture};

impl Picture {
    /// A picture of a table that gives so much light (0 to 1) at each of its points (m): the square of `across` rays for each pixel, and
    /// noise of this standard deviation of a byte.
    pub fn of_print(
        optics: &Optics,
        light: &dyn Fn([f64; 2]) -> f64,
        across: usize,
        noise: f64,
        seed: u64,
    ) -> Self {
        let (width, height) = (optics.width, optics.height);
        let rays = Rays::of(optics);
        let share = |i: usize| (i as f64 + 0.5) / across as f64;
        let mut bytes = Vec::with_capacity(3 * width * height);
        for row in 0..height {
            for column in 0..width {
                let seen = (0..across * across).map(|k| {
                    let ray = rays.through(column, row, share(k % across), share(k / across));
                    light(optics.on_table(ray))
                });
                let mean = seen.sum::<f64>() / (across * across) as f64;
                bytes.extend([byte(mean); 3]);
            }
        }
        Self {
            width,
            height,
            rgb: noisy(&bytes, noise, &bells(), seed),
        }
    }
}
