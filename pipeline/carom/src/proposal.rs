//! A rig file out of a log: topics and fields that look like the object's place, the command and the arm's state, and what they show of
//! rates, noise, bounds and limits. Sizes, masses and what an arm may do at most are in no log: these stay as the template has them.

use std::collections::BTreeMap;
use std::path::Path;

use check::{Finding, LogRead};
use ingest::{Ingest, LogOutcome};
use logs::{Event, Limits, LogError, Sample, TopicRequest};
use values::{FieldTopic, Reject, Rig};

use crate::{Error, words};

/// Where messages keep a place and a velocity, `.x` and `.y` after each; the empty one is the message itself.
const PLACES: [&str; 9] = [
    "point",
    "pose.position",
    "pose.pose.position",
    "position",
    "centroid",
    "transform.translation",
    "transforms[0].transform.translation",
    "poses[0].position",
    "",
];
const VELOCITIES: [&str; 6] = [
    "twist.twist.linear",
    "twist.linear",
    "linear",
    "velocity",
    "twist",
    "vector",
];
const STAMPS: [&str; 7] = [
    "header.stamp",
    "stamp",
    "timestamp",
    "time",
    "t",
    "ts",
    "transforms[0].header.stamp",
];
/// Parts of names by which a JSON message's numbers are taken for a velocity.
const OF_VELOCITY: [&str; 4] = ["vel", "twist", "linear", "speed"];
/// Parts of names by which a JSON message's numbers are taken for neither: a turn, or how fast it goes.
const OF_TURN: [&str; 3] = ["angular", "orientation", "rotation"];
/// Parts of names by which a topic is taken for the object's, the command's or the arm's, where more than one would do.
const OF_OBJECT: [&str; 9] = [
    "object", "puck", "centroid", "ball", "disc", "disk", "cylinder", "box", "marker",
];
const OF_COMMAND: [&str; 4] = ["command", "cmd", "desired", "reference"];
const OF_ARM: [&str; 8] = [
    "striker", "mallet", "state", "odom", "tool", "tip", "tcp", "effector",
];
/// Bounds are this much wider than what was seen, in m, and rounded to it; limits of the arm to the other, in m/s and rad.
const MARGIN: f64 = 0.05;
const LIMIT: f64 = 0.05;
/// Places farther out than this part of all are frames astray.
const ASTRAY: f64 = 0.001;

/// A topic whose messages hold a place, a velocity, or both.
struct Shown {
    name: String,
    schema: String,
    place: Option<Read>,
    velocity: Option<Read>,
}

/// Two fields of a topic.
struct Read {
    topic: FieldTopic,
    samples: Vec<Sample>,
}

