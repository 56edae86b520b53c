//! The world without effects, and the noise about it.
//!
//! Order: launches first, under independent errors; then ρ and κ by the profile likelihood with wild frames left out; then the
//! world again under this noise. ρ and κ tuned before launches are fitted end in a wrong mode.

use world::{World, WorldError};

use crate::{
    DiagnoseError,
    fit::{Fitted, Goal, prior},
    linearisation::products_under,
    mixed::{VarianceComponents, estimate_within},
    model::{Model, RESTITUTION},
    noise::{self, FIRST_SEARCH, FrameNoise, REFINEMENT, Rule, Search},
    strikes::{Nuisances, PreparedStrikes},
};

/// Change of restitution from which launches are set anew about the fit, and the number of times at the most.
const FAR: f64 = 0.1;
const REBASED: usize = 4;
/// Steps of expectation and maximisation at each trial of ρ and κ, and of Gauss–Newton after it.
const EM_STEPS: usize = 4;
const AFTER: usize = 4;

/// Fits the world without effects from where it was identified; the strikes come back with their noise and frames.
pub(crate) fn fit_null<'a>(
    prepared: PreparedStrikes<'a>,
    world: &World,
    greatest_wander: f64,
) -> Result<(PreparedStrikes<'a>, Fitted), DiagnoseError> {
    let plain = Model::plain(
        world.value("friction")?,
        world.value("restitution")?,
        prepared.rig,
        prepared.thresholds,
    );
    fit_anew(prepared, world, &plain, greatest_wander)
}

/// Fits a model, and the noise about it, to strikes that nothing is known of yet; they come back with their noise and frames.
pub(crate) fn fit_anew<'a>(
    mut prepared: PreparedStrikes<'a>,
    world: &World,
    model: &Model,
    greatest_wander: f64,
) -> Result<(PreparedStrikes<'a>, Fitted), DiagnoseError> {
    let camera = &prepared.rig.camera;
    let frame = 1.0 / camera.rate;
    let mut about = world.value("restitution")?;
    let components = VarianceComponents::initial(camera.noise, frame, greatest_wander);
    let start = vec![Nuisances::zeros(); prepared.strikes.len()];
    let mut null = prepared
        .fit(model, &components, &start, Goal::Settled)?
        .ok_or_else(diverges)?;
    for _ in 0..REBASED {
        if (null.model.values[RESTITUTION] - about).abs() < FAR {
            break;
        }
        // Far from the impacts that launches were taken about, they are taken again.
        about = null.model.values[RESTITUTION];
        prepared = prepared.about(world, &null.model)?;
        null = prepared
            .fit(
                &null.model,
                &null.estimated.components,
                &null.estimated.nuisances,
                Goal::Settled,
            )?
            .ok_or_else(diverges)?;
    }
    for (rule, search) in [(Rule::FIRST, FIRST_SEARCH), (Rule::FITTED, REFINEMENT)] {
        prepared = with_noise_about(prepared, &null, rule, search);
        null = prepared.refit(&null, AFTER)?.ok_or_else(diverges)?;
    }
    Ok((prepared, null))
}

fn diverges() -> DiagnoseError {
    DiagnoseError::NoFit {
        why: "its fit diverges".into(),
    }
}

/// The strikes with frames left out and noise estimated about a fitted model.
fn with_noise_about<'a>(
    prepared: PreparedStrikes<'a>,
    fitted: &Fitted,
    rule: Rule,
    search: Search,
) -> PreparedStrikes<'a> {
    let prepared = without_outliers(prepared, fitted, rule);
    let prior = prior(&fitted.model);
    let raw = &fitted.linearisation.raw;
    let start = (prepared.noise != FrameNoise::WHITE).then_some(prepared.noise);
    let noise = noise::estimate(start, search, |noise| {
        let products = products_under(&prepared, raw, noise);
        let components = fitted.estimated.components.under(noise);
        estimate_within(&products, &prior, &components, EM_STEPS)
            .map_or(f64::NEG_INFINITY, |estimated| estimated.likelihood_there)
    });
    prepared.with_noise(noise)
}

/// Strikes whose noise and frames are estimated anew about a model with effects; the world without effects and that model, each refitted under them.
/// `None` where either fit fails.
pub(crate) fn renewed<'a>(
    prepared: &PreparedStrikes<'a>,
    null: &Fitted,
    fitted: &Fitted,
) -> Result<Option<(PreparedStrikes<'a>, Fitted, Fitted)>, WorldError> {
    let prepared = with_noise_about(prepared.clone(), fitted, Rule::FITTED, REFINEMENT);
    let null = prepared.refit(null, AFTER)?;
    let fitted = prepared.refit(fitted, AFTER)?;
    Ok(null
        .zip(fitted)
        .map(|(null, fitted)| (prepared, null, fitted)))
}

/// Passes of leaving frames out: a stray frame bends its strike's launch, and hides others until it is gone.
const PASSES: usize = 3;

fn without_outliers<'a>(
    mut prepared: PreparedStrikes<'a>,
    fitted: &Fitted,
    rule: Rule,
) -> PreparedStrikes<'a> {
    let raw = &fitted.linearisation.raw;
    let prior = prior(&fitted.model);
    let mut estimated = fitted.estimated.clone();
    for _ in 0..PASSES {
        let mut frames = prepared.frames.clone();
        for (frames, raw) in frames.iter_mut().zip(raw.iter()) {
            frames.speeds = raw.speeds();
        }
        let left: Vec<_> = raw
            .iter()
            .zip(&estimated.nuisances)
            .map(|(raw, b)| &raw.residual - &raw.values * &estimated.beta - &raw.nuisances * b)
            .collect();
        let kept = noise::kept_frames(&frames, &left, rule);
        let is_steady = frames
            .iter()
            .zip(&kept)
            .all(|(frames, kept)| frames.kept == *kept);
        for (frames, kept) in frames.iter_mut().zip(kept) {
            frames.kept = kept;
        }
        prepared = prepared.with_frames(frames);
        if is_steady {
            break;
        }
        let products = products_under(&prepared, raw, prepared.noise);
        let components = estimated.components;
        match estimate_within(&products, &prior, &components, EM_STEPS) {
            Some(again) => estimated = again,
            None => break,
        }
    }
    prepared
}
