//! Drift: does a version's default model do worse here than chance explains?

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Gamma};
use store::Model;
use values::StopErrors;

/// The default model's mean stop error here against that on the strikes held out when the version was published.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    model: Model,
    /// Mean stop error when published, in m.
    published: f64,
    /// Mean stop error here, in m.
    here: f64,
    /// Their difference in units of its standard error, by the scatter when published.
    z: f64,
    /// Whether chance gives as much less often than [`CHANCE`].
    beyond_chance: bool,
}

/// Fewer held-out strikes when published give no scatter to judge by.
pub const LEAST: usize = 8;
/// Chance is called drift once in so many scores.
const CHANCE: f64 = 1e-3;

impl Drift {
    /// By the scatter of single strikes when published: by that of the strikes here, a wild miss would be its own excuse. Means of
    /// a few errors, which are never negative, are skewed: they follow a gamma distribution.
    pub fn between(model: Model, published: &StopErrors, here: &StopErrors) -> Self {
        let each = |n: usize| 1.0 / n.max(1) as f64;
        let variance = published.sd.powi(2) * (each(published.n) + each(here.n));
        let variance = variance.max(1e-18);
        let mean = published.mean;
        let chance =
            Gamma::new(mean * mean / variance, mean / variance).map(|gamma| gamma.sf(here.mean));
        Self {
            model,
            published: mean,
            here: here.mean,
            z: (here.mean - mean) / variance.sqrt(),
            beyond_chance: chance.unwrap_or(0.0) < CHANCE && here.mean > mean,
        }
    }

    /// For a person.
    pub fn sentence(&self) -> String {
        let verdict = if self.beyond_chance {
            "worse than chance explains: the rig has drifted, or these strikes lie where none was learnt from"
        } else {
            "no drift beyond chance"
        };
        format!(
            "{}: {:.2} cm here, {:.2} cm on the strikes held out when it was published (z = {:.1}): {verdict}",
            self.model,
            self.here * 100.0,
            self.published * 100.0,
            self.z
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_difference_beyond_chance_is_called_drift() {
        let published = StopErrors {
            mean: 0.005,
            sd: 0.003,
            median: 0.004,
            p95: 0.01,
            n: 50,
            failed: 0,
        };
        let here = |mean| StopErrors {
            mean,
            sd: 0.003,
            median: mean,
            p95: 0.01,
            n: 50,
            failed: 0,
        };
        let drift = |mean| Drift::between(Model::Sysid, &published, &here(mean));
        assert!(!drift(0.0055).beyond_chance);
        assert!(!drift(0.001).beyond_chance, "better is no drift");
        assert!(drift(0.009).beyond_chance);
        assert!((drift(0.0056).z - 1.0).abs() < 1e-9);

        // One strike that misses wildly makes the scatter here, and is reported all the same.
        let wild = StopErrors {
            mean: 0.030,
            sd: 0.080,
            n: 10,
            ..here(0.030)
        };
        assert!(Drift::between(Model::Sysid, &published, &wild).beyond_chance);
        let single = |mean| StopErrors {
            sd: 0.0,
            n: 1,
            ..here(mean)
        };
        // A normal distribution would call a single strike of 3.2 standard errors drift; of errors one in 200 is so large.
        let drift = |mean| Drift::between(Model::Sysid, &published, &single(mean));
        assert!(!drift(0.0147).beyond_chance && drift(0.0147).z > 3.1);
        assert!(drift(0.025).beyond_chance);
        let perfect = StopErrors {
            mean: 0.0,
            sd: 0.0,
            ..published
        };
        assert!(Drift::between(Model::Sysid, &perfect, &single(0.01)).beyond_chance);
    }
}
