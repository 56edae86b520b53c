//! What the effects' tests share, and what holds for the whole library.

use values::{Command, Conditions, Point, Rig, Shape};

use super::{
    Acts, AddedEffect, EFFECTS, EffectParameter, EffectSpec, Parameters, Slide, build, effect,
};
use crate::{GRAVITY, Simulated, Simulator, Steps, World};

mod statements;

const FRICTION: f64 = 0.25;
/// Deceleration by friction in a world without effects, in m/s².
pub(super) const DRY: f64 = FRICTION * GRAVITY;
/// Where the camera sees the object at rest, in m.
pub(super) const START: Point = Point::new(0.25, 0.05);
/// A moment, in s after touch, at which the tip has let go.
const RELEASED: f64 = 0.02;

/// The demo's cylinder in still air, in a world with one effect or none.
pub(super) struct Bench {
    pub(super) rig: Rig,
    world: World,
    conditions: Conditions,
}

/// The slide from shortly after the tip let go.
pub(super) struct FreeSlide {
    /// Where it begins, in m.
    pub(super) from: Point,
    /// Velocity there, in m/s.
    velocity: Point,
    /// Where it ends, in m.
    pub(super) stop: Point,
}

/// Velocity in m/s as the camera sees it, `t` seconds after touch.
pub(super) fn velocity(simulated: &Simulated, t: f64) -> Point {
    let half = 0.001;
    (simulated.at(t + half) - simulated.at(t - half)) * (0.5 / half)
}

impl Bench {
    pub(super) fn plain() -> Self {
        let rig = Rig::demo(Shape::Cylinder);
        let world = World::nominal()
            .with("friction", FRICTION)
            .with("fluid_blunt_drag", 0.0)
            .with("fluid_slender_drag", 0.0);
        Self {
            rig,
            world,
            conditions: Conditions::default(),
        }
    }

    pub(super) fn with(name: &str, parameters: &[(&str, f64)]) -> Self {
        let mut bench = Self::plain();
        bench
            .world
            .effects
            .push(AddedEffect::fixed(name, parameters));
        bench
    }

    pub(super) fn and(mut self, name: &str, parameters: &[(&str, f64)]) -> Self {
        self.world
            .effects
            .push(AddedEffect::fixed(name, parameters));
        self
    }

    pub(super) fn parameter(mut self, name: &str, value: f64) -> Self {
        self.world = self.world.with(name, value);
        self
    }

    pub(super) fn during(mut self, session: &str, order: f64) -> Self {
        self.conditions = Conditions {
            session: session.into(),
            order,
            ..Conditions::default()
        };
        self
    }

    pub(super) fn strike(&self, speed: f64, angle: f64) -> Simulated {
        self.strike_in(Steps::default(), speed, angle)
    }

    fn strike_in(&self, steps: Steps, speed: f64, angle: f64) -> Simulated {
        Simulator::with_steps(&self.rig, &self.world, steps)
            .expect("a valid world")
            .worker()
            .strike(START, Command { speed, angle }, &self.conditions)
            .expect("rests")
    }

    pub(super) fn slide(&self, speed: f64, angle: f64) -> FreeSlide {
        let simulated = self.strike(speed, angle);
        let from = simulated.at(RELEASED);
        FreeSlide {
            from,
            velocity: velocity(&simulated, RELEASED),
            stop: simulated.stop,
        }
    }
}

impl FreeSlide {
    /// Speed at which it begins, in m/s.
    pub(super) fn speed(&self) -> f64 {
        self.velocity.norm()
    }

    pub(super) fn assert_distance(&self, expected: f64) {
        let distance = self.stop.distance(self.from);
        assert!(
            (distance - expected).abs() < 3e-4,
            "slid {distance} m, where the formula says {expected} m",
        );
    }

    /// The slide ends where friction and a further acceleration, a function of position and velocity, bring a point.
    pub(super) fn assert_integrates(&self, acceleration: impl Fn(Point, Point) -> Point) {
        let step = 1e-5;
        let (mut position, mut velocity) = (self.from, self.velocity);
        while velocity.norm() > 2.0 * step * DRY {
            let braking = velocity * (-DRY / velocity.norm());
            velocity = velocity + (braking + acceleration(position, velocity)) * step;
            position = position + velocity * step;
        }
        assert_near(self.stop, position, 3e-4);
    }
}

pub(super) fn assert_near(a: Point, b: Point, tolerance: f64) {
    assert!(a.distance(b) < tolerance, "{a:?} is not {b:?}");
}

#[test]
fn every_effect_is_known_by_its_name_and_neutral_does_nothing() {
    let without = Bench::plain().strike(0.8, 0.1);
    for spec in EFFECTS {
        assert_eq!(effect(spec.name).expect("listed").name, spec.name);
        let neutral = Bench::with(spec.name, &[]).strike(0.8, 0.1);
        assert!(without.stop.distance(neutral.stop) < 1e-6, "{}", spec.name);
    }
}

/// Every parameter off its neutral value by so many times its scale, in the session `monday.mcap`.
fn strong(spec: &EffectSpec, times: f64) -> Vec<(&'static str, f64)> {
    let off = |p: &EffectParameter| (p.neutral + times * p.scale).clamp(p.low, p.high);
    match &spec.parameters {
        Parameters::Listed(listed) => listed.iter().map(|p| (p.name, off(p))).collect(),
        Parameters::BySession { parameter: p, .. } => {
            vec![("monday.mcap", off(p)), ("tuesday.mcap", p.neutral)]
        }
    }
}

