//! Logs with images in, logs with centroids out.

use std::path::Path;

use crate::common::messages::{
    SECOND, Wire, centroids, compressed, pictures, protobuf, raw, small, write, write_with,
};
use crate::common::tall;
use render::{Optics, Picture};
use track::{FrameReport, QUALITY_TOPIC, Reason, TrackError, track_log};
use values::{Point, Rig, Shape, StampMark};

fn reports(path: &Path) -> Vec<FrameReport> {
    let bytes = std::fs::read(path).unwrap();
    let messages = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap);
    let messages = messages.filter(|message| message.channel.topic == QUALITY_TOPIC);
    messages
        .map(|message| serde_json::from_slice(&message.data).unwrap())
        .collect()
}

#[test]
fn a_large_message_of_another_topic_is_copied_as_it_is() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let cloud: Vec<u8> = (0..5u32 << 20).map(|k| (k % 251) as u8).collect();
    let images = pictures(&rig, 3);
    let images = images.iter().enumerate();
    let images: Vec<_> = images
        .map(|(k, (_, picture))| compressed(&picture.png().unwrap(), k as u32 * 33_000_000))
        .collect();
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let first = Some(("/points", "sensor_msgs/msg/PointCloud2", cloud.as_slice()));
    let schema = ("sensor_msgs/msg/CompressedImage", "cdr");
    write_with(&log, schema, &images, first);
    let outcome = track_log(&log, &rig, &out, None).unwrap();
    assert_eq!((outcome.frames, outcome.centroids), (3, 3), "{outcome:?}");
    let bytes = std::fs::read(&out).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap();
    let points: Vec<_> = messages
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/points")
        .collect();
    assert_eq!(points.len(), 1);
    assert!(*points[0].data == cloud, "its bytes are others");
}

/// Brightness and colour differences of a pixel, ITU-R BT.601 of the range 16 to 235.
fn yuv(picture: &Picture, pixel: usize) -> [u8; 3] {
    let [r, g, b] = [0, 1, 2].map(|i| f64::from(picture.rgb[3 * pixel + i]));
    [
        16.0 + 0.257 * r + 0.504 * g + 0.098 * b,
        128.0 - 0.148 * r - 0.291 * g + 0.439 * b,
        128.0 + 0.439 * r - 0.368 * g - 0.071 * b,
    ]
    .map(|part| part.round() as u8)
}

/// Two pixels in four bytes, in some order of the two's brightness and the colour differences that they share.
fn pairs(picture: &Picture, order: fn([u8; 2], [u8; 2]) -> [u8; 4]) -> Vec<u8> {
    let pair = |k: usize| {
        let ([y, u, v], [z, s, t]) = (yuv(picture, 2 * k), yuv(picture, 2 * k + 1));
        let mean = |a: u8, b: u8| u8::midpoint(a, b);
        order([y, z], [mean(u, s), mean(v, t)])
    };
    (0..picture.rgb.len() / 6).flat_map(pair).collect()
}

/// A plane of brightness, and one of colour differences of every fourth pixel.
fn planes(picture: &Picture, order: fn([u8; 2]) -> [u8; 2]) -> Vec<u8> {
    let luma = (0..picture.width * picture.height).map(|k| yuv(picture, k)[0]);
    let mut data: Vec<u8> = luma.collect();
    for row in (0..picture.height).step_by(2) {
        for column in (0..picture.width).step_by(2) {
            let at = |dx, dy| yuv(picture, (row + dy) * picture.width + column + dx);
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            let mean = |i: usize| (four.iter().map(|yuv| u32::from(yuv[i])).sum::<u32>() / 4) as u8;
            data.extend(order([mean(1), mean(2)]));
        }
    }
    data
}

