//! An arm that errs by where it strikes: speed·(1 + γ + a·d + q·A·q) and angle + δ + c·d + q·C·q + w(φ).
//!
//! d is the start's place from the middle of the starts, q the same as reach and arc about the arm's base, φ the bearing there: an arm's
//! errors bend with how far it reaches, and a base joint's gear that is not round adds a wave w over the bearing.

use values::{Command, Point};

use super::{
    Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    formula::delivering, parameters::centre, wording,
};

/// Least share of its speed that an arm delivers.
const LEAST_FACTOR: f64 = 0.05;
/// Starts vary along an axis where their standard deviation is beyond so many of the camera's, and beyond how well objects are put down by
/// hand (m): what is seen of a start errs as what is seen of its way does.
const VARIED: (f64, f64) = (5.0, 0.005);
/// Slopes for each metre (of speed; rad), and an angle in rad, that are worth a word.
const STATED: f64 = 0.005;
const STATED_BIAS: f64 = 0.002;

/// The most for each metre and square metre: an arm at the end of its reach loses a tenth of its speed within some centimetres.
const SLOPE: f64 = 3.0;
const BEND: f64 = 100.0;

const fn value(name: &'static str, unit: &'static str, most: f64, scale: f64) -> EffectParameter {
    EffectParameter::new(name, unit, [-most, most], scale)
}

/// Period of the wave over the bearing, in rad from crest to crest.
const PERIOD: EffectParameter =
    EffectParameter::new("angle_period", "rad", [0.02, 6.3], 0.2).neutral_at(1.0);
/// Periods at which a wave is tried, in widths of the bearings that were struck at: a longer one bends no more than the arc does.
const PERIODS: [f64; 6] = [0.35, 0.5, 0.65, 0.85, 1.1, 1.4];

/// Striker error by place; parameters `speed_x`, `speed_y` = a, `speed_rr`, `speed_rb`, `speed_bb` = A, `angle_x`, `angle_y` = c, `angle_rr`,
/// `angle_rb`, `angle_bb` = C, `angle_sin`, `angle_cos`, `angle_period` of w, `gain` = γ, `bias` = δ, and `center_x`, `center_y`: the middle of the
/// starts of the strikes that were fitted.
pub const SPEC: EffectSpec = EffectSpec {
    name: "striker_error_by_place",
    parameters: Parameters::Listed(&[
        value("speed_x", "1/m", SLOPE, 0.2),
        value("speed_y", "1/m", SLOPE, 0.2),
        value("speed_rr", "1/m²", BEND, 0.5),
        value("speed_rb", "1/m²", BEND, 0.5),
        value("speed_bb", "1/m²", BEND, 0.5),
        value("angle_x", "rad/m", SLOPE, 0.1),
        value("angle_y", "rad/m", SLOPE, 0.1),
        value("angle_rr", "rad/m²", BEND, 0.3),
        value("angle_rb", "rad/m²", BEND, 0.3),
        value("angle_bb", "rad/m²", BEND, 0.3),
        value("angle_sin", "rad", 0.5, 0.02),
        value("angle_cos", "rad", 0.5, 0.02),
        PERIOD,
        value("gain", "", 0.5, 0.05),
        value("bias", "rad", 1.5, 0.02),
        centre("center_x", 0.3),
        centre("center_y", 0.0),
    ]),
    family: Family::LaunchByPlace,
    origin: Origin::Arm,
    equivalent: &[],
    contains: &["striker_angle_bias"],
    naming: Naming::Ordinary,
    source: "an arm's errors change smoothly with its posture (ISO 9283 tests accuracy at places over its reach), to second order",
    starts,
    build: |values, rig| {
        let of = |names: [&str; 5]| Form(names.map(|name| values.get(name)));
        let speed = of(["speed_x", "speed_y", "speed_rr", "speed_rb", "speed_bb"]);
        let angle = of(["angle_x", "angle_y", "angle_rr", "angle_rb", "angle_bb"]);
        let (gain, bias) = (values.get("gain"), values.get("bias"));
        let [sin, cos, period] =
            ["angle_sin", "angle_cos", "angle_period"].map(|name| values.get(name));
        let (centre, base) = (values.centre(), rig.robot.base.unwrap_or_default());
        delivering(move |command, from, _| {
            let place = from - centre;
            let polar = polar(from, centre, base);
            let turn = polar.y / centre.distance(base).max(1e-9);
            let phase = std::f64::consts::TAU * turn / period;
            let wave = sin * phase.sin() + cos * phase.cos();
            Command::new(
                command.speed * (1.0 + gain + speed.at(place, polar)).max(LEAST_FACTOR),
                command.angle + bias + angle.at(place, polar) + wave,
            )
        })
    },
    statement: |values| {
        let slope = |x: &str, y: &str| Point::new(values.get(x), values.get(y));
        let bends = |names: [&str; 3]| names.iter().any(|name| values.get(name) != 0.0);
        let (speed, angle) = (slope("speed_x", "speed_y"), slope("angle_x", "angle_y"));
        let mut says = Vec::new();
        let gain = values.get("gain");
        if gain.abs() >= STATED {
            says.push(format!(
                "delivers {:.3} times the commanded speed in the middle of the starts",
                1.0 + gain
            ));
        }
        if speed.norm() >= STATED {
            says.push(format!(
                "delivers {} more speed for each metre that the object lies towards {} from +x",
                wording::percent(speed.norm()),
                wording::degrees(speed.bearing())
            ));
        }
        if bends(["speed_rr", "speed_rb", "speed_bb"]) {
            says.push("delivers a speed that bends with the object's place".into());
        }
        if angle.norm() >= STATED {
            says.push(format!(
                "strikes {:.1}° further left for each metre that the object lies towards {} from +x",
                angle.norm().to_degrees(),
                wording::degrees(angle.bearing())
            ));
        }
        if bends(["angle_rr", "angle_rb", "angle_bb"]) {
            says.push("strikes at an angle that bends with the object's place".into());
        }
        let wave = values.get("angle_sin").hypot(values.get("angle_cos"));
        if wave >= STATED_BIAS {
            says.push(format!(
                "strikes up to {:.1}° to either side, in a wave over the object's bearing that repeats every {:.0}°",
                wave.to_degrees(),
                values.get("angle_period").to_degrees()
            ));
        }
        let bias = values.get("bias");
        if bias.abs() >= STATED_BIAS {
            says.push(format!(
                "strikes {:.1}° to the {} in the middle of the starts",
                bias.abs().to_degrees(),
                wording::side(bias)
            ));
        }
        match says.is_empty() {
            true => "the arm strikes alike wherever the object lies".into(),
            false => format!("the arm {}", says.join(", and ")),
        }
    },
};

