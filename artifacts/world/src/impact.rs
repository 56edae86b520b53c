//! The impact of the tip on the object, as the arm delivers it: restitution, the contact's duration, friction within it.

use std::f64::consts::PI;

use values::{Command, Conditions, Point};

use crate::effects::Effect;
use crate::touch::Nearest;

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

/// A correction of what the arm delivers, learnt from strikes: it acts after the world's effects and before the impact.
pub trait Delivery: Send + Sync {
    /// What is delivered (m/s, rad) for the command that was sent; `by_effects` gives what the world's effects alone would deliver for
    /// a command.
    fn deliver(&self, commanded: Command, by_effects: &dyn Fn(Command) -> Command) -> Command;
}

/// The arm delivers what it is commanded, whatever the world's effects make of a command: a solve then answers with the launch that a
/// path needs.
#[derive(Clone, Copy, Debug, Default)]
pub struct AsCommanded;

impl Delivery for AsCommanded {
    fn deliver(&self, commanded: Command, _by_effects: &dyn Fn(Command) -> Command) -> Command {
        commanded
    }
}

/// Distance of the reference beyond the cone, relative to what friction reaches.
const BEYOND_CONE: f64 = 1.02;
/// Share of the slip that one step takes away where friction can.
const TAKEN: f64 = 0.9;

/// The state of the contact in one step of an impact.
pub(crate) struct Grip {
    /// Square of the object's radius of gyration in m².
    pub(crate) gyration: f64,
    /// Coefficient of friction between tip and object.
    pub(crate) friction: f64,
    /// The contact's spring and damper per unit mass, in 1/s² and 1/s.
    pub(crate) solref: [f64; 2],
}

impl Grip {
    /// Rate in 1/s at which MuJoCo shall pull the slip towards zero in a step of `timestep` s; `velocity` (m/s) is that of the
    /// object's centre less the tip's, `spin` the object's in rad/s.
    pub(crate) fn rate(&self, touch: &Nearest, velocity: Point, spin: f64, timestep: f64) -> f64 {
        let Nearest { gap, arm, normal } = *touch;
        let tangent = Point::new(-normal.y, normal.x);
        let at_touch = velocity + Point::new(-arm.y, arm.x) * spin;
        let (parting, slip) = (at_touch.dot(normal), at_touch.dot(tangent));
        let all = TAKEN / timestep;
        // Velocity that a unit impulse over the mass gives the touched point, along the normal and against the slip.
        let lever = (cross(arm, normal), cross(arm, tangent) * slip.signum());
        let knn = 1.0 + lever.0 * lever.0 / self.gyration;
        let knt = lever.0 * lever.1 / self.gyration;
        let ktt = 1.0 + lever.1 * lever.1 / self.gyration;
        let [stiffness, damping] = self.solref;
        let pushed = (stiffness * -gap - damping * parting).max(0.0);
        let reached = pushed * (self.friction * ktt - knt) / (knn - self.friction * knt);
        (BEYOND_CONE * reached.max(0.0) / slip.abs().max(1e-9)).min(all)
    }
}

fn cross(a: Point, b: Point) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Speed of release over speed of approach of MuJoCo's semi-implicit steps through a contact of stiffness and damping
/// given per unit mass (1/s², 1/s), from a start half a step deep.
fn stepped_restitution(stiffness: f64, damping: f64, timestep: f64) -> f64 {
    let (mut depth, mut speed) = (0.5 * timestep, 1.0);
    while depth > 0.0 {
        speed -= timestep * (stiffness * depth + damping * speed).max(0.0);
        depth += timestep * speed;
    }
    -speed
}

/// Direct `solref` (−stiffness, −damping) of a contact that restores `restitution` (0.14–0.99) when it is taken through
/// in steps of `timestep` seconds, and whose undamped half period is `contact_time` in seconds.
pub fn contact_solref(contact_time: f64, restitution: f64, timestep: f64) -> [f64; 2] {
    let frequency = PI / contact_time;
    let stiffness = frequency * frequency;
    let (mut low, mut high) = (0.0, 2.0 * frequency);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if stepped_restitution(stiffness, middle, timestep) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    [-stiffness, -0.5 * (low + high)]
}

/// Tip speeds (m/s) and restitutions at which the contact's duration is measured.
pub(crate) const SPEEDS: [f64; 2] = [0.4, 1.0];
pub(crate) const RESTITUTIONS: [f64; 2] = [0.35, 0.65];

/// By how much MuJoCo's contact launches faster than an impact without duration: `constant + by_inverse_speed / speed` of the launch
/// speed, at each restitution, and linear between.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactDuration([Excess; 2]);

#[derive(Clone, Copy, Debug, Default)]
struct Excess {
    constant: f64,
    /// Coefficient of the inverse tip speed, in m/s.
    by_inverse_speed: f64,
}

impl Excess {
    fn at(self, speed: f64) -> f64 {
        self.constant + self.by_inverse_speed / speed.max(SPEEDS[0] / 2.0)
    }
}

impl ContactDuration {
    /// From launch speeds over those of an impact without duration, less one, at each restitution and each speed.
    pub(crate) fn of(measured: [[f64; 2]; 2]) -> Self {
        Self(measured.map(|[slow, fast]| {
            let by_inverse_speed = (slow - fast) / (1.0 / SPEEDS[0] - 1.0 / SPEEDS[1]);
            Excess {
                constant: fast - by_inverse_speed / SPEEDS[1],
                by_inverse_speed,
            }
        }))
    }

    /// Factor on a tip speed (m/s) that gives the launch of an impact without duration.
    pub(crate) fn factor(self, speed: f64, restitution: f64) -> f64 {
        let [low, high] = RESTITUTIONS;
        let share = (restitution - low) / (high - low);
        let [at_low, at_high] = self.0.map(|excess| excess.at(speed));
        1.0 / (1.0 + at_low + share * (at_high - at_low))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The limit of short steps.
    fn formula(damping_ratio: f64) -> f64 {
        let root = (1.0 - damping_ratio * damping_ratio).sqrt();
        (-damping_ratio / root
            * (2.0 * damping_ratio * root).atan2(2.0 * damping_ratio * damping_ratio - 1.0))
        .exp()
    }

    #[test]
    fn short_steps_approach_the_formula() {
        for restitution in [0.2, 0.3, 0.5, 0.8, 0.95] {
            let [stiffness, damping] = contact_solref(0.002, restitution, 1e-8);
            let ratio = -damping / (2.0 * (-stiffness).sqrt());
            assert!((formula(ratio) - restitution).abs() < 1e-4, "{restitution}");
        }
    }
}
