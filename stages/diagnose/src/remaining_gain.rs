//! What is left of a gap beside the effects found, and whether that is small enough for them to be named.

use world::effects::{Naming, effect};

use crate::{
    Thresholds,
    smooth::covariate::{Covariate, family},
};

/// Gain in log-likelihood that smooth dependences have beside a model.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct RemainingGain {
    /// All that are no chance.
    pub(crate) all: f64,
    /// Those that another form of the model's effects would not take.
    pub(crate) beyond_form: f64,
    /// Whether objects slide otherwise than any world says.
    pub(crate) is_astray: bool,
}

impl RemainingGain {
    /// Share of the gap that effects hold which gained this log-likelihood.
    pub(crate) fn share(&self, gained: f64) -> f64 {
        share(gained, self.all)
    }

    /// The same less what something else would take.
    pub(crate) fn less(self, taken: f64) -> Self {
        Self {
            all: (self.all - taken).max(0.0),
            beyond_form: (self.beyond_form - taken).max(0.0),
            ..self
        }
    }

    /// Whether it is small beside what these effects gained.
    pub(crate) fn is_small(&self, gained: f64, effects: &[&str], thresholds: &Thresholds) -> bool {
        let least = match self.is_astray {
            true => thresholds.explained_astray,
            false => thresholds.explained,
        };
        let in_form = match effects.iter().filter(|name| is_by_place(name)).count() {
            _ if effects.iter().any(|name| is_field(name)) => thresholds.explained_by_field,
            0 => thresholds.explained_in_form,
            1 => thresholds.explained_by_place,
            _ => thresholds.explained_by_places,
        };
        share(gained, self.beyond_form) >= least && self.share(gained) >= in_form
    }
}

fn share(gained: f64, left: f64) -> f64 {
    gained / (gained + left).max(1e-9)
}

fn is_by_place(name: &str) -> bool {
    let by_place = [Covariate::Position, Covariate::Surface];
    family(name)
        .iter()
        .any(|covariate| by_place.contains(covariate))
}

/// Whether an effect is a smooth field that stands in simpler ones' place.
fn is_field(name: &str) -> bool {
    effect(name).is_ok_and(|spec| spec.naming == Naming::LastResort)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_of_friction_leaves_less_of_its_own_kind_than_a_patch_may() {
        let thresholds = &Thresholds::default();
        let left = RemainingGain {
            all: 30.0,
            beyond_form: 0.0,
            is_astray: false,
        };
        assert!(left.is_small(100.0, &["friction_patch"], thresholds));
        assert!(!left.is_small(100.0, &["friction_map"], thresholds));
        assert!(left.is_small(400.0, &["friction_map"], thresholds));
        let beyond = RemainingGain {
            beyond_form: 30.0,
            ..left
        };
        assert!(!beyond.is_small(100.0, &["friction_patch"], thresholds));
    }
}
