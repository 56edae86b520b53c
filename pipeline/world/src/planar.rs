//! The slide without contacts: planar motion under friction, integrated in long steps.
//!
//! The same world as MuJoCo's, a hundred times faster: from where the tip lets go the object is one planar body that rubs on
//! an even base ([`Base`]), which MuJoCo's steps approach as well. The effects act
//! through the same functions in both. What is found here is fitted and judged in MuJoCo afterwards.

use values::{Command, Conditions, Point, Rig, Shape, Strike};

use crate::{
    Base, Blow, Release, World, WorldError,
    effects::{self, Acts, Effect, Slide},
    launch::Launch,
};

const GRAVITY: f64 = 9.81;
/// Longest step in s. Four evaluations a step follow the slide to a hundredth of a millimetre.
const LONGEST: f64 = 0.06;
/// Share of the time left that a step takes near rest, where a turning base rubs the less evenly the slower it is, and the last
/// step in s, which ends at rest.
const SHARE: f64 = 0.5;
const LAST: f64 = 0.008;
/// Slides that are followed at once.
const ABREAST: usize = 8;
/// No slide lasts longer, in s.
const ENDLESS: f64 = 20.0;

/// A world in planar form.
pub struct Planar<'a> {
    /// Friction between object and table.
    pub friction: f64,
    /// Speed of parting over speed of approach.
    pub restitution: f64,
    /// What rubs on the table.
    pub base: Base,
    /// Square of the radius of gyration, in m².
    pub gyration: f64,
    /// A small push beside the effects, to see what would follow from it.
    pub push: Option<&'a Push<'a>>,
    effects: &'a [Box<dyn Effect>],
    /// Those of them that act on friction or force, the same all through a slide or not, and on what is seen.
    even: Vec<&'a dyn Effect>,
    varying: Vec<&'a dyn Effect>,
    seen: Vec<&'a dyn Effect>,
}

/// Acceleration in m/s² by seconds since touch, position (m) and velocity (m/s).
pub type Push<'a> = dyn Fn(f64, Point, Point) -> Point + Sync + 'a;

/// What one strike is simulated from, and when it is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// Where the camera sees the object at rest, in m.
    pub initial: Point,
    /// What the arm is told.
    pub command: Command,
    /// Session and order.
    pub conditions: &'a Conditions,
    /// Seconds at which the object is looked at, rising, by the track's clock.
    pub times: &'a [f64],
}

impl<'a> From<&'a Strike> for Shot<'a> {
    /// A logged strike, at its own frames.
    fn from(strike: &'a Strike) -> Self {
        Self {
            initial: strike.initial,
            command: strike.command,
            conditions: &strike.conditions,
            times: &strike.track.t,
        }
    }
}

/// How one strike differs from what was commanded and measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Kick {
    /// Logarithm of the factor on speed.
    pub speed: f64,
    /// Angle in rad.
    pub angle: f64,
    /// Seconds from touch to the track's zero.
    pub delay: f64,
    /// Error of the resting place, in m.
    pub rest: Point,
}

/// A strike's frames as simulated.
#[derive(Clone, Debug, Default)]
pub struct Frames {
    /// Seen centroids, in m.
    pub at: Vec<Point>,
    /// Their rates of change, in m/s.
    pub rate: Vec<Point>,
    /// Where it is seen at rest, in m.
    pub stop: Point,
}

/// Square of the radius of gyration about the vertical, in m².
pub fn gyration(rig: &Rig) -> f64 {
    match rig.object.shape {
        Shape::Box => {
            let [x, y, _] = rig.object.half_size.unwrap_or_default();
            (x * x + y * y) / 3.0
        }
        Shape::Cylinder | Shape::Sphere => 0.5 * rig.object.radius.unwrap_or(0.0).powi(2),
    }
}

#[derive(Clone, Copy)]
struct Body {
    position: Point,
    velocity: Point,
    spin: f64,
}

#[derive(Clone, Copy, Default)]
struct Rate {
    velocity: Point,
    acceleration: Point,
    turning: f64,
}

