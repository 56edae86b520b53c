//! Whether a rig's values make sense: each error names the key, the value and what it must be.

use std::f64::consts::PI;

mod camera;
mod number;
mod robot;

use super::{CommandFrame, Fence, FieldTopic, Frames, Object, Rig, RigError, Solid, Topics};
use crate::{Interval, Point};
use number::{Largest, finite, interval, positive, value};

/// Largest half size, radius or tip in m; a strike moves things that lie on a table.
const LARGEST_SIZE: Largest = (1.0, "m", "metres, not millimetres?");
/// Largest mass in kg.
const LARGEST_MASS: Largest = (50.0, "kg", "kilograms, not grams?");
/// Farthest a table reaches from the robot's base, in m.
const LARGEST_TABLE: f64 = 20.0;
/// Fastest camera, in frames per second.
const LARGEST_RATE: Largest = (10_000.0, "frames per second", "hertz?");
/// Largest camera noise in m: above it nothing can be estimated from a track.
const LARGEST_NOISE: Largest = (0.05, "m", "metres, not millimetres or pixels?");
/// Fastest arm, in m/s.
const LARGEST_SPEED: Largest = (30.0, "m/s", "metres per second, not millimetres?");
/// Clocks that differ by more are not those of one session, in s.
const LARGEST_DELAY: f64 = 3600.0;
/// Strongest arm, in m/s².
const LARGEST_ACCELERATION: Largest = (1_000.0, "m/s²", "metres, not millimetres?");

pub(super) fn check(rig: &Rig) -> Result<(), RigError> {
    object(&rig.object)?;
    positive("striker.radius", rig.striker.radius, LARGEST_SIZE)?;
    table("table.x", rig.table.x)?;
    table("table.y", rig.table.y)?;
    positive("camera.rate", rig.camera.rate, LARGEST_RATE)?;
    positive("camera.noise", rig.camera.noise, LARGEST_NOISE)?;
    finite("camera.centre", rig.camera.centre.x)?;
    finite("camera.centre", rig.camera.centre.y)?;
    camera::check_camera(&rig.camera)?;
    camera::check_colour(&rig.object)?;
    camera::check_marker(&rig.object)?;
    interval("robot.speed", rig.robot.speed)?;
    positive(
        "robot.speed",
        rig.robot.speed.low,
        (LARGEST_SPEED.0, "m/s", "metres per second?"),
    )?;
    positive("robot.speed", rig.robot.speed.high, LARGEST_SPEED)?;
    interval("robot.angle", rig.robot.angle)?;
    for angle in [rig.robot.angle.low, rig.robot.angle.high] {
        if angle.abs() > PI {
            return Err(value(
                "robot.angle",
                angle,
                "must lie within ±3.1416 rad (radians, not degrees?)",
            ));
        }
    }
    let acceleration = rig.robot.acceleration;
    positive("robot.acceleration", acceleration, LARGEST_ACCELERATION)?;
    robot::check(&rig.robot)?;
    frames(rig)?;
    rig.table.fences.iter().try_for_each(fence)?;
    topic("topics.centroid", &rig.topics.centroid)?;
    topic("topics.command", &rig.topics.command)?;
    let Topics {
        state, pose, image, ..
    } = &rig.topics;
    topic("topics.state", &state.topic)?;
    path("topics.state", "position_x", &state.position_x)?;
    path("topics.state", "position_y", &state.position_y)?;
    topic("topics.pose", &pose.topic)?;
    path("topics.pose", "orientation", &pose.orientation)?;
    camera::check_topic(image.as_ref())
}

fn object(object: &Object) -> Result<(), RigError> {
    let sizes = match object.solid {
        Solid::Cylinder {
            radius,
            half_height,
        } => vec![
            ("object.radius", radius),
            ("object.half_height", half_height),
        ],
        Solid::Box { half_size } => half_size.map(|size| ("object.half_size", size)).to_vec(),
        Solid::Sphere { radius } => vec![("object.radius", radius)],
    };
    for (key, size) in sizes {
        positive(key, size, LARGEST_SIZE)?;
    }
    positive("object.mass", object.mass, LARGEST_MASS)
}

fn table(key: &str, bounds: Interval) -> Result<(), RigError> {
    interval(key, bounds)?;
    for bound in [bounds.low, bounds.high] {
        if bound.abs() > LARGEST_TABLE {
            let why = format!(
                "must lie within ±{LARGEST_TABLE} m of the robot's base (metres, not millimetres?)"
            );
            return Err(value(key, bound, &why));
        }
    }
    Ok(())
}

/// An arm's frame is turned by what is stated of its base.
fn frames(rig: &Rig) -> Result<(), RigError> {
    let Frames {
        command,
        camera_delay,
        ..
    } = rig.frames;
    if camera_delay.is_nan() || camera_delay.abs() > LARGEST_DELAY {
        let why = "must be the seconds by which the camera's stamps lie behind the arm's (not milliseconds?)";
        return Err(value("frames.camera_delay", camera_delay, why));
    }
    if command == CommandFrame::Base && rig.robot.base_yaw.is_none() {
        return Err(RigError::MissingKey {
            key: "robot.base_yaw".into(),
            mend: "base_yaw = 0.52   # rad, how the base is turned on the table".into(),
        });
    }
    Ok(())
}

fn fence(fence: &Fence) -> Result<(), RigError> {
    let ends = [fence.from, fence.to];
    let is_line = fence.from.distance(fence.to) > 0.0;
    let is_near = |end: &Point| end.is_finite() && end.norm() <= LARGEST_TABLE;
    if is_line && ends.iter().all(is_near) {
        return Ok(());
    }
    Err(RigError::Value {
        key: "table.fences".into(),
        value: format!("{ends:?}"),
        why: "must be two ends from = [x, y] and to = [x, y] that differ, in m".into(),
    })
}

fn topic(key: &str, topic: &FieldTopic) -> Result<(), RigError> {
    path(key, "name", &topic.name)?;
    path(key, "stamp", &topic.stamp)?;
    path(key, "x", &topic.x)?;
    path(key, "y", &topic.y)
}

/// A topic's name or a path of a field of its messages.
fn path(key: &str, field: &str, text: &str) -> Result<(), RigError> {
    if !text.trim().is_empty() {
        return Ok(());
    }
    Err(RigError::Value {
        key: format!("{key}.{field}"),
        value: format!("{text:?}"),
        why:
            "must not be empty; take the line out of the file, or the whole table, for the default"
                .into(),
    })
}
