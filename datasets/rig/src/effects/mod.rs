//! What the rig can hide: the contract's effects, other forms of the same phenomena, and what no candidate has.
//!
//! Each effect states its parameters in [`declare!`](crate::declare::declare) and overrides the steps of [`Acts`] at which it
//! acts. Where an effect has a name of the contract, its form may still differ from the textbook's (an elliptic patch with a
//! soft edge, another Stribeck exponent, a drift that saturates, a power law of restitution, a soft cap), while each parameter
//! keeps its meaning. The files: `friction`, `forces`, `striker`, `camera` have the contract's first effects, `foreign` and
//! `unnamed` what no candidate has, the others forms that only share the phenomenon.

mod arm;
mod camera;
mod forces;
mod foreign;
mod friction;
mod impact;
mod lens;
mod place;
mod sliding;
mod striker;
mod table;
mod unnamed;
mod wear;

use values::{Command, Point};

use crate::When;
use crate::declare::declare_all;

pub use arm::{AngleBacklash, RoundedSpeed, StrikerAngleError, TanhSpeed};
pub use camera::{CameraDistortion, CameraRotation};
pub use forces::{QuadraticDrag, TableBowl, TableTilt, ViscousDrag};
pub use foreign::{AirJet, StickyLine, Vibration};
pub use friction::{
    AnisotropicFriction, FrictionBySession, FrictionDrift, FrictionPatch, SpeedWeakeningFriction,
};
pub use impact::{RestitutionStep, ViscoelasticRestitution, YieldingRestitution};
pub use lens::{BrownLens, CameraLean, CameraScale};
pub use place::{FrictionGradient, FrictionMap, FrictionStep, RectangularPatch};
pub use sliding::{CosineGrain, LogarithmicStribeck, PowerDrag, RationalStribeck};
pub use striker::{
    OffCentreContact, SpeedDependentRestitution, StrikerAngleBias, StrikerSpeedError,
};
pub use table::{SineBowl, Trough, WarpedTilt};
pub use unnamed::{
    AngleRipple, FrictionAgeing, Magnet, SideForce, Sloshing, SpeedRipple, StitchedCameras, Swirl,
};
pub use wear::{
    CameraAngleBySession, FrictionOfSessions, LinearWear, RestitutionDrift, RunningIn,
    StrikerAngleBySession,
};

/// Standard gravity in m/s².
pub(crate) const GRAVITY: f64 = 9.806_65;

/// Where an effect may act; every step does nothing unless overridden.
pub(crate) trait Acts {
    /// The tip's speed and angle in place of the commanded ones.
    fn deliver(&self, command: Command, _when: When) -> Command {
        command
    }
    /// How far to the left of the centre the tip passes, in m.
    fn tip_offset(&self) -> f64 {
        0.0
    }
    /// Factor on the restitution at this speed of approach (m/s).
    fn restitution(&self, _speed: f64, _when: When) -> f64 {
        1.0
    }
    /// Factor on the friction of a whole strike.
    fn strike_friction(&self, _when: When) -> f64 {
        1.0
    }
    /// Whether [`Acts::local_friction`] or [`Acts::directional_friction`] differs over the base, with speed or direction.
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
    /// Factor on the friction of an element that slides in this direction (a unit vector).
    fn directional_friction(&self, _direction: Point) -> f64 {
        1.0
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
    fn see(&self, at: Point, _centre: Point, _when: When) -> Point {
        at
    }
    /// The finest length over which it changes, in m, where the integrator must step finely.
    fn grain_size(&self) -> f64 {
        f64::INFINITY
    }
}

declare_all!(
    /// An effect with its parameters; in files `{"name": …, "parameters": {…}}`.
    Effect: Acts by acts;
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
    RectangularPatch,
    FrictionGradient,
    FrictionStep,
    FrictionMap,
    RationalStribeck,
    LogarithmicStribeck,
    PowerDrag,
    CosineGrain,
    WarpedTilt,
    SineBowl,
    Trough,
    TanhSpeed,
    RoundedSpeed,
    StrikerAngleError,
    AngleBacklash,
    RunningIn,
    LinearWear,
    RestitutionDrift,
    RestitutionStep,
    FrictionOfSessions,
    StrikerAngleBySession,
    CameraAngleBySession,
    ViscoelasticRestitution,
    YieldingRestitution,
    CameraLean,
    BrownLens,
    CameraScale,
    Magnet,
    SideForce,
    Swirl,
    Sloshing,
    FrictionAgeing,
    SpeedRipple,
    AngleRipple,
    StitchedCameras,
);

impl Effect {
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
