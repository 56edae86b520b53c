//! How a slide answers to small changes: its equations of motion, linear about it.
//!
//! δp′ = δv, (δv, δω)′ = A·(δp, δv, δω) + b, with A the derivative of the rates and b what a change adds to them, both at the beginning, in the
//! middle and at the end of each step of the slide. One slide, and A along it, serve any number of changes.

use values::{Conditions, Point};

use super::{
    forces::{Body, Forces, Rate},
    sliding::{Phase, Sliding, weights},
    strike::{Deviation, Frames, StrikeInput},
    world::Planar,
};
use crate::{
    Release,
    effects::{self, Effect, Slide},
};

/// Nodes of most slides, at the most.
const NODES: usize = 48;
/// Steps of the differences by position (m), velocity (m/s), spin (rad/s) and the logarithm of friction.
const STEPS: (f64, f64, f64, f64) = (1e-5, 1e-5, 1e-3, 1e-4);

/// A slide, and what small changes make of it.
pub struct Response<'r> {
    /// The slide itself.
    pub frames: Frames,
    /// Position of the object at each frame, not as a camera sees it, and the derivative of what is seen.
    places: Vec<Place>,
    conditions: &'r Conditions,
    initial: Point,
    origin: Point,
    release: Release,
    /// The object as it leaves the tip, deviation included.
    released: Body,
    /// Shares of the way to the release, squared, at the frames before it.
    before: Vec<f64>,
    /// At the beginning of the first step, then in the middle and at the end of each.
    nodes: Vec<Node>,
    steps: Vec<Step>,
    /// Cubic weights of the frames within steps, on the position and velocity at both ends of the step.
    weights: Vec<[f64; 4]>,
    /// Times into the last stretch, which ends at rest, and how long that takes.
    last: Vec<f64>,
    left: f64,
}

/// A frame's place, and the derivative of what is seen of it by x and by y.
struct Place {
    at: Point,
    seen: [Point; 2],
}

/// The slide at one time.
pub struct Node {
    body: Body,
    /// Where the object was struck, in m.
    from: Point,
    rate: Rate,
    /// Deceleration by dry friction, of all effects, in m/s².
    dry: f64,
    /// Derivative of the rates by the logarithm of friction.
    by_friction: Rate,
    /// Derivatives of the acceleration along x and y and of the turning by position, velocity and spin.
    by: [[f64; 5]; 3],
}

/// A step of the slide: its length, and the frames before its end.
struct Step {
    length: f64,
    end: usize,
}

/// A small change of the state in which the object leaves the tip.
#[derive(Clone, Copy, Debug, Default)]
pub struct StartChange {
    /// Where the object lay, in m.
    pub origin: Point,
    /// Displacement from `origin` to where the tip lets go, in m.
    pub position: Point,
    /// Change of velocity, in m/s.
    pub velocity: Point,
    /// Change of spin, in rad/s.
    pub spin: f64,
}

impl Planar<'_> {
    /// The slide from a release, in steps no longer than `longest` (m); `None` where it does not rest.
    pub fn response<'r>(
        &self,
        input: &StrikeInput<'r>,
        release: Release,
        deviation: &Deviation,
        longest: f64,
    ) -> Option<Response<'r>> {
        let mut object = Sliding::new(self, input, release, deviation);
        object.within(longest);
        let moving = input.conditions.moving.unwrap_or_default();
        let origin = effects::unobserve(self.effects, input.initial + deviation.rest);
        let first = object.body;
        let delay = deviation.delay;
        let before = input.times[..object.frame].iter();
        let share = |time: &f64| ((time + delay).max(0.0) / release.time).powi(2);
        let before: Vec<f64> = before.map(share).collect();
        let mut places: Vec<Point> = before
            .iter()
            .map(|share| {
                let lead = first.position - origin - moving * release.time;
                origin + lead * *share + moving * (share.sqrt() * release.time)
            })
            .collect();
        let mut nodes = Vec::with_capacity(NODES);
        nodes.push(Node::new(&object.forces, object.body));
        let (mut steps, mut within) = (Vec::new(), Vec::with_capacity(input.times.len()));
        while object.phase == Phase::Slides {
            let (t, step, frame) = (object.t, object.step, object.frame);
            let (from, rate) = (object.body, object.rate);
            object.step_on();
            let (to, length) = (object.body, step);
            let middle = Body::between(&from, &rate, &to, &object.rate, length);
            nodes.push(Node::new(&object.forces, middle));
            nodes.push(Node::new(&object.forces, to));
            for time in &input.times[frame..object.frame] {
                let [a, b, c, d] = weights((time + delay - t) / length);
                let (c, d) = (c * length, d * length);
                within.push([a, b, c, d]);
                places.push(
                    from.position * a + to.position * b + from.velocity * c + to.velocity * d,
                );
            }
            steps.push(Step {
                length,
                end: within.len(),
            });
        }
        let Body {
            position, velocity, ..
        } = object.body;
        let (left, t) = (object.left(), object.t);
        let into = |time: &f64| (time + delay - t).min(left);
        let last: Vec<f64> = input.times[object.frame..].iter().map(into).collect();
        places.extend(last.iter().map(|into| {
            let (way, _) = way(*into, left);
            position + velocity * way
        }));
        let seen = |at: Point| -> [Point; 2] {
            match self.seen.is_empty() {
                true => [Point::new(1.0, 0.0), Point::new(0.0, 1.0)],
                false => {
                    let step = STEPS.0;
                    [Point::new(step, 0.0), Point::new(0.0, step)]
                        .map(|aside| (self.observe(at + aside) - self.observe(at)) * step.recip())
                }
            }
        };
        let place = |at| Place { at, seen: seen(at) };
        let places = places.into_iter().map(place).collect();
        Some(Response {
            frames: object.ended()?,
            places,
            conditions: input.conditions,
            initial: input.initial + deviation.rest,
            origin,
            release,
            released: Body {
                position: first.position - origin - moving * release.time,
                velocity: first.velocity - moving,
                spin: first.spin,
            },
            before,
            nodes,
            steps,
            weights: within,
            last,
            left,
        })
    }
}

