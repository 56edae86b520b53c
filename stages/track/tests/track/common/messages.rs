//! Image messages and logs of them, byte by byte.

use std::collections::BTreeMap;
use std::path::Path;

use logs::{Event, Limits, TopicRequest};
use render::{Moment, Optics, Picture, Renderer, Scene};
use values::{Point, Rig, Shape};

use super::{Case, places, rig, tall};

pub const SECOND: i64 = 1_700_000_000;

/// Little-endian CDR of ROS 2, and ROS 1's without alignment.
pub struct Wire(pub Vec<u8>, pub bool);

impl Wire {
    pub fn u32(mut self, value: u32) -> Self {
        while self.1 && !self.0.len().is_multiple_of(4) {
            self.0.push(0);
        }
        self.0.extend(value.to_le_bytes());
        self
    }
    pub fn bytes(self, data: &[u8]) -> Self {
        let mut wire = self.u32(data.len() as u32);
        wire.0.extend(data);
        wire
    }
    pub fn text(self, text: &str) -> Self {
        let end = if self.1 { "\0" } else { "" };
        self.bytes(format!("{text}{end}").as_bytes())
    }
    pub fn f64(mut self, value: f64) -> Self {
        while self.1 && !(self.0.len() - 4).is_multiple_of(8) {
            self.0.push(0);
        }
        self.0.extend(value.to_le_bytes());
        self
    }
    pub fn header(self, nanoseconds: u32) -> Self {
        self.u32(SECOND as u32).u32(nanoseconds).text("camera")
    }
}

/// `sensor_msgs/msg/Image`.
pub fn raw(encoding: &str, [width, height, step]: [u32; 3], data: &[u8], at: u32) -> Vec<u8> {
    let wire = Wire(vec![0, 1, 0, 0], true).header(at);
    let mut wire = wire.u32(height).u32(width).text(encoding);
    wire.0.push(0);
    wire.u32(step).bytes(data).0
}

/// `sensor_msgs/msg/CompressedImage`.
pub fn compressed(data: &[u8], at: u32) -> Vec<u8> {
    let wire = Wire(vec![0, 1, 0, 0], true).header(at);
    wire.text("jpeg").bytes(data).0
}

pub fn protobuf(data: &[u8], at: u32) -> Vec<u8> {
    let varint = |mut number: u64, to: &mut Vec<u8>| {
        while number > 127 {
            to.push(number as u8 | 0x80);
            number >>= 7;
        }
        to.push(number as u8);
    };
    let mut stamp = vec![8];
    varint(SECOND as u64, &mut stamp);
    stamp.push(16);
    varint(at.into(), &mut stamp);
    let mut message = vec![10, stamp.len() as u8];
    message.extend(stamp);
    message.push(18);
    varint(data.len() as u64, &mut message);
    message.extend(data);
    message
}

/// A log of image messages, each with a command behind it.
pub fn write(path: &Path, schema: &str, encoding: &str, messages: &[Vec<u8>]) {
    write_with(path, (schema, encoding), messages, None);
}

/// A log of image messages, each with a command behind it, after one message `first` of another topic: its name, type and bytes.
pub fn write_with(
    path: &Path,
    (schema, encoding): (&str, &str),
    messages: &[Vec<u8>],
    first: Option<(&str, &str, &[u8])>,
) {
    write_on("/camera/image", path, (schema, encoding), messages, first);
}

pub fn write_on(
    topic: &str,
    path: &Path,
    (schema, encoding): (&str, &str),
    messages: &[Vec<u8>],
    first: Option<(&str, &str, &[u8])>,
) {
    let mut writer = mcap::Writer::new(std::fs::File::create(path).unwrap()).unwrap();
    let id = writer.add_schema(schema, "ros2msg", b"").unwrap();
    let images = writer
        .add_channel(id, topic, encoding, &BTreeMap::new())
        .unwrap();
    let others = writer
        .add_channel(0, "/striker/command", "json", &BTreeMap::new())
        .unwrap();
    if let Some((topic, schema, data)) = first {
        let id = writer.add_schema(schema, "ros2msg", b"").unwrap();
        let channel_id = writer
            .add_channel(id, topic, "cdr", &BTreeMap::new())
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: 0,
            publish_time: 0,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    for (k, data) in messages.iter().enumerate() {
        for (channel_id, data) in [(images, data.as_slice()), (others, b"{}")] {
            let time = SECOND as u64 * 1_000_000_000 + k as u64;
            let header = mcap::records::MessageHeader {
                channel_id,
                sequence: k as u32,
                log_time: time,
                publish_time: time,
            };
            writer.write_to_known_channel(&header, data).unwrap();
        }
    }
    writer.finish().unwrap();
}

/// The object in so many places.
pub fn pictures(rig: &Rig, count: usize) -> Vec<(Moment, Picture)> {
    let optics = Optics::of(rig, [320, 240]).unwrap();
    let scene = Scene::plain(&rig.object).unwrap();
    let renderer = Renderer::new(optics, scene, 1.0, 3);
    let render =
        |(k, (at, _)): (usize, (Moment, f64))| (at, renderer.render(&|_| at, k as u64).picture);
    places(count).into_iter().enumerate().map(render).collect()
}

/// Messages of pictures as PNG, a nanosecond apart.
pub fn frames(pictures: &[(Moment, Picture)]) -> Vec<Vec<u8>> {
    let all = (1..).zip(pictures);
    all.map(|(at, (_, picture))| compressed(&picture.png().unwrap(), at))
        .collect()
}

/// A camera of few pixels.
pub fn small() -> Rig {
    rig(
        &tall(Shape::Cylinder),
        &Case {
            pixels: [320, 240],
            ..Case::flat()
        },
    )
}

/// The centroids of a log: stamps in ns and places.
pub fn centroids(path: &Path, rig: &Rig) -> Vec<(i64, Point)> {
    let wanted = [TopicRequest::required(&rig.topics.centroid)];
    let mut found = Vec::new();
    logs::read(path, &wanted, Limits::default(), &mut |event| {
        if let Event::Sample(_, sample) = event {
            found.push((sample.stamp, Point::new(sample.x, sample.y)));
        }
    })
    .unwrap();
    found
}
