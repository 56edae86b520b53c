//! H.264 video: `video.h264` is what x264 made of eight clean frames (`examples/frames.rs`, `tests/peers/video.py`), a key frame every four.

use crate::common::messages::{SECOND, write};
use crate::common::{Case, places, rig};
use render::case::disc;
use track::{
    Decoder, Image, ImageError, ImageMessage, Payload, Reason, Tracker, Window, excerpt, track_log,
};
use values::{Point, Rig};

const VIDEO: &[u8] = include_bytes!("../video.h264");
/// The delimiter before every image.
const DELIMITER: &[u8] = &[0, 0, 0, 1, 9];

fn images() -> Vec<&'static [u8]> {
    let starts: Vec<usize> = VIDEO
        .windows(DELIMITER.len())
        .enumerate()
        .filter(|(_, bytes)| *bytes == DELIMITER)
        .map(|(at, _)| at)
        .collect();
    let ends = starts.iter().copied().skip(1).chain([VIDEO.len()]);
    let parts = starts.iter().zip(ends);
    parts.map(|(start, end)| &VIDEO[*start..end]).collect()
}

fn camera() -> Rig {
    let case = Case {
        pixels: [640, 480],
        noise: 0.0,
        ..Case::flat()
    };
    rig(&disc(), &case)
}

fn decode<'a>(decoder: &'a mut Decoder, data: &[u8]) -> Result<&'a Image, ImageError> {
    let payload = Payload::Video("h264", data);
    decoder.decode(&ImageMessage { stamp: 0, payload })
}

#[test]
fn the_object_is_found_in_every_image_of_a_video() {
    let tracker = Tracker::new(&camera()).unwrap();
    let mut decoder = Decoder::default();
    let mut squares = 0.0;
    for (data, (at, _)) in images().into_iter().zip(places(8)) {
        let image = decode(&mut decoder, data).unwrap();
        assert_eq!([image.width, image.height], [640, 480]);
        let centre = tracker.observe(image).centre.unwrap();
        squares += centre.distance(Point::new(at.x, at.y)).powi(2);
    }
    let rms = (squares / 8.0).sqrt();
    println!("{:.3} mm rms", 1e3 * rms);
    // A tenth of a pixel of 2.4 mm.
    assert!(rms < 0.25e-3, "{rms}");
}

#[test]
fn what_builds_on_an_image_that_is_not_there_is_not_given() {
    let images = images();
    let mut decoder = Decoder::default();
    for data in &images[1..4] {
        let error = decode(&mut decoder, data)
            .map(|image| image.width)
            .expect_err("no key frame")
            .to_string();
        assert!(error.contains("before it"), "{error}");
    }
    assert!(decode(&mut decoder, images[4]).is_ok(), "a key frame");
    assert!(decode(&mut decoder, images[5]).is_ok());
    // Without its slice.
    assert!(decode(&mut decoder, &images[6][..6]).is_err());
    assert!(decode(&mut decoder, images[7]).is_err());
    assert!(decode(&mut decoder, images[0]).is_ok());
    assert!(decode(&mut decoder, b"no video").is_err());
}

#[test]
fn an_image_that_was_dropped_is_noticed() {
    let images = images();
    let mut decoder = Decoder::default();
    assert!(decode(&mut decoder, images[0]).is_ok());
    assert!(decode(&mut decoder, images[1]).is_ok());
    for data in [images[3], images[2]] {
        let decoded = decode(&mut decoder, data).map(|image| image.width);
        let error = decoded.expect_err("one is missing").to_string();
        assert!(error.contains("before it"), "{error}");
    }
    assert!(decode(&mut decoder, images[4]).is_ok(), "a key frame");
    // Where the key frame itself is dropped.
    assert!(decode(&mut decoder, images[5]).is_ok());
    assert!(decode(&mut decoder, images[6]).is_ok());
    assert!(decode(&mut decoder, images[1]).is_err());
}

#[test]
fn a_video_with_b_frames_is_refused() {
    /// Beginning of a slice of an image that builds on others, and the bit of its header by which P and B differ.
    const SLICE: &[u8] = &[0, 0, 1, 0x41];
    const KIND: u8 = 0b100;
    let images = images();
    let mut decoder = Decoder::default();
    assert!(decode(&mut decoder, images[0]).is_ok());
    let mut data = images[1].to_vec();
    let slice = data.windows(4).position(|bytes| bytes == SLICE).unwrap();
    data[slice + 4] ^= KIND;
    for data in [&data[..], images[4]] {
        let decoded = decode(&mut decoder, data).map(|image| image.width);
        let error = decoded.expect_err("B-frames").to_string();
        assert!(
            error.contains("B-frames") && error.contains("zerolatency"),
            "{error}"
        );
    }
}

