//! What is read from outside.

use std::fs;
use std::io::Cursor;
use std::sync::Arc;

use anyhow::{Context, anyhow};
use logs::{Decoder, Limits, SchemaText, TopicRequest};
use store::{ResidualModel, Store};
use values::{Command, Conditions, FieldTopic, Point, Rig, Shape};
use world::{Simulator, World};

use super::{Reads, Target, executor, images, live, seeds, segmenter};

pub fn targets() -> Vec<Target> {
    let (signatures, read_signature) = executor::signatures();
    // What a format's texts are made of, between bars.
    let target = |name, seeds, words: &'static str, read: Reads| Target {
        name,
        seeds,
        words: words.split('|').filter(|word| !word.is_empty()).collect(),
        read,
    };
    vec![
        target("mcap", seeds::logs(), "", Box::new(read_log)),
        target(
            "cdr",
            seeds::cdr(),
            "[]|[<=3]|[3]|wstring |string<=4 |Point |\n===\nMSG: |float64 |bool ",
            Box::new(|input| read_message(input, "cdr", "ros2msg")),
        ),
        target(
            "json",
            seeds::json(),
            "{|[|\"\\ud800\"|null|1e999|\"x\":|\"header\":{\"stamp\":",
            Box::new(|input| read_message(input, "json", "jsonschema")),
        ),
        target(
            "protobuf",
            seeds::protobuf(),
            ".demo.Point|google.protobuf.Timestamp|\u{3}\u{4}",
            Box::new(|input| read_message(input, "protobuf", "protobuf")),
        ),
        target(
            "image",
            images::seeds(),
            "rgb8|bgr8|mono8|bayer_rggb8|\u{4e}\u{20}\u{4e}\u{20}|IHDR|IDAT|h264",
            Box::new(images::reader()),
        ),
        target(
            "rig",
            seeds::rigs(),
            "[object]\n|shape = \"sphere\"\n|= [|half_size = [1.0, 1.0, 1.0]\n|\"\"\"|[[topics]]\n",
            Box::new(read_rig),
        ),
        target(
            "world",
            seeds::worlds(),
            "[[effects]]\n|name = \"table_tilt\"\n|friction|restitution|value = |low = |rolling_friction",
            Box::new(world_reader()),
        ),
        target(
            "manifest",
            vec![seeds::manifest().into_bytes()],
            "null|[|{|\"effect\"|18446744073709551616|\"schema\": 2,",
            Box::new(manifest_reader()),
        ),
        target(
            "weights",
            vec![seeds::weights()],
            "\"F64\"|\"data_offsets\":[0,|layer0.weight|\"__metadata__\":{|\"shape\":[",
            Box::new(|input| Ok(ResidualModel::from_safetensors(input).map(drop)?)),
        ),
        target("segmenter", segmenter::seeds(), "", segmenter::reader()),
        target(
            "batch",
            executor::lines(),
            "{\"from\":|\"to\":|[0.25, 0.05]|1e999|\n|null",
            Box::new(executor::batch_reader()),
        ),
        target(
            "live",
            live::seeds(),
            "\"op\":\"advertise\"|\"channels\":[|/object/centroid|\"encoding\":\"cdr\"|ros2msg|\"schema\":\"|18446744073709551615",
            Box::new(live::reader(Rig::demo(Shape::Cylinder).topics)),
        ),
        target(
            "signature",
            signatures,
            "untrusted comment: |trusted comment: |carom v0001 sequence 2|\n|=",
            read_signature,
        ),
    ]
}

/// The topics of the demo's rig.
fn topic() -> FieldTopic {
    Rig::demo(Shape::Cylinder).topics.centroid
}

fn read_log(input: &[u8]) -> anyhow::Result<()> {
    let topics = Rig::demo(Shape::Cylinder).topics;
    let wanted = [&topics.centroid, &topics.command].map(TopicRequest::required);
    let input = Cursor::new(input);
    let summary = logs::read_from("a.mcap", input, &wanted, Limits::default(), &mut |_| ())?;
    // What damage there is takes part in the kind of the answer.
    match summary.damage.first() {
        None => Ok(()),
        Some(damage) => Err(anyhow!(damage.why.clone())),
    }
}

/// A schema and a message: two bytes are the schema's length.
fn read_message(input: &[u8], message: &str, encoding: &str) -> anyhow::Result<()> {
    let (length, rest) = input.split_first_chunk::<2>().context("too short")?;
    let length = usize::from(u16::from_le_bytes(*length)).min(rest.len());
    let (schema, data) = rest.split_at(length);
    let schema = SchemaText {
        name: if encoding == "protobuf" {
            "demo.PointStamped"
        } else {
            "geometry_msgs/msg/PointStamped"
        },
        encoding,
        data: schema,
    };
    let decoder = Decoder::compile(message, Some(schema), &topic())?;
    Ok(decoder.decode(data).map(drop)?)
}

/// A rig that is read is written and read again as the same.
fn read_rig(input: &[u8]) -> anyhow::Result<()> {
    let text = std::str::from_utf8(input)?;
    let rig = Rig::parse(text)?;
    let again = Rig::parse(&rig.to_toml());
    assert_eq!(again.as_ref().ok(), Some(&rig), "{again:?}");
    Ok(())
}

/// A world that is read is written and read again as the same; a strike in it ends.
fn world_reader() -> impl Fn(&[u8]) -> anyhow::Result<()> {
    let rig = Rig::demo(Shape::Cylinder);
    move |input| {
        let text = std::str::from_utf8(input)?;
        let world = World::parse(text)?;
        let again = World::parse(&world.to_toml());
        assert_eq!(again.as_ref().ok(), Some(&world), "{again:?}");
        let simulator = Simulator::new(&rig, &world)?;
        let command = Command::new(0.8, 0.1);
        let struck =
            simulator
                .worker()
                .strike(Point::new(0.3, 0.0), command, &Conditions::default());
        Ok(struck.map(drop)?)
    }
}

/// A manifest in the place of a whole version's own, with its true hash: what its hash does not find.
fn manifest_reader() -> impl Fn(&[u8]) -> anyhow::Result<()> {
    let folder = Arc::new(tempfile::tempdir().expect("a folder"));
    let store = Store::open(folder.path());
    let version = store.publish(&seeds::contents()).expect("a version");
    let path = store.version_dir(&version).join("manifest.json");
    move |input| {
        let _kept = &folder;
        fs::write(&path, resealed(input))?;
        Ok(store.load(None).map(drop)?)
    }
}

/// A manifest's bytes with its own hash made to match them, where it holds one.
fn resealed(manifest: &[u8]) -> Vec<u8> {
    let key = b"\"sha256\": \"";
    let own = manifest.windows(key.len()).position(|bytes| bytes == key);
    let Some(own) = own.map(|at| at + key.len()..at + key.len() + 64) else {
        return manifest.to_vec();
    };
    let mut sealed = manifest.to_vec();
    if own.end > sealed.len() {
        return sealed;
    }
    sealed[own.clone()].fill(b'0');
    let hash = durable::sha256(&sealed);
    sealed[own].copy_from_slice(hash.as_bytes());
    sealed
}
