//! A plan for tests.

use std::sync::Arc;
use std::time::Duration;

use store::Model;
use values::{Command, Point, Rig, Shape};

use crate::Plan;
use crate::plan::{Details, GOOD_FOR};
use crate::stroke::Stroke;

/// A plan that moves an object from (0.3, 0) to (0.6, 0).
pub(crate) fn plan() -> Plan {
    make(0.8, GOOD_FOR)
}

/// A plan that moves an object from (0.3, 0) to (0.6, 0), executable for `good_for`.
pub(crate) fn plan_good_for(good_for: Duration) -> Plan {
    make(0.8, good_for)
}

/// A plan of a strike from (0.3, 0) at `speed` (m/s).
pub(crate) fn plan_at(speed: f64) -> Plan {
    make(speed, GOOD_FOR)
}

fn make(speed: f64, good_for: Duration) -> Plan {
    let rig = Rig::demo(Shape::Cylinder);
    let (from, to) = (Point::new(0.3, 0.0), Point::new(0.6, 0.0));
    let command = Command { speed, angle: 0.0 };
    let stroke = Stroke::plan(from, command, &rig.robot, 0.042);
    let maker = ("v0001".into(), Model::Sysid);
    let details = Details::unaided(maker, (from, to), command, &stroke, &rig);
    Plan::new(details, stroke, Arc::new(rig), good_for)
}
