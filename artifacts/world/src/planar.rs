//! The slide without contacts: planar motion under friction, integrated in long steps.
//!
//! The same world as MuJoCo's, a hundred times faster: from where the tip lets go the object is one planar body that rubs on
//! an even base ([`Base`]), which MuJoCo's steps approach as well. The effects act
//! through the same functions in both. What is found here is fitted and judged in MuJoCo afterwards.

mod forces;
mod sliding;

use values::{Command, Conditions, Point, Rig, Shape, Strike};

use crate::{
    Base, Blow, Release, World, WorldError,
    effects::{self, Acts, Effect},
    launch::Launch,
    planar::sliding::{ABREAST, Sliding, to_rest},
};

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
    /// Logarithm of the factor on friction.
    pub friction: f64,
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
        let delivered = effects::deliver(self.effects, shot.command, shot.conditions);
        let blow = Blow::of(self.effects, self.restitution, delivered, shot.conditions);
        launch.release(&blow)
    }

    /// The slide alone, from where the tip lets go of the object.
    pub fn slide(&self, shot: &Shot<'_>, release: Release, kick: &Kick) -> Option<Frames> {
        let mut alone = [Sliding::new(self, shot, release, kick)];
        to_rest(&mut alone);
        let [object] = alone;
        object.ended()
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
            let mut objects: Vec<Sliding<'_>> = jobs
                .iter()
                .map(|job| {
                    let release = job.planar.release(&job.shot, job.launch);
                    Sliding::new(job.planar, &job.shot, release, &job.kick)
                })
                .collect();
            to_rest(&mut objects);
            objects.into_iter().map(Sliding::ended)
        })
        .collect()
}

impl Frames {
    fn push(&mut self, at: Point, rate: Point) {
        self.at.push(at);
        self.rate.push(rate);
    }
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
                        yaw: None,
                    },
                    split: values::Split::Train,
                    conditions: Conditions {
                        session: "monday.mcap".into(),
                        order: 10.0 * f64::from(i),
                    },
                    delivered: None,
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
    fn finely(mut object: Sliding<'_>) -> Frames {
        while object.phase == sliding::Phase::Slides {
            object.step *= 0.05;
            let middle = object.rate_after(&object.rate, 0.5);
            let again = object.rate_after(&middle, 0.5);
            let end = object.rate_after(&again, 1.0);
            object.go(&middle, &again, &end);
        }
        object.ended().expect("rests")
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
                    let fine = finely(Sliding::new(&planar, &job.shot, release, &job.kick));
                    for (a, b) in frames.at.iter().zip(&fine.at) {
                        worst = worst.max(a.distance(*b));
                    }
                }
            }
        }
        assert!(worst < 2e-5, "{worst} m");
    }

    #[test]
    fn a_strike_on_more_friction_of_its_own_is_one_in_a_world_of_more_friction() {
        let rig = Rig::demo(Shape::Cylinder);
        let stop = |friction: f64, kick: Kick| {
            let world = World::nominal(&rig).with("friction", friction);
            let planar = Planar::new(&rig, &world, &[]).expect("known parameters");
            let strikes = strikes(&rig);
            let launch = launches(&rig, &World::nominal(&rig), &[strikes[3].command]);
            let launch = launch.expect("a valid world")[0].expect("parts");
            let frames = planar.strike(&(&strikes[3]).into(), &launch, &kick);
            frames.expect("rests").stop
        };
        let own = Kick {
            friction: 1.1f64.ln(),
            ..Kick::default()
        };
        let apart = stop(0.2, own).distance(stop(0.22, Kick::default()));
        assert!(apart < 1e-9, "{apart} m");
        assert!(stop(0.2, own).distance(stop(0.2, Kick::default())) > 0.01);
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
            (
                "friction_by_session",
                &[("monday.mcap", 0.1), ("tuesday.mcap", -0.1)],
            ),
            ("table_tilt", &[("tilt_x", -0.004), ("tilt_y", 0.006)]),
            ("table_bowl", &[("curvature", 0.04), ("center_x", 0.4)]),
            ("striker_speed_error", &[("offset", -0.04), ("cap", 0.9)]),
            ("striker_angle_bias", &[("bias", 0.03)]),
            ("speed_dependent_restitution", &[("slope", 0.2)]),
            ("off_centre_contact", &[("offset", 0.002)]),
            ("camera_rotation", &[("angle", 0.02)]),
            ("camera_distortion", &[("k1", 0.08)]),
            (
                "striker_angle_error",
                &[("gain", 0.3), ("bias", 0.02), ("slope", -0.05)],
            ),
            (
                "striker_angle_by_session",
                &[("monday.mcap", 0.04), ("tuesday.mcap", 0.0)],
            ),
            ("restitution_drift", &[("rate", -0.3)]),
            (
                "friction_gradient",
                &[("gradient_x", 0.5), ("gradient_y", -0.3)],
            ),
            (
                "friction_step",
                &[("direction", 0.4), ("offset", 0.45), ("change", 0.3)],
            ),
            (
                "friction_map",
                &[("height_12", 0.2), ("height_21", -0.2), ("low_x", 0.3)],
            ),
            ("camera_lean", &[("lean_x", 0.06), ("lean_y", -0.03)]),
            ("striker_speed_error", &[("cap", 1.1), ("softness", 0.4)]),
            ("friction_drift", &[("rate", 1.0), ("saturation", 5.0)]),
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
