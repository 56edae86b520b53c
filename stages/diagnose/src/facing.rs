//! Whether boxes whose yaw nobody tracked lie turned to face each strike.
//!
//! Without a yaw a box is taken to lie square to the table. A person or a fixture may as well turn it to the strike: it then leaves along the command at every
//! angle, as one that is square, whose tip slips or whose sizes are wrong, does not.

use values::{Rig, Shape, Strike};
use world::World;

use crate::{DiagnoseError, Thresholds, fit::Fitted, null::fit_null, run::prepare};

/// Log-likelihood by which a box that faces each strike must be the better one: that of odds which no prior reaches.
const BETTER: f64 = 10.0;

/// Whether strikes of a box that lies square are far less likely, without any effect, than those of one that faces each strike.
pub(crate) fn faces_each_strike(
    rig: &Rig,
    world: &World,
    strikes: &[Strike],
    thresholds: &Thresholds,
    square: &Fitted,
) -> Result<bool, DiagnoseError> {
    let is_tracked = strikes.iter().any(|strike| strike.conditions.yaw.is_some());
    if rig.object.shape() != Shape::Box || is_tracked {
        return Ok(false);
    }
    let mut facing = strikes.to_vec();
    for strike in &mut facing {
        strike.conditions.yaw = Some(strike.command.angle);
    }
    let (prepared, _) = prepare(rig, world, &facing, thresholds)?;
    let facing = match fit_null(prepared, world, thresholds.small_wander) {
        Ok((_, facing)) => facing,
        Err(DiagnoseError::NoFit { .. }) => return Ok(false),
        Err(error) => return Err(error),
    };
    Ok(facing.likelihood() > square.likelihood() + BETTER)
}
