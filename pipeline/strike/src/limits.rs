//! What a plan must keep to. Each check tells the limit, the value, and how to mend it; none moves a value into its limit.

use store::TrainedRegion;
use values::{Command, Interval, Point, Rig, Table};
use world::Profile;

use crate::Reason;

/// Paths shorter than this, in m, are no strike: the camera cannot tell them from rest.
const SHORTEST_PATH: f64 = 1e-3;
/// The base of the arm, in m along x: the tip never goes behind it.
const BASE: f64 = 0.0;

/// A limit that would be broken.
pub(crate) type Broken = (Reason, String);

/// A point is of numbers, and on the table.
pub(crate) fn point(table: &Table, name: &str, point: Point) -> Result<(), Broken> {
    let name = if name.contains(' ') {
        name.to_owned()
    } else {
        format!("`{name}`")
    };
    if !point.is_finite() {
        return Err((
            Reason::NotFinite,
            format!(
                "{name} is ({}, {}); both coordinates must be finite numbers, in m",
                point.x, point.y
            ),
        ));
    }
    if !table.contains(point) {
        return Err((
            Reason::OffTable,
            format!(
                "{name} {} is off the table, x in {} and y in {} m; choose a point on it",
                place(point),
                range(table.x),
                range(table.y)
            ),
        ));
    }
    Ok(())
}

/// Both points are numbers, on the table, and apart.
pub(crate) fn points(table: &Table, from: Point, to: Point) -> Result<(), Broken> {
    point(table, "from", from)?;
    point(table, "to", to)?;
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
    let (distance, bearing) = (path.norm(), path.bearing());
    let told = [
        Told {
            quantity: "the path's length in m",
            value: distance,
            trained: region.distance,
            is_trained: region.distance.contains(distance),
            mend: "lay the object nearer to or farther from its target",
        },
        Told {
            quantity: "the path's bearing in rad",
            value: bearing,
            trained: region.bearing,
            is_trained: region.holds_bearing(bearing),
            mend: "lay the object more in line with its target",
        },
    ];
    told.iter().try_for_each(Told::check)?;
    trained_stop(region, to)
}

/// The target lies where training strikes stopped.
pub(crate) fn trained_stop(region: &TrainedRegion, to: Point) -> Result<(), Broken> {
    let axes = [
        ("the target's x in m", to.x, region.stop_x),
        ("the target's y in m", to.y, region.stop_y),
    ];
    axes.into_iter().try_for_each(|(quantity, value, trained)| {
        let told = Told {
            quantity,
            value,
            trained,
            is_trained: trained.contains(value),
            mend: "choose a target among the training strikes' stops",
        };
        told.check()
    })
}

/// A quantity beside the interval that training strikes covered.
struct Told {
    quantity: &'static str,
    value: f64,
    trained: Interval,
    is_trained: bool,
    mend: &'static str,
}

impl Told {
    fn check(&self) -> Result<(), Broken> {
        if self.is_trained {
            return Ok(());
        }
        Err((
            Reason::OutsideTrainedRegion,
            format!(
                "{} is {:.4}, trained is {}; {}, or train on strikes that go there",
                self.quantity,
                self.value,
                range(self.trained),
                self.mend
            ),
        ))
    }
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

/// The final command, simulated, stops on the table, no farther from the target than what the residual may make good (m).
pub(crate) fn residual(rig: &Rig, to: Point, stop: Point, most: f64) -> Result<(), Broken> {
    let shift = stop.distance(to);
    let told = if !rig.table.contains(stop) {
        format!(
            "off the table, x in {} and y in {} m",
            range(rig.table.x),
            range(rig.table.y)
        )
    } else if shift <= most {
        return Ok(());
    } else {
        format!(
            "{:.1} mm from `to`, more than the {:.1} mm that the residual was trained to make good",
            shift * 1e3,
            most * 1e3
        )
    };
    Err((
        Reason::ResidualTooLarge,
        format!(
            "simulated with its residual, the command stops at {}, {told}; use the --model without it, or train it anew",
            place(stop)
        ),
    ))
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

/// A number for a person: beyond any table's size by its digits and power of ten.
fn number(value: f64) -> String {
    if value.abs() < 1e4 {
        format!("{value:.4}")
    } else {
        format!("{value:e}")
    }
}

/// A point for a person, in m.
pub(crate) fn place(point: Point) -> String {
    format!("({}, {})", number(point.x), number(point.y))
}

fn range(interval: Interval) -> String {
    format!("[{:.4}, {:.4}]", interval.low, interval.high)
}