/// The text of a rig file that reads this log.
pub fn propose(log: &Path) -> Result<String, Error> {
    let shown = topics(log)?;
    let is_named =
        |one: &Shown, parts: &[&str]| parts.iter().any(|p| one.name.to_lowercase().contains(p));
    let best = |parts: &[&str], others: &[&str], fits: &dyn Fn(&Shown) -> bool| {
        // The one that is named so, else one that is not named as something else.
        let all = || shown.iter().filter(|one| fits(one));
        all()
            .find(|one| is_named(one, parts))
            .or_else(|| all().find(|one| !is_named(one, others)))
    };
    let arms_and_commands = [&OF_ARM[..], &OF_COMMAND].concat();
    let object = best(&OF_OBJECT, &arms_and_commands, &|one| one.place.is_some());
    let Some((object, place)) = object.and_then(|one| Some((one, one.place.as_ref()?))) else {
        let found = shown
            .iter()
            .map(|one| format!("{} ({})", one.name, one.schema))
            .collect::<Vec<_>>();
        return Err(Error::input(format!(
            "find the object's place in {}: no topic with a place in a plane is there that could be an object's (of {}); log its centroid, \
             such as geometry_msgs/msg/PointStamped, or images (see `carom camera`)",
            log.display(),
            if found.is_empty() {
                "no topic".into()
            } else {
                found.join(", ")
            }
        )));
    };
    let state = best(&OF_ARM, &OF_OBJECT, &|one| {
        one.place.is_some()
            && one.velocity.is_some()
            && one.name != object.name
            && !is_named(one, &OF_COMMAND)
    });
    let command = best(&OF_COMMAND, &OF_OBJECT, &|one| {
        one.velocity.is_some()
            && one.name != object.name
            && state.is_none_or(|state| state.name != one.name)
    });

    let mut text = Rig::template().to_owned();
    set_topic(&mut text, "topics.centroid", &place.topic);
    if let Some(command) = command.and_then(|one| one.velocity.as_ref()) {
        set_topic(&mut text, "topics.command", &command.topic);
    }
    if let Some((velocity, position)) =
        state.and_then(|one| Some((one.velocity.as_ref()?, one.place.as_ref()?)))
    {
        set_topic(&mut text, "topics.state", &velocity.topic);
        set(
            &mut text,
            "topics.state",
            "position_x",
            &quoted(&position.topic.x),
        );
        set(
            &mut text,
            "topics.state",
            "position_y",
            &quoted(&position.topic.y),
        );
    }
    let seen = |sample: &&Sample| {
        sample.x.is_finite() && sample.y.is_finite() && (sample.x, sample.y) != (0.0, 0.0)
    };
    let ends = |of: fn(&Sample) -> f64| {
        let mut values: Vec<f64> = place.samples.iter().filter(seen).map(of).collect();
        values.sort_by(f64::total_cmp);
        let astray = (ASTRAY * values.len() as f64) as usize;
        let last = values.len().checked_sub(1 + astray)?;
        Some((values[astray], values[last]))
    };
    let (Some(x), Some(y)) = (ends(|s| s.x), ends(|s| s.y)) else {
        return Err(Error::input(format!(
            "find the object's place in {}: {} has no number in {} messages",
            log.display(),
            object.name,
            place.samples.len()
        )));
    };
    set(&mut text, "table", "x", &around(x, MARGIN, MARGIN));
    set(&mut text, "table", "y", &around(y, MARGIN, MARGIN));
    let middle = |(low, high): (f64, f64)| 0.5 * (low + high);
    let centre = format!("[{:.2}, {:.2}]", middle(x), middle(y));
    set(&mut text, "camera", "centre", &centre);
    if let Some(rate) = rate(&place.samples) {
        let rounded = if (rate / rate.round() - 1.0).abs() < 0.02 {
            rate.round()
        } else {
            (10.0 * rate).round() / 10.0
        };
        set(&mut text, "camera", "rate", &format!("{rounded:?}"));
    }
    let mut notes = vec![format!(
        "Proposed by `carom rig init --from {}`: topics, rates, bounds and limits are what this log shows; sizes, masses and the \
         acceleration are not, and stand as in the template.",
        log.file_name().unwrap_or_default().to_string_lossy()
    )];
    notes.push(said("the object", Some(object)));
    notes.push(said("the command", command));
    notes.push(said("the arm's state", state));
    let still = shown.iter().filter(|one| {
        state.is_none() && is_named(one, &OF_ARM) && one.place.is_some() && one.velocity.is_none()
    });
    notes.extend(still.map(|one| {
        format!(
            "{} ({}) tells where the arm is and not how fast: log its velocity as well, such as nav_msgs/msg/Odometry.",
            one.name, one.schema
        )
    }));
    let taken = [Some(object), command, state];
    let others = shown.iter().filter(|one| {
        let mut taken = taken.iter().flatten();
        !taken.any(|other| other.name == one.name)
    });
    let others: Vec<String> = others
        .filter(|one| one.place.is_some() || one.velocity.is_some())
        .map(|one| format!("{} ({})", one.name, one.schema))
        .collect();
    if !others.is_empty() {
        notes.push(format!("Also there: {}.", others.join(", ")));
    }
    if command.is_some() || state.is_some() {
        measure(&mut text, log, &mut notes, true)?;
    } else {
        notes.push(
            "Neither a command nor the arm's state is there: strikes cannot be found without one of both.".into(),
        );
    }
    let notes: Vec<String> = notes.iter().map(|note| format!("# {note}\n")).collect();
    Ok(notes.concat() + "\n" + &text)
}

