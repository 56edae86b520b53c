//! One object from where the tip lets go of it to its rest, in steps as long as its motion is smooth.

use values::Point;

use super::{
    forces::{Body, Forces, Rate},
    strike::{Deviation, Frames, StrikeInput},
    world::Planar,
};
use crate::{Release, effects};

/// Longest step in s. Four evaluations a step follow the slide to a hundredth of a millimetre.
const LONGEST: f64 = 0.06;
/// Share of the time left that a step takes near rest, where a turning base rubs the less evenly the slower it is, and the last
/// step in s, which ends at rest.
const SHARE: f64 = 0.5;
const LAST: f64 = 0.008;
/// No slide lasts longer, in s.
const ENDLESS: f64 = 20.0;
/// No table is larger, in m from the robot's base: what slides farther runs away, ever faster down a dome, and does not rest.
const FARTHEST: f64 = 10.0;

pub(super) struct Sliding<'s> {
    pub(super) forces: Forces<'s>,
    times: &'s [f64],
    to_rest: bool,
    delay: f64,
    /// Longest step, in m, over which effects are smooth.
    longest: f64,
    pub(super) body: Body,
    /// Seconds since touch.
    pub(super) t: f64,
    pub(super) frame: usize,
    seen: Frames,
    /// Rates at the present place, and the step taken from there, in s.
    pub(super) rate: Rate,
    pub(super) step: f64,
    pub(super) phase: Phase,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    Slides,
    Rests,
    Endless,
}

impl<'s> Sliding<'s> {
    pub(super) fn new(
        planar: &'s Planar<'s>,
        input: &StrikeInput<'s>,
        release: Release,
        deviation: &Deviation,
    ) -> Self {
        // A deviation turns and speeds what leaves the tip, and never turns it back, however large it is.
        let mut release = release;
        release.position = release.position.rotated(deviation.angle);
        release.velocity = release.velocity.rotated(deviation.angle) * deviation.speed.exp();
        release.spin *= deviation.speed.exp();
        let origin = effects::unobserve(planar.effects, input.initial + deviation.rest);
        // What it had before stays with it.
        let moving = input.conditions.moving.unwrap_or_default();
        let body = Body {
            position: origin + release.position + moving * release.time,
            velocity: release.velocity + moving,
            spin: release.spin,
        };
        let times = input.times;
        let mut seen = Frames {
            at: Vec::with_capacity(times.len()),
            rate: Vec::with_capacity(times.len()),
            stop: Point::default(),
        };
        // Frames before the release lie on the way there.
        let mut frame = 0;
        while frame < times.len() && times[frame] + deviation.delay < release.time {
            let share = (times[frame] + deviation.delay).max(0.0) / release.time;
            let at = origin + release.position * (share * share) + moving * (share * release.time);
            let rate = release.position * (2.0 * share / release.time) + moving;
            seen.push(planar.observe(at), rate);
            frame += 1;
        }
        let forces = Forces::new(planar, input.conditions, origin, deviation.friction);
        let mut object = Self {
            rate: forces.rate(&body),
            forces,
            times,
            to_rest: input.to_rest,
            delay: deviation.delay,
            longest: f64::INFINITY,
            body,
            t: release.time,
            frame,
            seen,
            step: 0.0,
            phase: Phase::Slides,
        };
        object.decide();
        object
    }

    /// Limits steps to `longest` (m).
    pub(super) fn within(&mut self, longest: f64) {
        self.longest = longest;
        let speed = self.body.velocity.norm();
        self.step = self.step.min(longest / speed);
    }

    /// Time to rest, in s, at the present deceleration.
    #[inline(always)]
    pub(super) fn left(&self) -> f64 {
        let velocity = self.body.velocity;
        let speed = velocity.norm();
        let slowing = -self.rate.acceleration.dot(velocity) / speed.max(1e-12);
        if slowing > 0.0 {
            speed / slowing
        } else {
            ENDLESS
        }
    }

