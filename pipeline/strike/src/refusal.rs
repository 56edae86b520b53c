//! Why a strike is not made: refused, never clamped.

use serde::Serialize;
use values::Point;

values::named! {
    /// The closed list of reasons.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Reason {
        /// A coordinate is NaN or infinite.
        NotFinite = "not_finite",
        /// The object or its target is not on the table.
        OffTable = "off_table",
        /// The path or the target lies where no training strike went.
        OutsideTrainedRegion = "outside_trained_region",
        /// No command brings the object there.
        Unreachable = "unreachable",
        /// No simulation came to a finite rest.
        Diverged = "diverged",
        /// The command is slower or faster than the arm may strike.
        SpeedLimit = "speed_limit",
        /// The command's angle is not one that the arm may strike at.
        AngleLimit = "angle_limit",
        /// The tip would have to leave its area or the arm's reach.
        Reach = "reach",
        /// The tip would come too near to the arm's base.
        KeepOut = "keep_out",
        /// The tip would meet an obstacle.
        Obstacle = "obstacle",
        /// The tip would push the object again after the impact.
        SecondPush = "second_push",
        /// A box is turned farther than is planned for.
        Turned = "turned",
        /// The plan is too old to be executed.
        PlanExpired = "plan_expired",
        /// A line of a batch is not `{"from": [x, y], "to": [x, y]}`.
        Malformed = "malformed",
        /// The command, simulated with its residual, stops off the table or farther from the target than the residual's training
        /// explains.
        ResidualTooLarge = "residual_too_large",
        /// The artifact was made for another object, striker, table or arm than this robot's own rig file states.
        OtherRig = "other_rig",
        /// The version is not signed by the configured key, or older than one that was loaded before.
        NotTrusted = "not_trusted",
        /// Recent strikes show another table than the version believes possible.
        TableChanged = "table_changed",
        /// The robot must not strike in the state that it is in.
        NotReady = "not_ready",
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