#[test]
fn every_effect_moves_the_stop_by_more_than_a_millimetre() {
    let plain = Bench::plain().strike(0.9, 0.2).stop;
    for spec in EFFECTS {
        let moved = |times: f64| {
            let bench = Bench::with(spec.name, &strong(spec, times)).during("monday.mcap", 80.0);
            plain.distance(bench.strike(0.9, 0.2).stop)
        };
        // What lies in one place moves with its other parameters, and not every strike comes there.
        let most = [-1.0, 0.5, 1.0, 2.0]
            .map(moved)
            .into_iter()
            .fold(0.0, f64::max);
        assert!(most > 1e-3, "{}: the stop moves by {most} m", spec.name);
    }
}

#[test]
fn halving_every_step_moves_no_stop_by_half_a_millimetre_whatever_the_effect() {
    let Steps { contact, slide } = Steps::default();
    let fine = Steps {
        contact: contact / 2.0,
        slide: slide / 2.0,
    };
    for spec in EFFECTS {
        let bench = Bench::with(spec.name, &strong(spec, 2.0)).during("monday.mcap", 80.0);
        for speed in [0.4, 0.55, 0.7, 0.85, 1.0] {
            let moved = bench
                .strike(speed, 0.3)
                .stop
                .distance(bench.strike_in(fine, speed, 0.3).stop);
            assert!(moved < 0.5e-3, "{}: {moved} m at {speed} m/s", spec.name);
        }
    }
}

#[test]
fn every_parameter_has_room_on_both_sides_of_its_scale() {
    for EffectSpec {
        name, parameters, ..
    } in EFFECTS
    {
        let one;
        let parameters = match parameters {
            Parameters::Listed(listed) => *listed,
            Parameters::BySession { parameter, .. } => {
                one = [*parameter];
                &one
            }
        };
        for p in parameters {
            assert!(
                p.low <= p.neutral
                    && p.neutral <= p.high
                    && p.low < p.high
                    && p.low + 4.0 * p.scale <= p.high,
                "{name}.{}",
                p.name
            );
        }
    }
}

#[test]
fn what_cannot_be_distinguished_says_so_on_both_sides() {
    for spec in EFFECTS {
        for simpler in spec.contains {
            assert!(effect(simpler).expect("known").contains.is_empty());
        }
        for other in spec.equivalent {
            let other = effect(other).expect("known");
            assert!(other.equivalent.contains(&spec.name), "{}", other.name);
        }
    }
}

#[test]
fn values_out_of_range_and_unknown_parameters_are_reported() {
    let error = |name: &str, parameters: &[(&str, f64)]| {
        super::check(&AddedEffect::fixed(name, parameters))
            .expect_err("refused")
            .to_string()
    };
    let unknown = error("friction_patch", &[("centre_x", 0.5)]);
    assert!(
        unknown.contains("`friction_patch.centre_x`") && unknown.contains("center_x, center_y"),
        "{unknown}"
    );
    // A map has more than a person reads.
    let of_a_map = error("table_map", &[("height_12", 0.001)]);
    assert!(
        of_a_map.contains("low_x, high_x") && of_a_map.contains("more") && of_a_map.len() < 250,
        "{of_a_map}"
    );
    let jump = error("friction_by_session", &[("monday.mcap", -1.5)]);
    assert!(
        jump.contains("friction_by_session.monday.mcap = -1.5"),
        "{jump}"
    );
    assert!(error("camera_distortion", &[("k1", f64::NAN)]).contains("must lie in"));
}

#[test]
fn a_world_with_every_effect_reads_back_as_it_was_written() {
    let mut world = World::nominal();
    for spec in EFFECTS {
        let parameters = match spec.parameters {
            Parameters::Listed(listed) => listed.iter().map(|p| (p.name, p.low)).collect(),
            Parameters::BySession { parameter: p, .. } => {
                vec![("monday.mcap", p.low), ("tuesday.mcap", p.high)]
            }
        };
        world
            .effects
            .push(AddedEffect::fixed(spec.name, &parameters));
    }
    assert_eq!(World::parse(&world.to_toml()).expect("valid"), world);
}

#[test]
fn each_acts_where_it_says_and_nowhere_else() {
    let rig = Rig::demo(Shape::Cylinder);
    let conditions = Conditions {
        session: "monday.mcap".into(),
        order: 40.0,
        ..Conditions::default()
    };
    let command = Command::new(0.8, 0.1);
    let places = [(0.3, 0.0), (0.45, 0.1), (0.7, -0.05)].map(|(x, y)| Point::new(x, y));
    for spec in EFFECTS {
        let effect =
            build(&AddedEffect::fixed(spec.name, &strong(spec, 0.7)), &rig).expect("valid");
        let slides = places.map(|position| {
            let slide = Slide {
                position,
                from: places[0],
                velocity: Point::new(2.0 * position.x, position.y),
                spin: 0.0,
                dry: DRY,
                conditions: &conditions,
            };
            (effect.friction_factor(&slide), effect.acceleration(&slide))
        });
        let is_even = slides.iter().all(|slide| *slide == slides[0]);
        let is_idle = is_even && slides[0] == (1.0, Point::default());
        let launches = effect.deliver(command, places[1], &conditions) != command
            || effect.tip_offset() != 0.0
            || effect.restitution_factor(1.0, &conditions) != 1.0;
        let is_seen = places.iter().any(|place| effect.observe(*place) != *place);
        let expected = match effect.acts() {
            Acts::Launch => (true, true, true, false),
            Acts::Strike => (true, false, false, false),
            Acts::Slide => (false, false, false, false),
            Acts::Camera => (true, true, false, true),
        };
        let found = (is_even, is_idle, launches, is_seen);
        assert_eq!(found, expected, "{}", spec.name);
    }
}
