//! Random numbers of a sensor: quick, and the same for the same seed.

/// SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

/// Numbers of a normal distribution with standard deviation 1, four from each draw: sums of a byte's and a half's bits are bell-shaped
/// enough for a sensor, and their moments are those of a normal distribution up to the third.
pub(crate) fn bells() -> Vec<f32> {
    /// Number of entries: as many as two bytes can count.
    const COUNT: usize = 1 << 16;
    // The quantiles, by the sum of twelve uniforms of a fixed stream: shuffled by construction.
    let mut random = Random(20_261_122);
    (0..COUNT)
        .map(|_| {
            let sum: f64 = (0..12)
                .map(|_| random.next() as f64 / u64::MAX as f64)
                .sum();
            (sum - 6.0) as f32
        })
        .collect()
}

/// Bytes with noise of this standard deviation, rounded.
pub(crate) fn noisy(bytes: &[f32], noise: f64, bells: &[f32], seed: u64) -> Vec<u8> {
    let mut noisy = vec![0; bytes.len()];
    if noise > 0.0 {
        let (mut random, noise) = (Random(seed), noise as f32);
        for (to, four) in noisy.chunks_mut(4).zip(bytes.chunks(4)) {
            let draw = random.next();
            for (k, (to, byte)) in to.iter_mut().zip(four).enumerate() {
                let bell = bells[(draw >> (16 * k)) as usize & 0xffff];
                // The cast keeps to 0 and 255.
                *to = (byte + noise * bell + 0.5) as u8;
            }
        }
    } else {
        for (to, byte) in noisy.iter_mut().zip(bytes) {
            *to = (byte + 0.5) as u8;
        }
    }
    noisy
}
