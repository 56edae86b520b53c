//! What the rig can hide: the contract's fifteen effects and three that no candidate has.
//!
//! Each effect states its parameters in [`effect!`] and overrides the steps of [`Acts`] at which it acts. Where it can, its
//! form differs from the textbook's (an elliptic patch with a soft edge, another Stribeck exponent, a drift that saturates,
//! a power law of restitution, a soft cap), while each parameter keeps its meaning.

mod camera;
mod forces;
mod foreign;
mod friction;
mod striker;

use serde::{Deserialize, Serialize};
use values::{Command, Point};

use crate::When;

pub use camera::{CameraDistortion, CameraRotation};
pub use forces::{QuadraticDrag, TableBowl, TableTilt, ViscousDrag};
pub use foreign::{AirJet, StickyLine, Vibration};
pub use friction::{
    AnisotropicFriction, FrictionBySession, FrictionDrift, FrictionPatch, SpeedWeakeningFriction,
};
pub use striker::{
    OffCentreContact, SpeedDependentRestitution, StrikerAngleBias, StrikerSpeedError,
};

/// Standard gravity in m/s².
pub(crate) const GRAVITY: f64 = 9.806_65;

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterSpec {
    /// Its name.
    pub name: &'static str,
    /// Its unit; `1` for a ratio.
    pub unit: &'static str,
    /// What it is where no value is given: a size that real tables show.
    pub default: f64,
    /// The value at which the effect vanishes; `None` for a parameter of place or form, which [`Effect::scaled`] keeps.
    pub neutral: Option<f64>,
}

/// Where an effect may act; every step does nothing unless overridden.
pub(crate) trait Acts {
    /// The tip's speed and angle in place of the commanded ones.
    fn deliver(&self, command: Command) -> Command {
        command
    }
    /// How far to the left of the centre the tip passes, in m.
    fn tip_offset(&self) -> f64 {
        0.0
    }
    /// Factor on the restitution at this speed of approach (m/s).
    fn restitution(&self, _speed: f64) -> f64 {
        1.0
    }
    /// Factor on the friction of a whole strike.
    fn strike_friction(&self, _when: When) -> f64 {
        1.0
    }
    /// Whether [`Acts::local_friction`] differs over the base or with speed.
    fn is_local(&self) -> bool {
        false
    }
    /// Factor on the friction of an element of the base here (m), sliding at this speed (m/s).
    fn local_friction(&self, _at: Point, _speed: f64) -> f64 {
        1.0
    }
    /// Factors on friction along two axes: the bearing of the first (rad), then both factors.
    fn grain(&self) -> Option<(f64, [f64; 2])> {
        None
    }
    /// Acceleration of the centre here (m), at this velocity (m/s), this long after the blow (s).
    fn acceleration(&self, _at: Point, _velocity: Point, _time: f64) -> Point {
        Point::default()
    }
    /// Rate at which a film slows motion, in 1/s: it acts on the spin too.
    fn film(&self) -> f64 {
        0.0
    }
    /// Where the camera, looking down on a centre (m), sees what lies here (m).
    fn see(&self, at: Point, _centre: Point) -> Point {
        at
    }
    /// The finest length over which it changes, in m, where the integrator must step finely.
    fn grain_size(&self) -> f64 {
        f64::INFINITY
    }
}