impl Body {
    fn along(self, rate: &Rate, t: f64) -> Self {
        Self {
            position: self.position + rate.velocity * t,
            velocity: self.velocity + rate.acceleration * t,
            spin: self.spin + rate.turning * t,
        }
    }
}

impl<'a> Planar<'a> {
    /// The planar form of a world with these effects in place of its own; of a cylinder or a box, for a ball rolls.
    pub fn new(
        rig: &Rig,
        world: &World,
        effects: &'a [Box<dyn Effect>],
    ) -> Result<Self, WorldError> {
        Ok(Self::of(
            [world.value("friction")?, world.value("restitution")?],
            Base::new(rig, world)?,
            gyration(rig) * world.value("inertia_z")?,
            effects,
        ))
    }

    /// The same of friction and restitution, a base, and the square of the radius of gyration in m².
    pub fn of(
        [friction, restitution]: [f64; 2],
        base: Base,
        gyration: f64,
        effects: &'a [Box<dyn Effect>],
    ) -> Self {
        let acting = |place: Acts| {
            let all = effects.iter().map(|effect| effect.as_ref());
            all.filter(|effect| effect.acts() == place).collect()
        };
        Self {
            friction,
            restitution,
            base,
            gyration,
            push: None,
            effects,
            even: acting(Acts::Strike),
            varying: acting(Acts::Slide),
            seen: acting(Acts::Camera),
        }
    }
}

impl Planar<'_> {
    fn observe(&self, point: Point) -> Point {
        self.seen
            .iter()
            .fold(point, |seen, effect| effect.observe(seen))
    }

    /// One strike, seen at its own frames; `None` where it does not rest within 20 s. `launch` is that of a command near
    /// the strike's ([`crate::launch::launches`]).
    pub fn strike(&self, shot: &Shot<'_>, launch: &Launch, kick: &Kick) -> Option<Frames> {
        self.slide(shot, self.release(shot, launch), kick)
    }

    fn release(&self, shot: &Shot<'_>, launch: &Launch) -> Release {
        let delivered = effects::deliver(self.effects, shot.command);
        launch.release(&Blow::of(self.effects, self.restitution, delivered))
    }

    /// The slide alone, from where the tip lets go of the object.
    pub fn slide(&self, shot: &Shot<'_>, release: Release, kick: &Kick) -> Option<Frames> {
        let mut alone = [Flight::new(self, shot, release, kick)];
        fly(&mut alone);
        let [flight] = alone;
        flight.ended()
    }
}

/// A strike to simulate.
#[derive(Clone, Copy)]
pub struct Job<'j> {
    /// The world.
    pub planar: &'j Planar<'j>,
    /// The strike.
    pub shot: Shot<'j>,
    /// How its object leaves the tip.
    pub launch: &'j Launch,
    /// What differs.
    pub kick: Kick,
}

