//! Which keys a rig file may and must hold: unknown ones are named with the nearest known one, missing ones
//! with a line that would mend it.

use std::ops::Range;

use toml::de::{DeArray, DeTable, DeValue};

use super::RigError;

/// Every key of a rig file, by dotted path; a required one carries the line that would mend its absence.
const KEYS: &[(&str, Option<&str>)] = &[
    ("object", Some("[object]")),
    (
        "object.shape",
        Some("shape = \"cylinder\"   # or \"box\", \"sphere\""),
    ),
    ("object.radius", None),
    ("object.half_height", None),
    ("object.half_size", None),
    ("object.mass", Some("mass = 0.100   # kg")),
    ("striker", Some("[striker]")),
    ("striker.tip", Some("tip = \"sphere\"   # or \"cylinder\"")),
    ("striker.radius", Some("radius = 0.012   # m")),
    ("table", Some("[table]")),
    ("table.x", Some("x = [0.10, 1.00]   # m")),
    ("table.y", Some("y = [-0.60, 0.60]   # m")),
    ("table.fences", None),
    ("camera", Some("[camera]")),
    ("camera.rate", Some("rate = 60.0   # frames per second")),
    (
        "camera.noise",
        Some("noise = 0.0007   # m, standard deviation of a coordinate"),
    ),
    (
        "camera.centre",
        Some("centre = [0.45, 0.0]   # m, the point it looks down on"),
    ),
    ("robot", Some("[robot]")),
    ("robot.speed", Some("speed = [0.4, 1.0]   # m/s")),
    ("robot.angle", Some("angle = [-0.80, 0.80]   # rad")),
    ("robot.acceleration", Some("acceleration = 5.0   # m/s²")),
    ("robot.base", None),
    ("robot.base_yaw", None),
    ("robot.base_height", None),
    ("robot.keep_out", None),
    ("robot.reach", None),
    ("robot.jerk", None),
    ("robot.strike_height", None),
    ("robot.travel_height", None),
    ("robot.tool_orientation", None),
    ("robot.tool_offset", None),
    ("robot.payload", None),
    ("robot.serial", None),
    ("robot.obstacles", None),
    ("frames", None),
    ("frames.command", None),
    ("frames.mirrored", None),
    ("frames.camera_delay", None),
    ("topics", None),
    ("topics.centroid", None),
    ("topics.centroid.name", None),
    ("topics.centroid.stamp", None),
    ("topics.centroid.x", None),
    ("topics.centroid.y", None),
    ("topics.command", None),
    ("topics.command.name", None),
    ("topics.command.stamp", None),
    ("topics.command.x", None),
    ("topics.command.y", None),
    ("topics.state", None),
    ("topics.state.name", None),
    ("topics.state.stamp", None),
    ("topics.state.x", None),
    ("topics.state.y", None),
    ("topics.state.position_x", None),
    ("topics.state.position_y", None),
    ("topics.pose", None),
    ("topics.pose.name", None),
    ("topics.pose.stamp", None),
    ("topics.pose.x", None),
    ("topics.pose.y", None),
    ("topics.pose.orientation", None),
];

/// Keys that are needed where images are read.
const IMAGE_KEYS: [(&str, Option<&str>); 21] = [
    ("camera.matrix", None),
    ("camera.size", None),
    ("camera.distortion", None),
    ("camera.position", None),
    ("camera.orientation", None),
    ("camera.exposure", None),
    ("camera.readout", None),
    ("camera.stamp", None),
    ("object.colour", None),
    (
        "object.colour.hue",
        Some("hue = [340.0, 20.0]   # degrees; may wrap around 360"),
    ),
    (
        "object.colour.saturation",
        Some("saturation = [0.4, 1.0]   # 0 to 1"),
    ),
    ("object.colour.value", Some("value = [0.2, 1.0]   # 0 to 1")),
    ("object.marker", None),
    (
        "object.marker.dictionary",
        Some("dictionary = \"DICT_APRILTAG_36h11\"   # OpenCV's name"),
    ),
    ("object.marker.id", Some("id = 0")),
    (
        "object.marker.size",
        Some("size = 0.040   # m, side of its black square"),
    ),
    ("object.marker.offset", None),
    ("object.marker.yaw", None),
    ("topics.image", None),
    (
        "topics.image.name",
        Some("name = \"/camera/image/compressed\""),
    ),
    ("topics.image.stamp", None),
];

