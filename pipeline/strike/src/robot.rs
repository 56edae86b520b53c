//! What can strike: a [`Robot`]. An arm is one by its maker's driver ([`arm`]); [`execute`] is the only way a plan reaches it.

pub mod arm;
mod choice;
#[cfg(feature = "sim")]
mod sim;
pub mod ur;
pub mod xarm;

pub use choice::{Choice, UnknownRobot};
#[cfg(feature = "sim")]
pub use sim::{SimRobot, TruthSource};

use logs::write::Samples;
use values::Point;

use crate::{Plan, Refusal};

/// An arm with its camera, or a simulation of both.
///
/// The order of calls is [`execute`]'s: `check`, then `strike`, and `abort` if `strike` failed. A driver connects when it
/// is made, and moves nothing before `strike`.
pub trait Robot {
    /// Name for a person, such as `sim`.
    fn name(&self) -> String;

    /// Whether the plan can be struck now: connection, rig, state of the arm (enabled, no fault, at rest), object in its
    /// place. Moves nothing. Errors: [`RobotError::NotReady`] for a state that a person must change,
    /// [`RobotError::Connection`] where the state cannot be read.
    fn check(&mut self, plan: &Plan) -> Result<(), RobotError>;

    /// Strikes: moves the tip from `plan.start` to `plan.stop` on the plan's profile, records from rest to rest, and
    /// returns when the object rests. None from a robot that moves nothing. On an error the arm may still move:
    /// [`execute`] aborts it.
    fn strike(&mut self, plan: &Plan) -> Result<Option<StrikeRecord>, RobotError>;

    /// Stops the arm where it is, as fast as it safely can, and leaves it at rest.
    fn abort(&mut self) -> Result<(), RobotError>;
}

/// `--robot dry-run`, which moves nothing: what is planned is what there is.
#[derive(Clone, Copy, Debug, Default)]
pub struct DryRun;

impl Robot for DryRun {
    fn name(&self) -> String {
        "dry-run".into()
    }

    fn check(&mut self, _: &Plan) -> Result<(), RobotError> {
        Ok(())
    }

    fn strike(&mut self, _: &Plan) -> Result<Option<StrikeRecord>, RobotError> {
        Ok(None)
    }

    fn abort(&mut self) -> Result<(), RobotError> {
        Ok(())
    }
}

/// What a strike recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct StrikeRecord {
    /// What goes into the log.
    pub samples: Samples,
    /// Where the camera saw the object come to rest, in m; none where no camera looked.
    pub stop: Option<Point>,
    /// Speed that the arm delivered at contact, in m/s; none where it is not measured.
    pub delivered_speed: Option<f64>,
    /// A warning for the operator.
    pub warning: Option<String>,
}

/// Why a robot did not strike. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum RobotError {
    #[error("reach robot {robot}: {why}")]
    Connection { robot: String, why: String },
    #[error("drive robot {robot}: another program does; try again when it has ended")]
    Busy { robot: String },
    #[error("strike with robot {robot}: {why}; nothing has moved")]
    NotReady { robot: String, why: String },
    #[error("execute the plan: {0}; nothing has moved")]
    Refused(Refusal),
    #[error("finish the strike of robot {robot}: {why}")]
    Interrupted {
        robot: String,
        why: String,
        samples: Option<Box<Samples>>,
    },
    #[error("{strike}; then failed to stop the arm: {abort}: press the emergency stop")]
    Runaway {
        strike: Box<RobotError>,
        abort: Box<RobotError>,
    },
}

impl RobotError {
    /// What was recorded of a strike that was begun and not ended.
    pub fn samples(&self) -> Option<&Samples> {
        match self {
            Self::Interrupted { samples, .. } => samples.as_deref(),
            Self::Runaway { strike, .. } => strike.samples(),
            Self::Connection { .. }
            | Self::Busy { .. }
            | Self::NotReady { .. }
            | Self::Refused(_) => None,
        }
    }
}

/// Checks the plan again and the robot, strikes, and stops the arm where the strike fails: nothing moves before the checks have
/// passed.
pub fn execute(robot: &mut dyn Robot, plan: &Plan) -> Result<Option<StrikeRecord>, RobotError> {
    holds(plan)?;
    robot.check(plan)?;
    // What was checked took time, and whoever is told to stand clear may take more.
    holds(plan)?;
    robot.strike(plan).map_err(|strike| match robot.abort() {
        Ok(()) => strike,
        Err(abort) => RobotError::Runaway {
            strike: Box::new(strike),
            abort: Box::new(abort),
        },
    })
}

