//! Which message a topic's samples are written as: the one that the rig file's field paths read.

use serde_json::{Map, Value, json};
use values::{FieldTopic, Topics};

use super::messages::{self, Cdr, NANOSECONDS, RosType, Slot, Stamped, StateSample};
use crate::path::{PathStep, parse};

/// What is written, in the order in which equal stamps are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Centroid = 0,
    Command = 1,
    State = 2,
    Pose = 3,
}

impl Kind {
    pub(super) const ALL: [Self; 4] = [Self::Centroid, Self::Command, Self::State, Self::Pose];
}

/// How the messages of a topic are written.
#[derive(Clone, Debug)]
pub(super) struct Form {
    pub(super) topic: String,
    ros: Option<&'static RosType>,
    stamp: String,
    x: String,
    y: String,
    position: Option<[String; 2]>,
    orientation: Option<String>,
}

/// One message's numbers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Numbers {
    pub(super) stamp: u64,
    x: f64,
    y: f64,
    position: [f64; 2],
    yaw: f64,
}

impl From<&Stamped> for Numbers {
    fn from(sample: &Stamped) -> Self {
        Self {
            stamp: sample.stamp,
            x: sample.x,
            y: sample.y,
            ..Self::default()
        }
    }
}

impl From<&StateSample> for Numbers {
    fn from(sample: &StateSample) -> Self {
        Self {
            stamp: sample.stamp,
            x: sample.velocity[0],
            y: sample.velocity[1],
            position: sample.position,
            yaw: 0.0,
        }
    }
}

impl Numbers {
    pub(super) fn turned(sample: &Stamped, yaw: f64) -> Self {
        Self {
            yaw,
            ..Self::from(sample)
        }
    }
}

impl Form {
    pub(super) fn of(kind: Kind, topics: &Topics) -> Self {
        let (topic, position, orientation) = match kind {
            Kind::Centroid => (&topics.centroid, None, None),
            Kind::Command => (&topics.command, None, None),
            Kind::State => {
                let state = &topics.state;
                let position = [state.position_x.clone(), state.position_y.clone()];
                (&state.topic, Some(position), None)
            }
            Kind::Pose => (
                &topics.pose.topic,
                None,
                Some(topics.pose.orientation.clone()),
            ),
        };
        let FieldTopic { name, stamp, x, y } = topic.clone();
        let mut form = Self {
            topic: name,
            ros: None,
            stamp,
            x,
            y,
            position,
            orientation,
        };
        form.ros = messages::TYPES.iter().find(|ros| form.fits(ros));
        form
    }

    /// Whether every path is a field of this type.
    fn fits(&self, ros: &RosType) -> bool {
        let has_header = ros.slots.contains(&Slot::Header);
        let is_number = |path: &String| {
            ros.slots.iter().any(|slot| match slot {
                Slot::Triple(under) => ["x", "y", "z"].iter().any(|c| *path == join(under, c)),
                _ => false,
            })
        };
        let has_orientation = |path: &String| {
            ros.slots
                .iter()
                .any(|slot| matches!(slot, Slot::Quaternion(under) if under == path))
        };
        (!has_header || self.stamp == "header.stamp")
            && [&self.x, &self.y].into_iter().all(is_number)
            && self.position.iter().flatten().all(is_number)
            && self.orientation.iter().all(has_orientation)
    }

    /// The schema's name, its encoding and text, and the messages' encoding.
    pub(super) fn schema(&self) -> (&str, &'static str, String, &'static str) {
        match self.ros {
            Some(ros) => {
                let text = messages::joined(ros.definition, ros.parts);
                (ros.name, "ros2msg", text, "cdr")
            }
            None => (
                &self.topic,
                "jsonschema",
                "{\"type\": \"object\"}".into(),
                "json",
            ),
        }
    }

    pub(super) fn write(&self, buffer: &mut Vec<u8>, numbers: &Numbers) {
        let Numbers {
            x,
            y,
            position,
            yaw,
            ..
        } = *numbers;
        let (sin, cos) = (0.5 * yaw).sin_cos();
        let mut fields: Vec<(String, f64)> = vec![(self.x.clone(), x), (self.y.clone(), y)];
        if let Some([px, py]) = &self.position {
            fields.extend([(px.clone(), position[0]), (py.clone(), position[1])]);
        }
        if let Some(under) = &self.orientation {
            let turn = [("x", 0.0), ("y", 0.0), ("z", sin), ("w", cos)];
            fields.extend(turn.map(|(part, value)| (join(under, part), value)));
        }
        match self.ros {
            Some(ros) => write_ros(buffer, ros, numbers.stamp, &fields),
            None => self.write_json(buffer, numbers.stamp, &fields),
        }
    }

    fn write_json(&self, buffer: &mut Vec<u8>, stamp: u64, fields: &[(String, f64)]) {
        let mut message = Value::Object(Map::new());
        let time = json!({ "sec": stamp / NANOSECONDS, "nanosec": stamp % NANOSECONDS });
        put(&mut message, &self.stamp, time);
        for (path, number) in fields {
            put(&mut message, path, json!(number));
        }
        buffer.extend_from_slice(message.to_string().as_bytes());
    }
}

