//! Which keys a rig file may and must hold: unknown ones are named with the nearest known one, missing ones
//! with a line that would mend it.

use std::ops::Range;

use toml::de::{DeArray, DeTable, DeValue};

use super::RigError;

/// Every key of a rig file, by the table that holds it. The root has no name.
const KEYS: [(&str, &str); 15] = [
    ("", "object striker table camera robot frames topics"),
    (
        "object",
        "shape radius half_height half_size mass colour marker",
    ),
    ("striker", "tip radius"),
    ("table", "x y fences"),
    (
        "robot",
        "speed angle acceleration base base_yaw base_height keep_out reach jerk strike_height travel_height tool_orientation tool_offset \
         payload serial obstacles",
    ),
    ("frames", "command mirrored camera_delay"),
    ("topics", "centroid command state pose image"),
    ("topics.centroid", "name stamp x y"),
    ("topics.command", "name stamp x y"),
    ("topics.state", "name stamp x y position_x position_y"),
    ("topics.pose", "name stamp x y orientation"),
    (
        "camera",
        "rate noise centre matrix size distortion position orientation exposure readout stamp",
    ),
    ("object.colour", "hue saturation value"),
    ("object.marker", "dictionary id size offset yaw"),
    ("topics.image", "name stamp"),
];

/// Where a table is there what it must hold, as lines of the file: `TABLE: LINE`.
const REQUIRED: &str = "\
: [object]
: [striker]
: [table]
: [camera]
: [robot]
object: shape = \"cylinder\"   # or \"box\", \"sphere\"
object: mass = 0.100   # kg
striker: tip = \"sphere\"   # or \"cylinder\"
striker: radius = 0.012   # m
table: x = [0.10, 1.00]   # m
table: y = [-0.60, 0.60]   # m
camera: rate = 60.0   # frames per second
camera: noise = 0.0007   # m, standard deviation of a coordinate
camera: centre = [0.45, 0.0]   # m, the point it looks down on
robot: speed = [0.4, 1.0]   # m/s
robot: angle = [-0.80, 0.80]   # rad
robot: acceleration = 5.0   # m/s²
object.colour: hue = [340.0, 20.0]   # degrees; may wrap around 360
object.colour: saturation = [0.4, 1.0]   # 0 to 1
object.colour: value = [0.2, 1.0]   # 0 to 1
object.marker: dictionary = \"DICT_APRILTAG_36h11\"   # OpenCV's name
object.marker: id = 0
object.marker: size = 0.040   # m, side of its black square
topics.image: name = \"/camera/image/compressed\"
";

/// The keys right under a table.
fn children(table: &str) -> impl Iterator<Item = &'static str> {
    let own = KEYS.iter().filter(move |(name, _)| *name == table);
    own.flat_map(|(_, keys)| keys.split(' '))
}

/// Keys that a table must hold, with the lines that would mend their absence.
fn required(table: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let lines = REQUIRED.lines().filter_map(|line| line.split_once(": "));
    let own = lines.filter(move |(name, _)| *name == table);
    own.map(|(_, line)| {
        let key = line.split(" = ").next().unwrap_or(line);
        (key.trim_matches(['[', ']']), line)
    })
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
        if !children(path).any(|known| known == key.get_ref()) {
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
    for (name, mend) in required(path) {
        if !table.keys().any(|key| key.get_ref() == name) {
            return Err(RigError::MissingKey {
                key: join(path, name),
                mend: mend.into(),
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
        if children(around).any(|known| known == key.get_ref()) {
            return Err(RigError::MisplacedKey {
                key: join(around, key.get_ref()),
                line: line_of(text, key.span()),
                list: list.into(),
                around: around.into(),
            });
        }
    }
    Ok(())
}

/// The known key most like this one: one of that very name, else a sibling where one is alike, else any whose last name is.
fn nearest(path: &str, key: &str) -> String {
    let best = |tables: &mut dyn Iterator<Item = &'static str>| {
        let all = tables.flat_map(|table| children(table).map(move |name| (table, name)));
        let alike = all.map(|(table, name)| (strsim::jaro_winkler(name, key), join(table, name)));
        alike.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let tables = || KEYS.iter().map(|(table, _)| *table);
    let sibling = best(&mut tables().filter(|table| *table == path));
    let anywhere = best(&mut tables());
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
