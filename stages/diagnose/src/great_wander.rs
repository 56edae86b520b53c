//! Whether effects that were sought beside a small wander of friction are to be sought again beside a great one.

use world::WorldError;

use crate::{
    fit::ITERATIONS,
    mixed::GREATEST,
    model::Model,
    search::Selection,
    smooth::covariate::{Covariate, family},
};

/// What a friction that wanders widely would hold of a selection.
pub(crate) struct GreatWander {
    /// As much as an effect of friction by order does, but for a gain that chance brings.
    pub(crate) replaces: bool,
    /// More than chance beside all effects.
    pub(crate) holds_more: bool,
}

impl GreatWander {
    pub(crate) fn beside(selection: &Selection<'_>) -> Result<Self, WorldError> {
        let (prepared, fitted) = (&selection.prepared, &selection.fitted);
        let by_chance = prepared.thresholds.beyond_wander;
        let free = fitted.estimated.components.with_greatest_wander(GREATEST);
        // What a model gains on the one that was found, under a great wander.
        let gain = |model: &Model| -> Result<f64, WorldError> {
            let wandering = prepared.fit(model, &free, &fitted.nuisances, ITERATIONS)?;
            Ok(wandering.map_or(f64::NEG_INFINITY, |wandering| {
                wandering.likelihood() - fitted.likelihood()
            }))
        };
        let mut replaces = false;
        for (place, effect) in selection.effects.iter().enumerate() {
            if family(effect.name).contains(&Covariate::Wear) {
                replaces |= gain(&fitted.model.without(place))? > -by_chance;
            }
        }
        Ok(Self {
            replaces,
            holds_more: gain(&fitted.model)? > by_chance,
        })
    }
}
