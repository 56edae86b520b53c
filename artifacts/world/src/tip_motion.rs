//! The tip from touch on, and the steps that its nearness to the object allows.

use values::{Point, Shape};

use crate::{GRAVITY, Profile, Simulator, engine::Engine, impact::Grip};

/// How long the tip holds its speed after touch, in contact times.
const HELD: f64 = 2.0;
/// Below this speed, in m/s, MuJoCo's soft friction lets the object creep: the rest of the slide, a tenth of a millimetre,
/// is solved exactly from the deceleration seen above it.
pub(crate) const CREEP: f64 = 0.025;
/// Speed in m/s above which an effect shortens the steps of the slide, so that a place on the table is not stepped over.
const STROLL: f64 = 0.5;

pub(crate) struct TipMotion {
    profile: Profile,
    pub(crate) t: f64,
    /// Seconds since touch until it brakes.
    held: f64,
    /// Whether tip and object have been apart.
    has_parted: bool,
}

impl TipMotion {
    /// Starts the motion half a step deep, so that the contact acts from the first step on, whatever the rounding.
    pub(crate) fn begin(profile: Profile, sim: &Simulator) -> Self {
        Self {
            profile,
            t: 0.5 * sim.steps.contact,
            held: HELD * sim.contact_time,
            has_parted: false,
        }
    }

    /// The arm's brake does not bite within a contact of a millisecond or two: the tip holds its speed for as long.
    fn tip(&self) -> (Point, Point) {
        let profile = &self.profile;
        let (strike, velocity) = profile.at(profile.t_strike);
        if self.t < self.held {
            return (strike + velocity * self.t, velocity);
        }
        let (position, slower) = profile.at(profile.t_strike + self.t - self.held);
        (position + velocity * self.held, slower)
    }

    /// Whether the tip has come to rest.
    pub(crate) fn is_over(&self) -> bool {
        self.profile.t_strike + self.t - self.held >= self.profile.t_stop
    }

    /// Length in s of a step in which the object slides alone; none where the tip touches it, or may.
    ///
    /// A box that has left the tip is not struck again by a corner that swings back: whether it is hangs on a degree.
    pub(crate) fn free_step(
        &mut self,
        sim: &Simulator,
        engine: &Engine,
        slowing: f64,
    ) -> Option<f64> {
        let (tip, tip_velocity) = self.tip();
        let (position, velocity) = (engine.position(), engine.velocity());
        let apart = position - tip;
        let opening = (velocity - tip_velocity).dot(apart) / apart.norm().max(1e-12);
        let gap = sim.nearest(engine, tip).gap;
        if gap <= 0.0 && !(self.has_parted && opening > 0.0) {
            return None;
        }
        let longest = Self::longest_step(sim, velocity.norm(), slowing);
        // The gap narrows by friction, at most twice as fast as the world's own.
        let narrowing = 2.0 * sim.friction * GRAVITY;
        let free = std::iter::successors(Some(longest), |step| Some(0.5 * step))
            .take(4)
            .find(|step| gap.max(0.0) + opening * step - 0.5 * narrowing * step * step > 0.0);
        self.has_parted |= free.is_some();
        free
    }

    /// Length in s of a step of an object that slides alone at this speed (m/s) and slows by this much (m/s²).
    pub(crate) fn longest_step(sim: &Simulator, speed: f64, slowing: f64) -> f64 {
        let mut longest = sim.steps.slide;
        // A ball passes from sliding to rolling within a few milliseconds.
        if sim.rig.object.shape() == Shape::Sphere {
            longest *= 0.25;
        }
        if !sim.effects.is_empty() {
            longest *= (STROLL / speed.max(1e-12)).min(1.0);
        }
        if slowing > 0.0 {
            // The last step ends where the rest of the slide is solved exactly.
            longest = longest.min(((speed - 0.8 * CREEP) / slowing).max(sim.steps.contact));
        }
        longest
    }

    /// Moves the tip; once it is no longer near, it is taken out of the object's way.
    pub(crate) fn drive(&self, sim: &Simulator, engine: &mut Engine, near: bool) {
        if near {
            let (position, velocity) = self.tip();
            engine.drive_striker(position, velocity);
            let touch = sim.nearest(engine, position);
            let grip = Grip {
                gyration: sim.gyration,
                friction: sim.tip_friction,
                solref: engine.strike_solref(),
            };
            let velocity = engine.velocity() - velocity;
            engine.set_grip(grip.rate(&touch, velocity, engine.spin(), sim.steps.contact));
        } else {
            engine.drive_striker(Point::new(-10.0, 0.0), Point::default());
        }
    }
}