#[test]
fn an_object_at_rest_may_have_the_same_pixels_in_a_video() {
    /// A delimiter that says that any kind of slice follows: the same pixels in other bytes.
    const OTHER: &[u8] = &[0, 0, 0, 1, 9, 0xf0];
    let folder = tempfile::tempdir().unwrap();
    let (log, out) = (
        folder.path().join("in.mcap"),
        folder.path().join("out.mcap"),
    );
    let images = images();
    let again = [OTHER, &images[0][OTHER.len()..]].concat();
    let track = |shown: &[&[u8]]| {
        let shown = (1u8..).zip(shown);
        let messages: Vec<_> = shown.map(|(k, data)| message(k, data)).collect();
        write(&log, "foxglove.CompressedVideo", "protobuf", &messages);
        track_log(&log, &camera(), &out, None).unwrap()
    };
    // The object is elsewhere in the third.
    let outcome = track(&[images[0], &again, images[4]]);
    assert_eq!(outcome.centroids, 3, "{outcome:?}");
    let outcome = track(&[images[0], images[0], images[4]]);
    assert_eq!(outcome.reasons[&Reason::Repeated], 1, "{outcome:?}");
}

#[test]
fn changed_bytes_are_errors_or_images_and_never_a_panic() {
    let images = images();
    let mut seed = 1u64;
    let mut next = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) as usize % below
    };
    let mut refused = 0;
    for _ in 0..100 {
        let mut decoder = Decoder::default();
        for data in &images[..3] {
            let mut data = data.to_vec();
            for _ in 0..next(4) {
                let at = next(data.len());
                data[at] = next(256) as u8;
            }
            data.truncate(data.len() - next(2) * next(data.len()));
            refused += usize::from(decode(&mut decoder, &data).is_err());
        }
    }
    assert!(refused > 0);
}

#[test]
fn a_log_of_video_gives_centroids() {
    let folder = tempfile::tempdir().unwrap();
    let (log, out) = (
        folder.path().join("in.mcap"),
        folder.path().join("out.mcap"),
    );
    let messages: Vec<Vec<u8>> = (1u8..)
        .zip(images())
        .map(|(k, data)| message(k, data))
        .collect();
    write(&log, "foxglove.CompressedVideo", "protobuf", &messages);
    let outcome = track_log(&log, &camera(), &out, None).unwrap();
    assert_eq!((outcome.frames, outcome.centroids), (8, 8), "{outcome:?}");
    // From its second image on, all up to the next key frame build on what is not there.
    write(&log, "foxglove.CompressedVideo", "protobuf", &messages[1..]);
    let outcome = track_log(&log, &camera(), &out, None).unwrap();
    assert_eq!((outcome.frames, outcome.centroids), (7, 4), "{outcome:?}");
    assert_eq!(outcome.reasons[&Reason::Undecodable], 3);
    assert!(outcome.notes[0].contains("before it"), "{outcome:?}");
}

#[test]
fn an_image_from_the_middle_of_a_video_is_shown_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("in.mcap");
    let messages: Vec<Vec<u8>> = (1u8..)
        .zip(images())
        .map(|(k, data)| message(k, data))
        .collect();
    write(&log, "foxglove.CompressedVideo", "protobuf", &messages);
    // Stamps are a nanosecond apart: the third builds on two that nobody wants; the sixth and the eighth are of the second key frame.
    let at = |k: i64| SECOND * 1_000_000_000 + k;
    let window = |from, to, most| Window {
        from: at(from),
        to: at(to),
        most,
    };
    let windows = [window(3, 3, 1), window(6, 8, 2)];
    let found = excerpt(&log, None, &windows).unwrap();
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    let stamps: Vec<i64> = found.images.iter().map(|image| image.stamp).collect();
    assert_eq!(stamps, [at(3), at(6), at(8)]);
    let tracker = Tracker::new(&camera()).unwrap();
    let shown = places(8);
    for (image, k) in found.images.iter().zip([2, 5, 7]) {
        assert_eq!(image.format, "jpeg");
        let mut decoder = Decoder::default();
        let payload = Payload::Compressed(&image.data);
        let decoded = decoder.decode(&ImageMessage { stamp: 0, payload }).unwrap();
        let centre = tracker.observe(decoded).centre.unwrap();
        let far = centre.distance(Point::new(shown[k].0.x, shown[k].0.y));
        // A pixel of 2.4 mm; each image's object is further from the others'.
        assert!(far < 2.4e-3, "{k}: {far}");
    }

    // From its second image on: what builds on what is not there is told.
    write(&log, "foxglove.CompressedVideo", "protobuf", &messages[1..]);
    let found = excerpt(&log, None, &windows).unwrap();
    let stamps: Vec<i64> = found.images.iter().map(|image| image.stamp).collect();
    assert_eq!(stamps, [at(6), at(8)]);
    assert!(found.notes[0].contains("before it"), "{:?}", found.notes);
}

fn message(at: u8, data: &[u8]) -> Vec<u8> {
    let varint = |mut number: u64| {
        let mut bytes = Vec::new();
        while number > 127 {
            bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        bytes.push(number as u8);
        bytes
    };
    let stamp = [&[8][..], &varint(SECOND as u64), &[16, at]].concat();
    let format = [34, 4, b'h', b'2', b'6', b'4'];
    let head = [&[10, stamp.len() as u8][..], &stamp].concat();
    [&head, &[26][..], &varint(data.len() as u64), data, &format].concat()
}
