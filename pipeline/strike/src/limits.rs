//! What a plan must keep to. Each check states the limit, the value, and how to mend it; none moves a value into its limit.

use store::TrainedRegion;
use values::{Command, Interval, Point, Rig, Shape};
use world::Simulated;

use crate::Reason;
use crate::stroke::Stroke;

/// Shortest path, in m: the camera cannot distinguish a shorter one from rest.
const SHORTEST_PATH: f64 = 1e-3;
/// Distance, in m, that the tip keeps from the object after the impact: several times what the camera's noise and a tenth more or less friction move
/// either by before the tip is at rest.
const SECOND_PUSH_MARGIN: f64 = 0.005;
/// Rate, in Hz, at which tip and object are sampled after the impact.
const SAMPLES: f64 = 1e3;
/// Angle, in rad, up to which a box may stand turned: fifteen degrees, over which the world is tested to strike it as a rigid body is struck.
const MOST_TURN: f64 = 0.26;

pub(crate) type BrokenLimit = (Reason, String);

/// Errors where a limit is broken.
pub(crate) fn refuse_if(
    is_broken: bool,
    reason: Reason,
    detail: impl FnOnce() -> String,
) -> Result<(), BrokenLimit> {
    match is_broken {
        true => Err((reason, detail())),
        false => Ok(()),
    }
}

/// Checks that a point's coordinates are finite, and that an object that rests there lies on the table with all of its footprint.
pub(crate) fn point(rig: &Rig, name: &str, point: Point) -> Result<(), BrokenLimit> {
    let table = &rig.table;
    let name = if name.contains(' ') {
        name.to_owned()
    } else {
        format!("`{name}`")
    };
    refuse_if(!point.is_finite(), Reason::NotFinite, || {
        format!(
            "{name} is ({}, {}); both coordinates must be finite numbers, in m",
            point.x, point.y
        )
    })?;
    refuse_if(!table.contains(point), Reason::OffTable, || {
        format!(
            "{name} {} is off the table, x in {} and y in {} m; choose a point on it",
            place(point),
            range(table.x),
            range(table.y)
        )
    })?;
    let (_, footprint) = sizes(rig);
    let room = (point.x - table.x.low)
        .min(table.x.high - point.x)
        .min(point.y - table.y.low)
        .min(table.y.high - point.y);
    // The rounding of decimals decides nothing.
    refuse_if(room < footprint - 1e-9, Reason::OffTable, || {
        format!(
            "an object at {name} {} reaches {footprint:.4} m around it, and the table's edge is {room:.4} m away; choose a point \
             farther in",
            place(point)
        )
    })
}

/// Checks that both points are finite, on the table, and apart.
pub(crate) fn points(rig: &Rig, from: Point, to: Point) -> Result<(), BrokenLimit> {
    point(rig, "from", from)?;
    point(rig, "to", to)?;
    let distance = from.distance(to);
    refuse_if(distance < SHORTEST_PATH, Reason::Unreachable, || {
        format!(
            "`to` lies {:.1} mm from `from`; a strike moves the object at least {:.0} mm",
            distance * 1e3,
            SHORTEST_PATH * 1e3
        )
    })
}

/// Checks that path and target lie where training strikes went.
pub(crate) fn trained(region: &TrainedRegion, from: Point, to: Point) -> Result<(), BrokenLimit> {
    let path = to - from;
    let (distance, bearing) = (path.norm(), path.bearing());
    covered(
        "the path's length in m",
        (distance, region.distance),
        region.distance.contains(distance),
        "lay the object nearer to or farther from its target",
    )?;
    covered(
        "the path's bearing in rad",
        (bearing, region.bearing),
        region.holds_bearing(bearing),
        "lay the object more in line with its target",
    )?;
    trained_start(region, from)?;
    trained_stop(region, to)
}

