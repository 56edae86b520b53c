//! Questions about the ways: do strikes that slide over the same places need the same, however small these places are?

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};
use values::{Point, Strike, median};

use super::{
    projection::Basis,
    table::{HATS, Row},
};

/// Distance in m at which two places have little in common: some object's width.
const NEAR: f64 = 0.03;
/// Part of the greatest variance along a direction below which the direction is left out.
const LEAST: f64 = 1e-4;
/// Part of the covariance that must be its own beside a basis: where few commands are repeated, ways are these commands over again.
const OWN: f64 = 0.2;

/// Places along a way, in m.
pub(super) type Way = [Point; HATS];

/// Where strikes are expected to slide by their commands and starts alone: as far as others do at their speed, as the square of it, and turned from
/// the command as others are. Where a strike really slid holds the very scatter that is asked about.
pub(super) fn commanded(strikes: &[&Strike], rows: &[Row]) -> Vec<Way> {
    let of = |each: &dyn Fn(usize) -> f64| median((0..rows.len()).map(each).collect());
    let reach = of(&|i| rows[i].slide / strikes[i].command.speed.powi(2)).unwrap_or(0.0);
    let turned = of(&|i| angle_between(strikes[i].path().bearing(), strikes[i].command.angle));
    let way = |strike: &&Strike| {
        let length = reach * strike.command.speed.powi(2);
        let heading = strike.command.angle + turned.unwrap_or(0.0);
        std::array::from_fn(|k| {
            let gone = (k as f64 + 0.5) / HATS as f64 * length;
            strike.initial + Point::polar(gone, heading)
        })
    };
    strikes.iter().map(way).collect()
}

/// From one bearing to another, within half a turn.
fn angle_between(to: f64, from: f64) -> f64 {
    (to - from + PI).rem_euclid(TAU) - PI
}

/// How much of their ways strikes share, 1 where each is the other's (a Gaussian of the distance, mean over all pairs of fifths, relative to
/// each way with itself).
pub(super) fn shared(ways: &[Way]) -> DMatrix<f64> {
    let near = |a: &Way, b: &Way| -> f64 {
        let pairs = a
            .iter()
            .flat_map(|a| b.iter().map(move |b| a.distance(*b) / NEAR));
        pairs.map(|d| (-0.5 * d * d).exp()).sum()
    };
    let own: Vec<f64> = ways.iter().map(|way| near(way, way).sqrt()).collect();
    DMatrix::from_fn(ways.len(), ways.len(), |i, j| {
        near(&ways[i], &ways[j]) / (own[i] * own[j])
    })
}

/// Columns q whose Σ(qᵀe)² is the score of a part of e with this covariance, beside a basis (Wu et al. 2011, "SKAT"), scaled so that it
/// grows by the sum of squared weights where that part has variance 1; `whitened` is what a column of such a part becomes.
pub(super) fn score(
    covariance: &DMatrix<f64>,
    basis: &Basis,
    weight: f64,
    whitened: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> Vec<DVector<f64>> {
    let eigen = covariance.clone().symmetric_eigen();
    let greatest = eigen.eigenvalues.max();
    let kept = (0..eigen.eigenvalues.len()).filter(|k| eigen.eigenvalues[*k] > LEAST * greatest);
    let whole: Vec<DVector<f64>> = kept
        .map(|k| whitened(&(eigen.eigenvectors.column(k) * eigen.eigenvalues[k].sqrt())))
        .collect();
    let trace = |parts: &[DVector<f64>]| parts.iter().map(DVector::norm_squared).sum::<f64>();
    let all_of_it = trace(&whole);
    let parts: Vec<DVector<f64>> = whole.into_iter().map(|part| basis.off(part)).collect();
    if parts.is_empty() || trace(&parts) < OWN * all_of_it {
        return Vec::new();
    }
    let all = DMatrix::from_columns(&parts);
    let square = all.tr_mul(&all).norm_squared();
    if square <= 0.0 {
        return Vec::new();
    }
    let scale = (weight / square).sqrt();
    parts.into_iter().map(|part| part * scale).collect()
}
