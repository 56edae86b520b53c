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

/// A feature's numbers, a list for each of its places.
pub struct Stats {
    numbers: Vec<Vec<f64>>,
    sorted: bool,
}

impl Stats {
    /// Of rows of so many numbers.
    pub fn new(width: usize) -> Self {
        Self {
            numbers: vec![Vec::new(); width],
            sorted: false,
        }
    }

    /// Adds a row.
    pub fn push(&mut self, row: &[f64]) {
        for (numbers, number) in self.numbers.iter_mut().zip(row) {
            numbers.push(*number);
        }
        self.sorted = false;
    }

    /// Least, greatest, mean and standard deviation (of the population), for each place.
    pub fn moments(&self) -> [Vec<f64>; 4] {
        let each = |of: fn(&[f64]) -> f64| self.numbers.iter().map(|n| of(n)).collect();
        [
            each(|n| n.iter().copied().fold(f64::INFINITY, f64::min)),
            each(|n| n.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
            each(mean),
            each(|n| {
                let middle = mean(n);
                let squares = n.iter().map(|n| (n - middle) * (n - middle));
                (squares.sum::<f64>() / n.len().max(1) as f64).sqrt()
            }),
        ]
    }

    /// For each of [`QUANTILES`] that quantile of each place, linear between neighbours.
    pub fn quantiles(&mut self) -> Vec<Vec<f64>> {
        if !self.sorted {
            for numbers in &mut self.numbers {
                numbers.sort_by(f64::total_cmp);
            }
            self.sorted = true;
        }
        let of = |share: f64| self.numbers.iter().map(|n| quantile(n, share)).collect();
        QUANTILES.iter().map(|(_, share)| of(*share)).collect()
    }

    /// All of them as JSON.
    pub fn json(&mut self) -> Value {
        let [min, max, mean, std] = self.moments();
        let count = self.numbers.first().map_or(0, Vec::len);
        let mut all = Map::new();
        for (name, numbers) in [("min", min), ("max", max), ("mean", mean), ("std", std)] {
            all.insert(name.into(), json!(numbers));
        }
        all.insert("count".into(), json!([count]));
        for ((name, _), numbers) in QUANTILES.into_iter().zip(self.quantiles()) {
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
        let [min, max, mean, std] = stats.moments();
        assert_eq!((min, max), (vec![1.0, 0.0], vec![5.0, 8.0]));
        assert_eq!(mean, [3.0, 2.0]);
        assert!((std[0] - 2f64.sqrt()).abs() < 1e-12, "{std:?}");
        let quantiles = stats.quantiles();
        assert_eq!(quantiles[2], [3.0, 0.0]);
        assert!((quantiles[3][0] - 4.6).abs() < 1e-12, "{quantiles:?}");
        assert!((quantiles[3][1] - 5.6).abs() < 1e-12, "{quantiles:?}");
    }
}
