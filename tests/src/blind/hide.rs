//! Draws what is hidden, and makes it as large as a case asks for.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{Effect, Hidden, Truth, When};
use values::{Command, Point, Shape};

use super::cases::{Case, FOREIGN};

/// Strikes by which an effect's size is measured.
const PROBES: usize = 24;
/// Share of frames lost in a `dropped` case, and factor on the camera's noise in a `noise` case.
const DROPPED: f64 = 0.1;
const NOISY: f64 = 3.0;

/// The rig of a case, its effects drawn and scaled; `None` where no strength makes a shift that large.
pub fn truth(case: &Case) -> Option<Truth> {
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
    let probes = probes(&truth, case.strikes, &mut random);
    let plain = truth.clone();
    let floor = floor(&plain, &probes)?;
    for name in &case.hidden {
        let mut effect = Effect::named(name)?;
        draw(&mut effect, &mut random);
        if case.variant == "textbook" {
            textbook(&mut effect);
        }
        let effect = scaled(&plain, &effect, &probes, case.magnitude * floor)?;
        truth.hidden.0.push(effect);
    }
    Some(truth)
}

fn uniform(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}

/// Another place, direction and sign of the effect, within what real tables show.
fn draw(effect: &mut Effect, random: &mut ChaCha8Rng) {
    let name = effect.name();
    let sign = if random.random::<f64>() < 0.5 {
        -1.0
    } else {
        1.0
    };
    let mut set = |parameter: &str, value: f64| {
        assert!(effect.set(parameter, value), "{name} has no {parameter}");
    };
    let mut between = |low: f64, high: f64| uniform(random, low, high);
    match name {
        "speed_weakening_friction" => set("v_s", between(0.2, 0.6)),
        "anisotropic_friction" => set("direction", between(-1.5, 1.5)),
        "friction_patch" => {
            set("center_x", between(0.40, 0.60));
            set("center_y", between(-0.12, 0.12));
            set("radius", between(0.06, 0.12));
            set("change", sign * 0.35);
        }
        "friction_drift" => set("change", sign * 0.2),
        "table_tilt" => {
            let bearing = between(-3.1, 3.1);
            set("t_x", 0.006 * bearing.cos());
            set("t_y", 0.006 * bearing.sin());
        }
        "table_bowl" => {
            set("kappa", sign * 0.04);
            set("center_x", between(0.35, 0.55));
            set("center_y", between(-0.1, 0.1));
        }
        "striker_speed_error" => {
            if sign > 0.0 {
                set("a", between(-0.08, -0.04));
                set("b", 1.0);
                set("cap", 1.2);
            } else {
                set("a", 0.0);
                set("b", 1.0);
                set("cap", between(0.75, 0.9));
            }
        }
        "striker_angle_bias" => set("delta", sign * 0.03),
        "off_centre_contact" => set("offset", sign * 0.002),
        "camera_rotation" => set("angle", sign * 0.015),
        "camera_distortion" => set("k1", sign * 0.08),
        "air_jet" => {
            set("center_x", between(0.42, 0.58));
            set("center_y", between(-0.08, 0.08));
            set("bearing", between(-3.1, 3.1));
        }
        "sticky_line" => {
            set("x", between(0.42, 0.55));
            set("lean", between(-0.5, 0.5));
        }
        "vibration" => {
            set("frequency", between(2.0, 5.0));
            set("bearing", between(-3.1, 3.1));
        }
        _ => {}
    }
}

/// The library's own form, where the rig has it.
fn textbook(effect: &mut Effect) {
    for (parameter, value) in [
        ("exponent", 2.0),
        ("stretch", 1.0),
        ("edge", 0.001),
        ("softness", 0.0),
    ] {
        if !(effect.name() == "speed_dependent_restitution" || effect.get(parameter).is_none()) {
            effect.set(parameter, value);
        }
    }
}

type Probe = (Point, Command, When);

/// Strikes as the demo draws them, spread over all sessions.
fn probes(truth: &Truth, strikes: usize, random: &mut ChaCha8Rng) -> Vec<Probe> {
    let robot = truth.rig.robot.clone();
    (0..PROBES)
        .map(|i| {
            let initial = Point::new(uniform(random, 0.2, 0.4), uniform(random, -0.2, 0.2));
            let command = Command {
                speed: uniform(random, robot.speed.low, robot.speed.high),
                angle: uniform(random, robot.angle.low, robot.angle.high),
            };
            let order = i * strikes / PROBES;
            let session = 4 * order / strikes;
            (initial, command, When { session, order })
        })
        .collect()
}

fn stops(truth: &Truth, probes: &[Probe]) -> Option<Vec<Point>> {
    probes
        .iter()
        .map(|(initial, command, when)| truth.expected_stop(*initial, *command, *when).ok())
        .collect()
}

fn rms(a: &[Point], b: &[Point]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| a.distance(*b).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
}

/// What repeats scatter by at rest, in m: by launch and camera.
fn floor(truth: &Truth, probes: &[Probe]) -> Option<f64> {
    let stops_here = stops(truth, probes)?;
    let moved = |speed: f64, angle: f64| {
        let probes: Vec<Probe> = probes
            .iter()
            .map(|(initial, command, when)| {
                let command = Command {
                    speed: command.speed * (1.0 + speed),
                    angle: command.angle + angle,
                };
                (*initial, command, *when)
            })
            .collect();
        Some(rms(&stops(truth, &probes)?, &stops_here))
    };
    let camera = truth.rig.camera.noise;
    Some(
        moved(truth.scatter.speed, 0.0)?
            .hypot(moved(0.0, truth.scatter.angle)?)
            .hypot(0.6 * camera),
    )
}

/// The effect as strong as shifts the stops by `shift` m, root mean square over the probes.
fn scaled(truth: &Truth, effect: &Effect, probes: &[Probe], shift: f64) -> Option<Effect> {
    let without = stops(truth, probes)?;
    let moved = |factor: f64| {
        let mut with = truth.clone();
        with.hidden = Hidden(vec![effect.scaled(factor)]);
        stops(&with, probes).map_or(f64::INFINITY, |with| rms(&with, &without))
    };
    // Strengths past the last are none that a table or an arm shows; of what no candidate has, any may be asked for.
    let strongest = if FOREIGN.contains(&effect.name()) {
        200.0
    } else {
        12.0
    };
    let (mut low, mut high) = (0.0, strongest);
    if moved(high) < shift {
        return None;
    }
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if moved(middle) < shift {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(effect.scaled(high))
}