/// What the strikes of the log show: noise at rest, limits of the arm, fences, and what the check finds.
fn measure(
    text: &mut String,
    log_path: &Path,
    notes: &mut Vec<String>,
    is_first: bool,
) -> Result<(), Error> {
    let before = notes.len();
    let mut rig = Rig::parse(text).map_err(Error::input)?;
    // Wide, so that no strike is left out.
    rig.robot.speed = [0.05, 5.0].into();
    rig.robot.angle = [-std::f64::consts::PI, std::f64::consts::PI].into();
    let read = ingest::ingest_log(log_path, &rig, &Ingest::default()).map_err(Error::input)?;
    notes.push(format!(
        "{} strikes are found with it, and {} rejected.",
        read.strikes.len(),
        read.rejects.len()
    ));
    if let Some(noise) = read.seen.noise_at_rest() {
        // No camera is better than this.
        let noise = (1e5 * noise).round().max(1.0) / 1e5;
        set(text, "camera", "noise", &format!("{noise}"));
    }
    let ends = |of: fn(&values::Strike) -> f64| {
        let values = read.strikes.iter().map(of);
        let ends = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        (ends.0 <= ends.1).then_some(ends)
    };
    if let Some(speed) = ends(|strike| strike.command.speed) {
        let low = ((speed.0 / LIMIT).floor() * LIMIT).max(0.05);
        let high = (speed.1 / LIMIT).ceil() * LIMIT;
        let high = if high > low { high } else { low + LIMIT };
        set(text, "robot", "speed", &format!("[{low:.2}, {high:.2}]"));
    }
    if let Some(angle) = ends(|strike| strike.command.angle) {
        set(text, "robot", "angle", &around(angle, 0.0, LIMIT));
    }
    let rig = Rig::parse(text).map_err(Error::input)?;
    let fences = ingest::fences(&rig, [&read.seen]);
    let LogOutcome {
        log,
        seen,
        strikes,
        rejects,
        ..
    } = &read;
    let rejects: Vec<Reject> = rejects.iter().cloned().map(Reject::in_words).collect();
    let log = LogRead {
        name: log,
        seen,
        kept: strikes.len(),
        rejects: rejects.iter().collect(),
    };
    let check = check::check(&rig, &[log], &fences);
    let apart = check.findings.iter().find_map(|finding| match finding {
        Finding::Reach { apart, .. } => Some(*apart),
        _ => None,
    });
    // With the radii as they are more strikes are found.
    if let (Some(apart), Some(object), true) = (apart, rig.object.solid.radius(), is_first) {
        let radius = apart - object;
        if radius > 0.0 {
            set(text, "striker", "radius", &format!("{radius:.4}"));
            notes.truncate(before);
            notes.push(format!(
                "the tip pushes the object where their centres are {:.1} mm apart: [striker] radius is what [object] radius, the template's, leaves of it; measure both.",
                1e3 * apart
            ));
            return measure(text, log_path, notes, false);
        }
    }
    for finding in &check.findings {
        let severity = words::severity(finding.severity());
        notes.push(format!(
            "{severity}: {}",
            words::say(finding, &rig).sentence()
        ));
    }
    Ok(())
}

/// Every topic of the log that holds a place or a velocity.
fn topics(log: &Path) -> Result<Vec<Shown>, Error> {
    let mut topics: BTreeMap<String, (String, Fields)> = BTreeMap::new();
    logs::read::read_raw::<LogError>(log, Limits::default(), &mut |message| {
        let channel = message.channel;
        if !topics.contains_key(&channel.topic) {
            let fields = match channel.encoding.as_str() {
                "json" => Fields::of_json(message.data),
                _ => Fields::usual(),
            };
            topics.insert(channel.topic.clone(), (channel.schema.clone(), fields));
        }
        Ok(())
    })
    .map_err(Error::input)?;
    let shown = topics.into_iter().map(|(name, (schema, fields))| Shown {
        place: first(log, &name, &fields.places),
        velocity: first(log, &name, &fields.velocities),
        name,
        schema,
    });
    Ok(shown.collect())
}

type Paths = [String; 2];

/// Where a topic's messages may keep a place and a velocity, the likeliest first.
struct Fields {
    places: Vec<Paths>,
    velocities: Vec<Paths>,
}

impl Fields {
    /// Where messages of known kinds keep them.
    fn usual() -> Self {
        let paths = |fields: &[&str]| fields.iter().map(|field| within(field)).collect();
        Self {
            places: paths(&PLACES),
            velocities: paths(&VELOCITIES),
        }
    }

    /// The paths at which this JSON message has numbers of these names.
    fn of_json(data: &[u8]) -> Self {
        let mut fields = Self::usual();
        if let Ok(message) = serde_json::from_slice(data) {
            fields.look(&message, "");
        }
        fields
    }

    fn look(&mut self, value: &serde_json::Value, path: &str) {
        let Some(object) = value.as_object() else {
            return;
        };
        // What was not seen has no number.
        let is_number = |name: &str| {
            object
                .get(name)
                .is_some_and(|v| v.is_number() || v.is_null())
        };
        let in_here = |name: &str| match path {
            "" => name.to_owned(),
            path => format!("{path}.{name}"),
        };
        if is_number("x") && is_number("y") {
            let name = path.rsplit('.').next().unwrap_or_default().to_lowercase();
            let is_of = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
            if is_of(&OF_VELOCITY) && !is_of(&OF_TURN) {
                self.velocities.push(within(path));
            } else if !is_of(&OF_TURN) {
                self.places.push(within(path));
            }
        }
        for flat in [["vx", "vy"], ["vel_x", "vel_y"]] {
            if flat.iter().all(|name| is_number(name)) {
                self.velocities.push(flat.map(in_here));
            }
        }
        for (name, value) in object {
            self.look(value, &in_here(name));
        }
    }
}

fn within(field: &str) -> Paths {
    ["x", "y"].map(|axis| match field {
        "" => axis.to_owned(),
        field => format!("{field}.{axis}"),
    })
}

