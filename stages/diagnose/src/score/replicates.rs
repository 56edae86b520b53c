//! Replicates of the residuals: what chance gains.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};

use super::columns::RandomColumns;

/// Residuals drawn, and flips. With 299 drawn, a probability below 1 % is at most one of them beyond.
pub(crate) const DRAWN: usize = 299;
pub(crate) const FLIPPED: usize = 499;

/// How many residuals are drawn, and how many times signs are flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Replicates {
    pub(crate) drawn: usize,
    pub(crate) flipped: usize,
    pub(crate) seed: u64,
}

impl Replicates {
    /// No replicates: scores alone.
    pub(crate) const NONE: Self = Self {
        drawn: 0,
        flipped: 0,
        seed: 0,
    };
}

/// Coefficients of the random columns in each replicate, the same for all strikes.
pub(super) fn common_heights(random: &[&RandomColumns], replicates: Replicates) -> DMatrix<f64> {
    let scales: Vec<f64> = random
        .iter()
        .flat_map(|columns| vec![columns.variance.sqrt(); columns.count()])
        .collect();
    let mut stream = ChaCha8Rng::seed_from_u64(replicates.seed);
    stream.set_stream(u64::MAX);
    DMatrix::from_fn(scales.len(), replicates.drawn, |k, _| {
        let normal: f64 = StandardNormal.sample(&mut stream);
        scales[k] * normal
    })
}

/// A row for each strike, a column for each flip: 1 or −1.
pub(crate) fn signs(strikes: usize, replicates: Replicates) -> DMatrix<f64> {
    let mut stream = ChaCha8Rng::seed_from_u64(replicates.seed);
    stream.set_stream(u64::MAX - 1);
    DMatrix::from_fn(strikes, replicates.flipped, |_, _| {
        if stream.random::<bool>() { 1.0 } else { -1.0 }
    })
}

/// Factors on drawn scores for the scatter being estimated from as many strikes, less the values fitted to them: scores over it follow Student's t.
pub(super) fn studentised(strikes: usize, fitted: usize, count: usize, seed: u64) -> Vec<f64> {
    let freedom = strikes.saturating_sub(fitted).max(1) as f64;
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    stream.set_stream(u64::MAX - 2);
    let Ok(distribution) = ChiSquared::new(freedom) else {
        return vec![1.0; count];
    };
    (0..count)
        .map(|_| (freedom / distribution.sample(&mut stream)).sqrt())
        .collect()
}
