//! Questions about the ways: do strikes that slide over the same places need the same, however small these places are? Does what they need wave over the
//! table, as over planks, tiles or ruts?

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};
use values::{Point, Strike, median};

use super::projection::Basis;
use super::table::{HATS, Row, Wave};

/// Distance in m at which two places have little in common: some object's width.
const NEAR: f64 = 0.03;
/// Part of the greatest variance along a direction below which the direction is left out.
const LEAST: f64 = 1e-4;
/// Part of the covariance that must be its own beside a basis: where few commands are repeated, ways are these commands over again.
const OWN: f64 = 0.2;

/// The shortest and the longest wave that is asked about, in m: objects are as wide as the first, fields and smooth functions hold the second.
const WAVES: (f64, f64) = (0.08, 0.5);

/// Places along a way, in m.
pub(super) type Way = [Point; HATS];

/// Where strikes are expected to slide by their commands and starts alone: as far as others do at their speed, as the square of it, and turned from
/// the command as others are. Where a strike really slid holds the very scatter that is asked about.
pub(super) fn commanded(strikes: &[&Strike], rows: &[Row]) -> Vec<Way> {
    let of = |each: &dyn Fn(usize) -> f64| median((0..rows.len()).map(each).collect());
    let reach = of(&|i| rows[i].slide / strikes[i].command.speed.powi(2)).unwrap_or(0.0);
    let turned = of(&|i| {
        strikes[i]
            .path()
            .rotated(-strikes[i].command.angle)
            .bearing()
    });
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

/// Mean over each way of the cosine and of the sine of each plane wave over the table, as far apart as these ways tell them apart.
pub(super) fn waves(ways: &[Way]) -> Vec<Wave> {
    let extent = |of: fn(&Point) -> f64| {
        let places = ways.iter().flatten().map(of);
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        (high - low).max(WAVES.0)
    };
    let (x, y) = (extent(|p| p.x), extent(|p| p.y));
    let steps = |extent: f64| (2.0 * extent / WAVES.0).floor() as i32;
    let of = |i: i32, j: i32| Point::new(PI * f64::from(i) / x, PI * f64::from(j) / y);
    let numbers = (0..=steps(x)).flat_map(|i| (-steps(y)..=steps(y)).map(move |j| of(i, j)));
    let known = |number: &Point| {
        let length = TAU / number.norm().max(f64::MIN_POSITIVE);
        (WAVES.0..=WAVES.1).contains(&length) && (number.x > 0.0 || number.y > 0.0)
    };
    let of_ways = |number: Point| {
        let mean = |wave: fn(f64) -> f64| {
            let each = ways.iter().map(|way| {
                let whole = (way[HATS - 1] - way[0]) * (HATS as f64 / (HATS - 1) as f64);
                let half = 0.5 * number.dot(whole);
                let kept = if half == 0.0 { 1.0 } else { half.sin() / half };
                kept * wave(number.dot(way[HATS / 2]))
            });
            DVector::from_iterator(ways.len(), each)
        };
        [mean(f64::cos), mean(f64::sin)]
    };
    numbers.filter(known).map(of_ways).collect()
}

/// What the wave that explains most explains of each column of a matrix; none where a basis holds them all.
pub(super) fn most_explained(
    waves: impl Iterator<Item = Wave>,
    basis: &Basis,
    all: &DMatrix<f64>,
) -> Option<Vec<f64>> {
    let questions: Vec<Vec<DVector<f64>>> = waves.map(|wave| basis.beside(wave)).collect();
    let columns: Vec<DVector<f64>> = questions.iter().flatten().cloned().collect();
    if columns.is_empty() {
        return None;
    }
    // By a product of two matrices, which is blocked, where one by dot products is not.
    let products = DMatrix::from_columns(&columns).transpose() * all;
    let most = products.column_iter().map(|product| {
        let mut squares = product.iter().map(|p| p * p);
        let each = questions
            .iter()
            .map(|wave| squares.by_ref().take(wave.len()).sum::<f64>());
        each.fold(0.0, f64::max)
    });
    Some(most.collect())
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

/// Columns whose products with themselves, summed, are a covariance.
pub(super) fn root(covariance: DMatrix<f64>) -> Vec<DVector<f64>> {
    let eigen = covariance.symmetric_eigen();
    let least = LEAST * eigen.eigenvalues.max();
    let kept = (0..eigen.eigenvalues.len()).filter(|k| eigen.eigenvalues[*k] > least);
    kept.map(|k| eigen.eigenvectors.column(k) * eigen.eigenvalues[k].sqrt())
        .collect()
}

/// Columns q whose Σ(qᵀe)² is the score of a part of e whose covariance has this root, beside a basis (Wu et al. 2011, "SKAT"), scaled so that it
/// grows by the sum of squared weights where that part has variance 1. None where the basis holds nearly all of it.
pub(super) fn score(root: Vec<DVector<f64>>, basis: &Basis, weight: f64) -> Vec<DVector<f64>> {
    let trace = |parts: &[DVector<f64>]| parts.iter().map(DVector::norm_squared).sum::<f64>();
    let whole = trace(&root);
    let parts: Vec<DVector<f64>> = root.into_iter().map(|part| basis.off(part)).collect();
    if parts.is_empty() || trace(&parts) < OWN * whole {
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
