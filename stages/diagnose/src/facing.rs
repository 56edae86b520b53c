//! Whether boxes whose yaw nobody tracked lie turned to face each strike.
//!
//! Without a yaw a box is taken to lie square to the table. A person or a fixture may as well turn it to the strike: it then leaves along the command at every
//! angle, as one that is square, whose tip slips or whose sizes are wrong, does not.

use values::{Rig, Shape, Strike};
use world::{
    World,
    effects::{Family, effect},
};

use crate::{
    DiagnoseError, Thresholds, fit::Fitted, null::fit_null, search::SelectedEffect,
    strikes::PreparedStrikes,
};

/// Log-likelihood by which a box that faces each strike must be the better one: that of odds which no prior reaches.
const BETTER: f64 = 10.0;

/// By how much likelier strikes of a box are, without any effect, where it faced each of them than where it lay square: in log-likelihood, none where that
/// is not in question.
pub(crate) fn gain_of_facing(
    rig: &Rig,
    world: &World,
    strikes: &[Strike],
    thresholds: &Thresholds,
    square: &Fitted,
) -> Result<Option<f64>, DiagnoseError> {
    let is_tracked = strikes.iter().any(|strike| strike.conditions.yaw.is_some());
    if rig.object.shape() != Shape::Box || is_tracked {
        return Ok(None);
    }
    let mut facing = strikes.to_vec();
    for strike in &mut facing {
        strike.conditions.yaw = Some(strike.command.angle);
    }
    let (prepared, _) = PreparedStrikes::of(rig, world, &facing, thresholds)?;
    match fit_null(prepared, world, thresholds.small_wander) {
        Ok((_, facing)) => Ok(Some(facing.likelihood() - square.likelihood())),
        Err(DiagnoseError::NoFit { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Whether a box that faces each strike, which gains so much, is far likelier than one that lies square, and than effects that turn launches: these have
/// values to be fitted, so that where it faces they gain as much and less than that beyond chance.
pub(crate) fn is_rather_facing(gain: f64, effects: &[SelectedEffect]) -> bool {
    let turning = effects.iter().filter(|held| turns_launches(held.name));
    let evidence: f64 = turning.map(|held| held.evidence).sum();
    gain > f64::max(BETTER, evidence)
}

/// Whether an effect turns launches by the command or the start.
pub(crate) fn turns_launches(name: &str) -> bool {
    effect(name).is_ok_and(|spec| {
        matches!(
            spec.family,
            Family::LaunchAngle | Family::LaunchAngleByCommand | Family::LaunchByPlace
        )
    })
}
