//! A plan for tests.

use store::Model;
use values::{Command, Point};
use world::Profile;

use crate::Plan;

/// A plan that moves an object from (0.3, 0) to (0.6, 0).
pub(crate) fn plan() -> Plan {
    let (from, to) = (Point::new(0.3, 0.0), Point::new(0.6, 0.0));
    let command = Command {
        speed: 0.8,
        angle: 0.0,
    };
    let profile = Profile::plan(from, command, 5.0, 0.042);
    Plan {
        artifact: "v0001".into(),
        model: Model::Sysid,
        from,
        to,
        path: to - from,
        speed_sim: command.speed,
        angle_sim: command.angle,
        d_speed: 0.0,
        d_angle: 0.0,
        speed: command.speed,
        angle: command.angle,
        start: profile.start,
        pre_strike: profile.pre_strike,
        strike: profile.strike,
        stop: profile.stop,
        acceleration: 5.0,
        expected_miss: None,
        expected_miss_strikes: None,
    }
}