/// All keys, those of images among them.
fn known() -> impl Iterator<Item = &'static (&'static str, Option<&'static str>)> {
    KEYS.iter().chain(&IMAGE_KEYS)
}

/// A key looks like a slip of a known one from this similarity (Jaro–Winkler) on.
const ALIKE: f64 = 0.7;

/// Checks that every key is known and every required one there. What is no TOML at all is left to the parser.
pub(super) fn check(text: &str) -> Result<(), RigError> {
    let Ok(root) = DeTable::parse(text) else {
        return Ok(());
    };
    check_table(text, "", root.get_ref())
}

fn check_table(text: &str, path: &str, table: &DeTable<'_>) -> Result<(), RigError> {
    for (key, value) in table {
        let dotted = join(path, key.get_ref());
        if !known().any(|(known, _)| *known == dotted) {
            return Err(RigError::UnknownKey {
                nearest: nearest(path, key.get_ref()),
                line: line_of(text, key.span()),
                key: dotted,
            });
        }
        match value.get_ref() {
            DeValue::Table(inner) => check_table(text, &dotted, inner)?,
            DeValue::Array(items) => check_items(text, path, &dotted, items)?,
            _ => {}
        }
    }
    for (name, mend) in children(path) {
        if let Some(mend) = mend
            && !table.keys().any(|key| key.get_ref() == name)
        {
            return Err(RigError::MissingKey {
                key: join(path, name),
                mend: (*mend).into(),
            });
        }
    }
    Ok(())
}

/// No table of a list, such as `[[robot.obstacles]]`, holds a key of the table around it: by TOML, what stands below such a table is the
/// table's own.
fn check_items(text: &str, around: &str, list: &str, items: &DeArray<'_>) -> Result<(), RigError> {
    let tables = items.iter().filter_map(|item| item.get_ref().as_table());
    for key in tables.flat_map(DeTable::keys) {
        let meant = join(around, key.get_ref());
        if known().any(|(known, _)| *known == meant) {
            return Err(RigError::MisplacedKey {
                key: meant,
                line: line_of(text, key.span()),
                list: list.into(),
                around: around.into(),
            });
        }
    }
    Ok(())
}

/// Names and mending lines of the keys right under a path.
fn children(path: &str) -> impl Iterator<Item = (&'static str, &'static Option<&'static str>)> {
    known().filter_map(move |(known, mend)| {
        let name = if path.is_empty() {
            known
        } else {
            known.strip_prefix(path)?.strip_prefix('.')?
        };
        (!name.contains('.')).then_some((name, mend))
    })
}

/// The known key most like this one: one of that very name, else a sibling where one is alike, else any whose last name is.
fn nearest(path: &str, key: &str) -> String {
    let best = |candidates: &mut dyn Iterator<Item = (String, &str)>| {
        candidates
            .map(|(dotted, name)| (strsim::jaro_winkler(name, key), dotted))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let sibling = best(&mut children(path).map(|(name, _)| (join(path, name), name)));
    let anywhere = best(&mut known().map(|(known, _)| {
        (
            (*known).to_string(),
            known.rsplit_once('.').map_or(*known, |(_, name)| name),
        )
    }));
    match (sibling, anywhere) {
        // The very name, at another place.
        (_, Some((alike, dotted))) if alike >= 1.0 => dotted,
        (Some((alike, dotted)), _) if alike >= ALIKE => dotted,
        (_, Some((alike, dotted))) if alike >= ALIKE => dotted,
        (Some((_, dotted)), _) | (None, Some((_, dotted))) => dotted,
        (None, None) => String::new(),
    }
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.into()
    } else {
        format!("{path}.{key}")
    }
}

/// Line of the text, from 1, on which a span begins.
fn line_of(text: &str, span: Range<usize>) -> usize {
    1 + text
        .bytes()
        .take(span.start)
        .filter(|byte| *byte == b'\n')
        .count()
}