/// As [`Planar::strike`], several at once: each waits for its own square roots, and so they take little longer than one.
pub fn strikes(jobs: &[Job<'_>]) -> Vec<Option<Frames>> {
    jobs.chunks(ABREAST)
        .flat_map(|jobs| {
            let mut flights: Vec<Flight<'_>> = jobs
                .iter()
                .map(|job| {
                    let release = job.planar.release(&job.shot, job.launch);
                    Flight::new(job.planar, &job.shot, release, &job.kick)
                })
                .collect();
            fly(&mut flights);
            flights.into_iter().map(Flight::ended)
        })
        .collect()
}

/// An object on its way.
struct Flight<'s> {
    sliding: Sliding<'s>,
    times: &'s [f64],
    delay: f64,
    body: Body,
    /// Seconds since touch.
    t: f64,
    /// Next frame.
    frame: usize,
    seen: Frames,
    /// At its present place, and the step that is taken from there.
    rate: Rate,
    step: f64,
    phase: Phase,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Phase {
    Slides,
    Rests,
    Endless,
}

impl<'s> Flight<'s> {
    fn new(planar: &'s Planar<'s>, shot: &Shot<'s>, release: Release, kick: &Kick) -> Self {
        // A kick turns and speeds what leaves the tip, and never turns it back, however large it is.
        let mut release = release;
        release.position = release.position.rotated(kick.angle);
        release.velocity = release.velocity.rotated(kick.angle) * kick.speed.exp();
        release.spin *= kick.speed.exp();
        let origin = effects::unobserve(planar.effects, shot.initial + kick.rest);
        let body = Body {
            position: origin + release.position,
            velocity: release.velocity,
            spin: release.spin,
        };
        let times = shot.times;
        let mut seen = Frames {
            at: Vec::with_capacity(times.len()),
            rate: Vec::with_capacity(times.len()),
            stop: Point::default(),
        };
        // Frames before the release lie on the way there.
        let mut frame = 0;
        while frame < times.len() && times[frame] + kick.delay < release.time {
            let share = (times[frame] + kick.delay).max(0.0) / release.time;
            let at = origin + release.position * (share * share);
            let rate = release.position * (2.0 * share / release.time);
            seen.push(planar.observe(at), rate);
            frame += 1;
        }
        let sliding = Sliding::new(planar, shot.conditions);
        let mut flight = Self {
            rate: sliding.rate(release.time, &body),
            sliding,
            times,
            delay: kick.delay,
            body,
            t: release.time,
            frame,
            seen,
            step: 0.0,
            phase: Phase::Slides,
        };
        flight.decide();
        flight
    }

    /// How far to go next, or that it ends here.
    #[inline(always)]
    fn decide(&mut self) {
        let Body {
            position, velocity, ..
        } = self.body;
        let speed = velocity.norm();
        let slowing = -self.rate.acceleration.dot(velocity) / speed.max(1e-12);
        let left = if slowing > 0.0 {
            speed / slowing
        } else {
            ENDLESS
        };
        if left <= LAST {
            self.rest(left);
        } else if self.t > ENDLESS || !speed.is_finite() {
            self.phase = Phase::Endless;
        } else {
            let stretch = self.sliding.stretch(position);
            self.step = LONGEST.min(SHARE * left).min(stretch / speed);
        }
    }

    /// The last step ends at rest.
    fn rest(&mut self, left: f64) {
        let Body {
            position, velocity, ..
        } = self.body;
        let planar = self.sliding.planar;
        for time in &self.times[self.frame..] {
            let into = (time + self.delay - self.t).min(left);
            let at = position + velocity * (into - 0.5 * into * into / left.max(1e-12));
            let still = 1.0 - into / left.max(1e-12);
            self.seen.push(planar.observe(at), velocity * still);
        }
        self.seen.stop = planar.observe(position + velocity * (0.5 * left));
        self.phase = Phase::Rests;
    }

    /// Rate after a share of the step at another rate.
    #[inline(always)]
    fn rate_after(&self, rate: &Rate, share: f64) -> Rate {
        let step = share * self.step;
        self.sliding
            .rate(self.t + step, &self.body.along(rate, step))
    }

    /// A step, by the rates at its beginning, twice in its middle, and at its end (Runge and Kutta).
    #[inline(always)]
    fn go(&mut self, second: &Rate, third: &Rate, fourth: &Rate) {
        let (first, body) = (&self.rate, &self.body);
        let sum = |a: Point, b: Point, c: Point, d: Point| a + (b + c) * 2.0 + d;
        let sixth = self.step / 6.0;
        let next = Body {
            position: body.position
                + sum(
                    first.velocity,
                    second.velocity,
                    third.velocity,
                    fourth.velocity,
                ) * sixth,
            velocity: body.velocity
                + sum(
                    first.acceleration,
                    second.acceleration,
                    third.acceleration,
                    fourth.acceleration,
                ) * sixth,
            spin: body.spin
                + (first.turning + 2.0 * (second.turning + third.turning) + fourth.turning) * sixth,
        };
        while let Some(time) = self.times.get(self.frame)
            && time + self.delay < self.t + self.step
        {
            let share = (time + self.delay - self.t) / self.step;
            let (at, velocity) = hermite(&self.body, &next, share, self.step);
            self.seen.push(self.sliding.planar.observe(at), velocity);
            self.frame += 1;
        }
        self.body = next;
        self.t += self.step;
        self.rate = self.sliding.rate(self.t, &self.body);
        self.decide();
    }

    fn ended(self) -> Option<Frames> {
        (self.phase == Phase::Rests).then_some(self.seen)
    }
}

/// All of them, to their ends.
fn fly(flights: &mut [Flight<'_>]) {
    let mut middle = [Rate::default(); ABREAST];
    let mut again = [Rate::default(); ABREAST];
    let mut end = [Rate::default(); ABREAST];
    loop {
        let slides = |flight: &Flight<'_>| flight.phase == Phase::Slides;
        if !flights.iter().any(slides) {
            return;
        }
        for (rate, flight) in middle.iter_mut().zip(&*flights) {
            if slides(flight) {
                *rate = flight.rate_after(&flight.rate, 0.5);
            }
        }
        for ((rate, middle), flight) in again.iter_mut().zip(&middle).zip(&*flights) {
            if slides(flight) {
                *rate = flight.rate_after(middle, 0.5);
            }
        }
        for ((rate, again), flight) in end.iter_mut().zip(&again).zip(&*flights) {
            if slides(flight) {
                *rate = flight.rate_after(again, 1.0);
            }
        }
        for (k, flight) in flights.iter_mut().enumerate() {
            if slides(flight) {
                flight.go(&middle[k], &again[k], &end[k]);
            }
        }
    }
}

/// What acts during one slide.
struct Sliding<'s> {
    planar: &'s Planar<'s>,
    conditions: &'s Conditions,
    /// Factor on friction, and force per unit mass in m/s², of what is the same all through it.
    factor: f64,
    force: Point,
    /// Square of the base's arm over that of the radius of gyration.
    leverage: f64,
}

impl<'s> Sliding<'s> {
    fn new(planar: &'s Planar<'s>, conditions: &'s Conditions) -> Self {
        let mut slide = Slide {
            position: Point::default(),
            velocity: Point::default(),
            dry: planar.friction * GRAVITY,
            conditions,
        };
        let even = planar.even.iter();
        let factor = even.map(|e| e.friction_factor(&slide)).product();
        slide.dry *= factor;
        let even = planar.even.iter();
        Self {
            planar,
            conditions,
            factor,
            force: even.fold(Point::default(), |sum, e| sum + e.acceleration(&slide)),
            leverage: planar.base.arm.powi(2) / planar.gyration,
        }
    }

    #[inline(always)]
    fn rate(&self, t: f64, body: &Body) -> Rate {
        let planar = self.planar;
        let mut slide = Slide {
            position: body.position,
            velocity: body.velocity,
            dry: planar.friction * GRAVITY,
            conditions: self.conditions,
        };
        let mut dry = slide.dry * self.factor;
        for effect in &planar.varying {
            dry *= effect.friction_factor(&slide);
        }
        slide.dry = dry;
        let mut acceleration = self.force;
        for effect in &planar.varying {
            acceleration = acceleration + effect.acceleration(&slide);
        }
        if let Some(push) = planar.push {
            acceleration = acceleration + push(t, body.position, body.velocity);
        }
        let base = &planar.base;
        let rim = base.arm * body.spin;
        let [pull, turning] = base.pull(body.velocity.dot(body.velocity), rim * rim);
        Rate {
            velocity: body.velocity,
            acceleration: acceleration - body.velocity * (dry * pull),
            turning: -dry * turning * body.spin * self.leverage,
        }
    }

    /// Distance in m that one step may go from a position.
    fn stretch(&self, position: Point) -> f64 {
        let each = self.planar.varying.iter();
        each.fold(f64::INFINITY, |least, e| least.min(e.stretch(position)))
    }
}

impl Frames {
    fn push(&mut self, at: Point, rate: Point) {
        self.at.push(at);
        self.rate.push(rate);
    }
}

/// Position and velocity a share `s` of a step (s) from `a` to `b`.
fn hermite(a: &Body, b: &Body, s: f64, step: f64) -> (Point, Point) {
    let (s2, s3) = (s * s, s * s * s);
    let at = a.position * (2.0 * s3 - 3.0 * s2 + 1.0)
        + b.position * (3.0 * s2 - 2.0 * s3)
        + (a.velocity * (s3 - 2.0 * s2 + s) + b.velocity * (s3 - s2)) * step;
    (at, a.velocity * (1.0 - s) + b.velocity * s)
}

#[cfg(test)]
mod tests {
    use values::Track;

    use super::*;
    use crate::{AddedEffect, Estimate, Simulator, launch::launches};

    /// Strikes over the rig's speeds and angles, with frames to compare at.
    fn strikes(rig: &Rig) -> Vec<Strike> {
        let times: Vec<f64> = (1..60).map(|i| f64::from(i) / rig.camera.rate).collect();
        (0..6)
            .map(|i| {
                let share = f64::from(i) / 5.0;
                let range = rig.robot.angle;
                let command = Command {
                    speed: 0.45 + 0.5 * share,
                    angle: range.low + (range.high - range.low) * ((2.0 * share) % 1.0),
                };
                Strike {
                    id: String::new(),
                    log: String::new(),
                    index: 0,
                    t_start: 0.0,
                    initial: Point::new(0.3, 0.05),
                    stop: Point::default(),
                    command,
                    track: Track {
                        x: vec![0.0; times.len()],
                        y: vec![0.0; times.len()],
                        t: times.clone(),
                    },
                    split: values::Split::Train,
                    conditions: Conditions {
                        session: "monday.mcap".into(),
                        order: 10.0 * f64::from(i),
                    },
                }
            })
            .collect()
    }

    fn added(name: &str, parameters: &[(&str, f64)]) -> AddedEffect {
        let value = |(name, value): &(&str, f64)| (name.to_string(), Estimate::fixed(*value));
        AddedEffect {
            name: name.into(),
            parameters: parameters.iter().map(value).collect(),
        }
    }

    /// Greatest distance in m between the planar slide and MuJoCo's, over all frames and stops.
    fn apart(shape: Shape, hidden: Option<(&str, &[(&str, f64)])>) -> f64 {
        let rig = Rig::demo(shape);
        let world = World::nominal(&rig)
            .with("friction", 0.22)
            .with("restitution", 0.5);
        let mut with = world.clone();
        with.effects
            .extend(hidden.map(|(name, parameters)| added(name, parameters)));
        let effects: Vec<_> = with
            .effects
            .iter()
            .map(|added| effects::build(added, &rig).expect("an effect of the library"))
            .collect();
        let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
        let strikes = strikes(&rig);
        let commands: Vec<Command> = strikes.iter().map(|strike| strike.command).collect();
        let launches = launches(&rig, &world, &commands).expect("a valid world");
        let simulator = Simulator::new(&rig, &with).expect("a valid world");
        let mut worker = simulator.worker();
        let mut worst: f64 = 0.0;
        for (strike, launch) in strikes.iter().zip(launches) {
            let frames = planar
                .strike(&strike.into(), &launch.expect("parts"), &Kick::default())
                .expect("rests");
            let simulated = worker
                .strike(strike.initial, strike.command, &strike.conditions)
                .expect("rests");
            worst = worst.max(frames.stop.distance(simulated.stop));
            for (t, at) in strike.track.t.iter().zip(&frames.at) {
                worst = worst.max(at.distance(simulated.at(*t)));
            }
        }
        worst
    }

    /// A slide in steps a twentieth as long.
    fn finely(mut flight: Flight<'_>) -> Frames {
        while flight.phase == Phase::Slides {
            flight.step *= 0.05;
            let middle = flight.rate_after(&flight.rate, 0.5);
            let again = flight.rate_after(&middle, 0.5);
            let end = flight.rate_after(&again, 1.0);
            flight.go(&middle, &again, &end);
        }
        flight.ended().expect("rests")
    }

    #[test]
    fn its_steps_follow_the_slide_and_several_at_once_are_each_as_alone() {
        let cases: &[(&str, &[(&str, f64)])] = &[
            ("speed_weakening_friction", &[("rise", 0.3), ("speed", 0.3)]),
            ("anisotropic_friction", &[("contrast", 0.1)]),
            (
                "friction_patch",
                &[("center_x", 0.5), ("change", 0.5), ("radius", 0.04)],
            ),
            ("table_bowl", &[("curvature", 0.04), ("center_x", 0.4)]),
            ("off_centre_contact", &[("offset", 0.004)]),
        ];
        let mut worst: f64 = 0.0;
        for shape in [Shape::Cylinder, Shape::Box] {
            let rig = Rig::demo(shape);
            let world = World::nominal(&rig).with("friction", 0.22);
            let strikes = strikes(&rig);
            let commands: Vec<Command> = strikes.iter().map(|s| s.command).collect();
            let launches = launches(&rig, &world, &commands).expect("a valid world");
            let launches: Vec<Launch> = launches.into_iter().flatten().collect();
            for (name, parameters) in cases {
                let effects = [effects::build(&added(name, parameters), &rig).expect("an effect")];
                let planar = Planar::new(&rig, &world, &effects).expect("known parameters");
                let jobs: Vec<Job<'_>> = (0..2 * ABREAST - 1)
                    .map(|i| i % strikes.len())
                    .map(|i| Job {
                        planar: &planar,
                        shot: (&strikes[i]).into(),
                        launch: &launches[i],
                        kick: Kick::default(),
                    })
                    .collect();
                for (job, frames) in jobs.iter().zip(super::strikes(&jobs)) {
                    let frames = frames.expect("rests");
                    let alone = planar.strike(&job.shot, job.launch, &job.kick);
                    assert_eq!(alone.expect("rests").at, frames.at, "{name}");
                    let release = planar.release(&job.shot, job.launch);
                    let fine = finely(Flight::new(&planar, &job.shot, release, &job.kick));
                    for (a, b) in frames.at.iter().zip(&fine.at) {
                        worst = worst.max(a.distance(*b));
                    }
                }
            }
        }
        assert!(worst < 2e-5, "{worst} m");
    }

    #[test]
    fn it_follows_mujoco_whatever_the_effect() {
        let cases: &[(&str, &[(&str, f64)])] = &[
            ("viscous_drag", &[("rate", 0.3)]),
            ("quadratic_drag", &[("coefficient", 0.2)]),
            ("speed_weakening_friction", &[("rise", 0.3), ("speed", 0.3)]),
            (
                "anisotropic_friction",
                &[("contrast", 0.1), ("direction", 0.5)],
            ),
            (
                "friction_patch",
                &[("center_x", 0.5), ("change", 0.3), ("radius", 0.08)],
            ),
            ("friction_drift", &[("rate", 0.2)]),
            ("friction_by_session", &[("monday.mcap", 0.1)]),
            ("table_tilt", &[("tilt_x", -0.004), ("tilt_y", 0.006)]),
            ("table_bowl", &[("curvature", 0.04), ("center_x", 0.4)]),
            ("striker_speed_error", &[("offset", -0.04), ("cap", 0.9)]),
            ("striker_angle_bias", &[("bias", 0.03)]),
            ("speed_dependent_restitution", &[("slope", 0.2)]),
            ("off_centre_contact", &[("offset", 0.002)]),
            ("camera_rotation", &[("angle", 0.02)]),
            ("camera_distortion", &[("k1", 0.08)]),
        ];
        let plain = apart(Shape::Cylinder, None);
        assert!(plain < 1e-4, "without effects: {plain} m");
        for (name, parameters) in cases {
            let apart = apart(Shape::Cylinder, Some((name, parameters)));
            assert!(apart < 4e-4, "{name}: {apart} m");
        }
        let turning = apart(Shape::Box, None);
        assert!(turning < 2e-4, "a box that turns: {turning} m");
    }
}