/// Checks that the object lies where training strikes started; older versions do not state it.
pub(crate) fn trained_start(region: &TrainedRegion, from: Point) -> Result<(), BrokenLimit> {
    let axes = [
        ("the object's x in m", from.x, region.start_x),
        ("the object's y in m", from.y, region.start_y),
    ];
    let mend = "lay the object among the training strikes' starts";
    axes.into_iter().try_for_each(|(quantity, value, trained)| {
        trained.map_or(Ok(()), |trained| {
            covered(quantity, (value, trained), trained.contains(value), mend)
        })
    })
}

/// Checks that the target lies where training strikes stopped.
pub(crate) fn trained_stop(region: &TrainedRegion, to: Point) -> Result<(), BrokenLimit> {
    let axes = [
        ("the target's x in m", to.x, region.stop_x),
        ("the target's y in m", to.y, region.stop_y),
    ];
    let mend = "choose a target among the training strikes' stops";
    axes.into_iter().try_for_each(|(quantity, value, trained)| {
        covered(quantity, (value, trained), trained.contains(value), mend)
    })
}

/// Checks that training strikes covered a quantity's value; beside it stands the interval that they covered.
fn covered(
    quantity: &str,
    (value, trained): (f64, Interval),
    is_trained: bool,
    mend: &str,
) -> Result<(), BrokenLimit> {
    refuse_if(!is_trained, Reason::OutsideTrainedRegion, || {
        format!(
            "{quantity} is {value:.4}, trained is {}; {mend}, or train on strikes that go there",
            range(trained)
        )
    })
}

/// Checks that the arm may be sent the command. `simulated` is the part of it that the world gave.
pub(crate) fn command(rig: &Rig, command: Command, simulated: Command) -> Result<(), BrokenLimit> {
    let is_slow = command.speed < rig.robot.speed.low;
    let way = if is_slow { "farther from" } else { "nearer to" };
    let limits = [
        (
            Reason::SpeedLimit,
            ["speed", "m/s"],
            (command.speed, simulated.speed, rig.robot.speed),
            format!("choose a target {way} the object"),
        ),
        (
            Reason::AngleLimit,
            ["angle", "rad"],
            (command.angle, simulated.angle, rig.robot.angle),
            "lay the object more in line with its target".into(),
        ),
    ];
    limits.into_iter().try_for_each(
        |(reason, [key, unit], (sent, simulated, allowed), mend)| {
            refuse_if(!allowed.contains(sent), reason, || {
                format!(
                    "the {key} {sent:.4} {unit} (simulated {simulated:.4}, residual {:+.4}) is outside robot.{key} {} {unit}; {mend}",
                    sent - simulated,
                    range(allowed)
                )
            })
        },
    )
}

/// Checks that the final command, simulated without its residual, stops no farther from the target than what the residual may make good (m).
pub(crate) fn shift(to: Point, stop: Point, most: f64) -> Result<(), BrokenLimit> {
    let distance = stop.distance(to);
    if distance <= most {
        return Ok(());
    }
    Err(residual_too_large(
        stop,
        &format!(
            "{:.1} mm from `to`, more than the {:.1} mm that the residual was trained to make good",
            distance * 1e3,
            most * 1e3
        ),
    ))
}

/// Checks that the final command, simulated without its residual, stops on the table.
pub(crate) fn shifted_on_table(table: &values::Table, stop: Point) -> Result<(), BrokenLimit> {
    if table.contains(stop) {
        return Ok(());
    }
    Err(residual_too_large(
        stop,
        &format!(
            "off the table, x in {} and y in {} m",
            range(table.x),
            range(table.y)
        ),
    ))
}

/// Checks that what a residual adds, in this unit, lies in a range.
pub(crate) fn added(unit: &str, added: f64, most: Interval) -> Result<(), BrokenLimit> {
    refuse_if(!most.contains(added), Reason::ResidualTooLarge, || {
        format!(
            "the residual adds {added:+.4} {unit}, by what it learnt it adds {} {unit}; use the --model without it, or train it anew",
            range(most)
        )
    })
}

fn residual_too_large(stop: Point, detail: &str) -> BrokenLimit {
    (
        Reason::ResidualTooLarge,
        format!(
            "simulated with its residual, the command stops at {}, {detail}; use the --model without it, or train it anew",
            place(stop)
        ),
    )
}