    /// Chooses the next step, or ends the slide.
    #[inline(always)]
    fn decide(&mut self) {
        let Body {
            position, velocity, ..
        } = self.body;
        let speed = velocity.norm();
        let left = self.left();
        if !self.to_rest && self.frame == self.times.len() {
            self.seen.stop = self.seen.at.last().copied().unwrap_or_default();
            self.phase = Phase::Rests;
        } else if left <= LAST {
            self.rest(left);
        } else if self.t > ENDLESS || position.norm() > FARTHEST || !speed.is_finite() {
            self.phase = Phase::Endless;
        } else {
            let stretch = self.forces.stretch(position).min(self.longest);
            self.step = LONGEST.min(SHARE * left).min(stretch / speed);
        }
    }

    /// The last step ends at rest.
    fn rest(&mut self, left: f64) {
        let Body {
            position, velocity, ..
        } = self.body;
        let planar = self.forces.planar;
        for time in &self.times[self.frame..] {
            let into = (time + self.delay - self.t).min(left);
            let at = position + velocity * (into - 0.5 * into * into / left.max(1e-12));
            let still = 1.0 - into / left.max(1e-12);
            self.seen.push(planar.observe(at), velocity * still);
        }
        self.seen.stop = planar.observe(position + velocity * (0.5 * left));
        self.phase = Phase::Rests;
    }

    #[inline(always)]
    fn rate_after(&self, rate: &Rate, share: f64) -> Rate {
        let step = share * self.step;
        self.forces.rate(&self.body.along(rate, step))
    }

    /// A step, by the rates at its beginning, twice in its middle, and at its end (Runge and Kutta).
    #[inline(always)]
    fn go(&mut self, second: &Rate, third: &Rate, fourth: &Rate) {
        let next = self
            .body
            .stepped([&self.rate, second, third, fourth], self.step);
        while let Some(time) = self.times.get(self.frame)
            && time + self.delay < self.t + self.step
        {
            let share = (time + self.delay - self.t) / self.step;
            let (at, velocity) = hermite(&self.body, &next, share, self.step);
            self.seen.push(self.forces.planar.observe(at), velocity);
            self.frame += 1;
        }
        self.body = next;
        self.t += self.step;
        self.rate = self.forces.rate(&self.body);
        self.decide();
    }

    /// One step.
    pub(super) fn step_on(&mut self) {
        let second = self.rate_after(&self.rate, 0.5);
        let third = self.rate_after(&second, 0.5);
        let fourth = self.rate_after(&third, 1.0);
        self.go(&second, &third, &fourth);
    }

    /// Integrates to rest; `None` where the object does not come to rest.
    pub(super) fn followed(mut self) -> Option<Frames> {
        while self.phase == Phase::Slides {
            self.step_on();
        }
        self.ended()
    }

    pub(super) fn ended(self) -> Option<Frames> {
        (self.phase == Phase::Rests).then_some(self.seen)
    }
}

/// Position and velocity a share `s` of a step (s) from `a` to `b`.
fn hermite(a: &Body, b: &Body, s: f64, step: f64) -> (Point, Point) {
    let [at_a, at_b, by_a, by_b] = weights(s);
    let at = a.position * at_a + b.position * at_b + (a.velocity * by_a + b.velocity * by_b) * step;
    (at, a.velocity * (1.0 - s) + b.velocity * s)
}

/// Weights of the cubic through both ends of a step: how much of each position, and of each velocity times the step, is in the position after a share
/// `s` of it.
pub(super) fn weights(s: f64) -> [f64; 4] {
    let (s2, s3) = (s * s, s * s * s);
    [
        2.0 * s3 - 3.0 * s2 + 1.0,
        3.0 * s2 - 2.0 * s3,
        s3 - 2.0 * s2 + s,
        s3 - s2,
    ]
}