#[test]
fn every_encoding_gives_the_same_centres() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let shots = pictures(&rig, 3);
    let order = |picture: &Picture, order: [usize; 3]| -> Vec<u8> {
        picture
            .rgb
            .chunks(3)
            .flat_map(|p| order.map(|i| p[i]))
            .collect()
    };
    type Encode<'a> = &'a dyn Fn(&Picture, u32) -> Vec<u8>;
    let size = |step| [320, 240, step];
    let ros = "sensor_msgs/msg/Image";
    let ros_compressed = "sensor_msgs/msg/CompressedImage";
    let encodings: [(&str, &str, &str, Encode<'_>); 13] = [
        ("rgb8", ros, "cdr", &|p, at| {
            raw("rgb8", size(960), &p.rgb, at)
        }),
        ("bgr8", ros, "cdr", &|p, at| {
            raw("bgr8", size(960), &order(p, [2, 1, 0]), at)
        }),
        ("bayer", ros, "cdr", &|p, at| {
            let mosaic: Vec<u8> = (0..320 * 240)
                .map(|k| p.rgb[3 * k + [[0, 1], [1, 2]][k / 320 % 2][k % 2]])
                .collect();
            raw("bayer_rggb8", size(320), &mosaic, at)
        }),
        ("rgb16", ros, "cdr", &|p, at| {
            let twice: Vec<u8> = p.rgb.iter().flat_map(|byte| [7, *byte]).collect();
            raw("rgb16", size(1920), &twice, at)
        }),
        ("bayer16", ros, "cdr", &|p, at| {
            let mosaic =
                (0..320 * 240).map(|k| p.rgb[3 * k + [[2, 1], [1, 0]][k / 320 % 2][k % 2]]);
            let twice: Vec<u8> = mosaic.flat_map(|byte| [7, byte]).collect();
            raw("bayer_bggr16", size(640), &twice, at)
        }),
        ("yuv422", ros, "cdr", &|p, at| {
            raw(
                "yuv422",
                size(640),
                &pairs(p, |[y, z], [u, v]| [u, y, v, z]),
                at,
            )
        }),
        ("yuv422_yuy2", ros, "cdr", &|p, at| {
            raw(
                "yuv422_yuy2",
                size(640),
                &pairs(p, |[y, z], [u, v]| [y, u, z, v]),
                at,
            )
        }),
        ("nv12", ros, "cdr", &|p, at| {
            raw("nv12", size(320), &planes(p, |[u, v]| [u, v]), at)
        }),
        ("nv21", ros, "cdr", &|p, at| {
            raw("nv21", size(320), &planes(p, |[u, v]| [v, u]), at)
        }),
        ("png", ros_compressed, "cdr", &|p, at| {
            compressed(&p.png().unwrap(), at)
        }),
        ("jpeg", ros_compressed, "cdr", &|p, at| {
            compressed(&p.jpeg(95).unwrap(), at)
        }),
        ("ros1", "sensor_msgs/CompressedImage", "ros1", &|p, at| {
            let wire = Wire(Vec::new(), false).u32(7).header(at);
            wire.text("png").bytes(&p.png().unwrap()).0
        }),
        (
            "foxglove",
            "foxglove.CompressedImage",
            "protobuf",
            &|p, at| protobuf(&p.jpeg(95).unwrap(), at),
        ),
    ];
    for (name, schema, encoding, encode) in encodings {
        let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
        let messages = shots
            .iter()
            .zip(1u32..)
            .map(|((_, p), k)| encode(p, 1000 * k));
        write(&log, schema, encoding, &messages.collect::<Vec<_>>());
        let outcome = track_log(&log, &rig, &out, None).unwrap();
        assert_eq!(
            (outcome.frames, outcome.centroids),
            (3, 3),
            "{name}: {outcome:?}"
        );
        for ((k, (at, _)), (stamp, found)) in shots.iter().enumerate().zip(centroids(&out, &rig)) {
            // A pixel is 4.8 mm, and a mosaic has half of the colours.
            let miss = found.distance(Point::new(at.x, at.y));
            assert!(miss < 1.5e-3, "{name}: {:.2} mm", 1e3 * miss);
            assert_eq!(
                stamp,
                SECOND * 1_000_000_000 + 1000 * (k as i64 + 1),
                "{name}"
            );
        }
    }
}

