//! Why a strike is not made: refused, never clamped.

use serde::Serialize;
use values::Point;

/// The closed list of reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// A coordinate is NaN or infinite.
    NotFinite,
    /// The object or its target is not on the table.
    OffTable,
    /// The path or the target lies where no training strike went.
    OutsideTrainedRegion,
    /// No command brings the object there.
    Unreachable,
    /// No simulation came to a finite rest.
    Diverged,
    /// The command is slower or faster than the arm may strike.
    SpeedLimit,
    /// The command's angle is not one that the arm may strike at.
    AngleLimit,
    /// The tip would have to leave its area or the arm's reach.
    Reach,
    /// The tip would come too near to the arm's base.
    KeepOut,
    /// The tip would meet an obstacle.
    Obstacle,
    /// The tip would push the object again after the impact.
    SecondPush,
    /// A box is turned farther than is planned for.
    Turned,
    /// The plan is too old to be executed.
    PlanExpired,
    /// A line of a batch is not `{"from": [x, y], "to": [x, y]}`.
    Malformed,
    /// The command, simulated with its residual, stops off the table or farther from the target than the residual's training
    /// explains.
    ResidualTooLarge,
    /// The artifact was made for another object, striker, table or arm than this robot's own rig file states.
    OtherRig,
    /// The version is not signed by the configured key, or older than one that was loaded before.
    NotTrusted,
    /// Recent strikes show another table than the version believes possible.
    TableChanged,
    /// The robot must not strike in the state that it is in.
    NotReady,
}

impl Reason {
    /// Every reason.
    pub const ALL: [Self; 19] = [
        Self::NotFinite,
        Self::OffTable,
        Self::OutsideTrainedRegion,
        Self::Unreachable,
        Self::Diverged,
        Self::SpeedLimit,
        Self::AngleLimit,
        Self::Reach,
        Self::KeepOut,
        Self::Obstacle,
        Self::SecondPush,
        Self::Turned,
        Self::PlanExpired,
        Self::Malformed,
        Self::ResidualTooLarge,
        Self::OtherRig,
        Self::NotTrusted,
        Self::TableChanged,
        Self::NotReady,
    ];

    /// The name in files, such as `off_table`.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::OffTable => "off_table",
            Self::OutsideTrainedRegion => "outside_trained_region",
            Self::Unreachable => "unreachable",
            Self::Diverged => "diverged",
            Self::SpeedLimit => "speed_limit",
            Self::AngleLimit => "angle_limit",
            Self::Reach => "reach",
            Self::KeepOut => "keep_out",
            Self::Obstacle => "obstacle",
            Self::SecondPush => "second_push",
            Self::Turned => "turned",
            Self::PlanExpired => "plan_expired",
            Self::Malformed => "malformed",
            Self::ResidualTooLarge => "residual_too_large",
            Self::OtherRig => "other_rig",
            Self::NotTrusted => "not_trusted",
            Self::TableChanged => "table_changed",
            Self::NotReady => "not_ready",
        }
    }
}

/// A strike that is not made. Serialised it is the contract's refusal. Its text completes "refused: ".
#[derive(Clone, Debug, PartialEq, Serialize, thiserror::Error)]
#[error("{}: {detail}", refused.name())]
pub struct Refusal {
    /// Where the object rests, in m; none where it was not given.
    pub from: Option<Point>,
    /// Where it was to come to rest, in m; none where it was not given.
    pub to: Option<Point>,
    /// Why.
    pub refused: Reason,
    /// Why, with numbers, and how to mend it.
    pub detail: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_written_by_their_names() {
        for reason in Reason::ALL {
            let written = serde_json::to_string(&reason).expect("plain data");
            assert_eq!(written, format!("\"{}\"", reason.name()));
        }
    }
}
