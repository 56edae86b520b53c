//! A fitted model as a world: `world.toml`.

use std::collections::BTreeMap;

use world::{AddedEffect, Estimate, Scatter, World, parameter};

use crate::{
    DiagnoseError,
    fit::Fitted,
    mixed::{ANGLE, SPEED},
    model::{FRICTION, RESTITUTION},
    noise::FrameNoise,
    sessions,
};

/// The identified world with the model's values and effects, each with its 95 % interval, and the scatter under which they were
/// fitted.
pub(crate) fn fitted_world(
    identified: &World,
    fitted: &Fitted,
    noise: FrameNoise,
) -> Result<World, DiagnoseError> {
    let model = &fitted.model;
    let covariance = fitted
        .robust_covariance()
        .ok_or_else(|| DiagnoseError::NoFit {
            why: "its parameters cannot be distinguished".into(),
        })?;
    let at_end = fitted.forms_at_end();
    let ninety_five = fitted.ninety_five();
    let estimate = |place: usize| {
        let free = &model.free[place];
        let value = model.values[place];
        // At the end of its range a form is not measured: the data want one that the library does not have.
        if at_end.contains(&place) {
            return Estimate::with_interval(value, free.low, free.high);
        }
        let error = covariance[(place, place)].max(0.0).sqrt();
        let bound = |v: f64| v.clamp(free.low, free.high);
        Estimate::with_interval(
            value,
            bound(value - ninety_five * error),
            bound(value + ninety_five * error),
        )
    };
    let mut world = identified.clone();
    world.scatter = scatter(fitted, noise);
    for (name, place) in [("friction", FRICTION), ("restitution", RESTITUTION)] {
        world.parameters.insert(name.into(), estimate(place));
    }
    if let Some(place) = model.tip_friction() {
        let log = estimate(place);
        // What the strikes say nothing of is left to its prior, and stays as it was.
        let is_known = log
            .high
            .zip(log.low)
            .is_some_and(|(high, low)| high - low < model.free[place].width);
        if is_known {
            let identified = world.value("tip_friction")?;
            let most = parameter("tip_friction")?.high;
            let tip_friction = |log: f64| (identified * log.exp()).min(most);
            let bounds = (
                log.low.map_or(0.0, tip_friction),
                log.high.map_or(0.0, tip_friction),
            );
            let estimate = Estimate::with_interval(tip_friction(log.value), bounds.0, bounds.1);
            world.parameters.insert("tip_friction".into(), estimate);
        }
    }
    for (place, part) in model.fitted_parts(&model.values).iter().enumerate() {
        let mut parameters: BTreeMap<String, Estimate> = part
            .parameters
            .iter()
            .map(|(name, value)| (name.clone(), Estimate::fixed(*value)))
            .collect();
        for (i, free) in model.free.iter().enumerate() {
            if let Some((_, name)) = free.of.as_ref().filter(|(of, _)| *of == place) {
                parameters.insert(name.clone(), estimate(i));
            }
        }
        let (free, places): (Vec<&str>, Vec<usize>) = model
            .free
            .iter()
            .enumerate()
            .filter_map(|(i, free)| {
                let (_, name) = free.of.as_ref().filter(|(of, _)| *of == place)?;
                Some((name.as_str(), i))
            })
            .unzip();
        let own = covariance.select_rows(&places).select_columns(&places);
        world.effects.push(AddedEffect {
            name: part.name.into(),
            parameters: sessions::centred_estimates(
                part.name,
                parameters,
                &free,
                &own,
                ninety_five,
            ),
        });
    }
    let world = world.with_populations();
    world.check()?;
    Ok(world)
}

/// Scatter and noise of a fit.
pub(crate) fn scatter(fitted: &Fitted, noise: FrameNoise) -> Scatter {
    let components = &fitted.estimated.components;
    Scatter {
        speed: components.nuisance[SPEED],
        angle: components.nuisance[ANGLE],
        friction: fitted.friction_scatter(),
        camera: components.camera,
        camera_correlation: noise.correlation,
        stamp_jitter: noise.jitter * components.camera,
    }
}
