//! What a plan must keep to. Each check tells the limit, the value, and how to mend it; none moves a value into its limit.

use artifacts::TrainedRegion;
use values::{Command, Interval, Point, Rig, Table};
use world::Profile;

use crate::Reason;

/// Paths shorter than this, in m, are no strike: the camera cannot tell them from rest.
const SHORTEST_PATH: f64 = 1e-3;
/// The base of the arm, in m along x: the tip never goes behind it.
const BASE: f64 = 0.0;

/// A limit that would be broken.
pub(crate) type Broken = (Reason, String);

/// Both points are numbers, on the table, and apart.
pub(crate) fn points(table: &Table, from: Point, to: Point) -> Result<(), Broken> {
    for (name, point) in [("from", from), ("to", to)] {
        if !point.is_finite() {
            return Err((
                Reason::NotFinite,
                format!(
                    "`{name}` is ({}, {}); both coordinates must be finite numbers, in m",
                    point.x, point.y
                ),
            ));
        }
        if !table.contains(point) {
            return Err((
                Reason::OffTable,
                format!(
                    "`{name}` {} is off the table, x in {} and y in {} m; choose a point on it",
                    place(point),
                    range(table.x),
                    range(table.y)
                ),
            ));
        }
    }
    let distance = from.distance(to);
    if distance < SHORTEST_PATH {
        return Err((
            Reason::Unreachable,
            format!(
                "`to` lies {:.1} mm from `from`; a strike moves the object at least {:.0} mm",
                distance * 1e3,
                SHORTEST_PATH * 1e3
            ),
        ));
    }
    Ok(())
}

/// Path and target lie where training strikes went.
pub(crate) fn trained(region: &TrainedRegion, from: Point, to: Point) -> Result<(), Broken> {
    let path = to - from;
    let within = |value: f64, trained: Interval| (value, trained, trained.contains(value));
    let bearing = path.bearing();
    for (quantity, (value, trained, is_trained), mend) in [
        (
            "the path's length in m",
            within(path.norm(), region.distance),
            "lay the object nearer to or farther from its target",
        ),
        (
            "the path's bearing in rad",
            (bearing, region.bearing, region.holds_bearing(bearing)),
            "lay the object more in line with its target",
        ),
        (
            "the target's x in m",
            within(to.x, region.stop_x),
            "choose a target among the training strikes' stops",
        ),
        (
            "the target's y in m",
            within(to.y, region.stop_y),
            "choose a target among the training strikes' stops",
        ),
    ] {
        if !is_trained {
            return Err((
                Reason::OutsideTrainedRegion,
                format!(
                    "{quantity} is {value:.4}, trained is {}; {mend}, or train on strikes that go there",
                    range(trained)
                ),
            ));
        }
    }
    Ok(())
}

/// The command is one that the arm may be told. `simulated` is the part of it that the world gave.
pub(crate) fn command(rig: &Rig, command: Command, simulated: Command) -> Result<(), Broken> {
    let robot = &rig.robot;
    if !robot.speed.contains(command.speed) {
        let mend = if command.speed < robot.speed.low {
            "choose a target farther from the object"
        } else {
            "choose a target nearer to the object"
        };
        return Err((
            Reason::SpeedLimit,
            format!(
                "the speed {:.4} m/s (simulated {:.4}, residual {:+.4}) is outside robot.speed {} m/s; {mend}",
                command.speed,
                simulated.speed,
                command.speed - simulated.speed,
                range(robot.speed)
            ),
        ));
    }
    if !robot.angle.contains(command.angle) {
        return Err((
            Reason::AngleLimit,
            format!(
                "the angle {:.4} rad (simulated {:.4}, residual {:+.4}) is outside robot.angle {} rad; \
                 lay the object more in line with its target",
                command.angle,
                simulated.angle,
                command.angle - simulated.angle,
                range(robot.angle)
            ),
        ));
    }
    Ok(())
}

/// Every position of the tip is within reach: over the table, or between the table and the arm's base at x = 0, from
/// where the arm reaches out.
pub(crate) fn reach(table: &Table, profile: &Profile) -> Result<(), Broken> {
    let x = Interval {
        low: table.x.low.min(BASE),
        high: table.x.high,
    };
    for (name, point) in [
        ("start", profile.start),
        ("pre_strike", profile.pre_strike),
        ("strike", profile.strike),
        ("stop", profile.stop),
    ] {
        if !(x.contains(point.x) && table.y.contains(point.y)) {
            return Err((
                Reason::Reach,
                format!(
                    "the tip's `{name}` {} is out of reach, x in {} and y in {} m (the table, and up to the arm's base); \
                     lay the object farther from that edge, or raise robot.acceleration if the arm can do more",
                    place(point),
                    range(x),
                    range(table.y)
                ),
            ));
        }
    }
    Ok(())
}

/// A point for a person, in m.
pub(crate) fn place(point: Point) -> String {
    format!("({:.4}, {:.4})", point.x, point.y)
}

fn range(interval: Interval) -> String {
    format!("[{:.4}, {:.4}]", interval.low, interval.high)
}
