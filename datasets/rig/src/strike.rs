//! One impact and what follows, before any camera noise.

use values::{Command, Point};

use crate::body::Body;
use crate::impact::{self, Tip};
use crate::motion::Motion;
use crate::slide::Lying;
use crate::surface::Surface;
use crate::{RigSimError, StrikeIndex, Truth, roll, slide};

/// No contact gives back more than this share of the speed of approach.
const HIGHEST_RESTITUTION: f64 = 0.98;

/// What one impact does, without noise.
#[derive(Clone, Debug)]
pub struct StrikeOutcome {
    /// Distance from the tip's centre to the object's at the impact, in m.
    pub gap: f64,
    motion: Motion,
}

impl StrikeOutcome {
    /// Where the object comes to rest on the table, in m.
    pub fn stop(&self) -> Point {
        self.motion.stop()
    }

    /// Seconds from the impact to rest; 0 if the tip missed.
    pub fn rest_time(&self) -> f64 {
        self.motion.rest_time()
    }

    /// Where its centre is this long after the impact (s), on the table, in m.
    pub fn at(&self, time: f64) -> Point {
        self.motion.at(time)
    }

    /// How it is turned this long after the impact (s), in rad.
    pub fn yaw(&self, time: f64) -> f64 {
        self.motion.yaw(time)
    }

    /// Every point passed at the integrator's steps, in m.
    pub fn points(&self) -> impl Iterator<Item = Point> {
        self.motion.points()
    }
}

/// A truth made ready to strike.
#[derive(Clone, Debug)]
pub(crate) struct PreparedRig {
    pub truth: Truth,
    body: Body,
}

impl PreparedRig {
    /// Errors if the rig file's object lacks a size.
    pub(crate) fn new(truth: Truth) -> Result<Self, RigSimError> {
        let body = Body::new(&truth.rig.object)?;
        Ok(Self { truth, body })
    }

    /// The farthest that any part of the object lies from its centre, in m.
    pub(crate) fn reach(&self) -> f64 {
        self.body.reach()
    }

    /// Strikes the object that rests at a point of the table with what the arm delivers.
    /// `friction_factor` is what this strike's friction differs by from the rig's.
    pub(crate) fn strike(
        &self,
        from: impl Into<Lying>,
        delivered: Command,
        index: StrikeIndex,
        friction_factor: f64,
    ) -> StrikeOutcome {
        self.strike_aside(from, delivered, 0.0, index, friction_factor)
    }

    /// One strike by a tip whose line passes so far (m) to the left of the object's centre.
    pub(crate) fn strike_aside(
        &self,
        from: impl Into<Lying>,
        delivered: Command,
        aside: f64,
        index: StrikeIndex,
        friction_factor: f64,
    ) -> StrikeOutcome {
        let from = from.into();
        let Truth {
            hidden,
            restitution,
            tip_friction,
            rolling,
            ..
        } = &self.truth;
        let tip = Tip {
            radius: self.truth.rig.striker.radius,
            offset: aside + hidden.acts().map(|effect| effect.tip_offset()).sum::<f64>(),
            friction: *tip_friction,
        };
        let bounce = |speed: f64| {
            let factor: f64 = hidden
                .acts()
                .map(|effect| effect.restitution(speed, index))
                .product();
            (restitution * factor).clamp(0.0, HIGHEST_RESTITUTION)
        };
        // The tip's velocity along the edges of a box as it lies.
        let velocity = Point::polar(delivered.speed, delivered.angle - from.yaw);
        let Some(launch) = impact::strike(&self.body, tip, velocity, bounce) else {
            return StrikeOutcome {
                gap: self.body.reach() + tip.radius,
                motion: Motion::still(from.at, from.yaw),
            };
        };
        let launched = launch.velocity.rotated(from.yaw);
        let friction = self.truth.friction * friction_factor;
        let surface = Surface::new(friction, hidden, index).with_fences(&self.truth.fences);
        let motion = if self.body.ball {
            roll::roll(&self.body, &surface, from.at, launched, rolling / friction)
        } else {
            slide::slide(&self.body, &surface, from, launched, launch.spin)
        };
        StrikeOutcome {
            gap: launch.gap,
            motion,
        }
    }
}

impl Truth {
    /// The strike without scatter or noise: `initial` is where the camera sees the object, `command` what the arm is sent.
    pub fn outcome(
        &self,
        initial: Point,
        command: Command,
        index: StrikeIndex,
    ) -> Result<StrikeOutcome, RigSimError> {
        let prepared = PreparedRig::new(self.without_strikes())?;
        let from = self.hidden.unsee(initial, self.rig.camera.centre, index);
        Ok(prepared.strike(from, self.hidden.deliver(command, from, index), index, 1.0))
    }

    /// Where the camera would see that strike's stop, without scatter or noise, in m.
    pub fn expected_stop(
        &self,
        initial: Point,
        command: Command,
        index: StrikeIndex,
    ) -> Result<Point, RigSimError> {
        Ok(self.see(self.outcome(initial, command, index)?.stop(), index))
    }
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;
    use crate::Hidden;

    #[test]
    fn a_turned_box_on_a_turned_table_moves_as_a_straight_one() {
        let mut truth = Truth::demo(&Truth::demo_rig(Shape::Box), 1);
        truth.hidden = Hidden::none();
        let prepared = PreparedRig::new(truth).expect("demo sizes");
        let struck = |angle: f64, yaw: f64| {
            let (at, speed) = (Point::default(), 0.8);
            let delivered = Command { speed, angle };
            prepared.strike(Lying { at, yaw }, delivered, StrikeIndex::default(), 1.0)
        };
        let straight = struck(0.2, 0.0);
        assert!(straight.yaw(straight.rest_time()).abs() > 0.05);
        for yaw in [-0.2, 0.1] {
            let turned = struck(0.2 + yaw, yaw);
            assert!(turned.stop().distance(straight.stop().rotated(yaw)) < 1e-9);
            for time in [0.0, 0.1, 0.3] {
                assert!((turned.yaw(time) - straight.yaw(time) - yaw).abs() < 1e-9);
            }
            // The same line onto a face that is turned leads elsewhere.
            assert!(struck(0.2, yaw).stop().distance(straight.stop()) > 2e-3);
        }
    }
}
