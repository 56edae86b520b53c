//! What is hidden, and how `--hide` says it.

use serde::{Deserialize, Serialize};
use values::{Command, Point};

use crate::effects::{
    Acts, CameraRotation, FrictionPatch, OffCentreContact, SpeedWeakeningFriction,
    StrikerAngleBias, StrikerSpeedError, TableTilt,
};
use crate::{Effect, RigSimError};

/// The effects that act in a rig, in the order in which they are applied.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Hidden(pub Vec<Effect>);

impl Hidden {
    /// Nothing hidden.
    pub fn none() -> Self {
        Self::default()
    }

    /// What the demo hides where nothing is asked for: a mixture that friction and one factor of launch cannot absorb.
    ///
    /// All but the last part depend on the displacement asked for alone, which is all that the paper's residual is told: an
    /// arm that is 10 % slow at its slowest and just over at its fastest, so that no constant factor fits; a hand-eye error
    /// in which the arm's angle, the tip's mount and the camera's turn all point the same way (7° on a cylinder); friction that
    /// rises as the object slows; a table that leans. A weak patch depends on the place, as real tables do, and is the part
    /// that the residual cannot learn. Each is of a size that real tables show. Together they leave a fitted friction and
    /// launch factor a mean stop error of 5 to 9 cm (the paper: 9.12 cm), while repeats scatter by about 4 mm;
    /// `tests/mixture.rs` measures both.
    pub fn demo() -> Self {
        Self(vec![
            Effect::StrikerSpeedError(StrikerSpeedError {
                a: -0.12,
                b: 1.20,
                cap: 1.02,
                softness: 0.05,
            }),
            Effect::StrikerAngleBias(StrikerAngleBias { delta: 0.05 }),
            Effect::OffCentreContact(OffCentreContact { offset: -0.0035 }),
            Effect::CameraRotation(CameraRotation { angle: 0.02 }),
            Effect::SpeedWeakeningFriction(SpeedWeakeningFriction {
                delta: 0.3,
                v_s: 0.4,
                exponent: 1.5,
            }),
            Effect::TableTilt(TableTilt {
                t_x: -0.004,
                t_y: 0.008,
            }),
            Effect::FrictionPatch(FrictionPatch {
                radius: 0.05,
                change: 0.12,
                ..FrictionPatch::default()
            }),
        ])
    }

    /// Reads the values of `--hide`, one item for each time the flag was given.
    ///
    /// `none`, which stands alone, hides nothing; `demo` the demo's mixture; `EFFECT` an effect with its defaults;
    /// `EFFECT=0.4,0.1` with all its parameters in order; `EFFECT=center_x:0.4,change:0.2` with those named. Several times:
    /// several effects.
    pub fn parse<S: AsRef<str>>(flags: &[S]) -> Result<Self, RigSimError> {
        let mut hidden = Self::none();
        let flags = || flags.iter().map(|flag| flag.as_ref().trim());
        let other = flags().find(|flag| *flag != "none");
        if let (true, Some(other)) = (flags().any(|flag| flag == "none"), other) {
            return Err(RigSimError::NoneAnd {
                other: other.to_owned(),
            });
        }
        for flag in flags() {
            match flag {
                "none" => {}
                "demo" => hidden.0.extend(Self::demo().0),
                effect => hidden.0.push(parse_effect(effect)?),
            }
        }
        Ok(hidden)
    }

    /// Every effect this many times as strong.
    pub fn scaled(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|effect| effect.scaled(factor)).collect())
    }

    pub(crate) fn acts(&self) -> impl Iterator<Item = &dyn Acts> {
        self.0.iter().map(Effect::acts)
    }

    /// What the arm delivers for a command, before launch scatter.
    pub fn deliver(&self, command: Command) -> Command {
        self.acts()
            .fold(command, |command, effect| effect.deliver(command))
    }

    /// Where the camera sees what lies at a point of the table, without noise, in m.
    pub fn see(&self, at: Point, centre: Point) -> Point {
        self.acts().fold(at, |at, effect| effect.see(at, centre))
    }

    /// What lies where the camera sees this point: the inverse of [`Hidden::see`], in m.
    pub fn unsee(&self, seen: Point, centre: Point) -> Point {
        // The camera's effects are small, so that this contracts by about a hundred at each step.
        let mut at = seen;
        for _ in 0..50 {
            let miss = seen - self.see(at, centre);
            at = at + miss;
            if miss.norm() < 1e-13 {
                break;
            }
        }
        at
    }
}

fn parse_effect(text: &str) -> Result<Effect, RigSimError> {
    let (name, values) = match text.split_once('=') {
        Some((name, values)) => (name.trim(), Some(values)),
        None => (text, None),
    };
    let mut effect = Effect::named(name).ok_or_else(|| unknown(name))?;
    let wrong = |why: String| RigSimError::EffectValue {
        effect: name.to_owned(),
        why,
        takes: takes(&effect),
    };
    let all = effect.parameters().len();
    let mut changed = effect;
    let (mut given, mut in_order) = (0, None);
    for (place, item) in values
        .into_iter()
        .flat_map(|values| values.split(','))
        .enumerate()
    {
        let (parameter, value) = match item.split_once(':') {
            Some((parameter, value)) => (parameter.trim(), value),
            None => match effect.parameters().get(place) {
                Some(spec) => {
                    in_order = in_order.or(Some((spec.name, item.trim())));
                    (spec.name, item)
                }
                None => return Err(wrong(format!("{} values are too many", place + 1))),
            },
        };
        let number: f64 = match value.trim().parse() {
            Ok(number) if f64::is_finite(number) => number,
            _ => return Err(wrong(format!("{value:?} is not a finite number"))),
        };
        if let Some((low, high)) = limits(name, parameter)
            && !(low..=high).contains(&number)
        {
            return Err(wrong(format!(
                "{parameter} = {number} is not within {low} to {high}"
            )));
        }
        if !changed.set(parameter, number) {
            return Err(wrong(format!("it has no parameter {parameter:?}")));
        }
        given = place + 1;
    }
    if let Some((first, value)) = in_order.filter(|_| given < all) {
        return Err(wrong(format!(
            "{given} of {all} values is too few: give all in their order, or name those that you mean ({first}:{value})"
        )));
    }
    effect = changed;
    Ok(effect)
}

