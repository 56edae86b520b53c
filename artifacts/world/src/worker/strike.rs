//! One simulated strike.
//!
//! The strike starts with the tip touching the object (an impact that falls between two steps would make the stop a
//! sawtooth of the speed), takes fine steps while tip and object are close and long ones while the object slides
//! alone, and ends when it rests.

use values::{Command, Conditions, Point};

use super::Worker;
use crate::{
    GRAVITY, WorldError,
    effects::{self, Slide},
    record::{Record, Simulated},
    tip_motion::{CREEP, TipMotion},
};

/// No slide lasts longer, in s.
const LONGEST_SLIDE: f64 = 20.0;
/// No slide leads farther, in m: what runs away downhill gains speed, and would take ever more and shorter steps.
const FARTHEST: f64 = 100.0;

impl Worker<'_> {
    /// Strikes the object that the camera sees at rest at `initial` (m) and follows it to its rest.
    ///
    /// Errors: a strike that misses the object, or does not come to a finite rest within 20 s.
    pub fn strike(
        &mut self,
        initial: Point,
        command: Command,
        conditions: &Conditions,
    ) -> Result<Simulated, WorldError> {
        self.strike_until(initial, command, conditions, f64::INFINITY)
    }

    /// Simulates a strike, followed no longer than a time (s since touch), whether it rests by then or not:
    /// [`Simulated::stop`] is then where it is.
    pub fn strike_until(
        &mut self,
        initial: Point,
        command: Command,
        conditions: &Conditions,
        until: f64,
    ) -> Result<Simulated, WorldError> {
        let diverged = |why| WorldError::Diverged {
            speed: command.speed,
            angle: command.angle,
            why,
        };
        if !(command.speed > 0.0
            && command.speed.is_finite()
            && command.angle.is_finite()
            && initial.is_finite())
        {
            return Err(diverged(
                "speed must be above zero, and speed, angle and position finite",
            ));
        }
        let sim = self.simulator;
        let impact = sim.impact(command, initial, conditions);
        if impact.command.speed <= 0.0 {
            return Err(diverged("the arm delivers no speed"));
        }
        let origin = effects::unobserve(&sim.effects, initial);
        let mut motion = self
            .place_at_touch(origin, impact)
            .ok_or_else(|| diverged("the tip passes beside the object"))?;
        let mut record = Record::new(sim, origin);
        let weight = sim.friction * GRAVITY;
        let mut touched = false;
        let mut acceleration = Point::default();
        let mut slowing = weight;
        // An object that moves is struck in the frame that moves with it, and goes on in the table's.
        let mut moving = conditions.moving;
        let mut is_alone = false;
        loop {
            if touched
                && let Some(before) = moving
                && motion.free_step(sim, &self.engine, slowing).is_some()
            {
                self.engine.carry(before * motion.t, before);
                (moving, is_alone) = (None, true);
            }
            let (position, velocity) = (self.engine.position(), self.engine.velocity());
            let free = if is_alone {
                Some(TipMotion::longest_step(sim, velocity.norm(), slowing))
            } else if touched {
                motion.free_step(sim, &self.engine, slowing)
            } else {
                None
            };
            let timestep = free.unwrap_or(sim.steps.contact);
            self.engine.set_timestep(timestep);
            // Forces at the middle of the step keep it second order.
            let slide = Slide {
                position: position + velocity * (0.5 * timestep),
                from: origin,
                velocity: velocity + acceleration * (0.5 * timestep),
                spin: self.engine.spin(),
                dry: weight,
                conditions,
            };
            self.apply_effects(&slide);
            motion.drive(sim, &mut self.engine, free.is_none());
            if free.is_some() {
                self.engine.slide();
            } else {
                self.engine.step();
                touched |= self.engine.tip_touches();
            }
            let begun = motion.t;
            motion.t += timestep;

            let (end, now) = (self.engine.position(), self.engine.velocity());
            if !(end.is_finite() && now.is_finite()) {
                return Err(diverged("the state is no longer finite"));
            }
            if free.is_some() {
                acceleration = (now - velocity) * (1.0 / timestep);
                record.arc(begun, timestep, position, velocity, acceleration);
                if now.norm() > CREEP {
                    slowing = -acceleration.dot(now) / now.norm();
                } else if slowing > 0.0 {
                    let left = now.norm() / slowing;
                    if motion.t + left > LONGEST_SLIDE {
                        return Err(diverged("it has not come to rest within 20 s"));
                    }
                    let braking = now * (-1.0 / left.max(1e-12));
                    record.arc(motion.t, left, end, now, braking);
                    let stop = end + now * (0.5 * left);
                    return Ok(record.end(motion.t + left, stop));
                }
            } else {
                // The impact's own acceleration says nothing of the slide's.
                acceleration = now * (-weight / now.norm().max(1e-12));
                record.step(motion.t, end);
                // An object slower than the tip's own braking is pushed to where the tip stops, and rests against it.
                // One that runs away downhill gains speed and does not.
                if motion.is_over() && now.norm() <= CREEP.min(velocity.norm()) {
                    return Ok(record.end(motion.t, end));
                }
            }
            if free.is_some() && motion.t >= until {
                return Ok(record.end(motion.t, end));
            }
            if end.distance(origin) > FARTHEST {
                return Err(diverged("it runs away"));
            }
            if motion.t > LONGEST_SLIDE {
                return Err(diverged("it has not come to rest within 20 s"));
            }
        }
    }

    fn apply_effects(&mut self, slide: &Slide<'_>) {
        let sim = self.simulator;
        if sim.effects.is_empty() {
            return;
        }
        let factor: f64 = sim
            .effects
            .iter()
            .map(|effect| effect.friction_factor(slide))
            .product();
        self.engine
            .scale_friction(factor * sim.whole_shift().friction.exp());
        let slide = &Slide {
            dry: factor * slide.dry,
            ..*slide
        };
        let acceleration = sim.effects.iter().fold(Point::default(), |sum, effect| {
            sum + effect.acceleration(slide)
        });
        self.engine.push(acceleration);
    }
}
