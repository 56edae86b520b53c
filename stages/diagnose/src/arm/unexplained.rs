//! What delivered launches still depend on where the arm's laws are taken off: a repeatable error of the arm that no law holds.

use statrs::distribution::{ContinuousCDF, Normal};
use values::{Rig, Strike};
use world::{WorldError, effects};

use super::{
    forms::{Pair, Quantity},
    law::{CHANCE, Law},
};
use crate::diagnosis::GapDependence;
use crate::words::{At, Dependence};

/// Fewer strikes show no dependence.
const FEWEST: usize = 20;
/// Neighbours that a dependence is averaged over.
const NEIGHBOURS: usize = 5;
/// Relative speed, or angle in rad, by which no stop moves visibly: 0.2 % of speed are 2 mm of half a metre.
const NEGLIGIBLE: f64 = 2e-3;

/// What a quantity of the launch depends on.
#[derive(Clone, Debug)]
pub(super) struct Unexplained {
    pub(super) quantity: Quantity,
    pub(super) dependence: GapDependence,
}

/// What launches may depend on: its name, its value, and where that is.
type By = (&'static str, fn(&Pair<'_>) -> f64, fn(f64) -> At);

const BY: [By; 4] = [
    ("speed", |pair| pair.command.speed, At::Speed),
    ("angle", |pair| pair.command.angle, At::Angle),
    ("start", |pair| pair.from.x, At::X),
    ("start", |pair| pair.from.y, At::Y),
];

/// What the launches of these strikes depend on beside these laws, by speed and angle of the command and by where the object lay.
///
/// Strikes are put in order of each: where neighbours are alike, the launch depends on it, by whatever form
/// (Bartels 1982, the rank version of von Neumann's ratio test, which takes no distribution of the scatter on trust).
pub(super) fn unexplained(
    rig: &Rig,
    laws: &[Law],
    strikes: &[&Strike],
) -> Result<Vec<Unexplained>, WorldError> {
    let pairs = Pair::all(strikes);
    let laws = laws.iter().map(|law| effects::build(&law.added, rig));
    let laws = laws.collect::<Result<Vec<_>, _>>()?;
    let predicted =
        |pair: &Pair<'_>| effects::deliver(&laws, pair.command, pair.from, pair.conditions);
    let looks = Quantity::ALL.len() * BY.len();
    let mut found = Vec::new();
    for quantity in Quantity::ALL {
        let left = |pair: &Pair<'_>| pair.difference(quantity, predicted(pair));
        for (covariate, of, place) in BY {
            let mut points: Vec<(f64, f64)> =
                pairs.iter().map(|pair| (of(pair), left(pair))).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let Some((p_value, share)) = rank_von_neumann_test(&points) else {
                continue;
            };
            let (at, off) = peak(&points);
            let p_value = (p_value * looks as f64).min(1.0);
            if p_value < CHANCE && off.abs() > NEGLIGIBLE {
                let at = place(at);
                let description = match quantity {
                    Quantity::Speed => Dependence::DeliveredSpeed { off, at },
                    Quantity::Angle => Dependence::DeliveredAngle { off, at },
                };
                let dependence = GapDependence {
                    covariate: covariate.into(),
                    description: description.into(),
                    p_value,
                    share,
                };
                found.push(Unexplained {
                    quantity,
                    dependence,
                });
            }
        }
    }
    found.sort_by(|a: &Unexplained, b| b.dependence.share.total_cmp(&a.dependence.share));
    Ok(found)
}

/// Probability that neighbours are so much alike by chance, and the share of the variance that goes with where they lie; none of few points.
fn rank_von_neumann_test(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    if points.len() < FEWEST {
        return None;
    }
    let n = points.len() as f64;
    let ranks = ranks(points);
    let mean = 0.5 * (n + 1.0);
    let squares: f64 = ranks.iter().map(|r| (r - mean).powi(2)).sum();
    let steps: f64 = ranks
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum();
    let ratio = steps / squares;
    let variance =
        4.0 * (n - 2.0) * (5.0 * n * n - 2.0 * n - 9.0) / (5.0 * n * (n + 1.0) * (n - 1.0).powi(2));
    let chance = Normal::standard().cdf((ratio - 2.0) / variance.sqrt());
    ratio
        .is_finite()
        .then(|| (chance, (1.0 - 0.5 * ratio).clamp(0.0, 1.0)))
}

/// Ranks of the second values from 1; of equal ones, the mean.
fn ranks(points: &[(f64, f64)]) -> Vec<f64> {
    let rank = |value: f64| {
        let count = |of: fn(&f64, &f64) -> bool| {
            points.iter().filter(|(_, other)| of(other, &value)).count() as f64
        };
        0.5 * (count(|a, b| a < b) + count(|a, b| a <= b) + 1.0)
    };
    points.iter().map(|(_, value)| rank(*value)).collect()
}

/// Where a mean over neighbours is farthest from none, and how far.
fn peak(points: &[(f64, f64)]) -> (f64, f64) {
    let mean = |of: fn(&(f64, f64)) -> f64, window: &[(f64, f64)]| {
        window.iter().map(of).sum::<f64>() / window.len() as f64
    };
    points
        .windows(NEIGHBOURS)
        .map(|window| (mean(|p| p.0, window), mean(|p| p.1, window)))
        .fold((0.0, 0.0), |far: (f64, f64), near| {
            if near.1.abs() > far.1.abs() {
                near
            } else {
                far
            }
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of scatter 1 beside a sine of this amplitude with four periods.
    fn points(amplitude: f64, seed: u64) -> Vec<(f64, f64)> {
        let mut state = seed;
        let mut uniform = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let at = |i: usize| i as f64 / 120.0;
        (0..120)
            .map(|i| {
                let scatter = 3f64.sqrt() * (2.0 * uniform() - 1.0);
                (
                    at(i),
                    scatter + amplitude * (8.0 * std::f64::consts::PI * at(i)).sin(),
                )
            })
            .collect()
    }

    #[test]
    fn scatter_alone_is_alike_by_chance_as_often_as_is_said() {
        let often = (0..2000).filter(|seed| {
            let (p_value, _) = rank_von_neumann_test(&points(0.0, *seed)).expect("enough");
            p_value < 0.01
        });
        let often = often.count();
        assert!((8..=35).contains(&often), "{often} of 2000");
    }

    #[test]
    fn a_dependence_of_any_form_is_found_where_it_is_as_large_as_scatter() {
        let points = points(1.5, 5);
        let (p_value, share) = rank_von_neumann_test(&points).expect("enough");
        assert!(p_value < 1e-4 && share > 0.3, "{p_value} {share}");
        let (at, off) = peak(&points);
        let is_crest = (0..8).any(|k| (at - (2 * k + 1) as f64 / 16.0).abs() < 0.04);
        assert!(is_crest && off.abs() > 1.0, "{at} {off}");
    }
}