#[test]
fn a_stamp_is_that_of_the_exposures_middle() {
    let (mut rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (at, picture) = pictures(&rig, 1).remove(0);
    rig.camera.stamp = StampMark::Start;
    rig.camera.exposure = Some(0.004);
    rig.camera.readout = Some(0.010);
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let data = compressed(&picture.png().unwrap(), 0);
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &[data]);
    track_log(&log, &rig, &out, None).unwrap();
    let found = centroids(&out, &rig)[0];
    let row = Optics::of(&rig, [320, 240])
        .unwrap()
        .seen([at.x, at.y, 0.02])[1];
    let expected = 0.002 + 0.010 * row / 239.0;
    let delay = 1e-9 * (found.0 - SECOND * 1_000_000_000) as f64;
    assert!((delay - expected).abs() < 1e-4, "{delay} {expected}");
}

#[test]
fn a_frame_that_cannot_be_trusted_has_a_reason_and_no_centroid() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let shots = pictures(&rig, 3);
    let png = |k: usize| shots[k].1.png().unwrap();
    let cut = png(0)[..400].to_vec();
    let messages = [
        compressed(&png(0), 1),
        compressed(&png(1), 2),
        compressed(&png(1), 3),
        compressed(&cut, 4),
        compressed(&png(2), 5),
        compressed(&png(0), 2),
    ];
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &messages);
    let outcome = track_log(&log, &rig, &out, None).unwrap();
    assert_eq!((outcome.frames, outcome.centroids), (6, 3));
    let reasons: Vec<_> = reports(&out)
        .into_iter()
        .map(|report| report.reason)
        .collect();
    let (repeated, undecodable, stale) = (Reason::Repeated, Reason::Undecodable, Reason::Stale);
    let expected = [
        None,
        None,
        Some(repeated),
        Some(undecodable),
        None,
        Some(stale),
    ];
    assert_eq!(reasons, expected);
    assert_eq!(centroids(&out, &rig).len(), 3);
}

#[test]
fn a_frame_before_1970_has_a_reason() {
    let (mut rig, dir) = (small(), tempfile::tempdir().unwrap());
    rig.camera.stamp = StampMark::End;
    rig.camera.exposure = Some(0.010);
    // Stamped 1 ns after the clock's beginning, it was exposed before.
    let mut message = compressed(&pictures(&rig, 1)[0].1.png().unwrap(), 1);
    // The seconds stand behind CDR's header.
    message[4..8].fill(0);
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &[message]);
    let outcome = track_log(&log, &rig, &out, None).unwrap();
    assert_eq!((outcome.frames, outcome.centroids), (1, 0));
    assert_eq!(reports(&out)[0].reason, Some(Reason::Stale));
    assert_eq!(outcome.reasons[&Reason::Stale], 1);
}

#[test]
fn a_damaged_png_is_told_apart_from_one_that_is_cut_and_named() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let shots = pictures(&rig, 2);
    let [whole, mut damaged] = [0, 1].map(|k: usize| shots[k].1.png().unwrap());
    let cut = damaged[..damaged.len() / 2].to_vec();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    for (data, said) in [
        (
            cut,
            "they end before the image does; record or copy it again",
        ),
        (damaged, "they are damaged; record or copy it again"),
    ] {
        let messages = [compressed(&whole, 0), compressed(&data, 20_000_000)];
        write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &messages);
        let notes = track_log(&log, &rig, &out, None).unwrap().notes;
        let expected =
            format!("image 2, of {SECOND}.020 s: its PNG data cannot be decoded: {said}");
        assert_eq!(notes, [expected]);
    }
}

#[test]
fn what_a_stopped_or_failed_track_leaves_is_the_old_log() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let view = dir.path().join("view.mcap");
    for file in [&out, &view] {
        std::fs::write(file, "old").unwrap();
    }
    let cut = compressed(&pictures(&rig, 1)[0].1.png().unwrap()[..400], 0);
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &[cut]);
    track_log(&log, &rig, &out, Some(&view)).unwrap_err();
    for file in [&out, &view] {
        assert_eq!(std::fs::read(file).unwrap(), b"old");
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 3);
}

