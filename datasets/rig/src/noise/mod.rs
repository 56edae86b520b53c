//! Noise that a real table has: what differs from strike to strike or from frame to frame, and a rig file that is wrong.
//!
//! No kind of noise is an effect: a diagnosis that knows its noise finds nothing where only these act. Each states its
//! parameters in [`declare!`](crate::declare::declare) and adds to the [`Levels`] that the rig draws from.

mod kinds;

use serde::{Deserialize, Serialize};
use values::Rig;

use crate::declare::declare_all;

use kinds::*;
pub(crate) use kinds::{Disturbs, Levels};

declare_all!(
    /// A kind of noise with its parameters; in files `{"name": …, "parameters": {…}}`.
    NoiseKind: Disturbs by disturbs;
    FrictionScatter,
    FrictionWander,
    LaunchTails,
    LaunchScatterBySpeed,
    LaunchScatterByAngle,
    CameraCorrelation,
    CameraTails,
    CameraNoiseByStrike,
    LateStamps,
    JitteringStamps,
    StrayFrames,
    MountVibration,
    WrongRigFile,
    YawScatter,
    QuantisedPlaces,
    QuantisedStamps,
    LostBursts,
    NarrowView,
    RollingShutter,
    TwoObjects,
);

/// The kinds of noise that act in a rig beside launch scatter and independent camera noise; `noise` in `truth.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Noise(pub Vec<NoiseKind>);

impl Noise {
    /// Only launch scatter and independent camera noise.
    pub fn none() -> Self {
        Self::default()
    }

    /// Whether there is only launch scatter and independent camera noise.
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn levels(&self) -> Levels {
        let mut levels = Levels::default();
        for kind in &self.0 {
            kind.disturbs().add_to(&mut levels);
        }
        levels
    }

    /// Standard deviation of friction from strike to strike over this many strikes, wander included, as a share of it.
    pub fn friction_sd(&self, strikes: usize) -> f64 {
        let levels = self.levels();
        // A random walk of n steps scatters about its own mean by a variance of n/6 steps'.
        levels
            .friction_scatter
            .hypot(levels.friction_wander * (strikes as f64 / 6.0).sqrt())
            .hypot(levels.other_change * (levels.other_share * (1.0 - levels.other_share)).sqrt())
    }

    /// Autocorrelation of camera noise from one frame to the next.
    pub fn camera_correlation(&self) -> f64 {
        self.levels().camera_correlation
    }

    /// The rig file that is written for a rig: its sizes may be wrong.
    pub(crate) fn rig_file(&self, rig: &Rig) -> Rig {
        let levels = self.levels();
        let mut file = rig.clone();
        file.object.solid = file.object.solid.scaled(1.0 + levels.object_error);
        file.object.mass *= 1.0 + levels.mass_error;
        file.striker.radius *= 1.0 + levels.tip_error;
        file.camera.noise *= 1.0 + levels.camera_noise_error;
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_files_are_those_of_the_kinds_and_of_no_effect() {
        for kind in NoiseKind::all() {
            let value = serde_json::to_value(kind).expect("plain data");
            assert_eq!(value["name"], kind.name());
            assert!(
                crate::Effect::named(kind.name()).is_none(),
                "{}",
                kind.name()
            );
        }
    }

    #[test]
    fn without_noise_the_rig_file_is_the_rig() {
        let rig = Rig::demo(values::Shape::Box);
        assert_eq!(Noise::none().rig_file(&rig), rig);
        let wrong = Noise(vec![NoiseKind::WrongRigFile(WrongRigFile::default())]).rig_file(&rig);
        let ratio = wrong.object.solid.reach() / rig.object.solid.reach();
        assert!((ratio - 1.1).abs() < 1e-12);
    }
}
