//! How `--hide` says what is hidden: effects and kinds of noise.

use crate::{Effect, Hidden, Noise, NoiseKind, ParameterSpec, RigSimError};

/// The value of `--hide`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hide {
    /// Effects.
    pub hidden: Hidden,
    /// Kinds of noise.
    pub noise: Noise,
}

impl Hide {
    /// Reads the values of `--hide`, one item for each time the flag was given.
    ///
    /// `none`, with nothing beside it, hides nothing; `demo` the demo's mixture; `NAME` an effect or a kind of noise with its
    /// defaults; `NAME=0.4,0.1` with all its parameters in order; `NAME=center_x:0.4,change:0.2` with those named. Several
    /// times: several of them.
    pub fn parse<S: AsRef<str>>(flags: &[S]) -> Result<Self, RigSimError> {
        let mut hide = Self::default();
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
                "demo" => hide.hidden.0.extend(Hidden::demo().0),
                one => match parse_one(one)? {
                    Part::Effect(effect) => hide.hidden.0.push(effect),
                    Part::Noise(kind) => hide.noise.0.push(kind),
                },
            }
        }
        Ok(hide)
    }
}

impl Hidden {
    /// Effects as `--hide` says them; kinds of noise are refused. See [`Hide::parse`].
    pub fn parse<S: AsRef<str>>(flags: &[S]) -> Result<Self, RigSimError> {
        let hide = Hide::parse(flags)?;
        match hide.noise.0.first() {
            None => Ok(hide.hidden),
            Some(noise) => Err(RigSimError::NoEffect { name: noise.name() }),
        }
    }
}

/// One effect or kind of noise.
#[derive(Clone, Copy)]
enum Part {
    Effect(Effect),
    Noise(NoiseKind),
}

impl Part {
    fn named(name: &str) -> Option<Self> {
        let noise = || NoiseKind::named(name).map(Self::Noise);
        Effect::named(name).map(Self::Effect).or_else(noise)
    }

    fn parameters(&self) -> &'static [ParameterSpec] {
        match self {
            Self::Effect(effect) => effect.parameters(),
            Self::Noise(kind) => kind.parameters(),
        }
    }

    fn set(&mut self, name: &str, value: f64) -> bool {
        match self {
            Self::Effect(effect) => effect.set(name, value),
            Self::Noise(kind) => kind.set(name, value),
        }
    }
}

fn parse_one(text: &str) -> Result<Part, RigSimError> {
    let (name, values) = match text.split_once('=') {
        Some((name, values)) => (name.trim(), Some(values)),
        None => (text, None),
    };
    let part = Part::named(name).ok_or_else(|| unknown(name))?;
    let specs = part.parameters();
    let wrong = |why: String| RigSimError::EffectValue {
        effect: name.to_owned(),
        why,
        takes: takes(specs),
    };
    let mut changed = part;
    let (mut given, mut in_order) = (0, None);
    for (place, item) in values
        .into_iter()
        .flat_map(|values| values.split(','))
        .enumerate()
    {
        let (parameter, value) = match item.split_once(':') {
            Some((parameter, value)) => (parameter.trim(), value),
            None => match specs.get(place) {
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
            let range = match (low > f64::MIN, high < f64::MAX) {
                (true, false) => format!("at least {low}"),
                (false, true) => format!("at most {high}"),
                _ => format!("within {low} to {high}"),
            };
            return Err(wrong(format!("{parameter} = {number} is not {range}")));
        }
        if !changed.set(parameter, number) {
            return Err(wrong(format!("it has no parameter {parameter:?}")));
        }
        given = place + 1;
    }
    let all = specs.len();
    if let Some((first, value)) = in_order.filter(|_| given < all) {
        return Err(wrong(format!(
            "{given} of {all} values is too few: give all in their order, or name those that you mean ({first}:{value})"
        )));
    }
    Ok(changed)
}

/// Beyond these a formula has no meaning, or the object would leave the camera's view.
fn limits(name: &str, parameter: &str) -> Option<(f64, f64)> {
    match (name, parameter) {
        ("camera_rotation", "angle") | ("camera_lean", "lean") | ("pushed_camera", "turn") => {
            Some((-0.5, 0.5))
        }
        ("camera_distortion" | "brown_lens" | "off_centre_lens", "k1") => Some((-0.4, 0.4)),
        ("camera_scale", "excess") => Some((-0.5, 0.5)),
        ("wrong_rig_file", _) => Some((-0.9, 9.0)),
        ("camera_correlation", "rho") => Some((0.0, 0.99)),
        ("stray_frames" | "lost_bursts" | "two_objects", "share") => Some((0.0, 0.5)),
        ("friction_scatter" | "friction_wander" | "late_stamps" | "jittering_stamps", _) => {
            Some((0.0, 1.0))
        }
        ("launch_scatter_by_speed" | "launch_scatter_by_angle", _) => Some((0.0, f64::MAX)),
        ("speed_dependent_restitution", "exponent") | ("restitution_step", "from") => None,
        (
            _,
            "v_s" | "v_ref" | "exponent" | "radius" | "edge" | "stretch" | "over" | "every"
            | "width" | "decay" | "reference" | "cap" | "length" | "half_length" | "half_width"
            | "height" | "depth" | "period" | "sharpness",
        ) => Some((1e-4, f64::MAX)),
        (_, "softness") => Some((0.0, f64::MAX)),
        _ => None,
    }
}

fn unknown(name: &str) -> RigSimError {
    let effects = Effect::all();
    let kinds = NoiseKind::all();
    let names: Vec<&str> = effects
        .iter()
        .map(Effect::name)
        .chain(kinds.iter().map(NoiseKind::name))
        .collect();
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

fn takes(specs: &[ParameterSpec]) -> String {
    let one =
        |spec: &ParameterSpec| format!("{} ({}, default {})", spec.name, spec.unit, spec.default);
    specs.iter().map(one).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{FrictionPatch, TableTilt};

    #[test]
    fn noise_and_effects_are_taken_side_by_side() {
        let hide = Hide::parse(&["friction_scatter=0.02", "table_tilt"]).expect("valid");
        assert_eq!(hide.hidden.0.len(), 1);
        assert_eq!(hide.noise.0[0].get("sd"), Some(0.02));
        let error = Hidden::parse(&["friction_scatter"])
            .expect_err("no effect")
            .to_string();
        assert!(error.contains("friction_scatter"), "{error}");
    }

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
            error.contains("camera_distortion") && error.contains("friction_scatter"),
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
    fn an_incomplete_list_is_refused() {
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
            assert!(
                ["is not within", "is not at least"]
                    .iter()
                    .any(|why| error.contains(why)),
                "{error}"
            );
        }
    }
}