fn holds(plan: &Plan) -> Result<(), RobotError> {
    plan.check_again().map_err(|(refused, detail)| {
        RobotError::Refused(Refusal {
            from: Some(plan.from),
            to: Some(plan.to),
            refused,
            detail,
        })
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use logs::write::Stamped;

    use super::*;
    use crate::Reason;
    use crate::testing::plan;

    /// A robot that records its calls, and fails at the one that is given.
    #[derive(Default)]
    struct Noting {
        calls: Vec<&'static str>,
        fails: Vec<&'static str>,
        /// Time that its check takes.
        checks_for: Duration,
    }

    /// What the robot recorded before it failed.
    fn sampled() -> Samples {
        let command = Stamped::at(1, Point::new(0.5, 0.0));
        Samples {
            commands: vec![command],
            ..Samples::default()
        }
    }

    impl Noting {
        fn call(&mut self, name: &'static str) -> Result<(), RobotError> {
            self.calls.push(name);
            if self.fails.contains(&name) {
                return Err(RobotError::Interrupted {
                    robot: "noting".into(),
                    why: name.into(),
                    samples: (name == "strike").then(|| Box::new(sampled())),
                });
            }
            Ok(())
        }
    }

    impl Robot for Noting {
        fn name(&self) -> String {
            "noting".into()
        }
        fn check(&mut self, _: &Plan) -> Result<(), RobotError> {
            std::thread::sleep(self.checks_for);
            self.call("check")
        }
        fn strike(&mut self, _: &Plan) -> Result<Option<StrikeRecord>, RobotError> {
            self.call("strike").map(|()| None)
        }
        fn abort(&mut self) -> Result<(), RobotError> {
            self.call("abort")
        }
    }

    fn calls(
        fails: &[&'static str],
    ) -> (Vec<&'static str>, Result<Option<StrikeRecord>, RobotError>) {
        let mut robot = Noting {
            fails: fails.into(),
            ..Noting::default()
        };
        let outcome = execute(&mut robot, &plan());
        (robot.calls, outcome)
    }

    #[test]
    fn a_strike_is_checked_first() {
        let (calls, outcome) = calls(&[]);
        assert_eq!(calls, ["check", "strike"]);
        assert!(matches!(outcome, Ok(None)));
    }

    #[test]
    fn a_plan_that_is_old_or_breaks_a_limit_reaches_no_robot() {
        let mut robot = Noting::default();
        let mut refused = |plan: &Plan| match execute(&mut robot, plan) {
            Err(RobotError::Refused(refusal)) => refusal.refused,
            other => panic!("{other:?}"),
        };
        let old = crate::testing::plan_good_for(Duration::ZERO);
        assert_eq!(refused(&old), Reason::PlanExpired);
        let fast = crate::testing::plan_at(1.2);
        assert_eq!(refused(&fast), Reason::SpeedLimit);
        assert!(robot.calls.is_empty());
    }

    #[test]
    fn a_plan_that_grows_old_while_the_robot_is_checked_is_not_struck() {
        let mut robot = Noting {
            checks_for: Duration::from_millis(600),
            ..Noting::default()
        };
        let plan = crate::testing::plan_good_for(Duration::from_millis(500));
        let error = execute(&mut robot, &plan).expect_err("old");
        assert!(matches!(error, RobotError::Refused(_)), "{error}");
        assert!(!robot.calls.contains(&"strike"));
    }

    #[test]
    fn nothing_moves_where_the_check_fails() {
        let (calls, outcome) = calls(&["check"]);
        assert_eq!(calls, ["check"]);
        assert!(outcome.is_err());
    }

    #[test]
    fn a_strike_that_fails_is_aborted() {
        let (calls, outcome) = calls(&["strike"]);
        assert_eq!(calls, ["check", "strike", "abort"]);
        let error = outcome.expect_err("failed");
        assert!(matches!(error, RobotError::Interrupted { .. }));
        assert_eq!(
            error.samples(),
            Some(&sampled()),
            "what was recorded is kept"
        );
    }

    #[test]
    fn an_arm_that_cannot_be_stopped_is_reported_with_both_reasons() {
        let (_, outcome) = calls(&["strike", "abort"]);
        let error = outcome.expect_err("failed");
        assert_eq!(error.samples(), Some(&sampled()));
        let text = error.to_string();
        assert!(
            text.contains("noting: strike") && text.contains("noting: abort"),
            "{text}"
        );
        assert!(text.contains("emergency stop"), "{text}");
    }
}
