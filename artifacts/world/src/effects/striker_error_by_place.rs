//! An arm that errs by where it strikes, as by how far it reaches: speed·(1 + γ + a·d + d·A·d) and angle + δ + c·d + d·C·d, d the
//! start's place from the middle of the starts.

use values::{Command, Conditions, Point, Rig};

use super::{
    action::{Acts, Effect},
    parameters::{EffectParameter, Parameters, Values, centre},
    spec::{EffectSpec, Family, Naming},
    start::{Column, Experiment, FitStart},
    wording,
};

/// However much of its speed an arm loses, this share is left.
const LEAST_FACTOR: f64 = 0.05;
/// Starts vary along an axis where their standard deviation is beyond so many of the camera's, and beyond how well objects are put down by
/// hand (m): what is seen of a start errs as what is seen of its way does.
const VARIED: (f64, f64) = (5.0, 0.005);
/// Slopes for each metre (of speed; rad), and an angle in rad, that are worth a word.
const STATED: f64 = 0.005;
const STATED_BIAS: f64 = 0.002;

const fn value(name: &'static str, unit: &'static str, most: f64, scale: f64) -> EffectParameter {
    EffectParameter {
        name,
        unit,
        low: -most,
        high: most,
        neutral: 0.0,
        scale,
    }
}

/// Striker error by place; parameters `speed_x`, `speed_y` = a, `speed_xx`, `speed_xy`, `speed_yy` = A, `angle_x`, `angle_y` = c, `angle_xx`,
/// `angle_xy`, `angle_yy` = C, `gain` = γ, `bias` = δ, and `center_x`, `center_y`: the middle of the starts of the strikes that were fitted.
pub const SPEC: EffectSpec = EffectSpec {
    name: "striker_error_by_place",
    parameters: Parameters::Listed(&[
        value("speed_x", "1/m", 3.0, 0.2),
        value("speed_y", "1/m", 3.0, 0.2),
        value("speed_xx", "1/m²", 30.0, 2.0),
        value("speed_xy", "1/m²", 30.0, 2.0),
        value("speed_yy", "1/m²", 30.0, 2.0),
        value("angle_x", "rad/m", 3.0, 0.1),
        value("angle_y", "rad/m", 3.0, 0.1),
        value("angle_xx", "rad/m²", 30.0, 1.0),
        value("angle_xy", "rad/m²", 30.0, 1.0),
        value("angle_yy", "rad/m²", 30.0, 1.0),
        value("gain", "", 0.5, 0.05),
        value("bias", "rad", 1.5, 0.02),
        centre("center_x", 0.3),
        centre("center_y", 0.0),
    ]),
    family: Family::LaunchByPlace,
    equivalent: &[],
    contains: &["striker_angle_bias"],
    naming: Naming::Ordinary,
    source: "an arm's errors change smoothly with its posture (ISO 9283 tests accuracy at places over its reach), to second order",
    starts,
    build: |values: &Values, _: &Rig| {
        let of = |names: [&str; 5]| Form(names.map(|name| values.get(name)));
        Box::new(StrikerErrorByPlace {
            speed: of(["speed_x", "speed_y", "speed_xx", "speed_xy", "speed_yy"]),
            angle: of(["angle_x", "angle_y", "angle_xx", "angle_xy", "angle_yy"]),
            gain: values.get("gain"),
            bias: values.get("bias"),
            centre: Point::new(values.get("center_x"), values.get("center_y")),
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
        if bends(["speed_xx", "speed_xy", "speed_yy"]) {
            says.push("delivers a speed that bends with the object's place".into());
        }
        if angle.norm() >= STATED {
            says.push(format!(
                "strikes {:.1}° further left for each metre that the object lies towards {} from +x",
                angle.norm().to_degrees(),
                wording::degrees(angle.bearing())
            ));
        }
        if bends(["angle_xx", "angle_xy", "angle_yy"]) {
            says.push("strikes at an angle that bends with the object's place".into());
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
        varied(&[("speed_xx", x), ("speed_xy", x && y), ("speed_yy", y)]),
    ];
    let angle = [
        varied(&[("angle_x", x), ("angle_y", y), ("bias", x || y)]),
        varied(&[("angle_xx", x), ("angle_xy", x && y), ("angle_yy", y)]),
    ];
    if speed[0].is_empty() {
        return Vec::new();
    }
    let start = |names: &[&[&'static str]]| {
        let names = names.concat();
        // Some millimetres, wherever starts are.
        let small = |name: &str| match name.rsplit_once('_') {
            Some((_, "x" | "y")) => 0.02,
            Some(_) => 0.2,
            None => 0.005,
        };
        let column = |name: &&'static str| Column::new(&centre, (*name, small(name)));
        FitStart::new(names.iter().map(column).collect(), &names)
    };
    vec![
        start(&[&speed[0]]),
        start(&[&angle[0]]),
        start(&[&speed[0], &angle[0]]),
        start(&[&speed[0], &speed[1]]),
        start(&[&angle[0], &angle[1]]),
        start(&[&speed[0], &speed[1], &angle[0], &angle[1]]),
    ]
}

/// Coefficients of x, y, x², x·y, y².
struct Form([f64; 5]);

impl Form {
    fn at(&self, Point { x, y }: Point) -> f64 {
        let terms = [x, y, x * x, x * y, y * y];
        self.0.iter().zip(terms).map(|(by, term)| by * term).sum()
    }
}

struct StrikerErrorByPlace {
    speed: Form,
    angle: Form,
    gain: f64,
    bias: f64,
    centre: Point,
}

impl Effect for StrikerErrorByPlace {
    fn acts(&self) -> Acts {
        Acts::Launch
    }

    fn deliver(&self, command: Command, from: Point, _: &Conditions) -> Command {
        let place = from - self.centre;
        Command {
            speed: command.speed * (1.0 + self.gain + self.speed.at(place)).max(LEAST_FACTOR),
            angle: command.angle + self.bias + self.angle.at(place),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, START, assert_near};

    #[test]
    fn it_changes_the_track() {
        for parameter in [
            ("speed_x", 0.5),
            ("speed_yy", 10.0),
            ("angle_y", 0.5),
            ("angle_xx", 5.0),
            ("bias", 0.02),
        ] {
            Bench::with("striker_error_by_place", &[parameter]).assert_changes_track();
        }
    }

    #[test]
    fn it_strikes_as_if_commanded_what_its_formula_says_of_the_place() {
        let (x, y) = (START.x - 0.4, START.y + 0.1);
        let parameters = [
            ("center_x", 0.4),
            ("center_y", -0.1),
            ("speed_x", 0.4),
            ("speed_xy", 2.0),
            ("angle_y", -0.5),
            ("angle_yy", 1.5),
            ("bias", 0.03),
        ];
        let factor = 1.0 + 0.4 * x + 2.0 * x * y;
        let turn = 0.03 - 0.5 * y + 1.5 * y * y;
        let stop = Bench::with("striker_error_by_place", &parameters)
            .strike(0.8, 0.1)
            .stop;
        let expected = Bench::plain().strike(0.8 * factor, 0.1 + turn).stop;
        assert_near(stop, expected, 1e-6);
    }
}