fn write_ros(buffer: &mut Vec<u8>, ros: &RosType, stamp: u64, fields: &[(String, f64)]) {
    let value = |path: String| {
        fields
            .iter()
            .find(|(known, _)| *known == path)
            .map(|(_, v)| *v)
    };
    let mut cdr = Cdr::new(buffer);
    for slot in ros.slots {
        match slot {
            Slot::Header => messages::header(&mut cdr, stamp),
            Slot::Child => cdr.string(messages::TIP_FRAME),
            Slot::Triple(under) => {
                for part in ["x", "y", "z"] {
                    cdr.float64(value(join(under, part)).unwrap_or(0.0));
                }
            }
            Slot::Quaternion(under) => {
                for (part, upright) in [("x", 0.0), ("y", 0.0), ("z", 0.0), ("w", 1.0)] {
                    cdr.float64(value(join(under, part)).unwrap_or(upright));
                }
            }
            Slot::Covariance => (0..36).for_each(|_| cdr.float64(0.0)),
        }
    }
}

fn join(under: &str, part: &str) -> String {
    if under.is_empty() {
        part.into()
    } else {
        format!("{under}.{part}")
    }
}

/// Puts a value where a path leads; what is on the way is made. A path that cannot be parsed leads nowhere: the reader says so.
fn put(message: &mut Value, path: &str, value: Value) {
    let mut at = message;
    for step in parse(path).unwrap_or_default() {
        at = match step {
            PathStep::Name(name) => {
                if !at.is_object() {
                    *at = Value::Object(Map::new());
                }
                &mut at[name]
            }
            PathStep::Index(index) => {
                if !at.is_array() {
                    *at = Value::Array(Vec::new());
                }
                if let Some(elements) = at.as_array_mut()
                    && elements.len() <= index
                {
                    elements.resize(index + 1, Value::Null);
                }
                &mut at[index]
            }
        };
    }
    *at = value;
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

    use std::io::Cursor;

    use super::*;
    use crate::write::{RecordingWriter, Samples};
    use crate::{Event, Limits, TopicRequest, read_from};

    /// What is written with these paths reads back with them.
    fn reads_back(centroid: (&str, &str, &str), command: (&str, &str, &str), schema: &str) {
        let mut topics = Topics::default();
        for (topic, (stamp, x, y)) in [
            (&mut topics.centroid, centroid),
            (&mut topics.command, command),
        ] {
            (topic.stamp, topic.x, topic.y) = (stamp.into(), x.into(), y.into());
        }
        let at = |stamp, x, y| Stamped { stamp, x, y };
        let samples = Samples {
            centroids: vec![at(1_700_000_000_000_000_001, 0.3, -0.1)],
            commands: vec![at(1_700_000_001_000_000_000, 0.7, 0.2)],
            states: vec![StateSample {
                stamp: 1_700_000_002_000_000_000,
                position: [0.25, -0.125],
                velocity: [0.5, -0.5],
            }],
        };
        let mut writer = RecordingWriter::new(Cursor::new(Vec::new()), &topics).unwrap();
        writer.write(&samples).unwrap();
        let log = writer.finish().unwrap().into_inner();
        let position = [
            topics.state.position_x.clone(),
            topics.state.position_y.clone(),
        ];
        let wanted = [
            (&topics.centroid, &[][..]),
            (&topics.command, &[]),
            (&topics.state.topic, &position),
        ]
        .map(|(topic, more)| TopicRequest {
            topic,
            more,
            required: true,
        });
        let mut seen = Vec::new();
        let summary = read_from(
            "own",
            Cursor::new(&log),
            &wanted,
            Limits::default(),
            &mut |event| match event {
                Event::Sample(_, s) => seen.push((s.stamp, s.x, s.y)),
                Event::Extended(_, s, more) => {
                    seen.push((s.stamp, s.x, s.y));
                    seen.push((0, more[0], more[1]));
                }
                Event::Lost(_) => panic!("lost"),
            },
        )
        .unwrap();
        assert_eq!(
            seen,
            [
                (1_700_000_000_000_000_001, 0.3, -0.1),
                (1_700_000_001_000_000_000, 0.7, 0.2),
                (1_700_000_002_000_000_000, 0.5, -0.5),
                (0, 0.25, -0.125),
            ]
        );
        assert!(summary.damage.is_empty());
        let first = mcap::MessageStream::new(&log)
            .unwrap()
            .next()
            .unwrap()
            .unwrap();
        assert_eq!(first.channel.schema.as_ref().unwrap().name, schema);
    }

    #[test]
    fn what_is_written_has_the_rig_files_schema_and_reads_back() {
        let header = "header.stamp";
        let twist = (header, "twist.linear.x", "twist.linear.y");
        reads_back(
            (header, "point.x", "point.y"),
            twist,
            "geometry_msgs/msg/PointStamped",
        );
        reads_back(
            (header, "pose.position.x", "pose.position.y"),
            (header, "linear.x", "linear.y"),
            "geometry_msgs/msg/PoseStamped",
        );
        reads_back(
            (header, "point.y", "point.x"),
            (header, "vector.x", "vector.y"),
            "geometry_msgs/msg/PointStamped",
        );
        reads_back(
            ("stamp", "poses[0].position.x", "poses[0].position.y"),
            ("t", "v.x", "v.y"),
            "/object/centroid",
        );
    }
}
