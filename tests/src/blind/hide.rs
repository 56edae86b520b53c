//! Draws what a set of the plain benchmark hides, and makes it as large as the case states.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rig::{Effect, Hidden, StrikeIndex, Truth};
use values::{Command, Point, Shape};

use super::cases::{Case, FOREIGN};
use super::form::{draw, textbook, uniform};
use super::size::{Probes, Shift};

/// Share of frames lost in a `dropped` case, and factor on the camera's noise in a `noise` case.
const DROPPED: f64 = 0.1;
const NOISY: f64 = 3.0;
/// Strikes by which an effect's size is measured.
const PROBES: usize = 24;
/// Sessions of a demo of 40 strikes and more.
const SESSIONS: usize = 4;
/// Strengths in units of an effect's default beyond which it is none that a table or an arm shows; of what no candidate has,
/// any strength is allowed.
const STRONGEST: f64 = 12.0;
const STRONGEST_FOREIGN: f64 = 200.0;

/// The rig of a case, its effects drawn and scaled; `None` where no strength makes a shift that large.
pub(super) fn truth(case: &Case) -> Option<Truth> {
    let mut random = ChaCha8Rng::seed_from_u64(case.seed);
    let shape = if case.is_box() {
        Shape::Box
    } else {
        Shape::Cylinder
    };
    let mut rig = Truth::demo_rig(shape);
    if case.variant == "noise" {
        rig.camera.noise *= NOISY;
    }
    let mut truth = Truth::demo(&rig, case.seed);
    truth.hidden = Hidden::none();
    truth.friction = uniform(&mut random, 0.15, 0.30);
    truth.restitution = uniform(&mut random, 0.40, 0.60);
    if case.variant == "dropped" {
        truth.camera.dropped = DROPPED;
    }
    let strikes = (0..PROBES).map(|i| probe(&truth, case.strikes, i, &mut random));
    let probes = Probes::new(&truth, strikes.collect())?;
    let floor = probes.floor(case.strikes)?;
    for name in &case.hidden {
        let mut effect = Effect::named(name)?;
        draw(
            &mut effect,
            (case.strikes, case.strikes.div_ceil(SESSIONS)),
            &mut random,
        );
        if case.variant == "textbook" {
            textbook(&mut effect);
        }
        let strongest = if FOREIGN.contains(&effect.name()) {
            STRONGEST_FOREIGN
        } else {
            STRONGEST
        };
        let shift = case.magnitude * floor;
        truth
            .hidden
            .0
            .push(probes.scaled(&effect, shift, Shift::Whole, strongest)?);
    }
    Some(truth)
}

/// A strike as the demo draws it, one of several that are spread over all sessions of a set.
fn probe(
    truth: &Truth,
    strikes: usize,
    i: usize,
    random: &mut ChaCha8Rng,
) -> (Point, Command, StrikeIndex) {
    let robot = &truth.rig.robot;
    let initial = Point::new(uniform(random, 0.2, 0.4), uniform(random, -0.2, 0.2));
    let command = Command::new(
        uniform(random, robot.speed.low, robot.speed.high),
        uniform(random, robot.angle.low, robot.angle.high),
    );
    let order = i * strikes / PROBES;
    let session = SESSIONS * order / strikes;
    (initial, command, StrikeIndex { session, order })
}
