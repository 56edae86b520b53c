//! Whether effects that were sought beside a small wander of friction are to be sought again beside a great one.

use world::WorldError;

use crate::{
    fit::Goal,
    mixed::GREATEST,
    model::Model,
    remaining_gain::RemainingGain,
    search::Selection,
    smooth::covariate::{Covariate, family},
};

/// What a friction that wanders widely would hold of a selection.
pub(crate) struct GreatWander {
    /// As much as an effect of friction by order does, but for a gain that chance brings.
    pub(crate) replaces: bool,
    /// More than chance beside all effects, and so much that these could be named then.
    pub(crate) could_explain: bool,
}

impl GreatWander {
    /// Of a selection, beside which smooth dependences gain what is left.
    pub(crate) fn beside(
        selection: &Selection<'_>,
        left: RemainingGain,
    ) -> Result<Self, WorldError> {
        let (prepared, fitted) = (&selection.prepared, &selection.fitted);
        let by_chance = prepared.thresholds.beyond_wander;
        let free = fitted.estimated.components.with_greatest_wander(GREATEST);
        // What a model gains on the one that was found, under a great wander.
        let gain = |model: &Model| -> Result<f64, WorldError> {
            let wandering = prepared.fit(model, &free, &fitted.nuisances, Goal::LIKELIHOOD)?;
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
        let names: Vec<&str> = selection.effects.iter().map(|effect| effect.name).collect();
        let more = gain(&fitted.model)?;
        let is_rest_small = names.is_empty()
            || left
                .less(more)
                .is_small(selection.gain(), &names, prepared.thresholds);
        Ok(Self {
            replaces,
            could_explain: more > by_chance && is_rest_small,
        })
    }
}
