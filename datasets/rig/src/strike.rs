//! One impact and what follows, before any camera noise.

use values::{Command, Point};

use crate::body::Body;
use crate::impact::{self, Tip};
use crate::motion::Motion;
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
        from: Point,
        delivered: Command,
        index: StrikeIndex,
        friction_factor: f64,
    ) -> StrikeOutcome {
        self.strike_aside(from, delivered, 0.0, index, friction_factor)
    }

    /// The same by a tip whose line passes so far (m) to the left of the object's centre.
    pub(crate) fn strike_aside(
        &self,
        from: Point,
        delivered: Command,
        aside: f64,
        index: StrikeIndex,
        friction_factor: f64,
    ) -> StrikeOutcome {
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
        let velocity = Point::polar(delivered.speed, delivered.angle);
        let Some(launch) = impact::strike(&self.body, tip, velocity, bounce) else {
            return StrikeOutcome {
                gap: self.body.reach() + tip.radius,
                motion: Motion::still(from),
            };
        };
        let friction = self.truth.friction * friction_factor;
        let surface = Surface::new(friction, hidden, index);
        let motion = if self.body.ball {
            roll::roll(
                &self.body,
                &surface,
                from,
                launch.velocity,
                rolling / friction,
            )
        } else {
            slide::slide(&self.body, &surface, from, launch.velocity, launch.spin)
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
        Ok(prepared.strike(from, self.hidden.deliver(command, index), index, 1.0))
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
