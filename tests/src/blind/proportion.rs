//! How many of how many, with an exact interval.

use statrs::distribution::{Beta, ContinuousCDF};

/// A count out of a total.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Proportion {
    /// Those that count.
    pub hits: usize,
    /// All.
    pub all: usize,
}

impl Proportion {
    /// Counts the items for which `hit` holds.
    pub fn of<T>(items: impl Iterator<Item = T>, hit: impl Fn(&T) -> bool) -> Self {
        items.fold(Self::default(), |so_far, item| Self {
            hits: so_far.hits + usize::from(hit(&item)),
            all: so_far.all + 1,
        })
    }

    /// Both counts together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            all: self.all + other.all,
        }
    }

    /// The share; 0 of 0 is 0.
    pub fn share(self) -> f64 {
        self.hits as f64 / self.all.max(1) as f64
    }

    /// 95 % interval of the share (Clopper and Pearson 1934); of 0 of 0, all shares.
    pub fn interval(self) -> (f64, f64) {
        let (hits, all) = (self.hits as f64, self.all as f64);
        let quantile = |a: f64, b: f64, p: f64| match Beta::new(a, b) {
            Ok(beta) => beta.inverse_cdf(p),
            Err(_) => f64::NAN,
        };
        let low = if self.hits == 0 {
            0.0
        } else {
            quantile(hits, all - hits + 1.0, 0.025)
        };
        let high = if self.hits == self.all {
            1.0
        } else {
            quantile(hits + 1.0, all - hits, 0.975)
        };
        (low, high)
    }
}

/// As percent with its interval and both counts; a dash for 0 of 0.
impl std::fmt::Display for Proportion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.all == 0 {
            return f.write_str("–");
        }
        let (low, high) = self.interval();
        write!(
            f,
            "{:.1} % [{:.1}, {:.1}] ({} of {})",
            100.0 * self.share(),
            100.0 * low,
            100.0 * high,
            self.hits,
            self.all
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_clopper_and_pearson() {
        let (low, high) = Proportion { hits: 3, all: 200 }.interval();
        assert!((low - 0.003_1).abs() < 1e-4 && (high - 0.043_2).abs() < 1e-4);
        let none = Proportion { hits: 0, all: 20 };
        assert_eq!(none.to_string(), "0.0 % [0.0, 16.8] (0 of 20)");
        assert_eq!(Proportion::default().to_string(), "–");
    }
}