/// The slopes first, then what bends; of the speed, of the angle, of both. A constant factor on the
/// speed is restitution's by another name, but where the arm's state is logged.
fn starts(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let (middle, spread) = experiment.starts();
    let least = VARIED.1.max(VARIED.0 * experiment.rig.camera.noise);
    let (x, y) = (spread.x > least, spread.y > least);
    let centre = [("center_x", middle.x), ("center_y", middle.y)];
    let varied = |named: &[(&'static str, bool)]| -> Vec<&'static str> {
        let varied = named.iter().filter(|(_, varies)| *varies);
        varied.map(|(name, _)| *name).collect()
    };
    let speed = [
        varied(&[("speed_x", x), ("speed_y", y)]),
        varied(&[("speed_rr", x), ("speed_rb", x && y), ("speed_bb", y)]),
    ];
    let angle = [
        varied(&[("angle_x", x), ("angle_y", y), ("bias", x || y)]),
        varied(&[("angle_rr", x), ("angle_rb", x && y), ("angle_bb", y)]),
    ];
    if speed[0].is_empty() {
        return Vec::new();
    }
    let start = |given: &[(&str, f64)], names: &[&[&'static str]]| {
        let names = names.concat();
        let form = [&centre[..], given].concat();
        // Some millimetres, wherever starts are.
        let small = |name: &str| match name.rsplit_once('_') {
            Some((_, "x" | "y")) => 0.02,
            Some((_, "rr" | "rb" | "bb")) => 0.2,
            _ => 0.005,
        };
        let column = |name: &&'static str| Column::new(&form, (*name, small(name)));
        FitStart::new(names.iter().map(column).collect(), &names)
    };
    let mut starts = vec![
        start(&[], &[&speed[0]]),
        start(&[], &[&angle[0]]),
        start(&[], &[&speed[0], &angle[0]]),
        start(&[], &[&speed[0], &speed[1]]),
        start(&[], &[&angle[0], &angle[1]]),
        start(&[], &[&speed[0], &speed[1], &angle[0], &angle[1]]),
    ];
    let base = experiment.rig.robot.base.unwrap_or_default();
    let bearings = experiment.strikes.iter().map(|strike| {
        let arc = polar(strike.initial, middle, base).y;
        arc / middle.distance(base).max(1e-9)
    });
    let (low, high) = bearings.fold((0.0f64, 0.0f64), |(low, high), b| (low.min(b), high.max(b)));
    for period in PERIODS.map(|share| share * (high - low)) {
        if (PERIOD.low..PERIOD.high).contains(&period) {
            let wave = ["angle_sin", "angle_cos", "bias"];
            let mut start = start(&[("angle_period", period)], &[&wave]);
            start.free.push("angle_period".into());
            starts.push(start.kept_in("angle_period", (0.7 * period, 1.4 * period)));
        }
    }
    starts
}

/// A place as reach and arc about the arm's base, from the middle of the starts, in m.
fn polar(place: Point, middle: Point, base: Point) -> Point {
    let (from, to) = (middle - base, place - base);
    let turn = (from.x * to.y - from.y * to.x).atan2(from.dot(to));
    Point::new(to.norm() - from.norm(), from.norm() * turn)
}

/// Coefficients of x, y, and of the products of reach and arc.
struct Form([f64; 5]);

impl Form {
    fn at(&self, Point { x, y }: Point, Point { x: r, y: b }: Point) -> f64 {
        let terms = [x, y, r * r, r * b, b * b];
        self.0.iter().zip(terms).map(|(by, term)| by * term).sum()
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn it_strikes_as_if_commanded_what_its_formula_says_of_the_place() {
        // The base is the origin; START is 0.005 m farther from it than the middle, and its bearing 0.197 rad further left.
        let middle = 0.25;
        let (reach, bearing) = (START.norm() - middle, START.bearing());
        let parameters = [
            ("center_x", middle),
            ("speed_y", 0.4),
            ("speed_rb", 2.0),
            ("angle_y", -0.5),
            ("angle_bb", 1.5),
            ("angle_sin", 0.02),
            ("angle_period", 1.2),
            ("bias", 0.03),
        ];
        let arc = middle * bearing;
        let factor = 1.0 + 0.4 * START.y + 2.0 * reach * arc;
        let wave = 0.02 * (std::f64::consts::TAU * bearing / 1.2).sin();
        let turn = 0.03 - 0.5 * START.y + 1.5 * arc * arc + wave;
        let stop = Bench::with("striker_error_by_place", &parameters)
            .strike(0.8, 0.1)
            .stop;
        let expected = Bench::plain().strike(0.8 * factor, 0.1 + turn).stop;
        assert_near(stop, expected, 1e-6);
    }
}
