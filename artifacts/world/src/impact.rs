//! The impact of the tip on the object, as the arm delivers it.

use values::{Command, Conditions};

use crate::effects::Effect;

/// What the tip does to the object, as the arm delivers it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Speed in m/s and angle in rad.
    pub command: Command,
    /// Lateral offset of the tip's line, in m to the left of the object's centre.
    pub tip_offset: f64,
    /// Speed of parting over speed of approach.
    pub restitution: f64,
    /// How the object is turned, in rad: 0 where a box's faces lie along the table's axes. Of a round one it counts for nothing.
    pub yaw: f64,
    /// Logarithm of a factor on the world's friction between tip and object, over which a launch is interpolated.
    pub tip_friction: f64,
}

impl Impact {
    /// The impact of a tip that the arm leads with this speed and angle, under these effects, in a world of this restitution.
    pub fn of(
        effects: &[Box<dyn Effect>],
        restitution: f64,
        delivered: Command,
        conditions: &Conditions,
    ) -> Self {
        Self {
            command: delivered,
            tip_offset: effects.iter().map(|effect| effect.tip_offset()).sum(),
            tip_friction: effects.iter().map(|effect| effect.tip_friction()).sum(),
            restitution: effects
                .iter()
                .map(|effect| effect.restitution_factor(delivered.speed, conditions))
                .fold(restitution, |e, factor| e * factor),
            yaw: conditions.yaw.map_or(0.0, |seen| {
                effects
                    .iter()
                    .fold(seen, |yaw, effect| yaw - effect.seen_turn())
            }),
        }
    }
}
