//! The numbers set by hand that decide what is named, in one place.

use serde::{Deserialize, Serialize};

/// What decides whether an effect is tried, added, replaced, excluded and named. Evidence is gain in log-likelihood beyond chance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// Share of what a smooth field of friction gains from which on simpler effects explain it.
    pub explained: f64,
    /// Share of the best candidate's linear gain, or of that of the effect in whose place it is tried, below which another is not fitted.
    pub fitted: f64,
    /// Log-odds below which a rival is not excluded: a hundred to one.
    pub excluded: f64,
    /// Evidence by which a rival takes an effect's place.
    pub better: f64,
    /// Share of an effect's evidence below which one that is nearly the same by construction is excluded, and up to which it stands
    /// beside it: the form of each is a choice of the library's.
    pub alike: f64,
    /// Evidence that another effect must bring for each value that it frees: one missing effect is likelier than two.
    pub another: f64,
    /// Share of what the effects so far gain that another must bring: what is left of a strong effect looks like a weak one, for a real
    /// one never has quite the library's form.
    pub form: f64,
    /// Least part of that share, for an effect of whose score no smooth form of the others takes as much.
    pub form_least: f64,
    /// Share of its own gain that an effect which contains a simpler one must bring beyond it.
    pub contains: f64,
    /// Evidence that each further value of such an effect must bring.
    pub contains_value: f64,
    /// Wander of friction from the first strike to the last, relative, beside which effects are sought first: it moves no stop by more
    /// than launches scatter.
    pub small_wander: f64,
    /// Typical gains (medians of their sizes) that a strike left out of fits may count for in the test whether effects predict it: 5 are 3.4
    /// standard deviations of a normal distribution.
    pub typical_gains: f64,
    /// Standard deviation of the logarithm of the tip's radius over half a side of a box, about what the rig file says: 0.14 where each is
    /// wrong by a tenth.
    pub wrong_sizes: f64,
    /// Standard deviations of wrong sizes that are believed: 2 are both sizes off by a seventh, one up and one down.
    pub believed_sizes: f64,
    /// The camera's noise over that of the rig file from which on objects slide otherwise than the world says.
    pub astray: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self {
            explained: 0.95,
            fitted: 0.75,
            excluded: 4.6,
            better: 0.5,
            alike: 0.6,
            another: 2.0,
            form: 0.02,
            form_least: 0.3,
            contains: 0.02,
            contains_value: 2.0,
            small_wander: 0.004,
            typical_gains: 5.0,
            wrong_sizes: 0.14,
            believed_sizes: 2.0,
            astray: 3.0,
        }
    }
}
