//! The effects that act in a rig.

use serde::{Deserialize, Serialize};
use values::{Command, Point};

use crate::effects::{
    Acts, CameraRotation, FrictionPatch, OffCentreContact, SpeedWeakeningFriction,
    StrikerAngleBias, StrikerSpeedError, TableTilt,
};
use crate::{Effect, StrikeIndex};

/// The effects that act in a rig, in the order in which they are applied.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Hidden(pub Vec<Effect>);

impl Hidden {
    /// Nothing hidden.
    pub fn none() -> Self {
        Self::default()
    }

    /// What the demo hides by default: a mixture that friction and one factor of launch cannot absorb.
    ///
    /// All but the last part depend on the desired displacement alone, which is the only input of the paper's residual: an
    /// arm that is 10 % slow at its slowest and just over at its fastest, so that no constant factor fits; a hand-eye error
    /// in which the arm's angle, the tip's mount and the camera's turn all point the same way (7° on a cylinder); friction that
    /// rises as the object slows; a table that leans. A weak patch depends on the place, as real tables do, and is the part
    /// that the residual cannot learn. Each is of a size that real tables show. Together they leave a fitted friction and
    /// launch factor a mean stop error of 5 to 9 cm (the paper: 9.12 cm), while repeats scatter by about 4 mm;
    /// `tests/whole/end_to_end.rs` measures both.
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

    /// Every effect this many times as strong.
    pub fn scaled(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|effect| effect.scaled(factor)).collect())
    }

    pub(crate) fn acts(&self) -> impl Iterator<Item = &dyn Acts> {
        self.0.iter().map(Effect::acts)
    }

    /// What the arm delivers for a command and an object that lies at a point of the table (m), before launch scatter.
    pub fn deliver(&self, command: Command, from: Point, index: StrikeIndex) -> Command {
        self.acts().fold(command, |command, effect| {
            effect.deliver(command, from, index)
        })
    }

    /// Where the camera sees what lies at a point of the table, without noise, in m.
    pub fn see(&self, at: Point, centre: Point, index: StrikeIndex) -> Point {
        self.acts()
            .fold(at, |at, effect| effect.see(at, centre, index))
    }

    /// What lies where the camera sees this point: the inverse of [`Hidden::see`], in m.
    pub fn unsee(&self, seen: Point, centre: Point, index: StrikeIndex) -> Point {
        // The camera's effects are small, so that this contracts by about a hundred at each step.
        let mut at = seen;
        for _ in 0..50 {
            let miss = seen - self.see(at, centre, index);
            at = at + miss;
            if miss.norm() < 1e-13 {
                break;
            }
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::CameraDistortion;

    #[test]
    fn what_is_seen_can_be_unseen() {
        let hidden = Hidden(vec![
            Effect::CameraRotation(CameraRotation { angle: 0.03 }),
            Effect::CameraDistortion(CameraDistortion { k1: 0.1 }),
        ]);
        let (at, centre) = (Point::new(0.9, -0.5), Point::new(0.45, 0.0));
        let index = StrikeIndex::default();
        let seen = hidden.see(at, centre, index);
        assert!(hidden.unsee(seen, centre, index).distance(at) < 1e-12);
    }
}