#[test]
fn the_bytes_do_not_depend_on_the_threads() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    // More images than wait at once.
    let shots = pictures(&rig, 100);
    let images = shots.iter().zip(1..);
    let images = images.map(|((_, picture), at)| compressed(&picture.jpeg(90).unwrap(), at));
    let log = dir.path().join("in.mcap");
    let images: Vec<_> = images.collect();
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &images);
    let tracked = [1, 2, 5].map(|threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let [out, view] = ["out", "view"].map(|name| dir.path().join(format!("{name}{threads}")));
        let track = || track_log(&log, &rig, &out, Some(&view)).unwrap();
        let outcome = pool.build().unwrap().install(track);
        assert!(
            outcome.frames == 100 && outcome.centroids > 90,
            "{outcome:?}"
        );
        [out, view].map(|file| std::fs::read(file).unwrap())
    });
    assert!(tracked[1..].iter().all(|other| *other == tracked[0]));
}

#[test]
fn hostile_images_are_typed_errors() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let picture = &pictures(&rig, 1)[0].1;
    let mut huge = picture.png().unwrap();
    huge[16..24].copy_from_slice(&[0, 0, 0x4e, 0x20, 0, 0, 0x4e, 0x20]);
    let mut huge_jpeg = picture.jpeg(90).unwrap();
    let sof = huge_jpeg
        .windows(2)
        .position(|bytes| bytes == [0xff, 0xc0])
        .unwrap();
    huge_jpeg[sof + 5..sof + 9].copy_from_slice(&[0x4e, 0x20, 0x4e, 0x20]);
    let jpeg = picture.jpeg(90).unwrap();
    let rows = [320, 240, 960];
    let whole = |message| ("sensor_msgs/msg/CompressedImage", message);
    let image = |data: &[u8]| whole(compressed(data, 0));
    let raw = |encoding, size, data: &[u8]| ("sensor_msgs/msg/Image", raw(encoding, size, data, 0));
    let cut = compressed(&jpeg, 0)[..40].to_vec();
    for (name, (schema, data), said) in [
        ("png of 20,000 × 20,000", image(&huge), ""),
        ("jpeg of 20,000 × 20,000", image(&huge_jpeg), ""),
        ("cut jpeg", image(&jpeg[..jpeg.len() / 2]), "JPEG"),
        ("no image", image(b"hello"), "neither JPEG, PNG nor WebP"),
        ("empty", whole(Vec::new()), "ends at byte 0"),
        ("cut message", whole(cut), "ends at byte"),
        (
            "vast",
            raw("rgb8", [20_000, 20_000, 60_000], &[0; 9]),
            "20000 × 20000",
        ),
        ("too short", raw("rgb8", rows, &[0; 1000]), "240 rows"),
        (
            "a lying step",
            raw("rgb8", [320, 240, 4], &picture.rgb),
            "rows of 4",
        ),
        ("no pixels", raw("rgb8", [0, 0, 0], &[]), "0 × 0"),
        (
            "not read",
            raw("bayer_rggb12", rows, &picture.rgb),
            "bayer_rggb12",
        ),
        (
            "lying",
            raw("rgb16", rows, &picture.rgb),
            "pixels of 6 bytes",
        ),
    ] {
        let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
        write(&log, schema, "cdr", &[data]);
        match track_log(&log, &rig, &out, None) {
            Err(TrackError::Undecodable { why, .. }) => {
                assert!(why.contains(said), "{name}: {why}")
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn what_a_log_or_rig_lacks_is_named() {
    let (mut rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    write(&log, "std_msgs/msg/String", "cdr", &[vec![0; 8]]);
    let said = |rig: &Rig| track_log(&log, rig, &out, None).unwrap_err().to_string();
    assert!(said(&rig).contains("std_msgs/msg/String"));
    rig.topics.image.as_mut().unwrap().name = "/other".into();
    assert!(said(&rig).contains("/other"));
    rig.object.colour = None;
    assert!(said(&rig).contains("object.colour"));
    rig.topics.image = None;
    rig.object.colour = tall(Shape::Cylinder).colour;
    assert!(said(&rig).contains("topics.image.name"));
}
