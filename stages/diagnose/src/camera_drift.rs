//! A drift of the camera's scale or of its clock, which is seen as a drift of launch speed and friction at once.
//!
//! Where lengths are seen larger by a share, speeds and friction are, by the same share; where time is seen shorter, speeds are by a share and
//! friction by twice as much. Strikes alone do not say whether the camera does this or a tip that wears on a table that changes.

use world::{
    Impact, WorldError,
    effects::{Drift, effect},
};

use crate::{
    fit::{Fitted, NINETY_FIVE},
    model::RESTITUTION,
    sessions::is_by_session,
    strikes::PreparedStrikes,
};

/// Relative change of friction for each relative change of launch speed: by a camera's scale, by its clock.
const OF: [f64; 2] = [1.0, 2.0];

/// Whether friction and launch speed change over so many strikes as a camera's scale or clock would have it, within their errors.
pub(crate) fn could_be(fitted: &Fitted, strikes: f64) -> bool {
    let free = &fitted.model.free;
    let place = |name: &str, of_it: &str| {
        let part = fitted
            .model
            .parts
            .iter()
            .position(|part| part.name == name)?;
        let is_it = |of: &Option<(usize, String)>| matches!(of, Some((of, parameter)) if *of == part && parameter == of_it);
        free.iter().position(|free| is_it(&free.of))
    };
    let (Some(friction), Some(restitution), Some(covariance)) = (
        place("friction_drift", "rate"),
        place("restitution_drift", "rate"),
        fitted.robust_covariance(),
    ) else {
        return false;
    };
    // Hundreds of strikes by the last one, as many as go on.
    let gone_on = |name: &str| {
        let value =
            |of: &str, none: f64| place(name, of).map_or(none, |at| fitted.model.values[at]);
        let drift = Drift {
            rate: 1.0,
            saturation: 0.01 * value("saturation", 0.0),
            shape: value("shape", 1.0),
        };
        0.01 * drift.gone_on(strikes)
    };
    let (wears, brakes) = (gone_on("restitution_drift"), gone_on("friction_drift"));
    let restored = fitted.model.values[RESTITUTION];
    let (worn, braked) = (
        wears * fitted.model.values[restitution],
        brakes * fitted.model.values[friction],
    );
    // By the last strike: logarithms of the factors, and their derivatives by the rates.
    let launch = (restored * worn / (1.0 + restored)).max(-0.9).ln_1p();
    let by_worn = wears * restored / (1.0 + restored * (1.0 + worn));
    let brake = braked.max(-0.9).ln_1p();
    let by_braked = brakes / (1.0 + braked).max(0.1);
    // What goes with a square is no straight line: by its curvature about one.
    let curved = 0.5 * launch.abs().max(brake.abs()).powi(2);
    OF.into_iter().any(|share| {
        let by_launch = share * by_worn;
        let variance = by_launch.powi(2) * covariance[(restitution, restitution)]
            - 2.0 * by_launch * by_braked * covariance[(restitution, friction)]
            + by_braked.powi(2) * covariance[(friction, friction)];
        let error = NINETY_FIVE * variance.max(0.0).sqrt();
        (share * launch - brake).abs() < error + curved
    })
}

/// Greatest part of the change of friction, in strikes of sessions, that a camera's zoom may leave unexplained.
const LEFT: f64 = 0.15;
/// Relative change of friction that counts as none.
const NONE: f64 = 1e-3;

/// Whether friction by session, beside a restitution that changes with the order, changes strike by strike as a camera would have it that was
/// zoomed in some of the sessions.
pub(crate) fn could_be_by_session(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
) -> Result<bool, WorldError> {
    let is_by_order = |name| effect(name).is_ok_and(|spec| spec.family.is_by_order());
    let mut model = fitted.model.clone();
    for place in (0..model.parts.len()).rev() {
        if !is_by_order(model.parts[place].name) {
            model = model.without(place);
        }
    }
    let mut parts = model.parts.iter();
    if !parts.any(|part| is_by_session(part.name)) {
        return Ok(false);
    }
    let effects = model.effects(prepared.rig, &model.values)?;
    let planar = prepared.planar(&model.values, &effects);
    let each = prepared.strikes.iter().map(|strike| {
        let (friction, _) = planar.even(&strike.conditions);
        let restitution = model.values[RESTITUTION];
        let impact = Impact::of(&effects, restitution, strike.command, &strike.conditions);
        (impact.restitution.ln_1p(), friction.ln())
    });
    let (launches, frictions): (Vec<f64>, Vec<f64>) = each.unzip();
    let square = |of: &dyn Fn(usize) -> f64| {
        let n = launches.len() as f64;
        let mean = (0..launches.len()).map(of).sum::<f64>() / n;
        let squares = (0..launches.len()).map(|i| (of(i) - mean).powi(2));
        squares.sum::<f64>() / n
    };
    let whole = square(&|i| frictions[i]);
    let is_left = |share: f64| square(&|i| frictions[i] - share * launches[i]);
    Ok(whole.sqrt() > NONE
        && OF
            .into_iter()
            .any(|share| is_left(share) < LEFT * LEFT * whole))
}
