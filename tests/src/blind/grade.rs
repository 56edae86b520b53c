//! Right or wrong.

use statrs::distribution::{Beta, ContinuousCDF};

use super::cases::CLASSES;
use super::outcome::Outcome;

/// How many of how many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Those that count.
    pub hits: usize,
    /// All.
    pub all: usize,
}

impl Tally {
    /// The share; 0 of 0 is 0.
    pub fn share(self) -> f64 {
        self.hits as f64 / self.all.max(1) as f64
    }

    /// 95 % interval of the share (Clopper and Pearson 1934).
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

/// Counts the outcomes for which `hit` holds.
pub fn tally<'o>(
    outcomes: impl Iterator<Item = &'o Outcome>,
    hit: impl Fn(&Outcome) -> bool,
) -> Tally {
    outcomes.fold(Tally::default(), |tally, outcome| Tally {
        hits: tally.hits + usize::from(hit(outcome)),
        all: tally.all + 1,
    })
}

/// Whether just what is hidden was named, each effect by its name or in a class that was said.
pub fn is_right(outcome: &Outcome) -> bool {
    let hidden = &outcome.case.hidden;
    match outcome.verdict.as_str() {
        "consistent" => hidden.is_empty(),
        "unexplained" => outcome.case.kind == super::Kind::Foreign,
        "named" => {
            outcome.named.len() == hidden.len()
                && hidden.iter().all(|effect| {
                    outcome
                        .named
                        .iter()
                        .any(|(name, equivalent)| name == effect || equivalent.contains(effect))
                })
        }
        _ => false,
    }
}

/// Whether every name is just what is hidden.
pub fn is_exact(outcome: &Outcome) -> bool {
    outcome.verdict == "named"
        && outcome.named.len() == outcome.case.hidden.len()
        && outcome
            .named
            .iter()
            .all(|(name, _)| outcome.case.hidden.contains(name))
}

/// Whether data can tell the effect from the others: it is of no class that is the same by construction, and the diagnosis
/// itself excludes all others.
pub fn can_be_told(outcome: &Outcome) -> bool {
    let in_class = outcome
        .case
        .hidden
        .iter()
        .any(|effect| CLASSES.iter().any(|class| class.contains(&effect.as_str())));
    !in_class
        && outcome
            .named
            .iter()
            .all(|(_, equivalent)| equivalent.is_empty())
}
