//! The robot that moves nothing: what is planned is what there is.

use super::{Robot, RobotError, StrikeRecord};
use crate::Plan;

/// `--robot dry-run`.
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