/// Distance that an object goes at unit velocity within `into` s of its last stretch, which takes `left` s to rest, and its derivative by `left`.
fn way(into: f64, left: f64) -> (f64, f64) {
    let share = into / left.max(1e-12);
    (into * (1.0 - 0.5 * share), 0.5 * share * share)
}

impl Node {
    fn new(forces: &Forces<'_>, body: Body) -> Self {
        let rate = forces.rate(&body);
        let (p, v, spin, friction) = STEPS;
        let by = |change: &dyn Fn(&mut Body), step: f64| {
            let mut beside = body;
            change(&mut beside);
            forces.rate(&beside).less(&rate) * step.recip()
        };
        let by = [
            by(&|body| body.position.x += p, p),
            by(&|body| body.position.y += p, p),
            by(&|body| body.velocity.x += v, v),
            by(&|body| body.velocity.y += v, v),
            by(&|body| body.spin += spin, spin),
        ];
        Self {
            body,
            from: forces.from,
            dry: forces.dry(&body),
            by_friction: forces.rubbed(&body, 1.0 + friction).less(&rate) * friction.recip(),
            by: [
                by.map(|rate| rate.acceleration.x),
                by.map(|rate| rate.acceleration.y),
                by.map(|rate| rate.turning),
            ],
            rate,
        }
    }

    /// Change of the rates by that of the state, and what is added to them.
    #[inline(always)]
    fn changed(&self, by: &Body, and: &Rate) -> Rate {
        let (p, v) = (by.position, by.velocity);
        let along = |row: &[f64; 5]| {
            row[0] * p.x + row[1] * p.y + row[2] * v.x + row[3] * v.y + row[4] * by.spin
        };
        let [x, y, turning] = &self.by;
        Rate {
            velocity: v,
            acceleration: Point::new(along(x), along(y)) + and.acceleration,
            turning: along(turning) + and.turning,
        }
    }

    /// Change of the rates by the logarithm of friction.
    pub fn friction(&self) -> Rate {
        self.by_friction
    }

    /// Change of the rates by a push: its acceleration in m/s² by position and velocity.
    pub fn push(&self, push: &dyn Fn(Point, Point) -> Point) -> Rate {
        Rate {
            acceleration: push(self.body.position, self.body.velocity),
            ..Rate::default()
        }
    }

    fn slide<'c>(&self, conditions: &'c Conditions) -> Slide<'c> {
        Slide {
            position: self.body.position,
            from: self.from,
            velocity: self.body.velocity,
            spin: self.body.spin,
            dry: self.dry,
            conditions,
        }
    }
}