/// Checks that after the impact tip and object part and never meet again, while either moves. `clear` (m) is the distance of their centres at which
/// they cannot touch, however the object is turned.
pub(crate) fn second_push(
    stroke: &Stroke,
    object: &Simulated,
    clear: f64,
) -> Result<(), BrokenLimit> {
    let end = object.rest_time.max(stroke.t_stop - stroke.t_strike);
    let gap = |t: f64| object.at(t).distance(stroke.at(stroke.t_strike + t).0) - clear;
    let mut has_parted = false;
    let mut t = 0.0;
    while t <= end {
        let now = gap(t);
        refuse_if(
            has_parted && now < SECOND_PUSH_MARGIN,
            Reason::SecondPush,
            || {
                format!(
                    "{:.2} s after the impact the tip comes within {:.1} mm of the object again, {:.1} mm is the least; choose a target \
                     farther away, or raise robot.acceleration if the arm can do more",
                    t,
                    now * 1e3,
                    SECOND_PUSH_MARGIN * 1e3
                )
            },
        )?;
        has_parted |= now >= SECOND_PUSH_MARGIN;
        t += 1.0 / SAMPLES;
    }
    refuse_if(!has_parted, Reason::SecondPush, || {
        format!(
            "tip and object never part by {:.1} mm: the tip pushes; choose a target farther away, or raise robot.acceleration if the \
             arm can do more",
            SECOND_PUSH_MARGIN * 1e3
        )
    })
}

/// Distance in m of tip's and object's centre beyond which they cannot touch, and by how much (m) the object's footprint reaches
/// beyond its centre however it is turned.
pub(crate) fn sizes(rig: &Rig) -> (f64, f64) {
    let reach = rig.object.solid.reach();
    let footprint = match rig.object.shape() {
        // A ball rests on a point.
        Shape::Sphere => 0.0,
        Shape::Cylinder | Shape::Box => reach,
    };
    (reach + rig.striker.radius, footprint)
}

/// How far (rad) a box that is seen at this yaw (rad) is turned from one whose faces lie along the table's axes: a quarter or half of a
/// turn changes nothing. None where it is not, and for what is round.
pub(crate) fn turn(rig: &Rig, yaw: f64) -> Result<Option<f64>, BrokenLimit> {
    refuse_if(!yaw.is_finite(), Reason::NotFinite, || {
        format!("`yaw` is {yaw}; it must be a finite number, in rad")
    })?;
    let Some(period) = rig.object.solid.period() else {
        return Ok(None);
    };
    let turn = yaw - (yaw / period).round() * period;
    if turn.abs() <= MOST_TURN {
        return Ok((turn != 0.0).then_some(turn));
    }
    Err((
        Reason::Turned,
        format!(
            "the box is turned by {turn:.4}, at most {MOST_TURN} from the table's axes is planned for, in rad; lay it straighter"
        ),
    ))
}

/// Checks that a turned box is struck on its face as training strikes struck theirs: its path leads along a trained bearing from its own edges, too.
pub(crate) fn trained_face(
    region: &TrainedRegion,
    path: Point,
    turn: Option<f64>,
) -> Result<(), BrokenLimit> {
    let bearing = path.bearing() - turn.unwrap_or(0.0);
    covered(
        "the path's bearing from the turned box's edges in rad",
        (bearing, region.bearing),
        turn.is_none() || region.holds_bearing(bearing),
        "lay the box straighter",
    )
}

/// A number as a person reads it: beyond any table's size by its digits and power of ten.
fn number(value: f64) -> String {
    if value.abs() < 1e4 {
        format!("{value:.4}")
    } else {
        format!("{value:e}")
    }
}

/// A point, in m, as a person reads it.
pub(crate) fn place(point: Point) -> String {
    format!("({}, {})", number(point.x), number(point.y))
}

pub(crate) fn range(interval: Interval) -> String {
    format!("[{:.4}, {:.4}]", interval.low, interval.high)
}