/// Declares an effect: its name, and each parameter with default, unit and the value at which it vanishes.
macro_rules! effect {
    ($(#[$doc:meta])* $effect:ident = $name:literal {
        $($(#[$about:meta])* $field:ident: $default:literal, $unit:literal, $neutral:expr;)*
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $effect {
            $($(#[$about])* pub $field: f64,)*
        }

        impl Default for $effect {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl $effect {
            pub(super) const NAME: &'static str = $name;
            pub(super) const PARAMETERS: &'static [$crate::effects::ParameterSpec] = &[
                $($crate::effects::ParameterSpec {
                    name: stringify!($field), unit: $unit, default: $default, neutral: $neutral,
                },)*
            ];

            pub(super) fn parameter(&mut self, name: &str) -> Option<&mut f64> {
                match name {
                    $(stringify!($field) => Some(&mut self.$field),)*
                    _ => None,
                }
            }
        }
    };
}
pub(crate) use effect;

macro_rules! effects {
    ($($effect:ident),* $(,)?) => {
        /// An effect with its parameters; in files `{"name": …, "parameters": {…}}`.
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "name", content = "parameters", rename_all = "snake_case")]
        pub enum Effect {
            $(#[doc = concat!("See [`", stringify!($effect), "`].")] $effect($effect),)*
        }

        impl Effect {
            /// Every effect with its default parameters.
            pub fn all() -> Vec<Self> {
                vec![$(Self::$effect($effect::default()),)*]
            }

            /// Its name, as in the contract.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$effect(_) => $effect::NAME,)* }
            }

            /// Its parameters, in the order in which `--hide` takes their values.
            pub fn parameters(&self) -> &'static [ParameterSpec] {
                match self { $(Self::$effect(_) => $effect::PARAMETERS,)* }
            }

            fn parameter(&mut self, name: &str) -> Option<&mut f64> {
                match self { $(Self::$effect(effect) => effect.parameter(name),)* }
            }

            pub(crate) fn acts(&self) -> &dyn Acts {
                match self { $(Self::$effect(effect) => effect,)* }
            }
        }
    };
}

effects!(
    ViscousDrag,
    QuadraticDrag,
    SpeedWeakeningFriction,
    AnisotropicFriction,
    FrictionPatch,
    FrictionDrift,
    FrictionBySession,
    TableTilt,
    TableBowl,
    StrikerSpeedError,
    StrikerAngleBias,
    SpeedDependentRestitution,
    OffCentreContact,
    CameraRotation,
    CameraDistortion,
    AirJet,
    StickyLine,
    Vibration,
);

impl Effect {
    /// The effect of this name with its defaults.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|effect| effect.name() == name)
    }

    /// The value of a parameter; `None` if it has none of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let mut copy = *self;
        copy.parameter(name).map(|value| *value)
    }

    /// Sets a parameter; false if it has none of that name.
    pub fn set(&mut self, name: &str, value: f64) -> bool {
        self.parameter(name)
            .map(|parameter| *parameter = value)
            .is_some()
    }

    /// The same effect this many times as strong: parameters of strength move away from where the effect vanishes,
    /// those of place and form stay.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = *self;
        for spec in self.parameters() {
            if let (Some(neutral), Some(value)) = (spec.neutral, scaled.parameter(spec.name)) {
                *value = neutral + factor * (*value - neutral);
            }
        }
        scaled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_names_the_effect_and_its_parameters() {
        let effect = Effect::named("table_tilt").expect("a known effect");
        let text = serde_json::to_string(&effect).expect("plain data");
        assert_eq!(
            text,
            r#"{"name":"table_tilt","parameters":{"t_x":-0.003,"t_y":0.006}}"#
        );
        assert_eq!(
            serde_json::from_str::<Effect>(&text).expect("reads back"),
            effect
        );
    }

    #[test]
    fn names_in_files_are_those_of_the_effects() {
        for effect in Effect::all() {
            let value = serde_json::to_value(effect).expect("plain data");
            assert_eq!(value["name"], effect.name());
            for spec in effect.parameters() {
                assert_eq!(effect.get(spec.name), Some(spec.default));
            }
        }
    }

    #[test]
    fn scaling_moves_strength_and_keeps_place() {
        let patch = Effect::named("friction_patch")
            .expect("a known effect")
            .scaled(2.0);
        let plain = Effect::named("friction_patch").expect("a known effect");
        assert_eq!(patch.get("change"), plain.get("change").map(|c| 2.0 * c));
        assert_eq!(patch.get("center_x"), plain.get("center_x"));
        let speed = Effect::named("striker_speed_error")
            .expect("a known effect")
            .scaled(0.0);
        assert_eq!(speed.get("b"), Some(1.0));
    }
}
