//! Image messages: what a camera's driver, or a damaged log, may send.

use anyhow::{Context, anyhow};
use render::{Moment, Optics, Picture, Renderer, Scene};
use track::{Decoder, ImageMessage, Tracker};
use values::{Colour, Rig, Shape};

/// Types of messages and their encodings; an input's first byte names one.
const TYPES: [(&str, &str); 6] = [
    ("sensor_msgs/msg/Image", "cdr"),
    ("sensor_msgs/msg/CompressedImage", "cdr"),
    ("sensor_msgs/CompressedImage", "ros1"),
    ("foxglove.CompressedImage", "protobuf"),
    ("foxglove.RawImage", "protobuf"),
    ("foxglove.CompressedVideo", "protobuf"),
];
/// Pixels of the seeds: small, so that most bytes mean something.
const SIZE: [usize; 2] = [48, 32];

/// A key frame of this size, of a red disc (`tests/peers/video.py`).
const VIDEO: &[u8] = include_bytes!("frame.h264");

/// A rig whose camera sees the object in the seeds.
fn rig() -> Rig {
    let mut rig = Rig::demo(Shape::Cylinder);
    rig.object.colour = Some(Colour::demo());
    rig.camera.matrix = Some([120.0, 120.0, 23.5, 15.5]);
    rig.camera.position = Some([0.5, 0.0, 0.5]);
    let h = std::f64::consts::FRAC_1_SQRT_2;
    rig.camera.orientation = Some([-h, h, 0.0, 0.0]);
    rig
}

fn picture(rig: &Rig) -> Picture {
    let optics = Optics::of(rig, SIZE).expect("complete");
    let scene = Scene::plain(&rig.object).expect("sizes");
    let at = Moment {
        x: 0.5,
        y: 0.0,
        yaw: 0.0,
    };
    Renderer::new(optics, scene, 1.0, 2)
        .render(&|_| at, 1)
        .picture
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let picture = picture(&rig());
    let (png, jpeg) = (
        picture.png().expect("encodes"),
        picture.jpeg(90).expect("encodes"),
    );
    let mut mosaic = picture.rgb.clone();
    mosaic.truncate(SIZE[0] * SIZE[1]);
    let [width, height] = SIZE.map(|size| size as u32);
    vec![
        typed(0, &raw("rgb8", [width, height, 3 * width], &picture.rgb)),
        typed(0, &raw("bayer_rggb8", [width, height, width], &mosaic)),
        typed(1, &compressed(&jpeg)),
        typed(1, &compressed(&png)),
        typed(2, &[&[0; 16][..], &field(b"jpeg"), &field(&jpeg)].concat()),
        typed(3, &bytes(2, &jpeg)),
        typed(
            4,
            &[
                fixed(2, width),
                fixed(3, height),
                bytes(4, b"mono8"),
                fixed(5, width),
                bytes(6, &mosaic),
            ]
            .concat(),
        ),
        typed(5, &[bytes(3, VIDEO), bytes(4, b"h264")].concat()),
    ]
}

/// Decodes a message and looks for the object in it.
pub(super) fn reader() -> impl Fn(&[u8]) -> anyhow::Result<()> {
    let tracker = Tracker::new(&rig()).expect("complete");
    move |input| {
        let (which, data) = input.split_first().context("empty")?;
        let (schema, encoding) = TYPES[usize::from(*which) % TYPES.len()];
        let message = ImageMessage::parse(schema, encoding, data)?;
        let mut decoder = Decoder::default();
        let image = decoder.decode(&message)?;
        assert_eq!(image.rgb.len(), 3 * image.width * image.height);
        let seen = tracker.observe(image);
        seen.centre
            .map(drop)
            .map_err(|reason| anyhow!(reason.name()))
    }
}

fn typed(which: u8, message: &[u8]) -> Vec<u8> {
    [&[which], message].concat()
}

/// Bytes behind their length in four.
fn field(content: &[u8]) -> Vec<u8> {
    let length = u32::try_from(content.len()).unwrap_or(u32::MAX);
    [&length.to_le_bytes()[..], content].concat()
}

/// Little-endian CDR from its header to behind an empty `frame_id`, which ends in a zero.
fn begun() -> Vec<u8> {
    let mut message = vec![0, 1, 0, 0];
    message.extend([0; 8]);
    message.extend(field(b"\0"));
    message.extend([0; 3]);
    message
}

fn raw(encoding: &str, [width, height, step]: [u32; 3], data: &[u8]) -> Vec<u8> {
    let mut message = begun();
    for number in [height, width] {
        message.extend(number.to_le_bytes());
    }
    message.extend(field(format!("{encoding}\0").as_bytes()));
    // Not big-endian, and on to a multiple of four behind the header.
    message.push(0);
    message.resize(message.len().next_multiple_of(4), 0);
    message.extend(step.to_le_bytes());
    message.extend(field(data));
    message
}

fn compressed(data: &[u8]) -> Vec<u8> {
    let mut message = begun();
    message.extend(field(b"png\0"));
    message.extend(field(data));
    message
}

/// A field of protobuf: a number of four bytes.
fn fixed(tag: u8, number: u32) -> Vec<u8> {
    [&[tag << 3 | 5][..], &number.to_le_bytes()].concat()
}

/// A field of protobuf: bytes behind their length.
pub(super) fn bytes(tag: u8, content: &[u8]) -> Vec<u8> {
    let mut field = vec![tag << 3 | 2];
    let mut length = content.len();
    while length > 127 {
        field.push(length as u8 | 128);
        length >>= 7;
    }
    field.push(length as u8);
    field.extend(content);
    field
}
