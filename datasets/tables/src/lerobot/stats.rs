//! Statistics of a feature, as policies normalise by them.

use serde_json::{Map, Value, json};

/// Names of quantiles and their shares.
pub const QUANTILES: [(&str, f64); 5] = [
    ("q01", 0.01),
    ("q10", 0.10),
    ("q50", 0.50),
    ("q90", 0.90),
    ("q99", 0.99),
];

pub const MOMENTS: [&str; 4] = ["min", "max", "mean", "std"];

/// A feature's numbers, a list for each of its places.
pub struct Stats(Vec<Vec<f64>>);

/// The statistics of a feature, for each of its places.
pub struct Summary {
    count: usize,
    /// The moments of [`MOMENTS`], a list each; the standard deviation is that of the population.
    pub moments: [Vec<f64>; 4],
    /// The quantiles of [`QUANTILES`], a list each, linear between neighbours.
    pub quantiles: Vec<Vec<f64>>,
}

impl Stats {
    /// An empty collection for rows of `width` numbers.
    pub fn new(width: usize) -> Self {
        Self(vec![Vec::new(); width])
    }

    pub fn push(&mut self, row: &[f64]) {
        for (numbers, number) in self.0.iter_mut().zip(row) {
            numbers.push(*number);
        }
    }

    /// Its summary; the numbers are given away.
    pub fn summary(self) -> Summary {
        let Self(mut places) = self;
        let each = |of: fn(&[f64]) -> f64| places.iter().map(|n| of(n)).collect();
        let moments = [
            each(|n| n.iter().copied().fold(f64::INFINITY, f64::min)),
            each(|n| n.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            each(mean),
            each(|n| {
                let middle = mean(n);
                let squares = n.iter().map(|n| (n - middle) * (n - middle));
                (squares.sum::<f64>() / n.len().max(1) as f64).sqrt()
            }),
        ];
        for numbers in &mut places {
            numbers.sort_by(f64::total_cmp);
        }
        let of = |share: f64| places.iter().map(|n| quantile(n, share)).collect();
        Summary {
            count: places.first().map_or(0, Vec::len),
            moments,
            quantiles: QUANTILES.iter().map(|(_, share)| of(*share)).collect(),
        }
    }
}

impl Summary {
    pub fn json(&self) -> Value {
        let mut all = Map::new();
        for (name, numbers) in MOMENTS.into_iter().zip(&self.moments) {
            all.insert(name.into(), json!(numbers));
        }
        all.insert("count".into(), json!([self.count]));
        for ((name, _), numbers) in QUANTILES.into_iter().zip(&self.quantiles) {
            all.insert(name.into(), json!(numbers));
        }
        Value::Object(all)
    }
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len().max(1) as f64
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return 0.0;
    };
    let at = share * last as f64;
    let (below, above) = (at.floor() as usize, at.ceil() as usize);
    sorted[below] + (sorted[above] - sorted[below]) * (at - at.floor())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_and_quantiles_are_those_of_each_place() {
        let mut stats = Stats::new(2);
        for row in [[3.0, 0.0], [1.0, 0.0], [2.0, 8.0], [4.0, 0.0], [5.0, 2.0]] {
            stats.push(&row);
        }
        let Summary {
            moments: [min, max, mean, std],
            quantiles,
            ..
        } = stats.summary();
        assert_eq!((min, max), (vec![1.0, 0.0], vec![5.0, 8.0]));
        assert_eq!(mean, [3.0, 2.0]);
        assert!((std[0] - 2f64.sqrt()).abs() < 1e-12, "{std:?}");
        assert_eq!(quantiles[2], [3.0, 0.0]);
        assert!((quantiles[3][0] - 4.6).abs() < 1e-12, "{quantiles:?}");
        assert!((quantiles[3][1] - 5.6).abs() < 1e-12, "{quantiles:?}");
    }
}
