//! What the rig can hide: the contract's effects, other forms of the same phenomena, and what no candidate has.
//!
//! Each effect states its parameters in [`declare!`](crate::declare::declare) and overrides the steps of [`Acts`] at which it
//! acts. Where an effect has a name of the contract, its form may still differ from the textbook's (an elliptic patch with a
//! soft edge, another Stribeck exponent, a drift that saturates, a power law of restitution, a soft cap), while each parameter
//! keeps its meaning. The files: `friction`, `forces`, `striker`, `camera` have the contract's first effects, `foreign` and
//! `unnamed` what no candidate has, the others forms that only share the phenomenon.

mod acts;
mod arm;
mod camera;
mod forces;
mod foreign;
mod friction;
mod order;
mod place;
mod reach;
mod sliding;
mod striker;
mod table;
mod unnamed;
mod wear;

use crate::declare::declare_all;

pub(crate) use acts::{Acts, GRAVITY};

pub(crate) use self::{
    arm::*, camera::*, forces::*, foreign::*, friction::*, order::*, place::*, reach::*,
    sliding::*, striker::*, table::*, unnamed::*, wear::*,
};

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
    OffCentreLens,
    Saddle,
    TableMap,
    StrikerErrorByPlace,
    SpeedByReach,
    HeadingByBearing,
    FrictionChange,
    SandedTable,
    FrictionCycle,
    WipedTable,
    WarmingArm,
    PushedCamera,
);

impl Effect {
    /// This effect `times` times as strong: parameters of strength move away from where the effect vanishes,
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