/// The first of these fields that the topic's messages have.
fn first(log: &Path, name: &str, fields: &[Paths]) -> Option<Read> {
    fields.iter().find_map(|[x, y]| {
        let topic = |stamp: &str| FieldTopic {
            name: name.into(),
            stamp: stamp.into(),
            x: x.clone(),
            y: y.clone(),
        };
        let (samples, is_stamped) = samples(log, &topic(STAMPS[0]))?;
        if is_stamped {
            let topic = topic(STAMPS[0]);
            return Some(Read { topic, samples });
        }
        // Without a stamp log times are taken.
        let stamped = STAMPS[1..].iter().find_map(|stamp| {
            let topic = topic(stamp);
            let (samples, is_stamped) = self::samples(log, &topic)?;
            is_stamped.then_some(Read { topic, samples })
        });
        Some(stamped.unwrap_or(Read {
            topic: topic(STAMPS[0]),
            samples,
        }))
    })
}

/// A topic's samples, and whether they are stamped; none where the paths lead nowhere.
fn samples(log: &Path, topic: &FieldTopic) -> Option<(Vec<Sample>, bool)> {
    let mut samples = Vec::new();
    let wanted = [TopicRequest::required(topic)];
    let summary = logs::read(log, &wanted, Limits::default(), &mut |event| {
        if let Event::Sample(_, sample) = event {
            samples.push(sample);
        }
    });
    let is_stamped = !*summary.ok()?.unstamped.first()?;
    (!samples.is_empty()).then_some((samples, is_stamped))
}

/// Messages a second, by the middle interval.
fn rate(samples: &[Sample]) -> Option<f64> {
    let intervals = samples.windows(2).map(|pair| {
        let nanoseconds = (pair[1].stamp - pair[0].stamp) as f64;
        1e-9 * nanoseconds
    });
    let interval = values::median(intervals.filter(|interval| *interval > 0.0).collect())?;
    Some(1.0 / interval)
}

/// An interval that holds both ends with a margin, on a grid.
fn around((low, high): (f64, f64), margin: f64, grid: f64) -> String {
    let low = ((low - margin) / grid).floor() * grid;
    let high = ((high + margin) / grid).ceil() * grid;
    let high = if high > low { high } else { low + grid };
    format!("[{low:.2}, {high:.2}]")
}

fn said(what: &str, one: Option<&Shown>) -> String {
    let Some(one) = one else {
        return format!("{what}: no topic of the log looks like it.");
    };
    let read = one.velocity.as_ref().or(one.place.as_ref());
    let rate = read.and_then(|read| rate(&read.samples));
    let rate = rate.map_or(String::new(), |rate| format!(", {rate:.0} Hz"));
    format!("{what}: {} ({}{rate}).", one.name, one.schema)
}

fn quoted(text: &str) -> String {
    format!("\"{text}\"")
}

fn set_topic(text: &mut String, section: &str, topic: &FieldTopic) {
    for (key, value) in [
        ("name", &topic.name),
        ("stamp", &topic.stamp),
        ("x", &topic.x),
        ("y", &topic.y),
    ] {
        set(text, section, key, &quoted(value));
    }
}

/// Puts a value in the place of the template's; the line's comment stays.
fn set(text: &mut String, section: &str, key: &str, value: &str) {
    let header = format!("[{section}]");
    let mut is_within = false;
    let lines: Vec<String> = text
        .lines()
        .map(|line| {
            if line.starts_with('[') {
                is_within = line.split_whitespace().next() == Some(&header);
            }
            match line.split_once(" = ") {
                Some((name, rest)) if is_within && name == key => {
                    let comment = rest.find('#').map_or("", |at| &rest[at..]);
                    format!("{key} = {value}   {comment}").trim_end().to_owned()
                }
                _ => line.to_owned(),
            }
        })
        .collect();
    *text = lines.join("\n") + "\n";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn how_fast_an_arm_turns_is_no_place_of_it() {
        let vector = r#"{"x":0.1,"y":0.0,"z":0.0}"#;
        let command =
            format!(r#"{{"twist":{{"linear":{vector},"angular":{vector}}},"at":{vector}}}"#);
        let fields = Fields::of_json(command.as_bytes());
        assert!(fields.velocities.contains(&within("twist.linear")));
        assert!(fields.places.contains(&within("at")));
        let all = [fields.places, fields.velocities].concat();
        assert!(!all.contains(&within("twist.angular")));
    }

    #[test]
    fn a_value_of_the_template_is_replaced_and_its_comment_stays() {
        let mut text = Rig::template().to_owned();
        set(&mut text, "camera", "rate", "120.0");
        set(&mut text, "topics.state", "x", "\"v.x\"");
        let rig = Rig::parse(&text).expect("a rig file");
        assert_eq!(rig.camera.rate, 120.0);
        assert_eq!(rig.topics.state.topic.x, "v.x");
        assert_eq!(rig.topics.centroid.x, "point.x");
        assert!(text.contains("rate = 120.0   # frames per second"));
    }
}