impl Response<'_> {
    /// Change of the start by the logarithm of the launch speed.
    pub fn faster(&self) -> StartChange {
        StartChange {
            velocity: self.released.velocity,
            spin: self.released.spin,
            ..StartChange::default()
        }
    }

    /// Change of the start by the launch angle, in rad.
    pub fn turned(&self) -> StartChange {
        let left = |p: Point| Point::new(-p.y, p.x);
        StartChange {
            position: left(self.released.position),
            velocity: left(self.released.velocity),
            ..StartChange::default()
        }
    }

    /// Change of the start by the spin, in rad/s.
    pub fn spun(&self) -> StartChange {
        StartChange {
            spin: 1.0,
            ..StartChange::default()
        }
    }

    /// Change of the rates by one more effect.
    pub fn effect(&self, node: &Node, effect: &dyn Effect) -> Rate {
        let slide = node.slide(self.conditions);
        let mut rate = node.by_friction * (effect.friction_factor(&slide) - 1.0);
        rate.acceleration = rate.acceleration + effect.acceleration(&slide);
        rate
    }

    /// Change of the frames (all x, then all y) by another start, and by what is added to the rates.
    pub fn answer(&self, start: StartChange, added: &dyn Fn(&Node) -> Rate, column: &mut [f64]) {
        let n = self.places.len();
        let mut frame = 0;
        let mut see = |change: Point| {
            let [x, y] = self.places[frame].seen;
            let seen = x * change.x + y * change.y;
            (column[frame], column[n + frame]) = (seen.x, seen.y);
            frame += 1;
        };
        for share in &self.before {
            see(start.origin + start.position * *share);
        }
        let mut body = Body {
            position: start.origin + start.position,
            velocity: start.velocity,
            spin: start.spin,
        };
        let mut add = added(&self.nodes[0]);
        let mut seen = 0;
        for (step, nodes) in self.steps.iter().zip(self.nodes.windows(3).step_by(2)) {
            let h = step.length;
            let [middle, end] = [added(&nodes[1]), added(&nodes[2])];
            let first = nodes[0].changed(&body, &add);
            let second = nodes[1].changed(&body.along(&first, 0.5 * h), &middle);
            let third = nodes[1].changed(&body.along(&second, 0.5 * h), &middle);
            let fourth = nodes[2].changed(&body.along(&third, h), &end);
            let next = body.stepped([&first, &second, &third, &fourth], h);
            for [a, b, c, d] in &self.weights[seen..step.end] {
                see(body.position * *a
                    + next.position * *b
                    + body.velocity * *c
                    + next.velocity * *d);
            }
            seen = step.end;
            (body, add) = (next, end);
        }
        let Some(node) = self.nodes.last().filter(|_| !self.last.is_empty()) else {
            return;
        };
        // It slows by what brakes it along its way; the last stretch is as long as that takes.
        let (v, a) = (node.body.velocity, node.rate.acceleration);
        let speed = v.norm().max(1e-12);
        let ahead = v * speed.recip();
        let faster = ahead.dot(body.velocity);
        let turned = (body.velocity - ahead * faster) * speed.recip();
        let braked = -(node.changed(&body, &add).acceleration.dot(ahead) + a.dot(turned));
        let longer = (faster - self.left * braked) / -a.dot(ahead);
        for into in &self.last {
            let (way, by_left) = way(*into, self.left);
            see(body.position + body.velocity * way + v * (by_left * longer));
        }
    }

    /// Change of the frames by another world, in which the tip lets go as in `release`: by what differs there, on the way, and in what a camera sees.
    pub fn answer_of(
        &self,
        other: &Planar<'_>,
        release: &Release,
        deviation: &Deviation,
        column: &mut [f64],
    ) {
        let forces = Forces::new(other, self.conditions, self.origin, deviation.friction);
        let start = self.start_of(other, release, deviation);
        let added = |node: &Node| forces.rate(&node.body).less(&node.rate);
        self.answer(start, &added, column);
        if other.seen.is_empty() {
            return;
        }
        let n = self.places.len();
        for (k, (place, here)) in self.places.iter().zip(&self.frames.at).enumerate() {
            let seen = other.observe(place.at) - *here;
            column[k] += seen.x;
            column[n + k] += seen.y;
        }
    }

    fn start_of(
        &self,
        other: &Planar<'_>,
        release: &Release,
        deviation: &Deviation,
    ) -> StartChange {
        let late = release.time - self.release.time;
        let factor = deviation.speed.exp();
        let turned = |p: Point| p.rotated(deviation.angle);
        let (released, rate) = (&self.released, &self.nodes[0].rate);
        StartChange {
            origin: effects::unobserve(other.effects, self.initial) - self.origin,
            position: turned(release.position) - released.position - released.velocity * late,
            velocity: turned(release.velocity) * factor
                - released.velocity
                - rate.acceleration * late,
            spin: release.spin * factor - released.spin - rate.turning * late,
        }
    }
}