/// Beyond these the effect's formula has no meaning, or the camera could not be told where to look.
fn limits(effect: &str, parameter: &str) -> Option<(f64, f64)> {
    match (effect, parameter) {
        ("camera_rotation", "angle") => Some((-0.5, 0.5)),
        ("camera_distortion", "k1") => Some((-0.4, 0.4)),
        ("speed_dependent_restitution", "exponent") => None,
        (
            _,
            "v_s" | "exponent" | "radius" | "edge" | "stretch" | "over" | "width" | "decay"
            | "reference" | "cap",
        ) => Some((1e-4, f64::MAX)),
        (_, "softness") => Some((0.0, f64::MAX)),
        _ => None,
    }
}

fn unknown(name: &str) -> RigSimError {
    let names: Vec<&str> = Effect::all().iter().map(Effect::name).collect();
    let near = |known: &&&str| ordered(strsim::jaro_winkler(name, known));
    RigSimError::UnknownEffect {
        name: name.to_owned(),
        nearest: names
            .iter()
            .max_by_key(near)
            .map_or(String::new(), |near| (*near).to_owned()),
        all: format!("{}, none, demo", names.join(", ")),
    }
}

/// A likeness in [0, 1] as a number that has an order.
fn ordered(likeness: f64) -> u64 {
    (likeness * 1e9) as u64
}

fn takes(effect: &Effect) -> String {
    let one = |spec: &crate::ParameterSpec| {
        format!("{} ({}, default {})", spec.name, spec.unit, spec.default)
    };
    effect
        .parameters()
        .iter()
        .map(one)
        .collect::<Vec<_>>()
        .join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_taken_in_order_or_by_name() {
        let hidden = Hidden::parse(&["table_tilt=0.001,0.002", "friction_patch=change:-0.4"])
            .expect("valid");
        assert_eq!(
            hidden.0[0],
            Effect::TableTilt(TableTilt {
                t_x: 0.001,
                t_y: 0.002
            })
        );
        assert_eq!(
            hidden.0[1],
            Effect::FrictionPatch(FrictionPatch {
                change: -0.4,
                ..FrictionPatch::default()
            })
        );
        assert_eq!(Hidden::parse(&["none"]).expect("valid"), Hidden::none());
    }

    #[test]
    fn an_unknown_effect_is_answered_with_the_nearest_and_all() {
        let error = Hidden::parse(&["table_titl"])
            .expect_err("a misspelt name")
            .to_string();
        assert!(error.contains("nearest is table_tilt"), "{error}");
        assert!(
            error.contains("camera_distortion") && error.contains("vibration"),
            "{error}"
        );
    }

    #[test]
    fn wrong_values_say_what_the_effect_takes() {
        for (text, why) in [
            ("viscous_drag=fast", "\"fast\" is not a finite number"),
            ("viscous_drag=1,2", "2 values are too many"),
            ("viscous_drag=rate:1", "no parameter \"rate\""),
            ("viscous_drag=nan", "not a finite number"),
        ] {
            let error = Hidden::parse(&[text]).expect_err(text).to_string();
            assert!(
                error.contains(why) && error.contains("c (1/s, default 0.5)"),
                "{error}"
            );
        }
    }

    #[test]
    fn what_is_half_said_is_refused() {
        for (flags, why) in [
            (
                vec!["table_tilt=0.004"],
                "name those that you mean (t_x:0.004)",
            ),
            (vec!["none", "table_tilt"], "hide none and table_tilt"),
            (vec!["demo", "none"], "hide none and demo"),
        ] {
            let error = Hidden::parse(&flags).expect_err(why).to_string();
            assert!(error.contains(why), "{error}");
        }
        Hidden::parse(&["table_tilt=t_x:0.004"]).expect("named");
    }

    #[test]
    fn a_value_without_meaning_is_refused() {
        for text in [
            "camera_rotation=2",
            "speed_weakening_friction=0.3,0",
            "friction_patch=radius:-0.1",
        ] {
            let error = Hidden::parse(&[text]).expect_err(text).to_string();
            assert!(error.contains("is not within"), "{error}");
        }
    }

    #[test]
    fn what_is_seen_can_be_unseen() {
        let hidden =
            Hidden::parse(&["camera_rotation=0.03", "camera_distortion=0.1"]).expect("valid");
        let (at, centre) = (Point::new(0.9, -0.5), Point::new(0.45, 0.0));
        assert!(hidden.unsee(hidden.see(at, centre), centre).distance(at) < 1e-12);
    }
}
