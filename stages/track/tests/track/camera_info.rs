//! A log's CameraInfo, images of another size, video, and logs for viewers.

use std::collections::BTreeSet;

use crate::common::messages::{
    Wire, centroids, frames, pictures, small, write, write_on, write_with,
};
use render::Optics;
use track::{Reason, TrackError, track_log};
use values::Point;

/// `sensor_msgs/msg/CameraInfo` of 320 × 240 pixels up to its projection P: distortion of `plumb_bob`, K = `matrix`, P's focal lengths and principal
/// point.
fn rectified(distortion: &[f64], matrix: [f64; 4], [fx, fy, cx, cy]: [f64; 4]) -> Vec<u8> {
    let mut wire = Wire(info("plumb_bob", distortion, matrix, [320, 240]), true);
    let rotation = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let projection = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    for number in rotation.into_iter().chain(projection) {
        wire = wire.f64(number);
    }
    wire.0
}

/// `sensor_msgs/msg/CameraInfo` up to its matrix.
fn info(model: &str, distortion: &[f64], [fx, fy, cx, cy]: [f64; 4], size: [u32; 2]) -> Vec<u8> {
    let wire = Wire(vec![0, 1, 0, 0], true).header(0);
    let mut wire = wire.u32(size[1]).u32(size[0]).text(model);
    wire = wire.u32(distortion.len() as u32);
    for number in distortion {
        wire = wire.f64(*number);
    }
    for number in [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0] {
        wire = wire.f64(number);
    }
    wire.0
}

#[test]
fn a_lens_is_taken_from_the_logs_camera_info_where_the_rig_file_has_none() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let optics = Optics::of(&rig, [320, 240]).unwrap();
    let frames = frames(&pictures(&rig, 2));
    let images = ("sensor_msgs/msg/CompressedImage", "cdr");
    let mut without = rig.clone();
    (without.camera.matrix, without.camera.distortion) = (None, None);
    let track = |data: &[u8], topic: &str| {
        let first = (topic, "sensor_msgs/msg/CameraInfo", data);
        write_with(&log, images, &frames, Some(first));
        track_log(&log, &without, &out, None)
    };
    let good = info("plumb_bob", &[0.0; 5], optics.matrix, [320, 240]);
    // Beside the images, and the only one, wherever it is.
    for topic in ["/camera/camera_info", "/info"] {
        let outcome = track(&good, topic).unwrap();
        assert_eq!(outcome.centroids, 2, "{outcome:?}");
    }
    let other = info("plumb_bob", &[0.0; 5], optics.matrix, [640, 480]);
    match track(&other, "/camera/camera_info") {
        Err(TrackError::Undecodable { why, .. }) => assert!(why.contains("640 × 480"), "{why}"),
        other => panic!("{other:?}"),
    }
    let fish = info("equidistant", &[0.1; 4], optics.matrix, [320, 240]);
    let said = track(&fish, "/camera/camera_info").unwrap_err().to_string();
    assert!(
        said.contains("equidistant") && said.contains("/camera/camera_info"),
        "{said}"
    );
    let said = track(&good[..40], "/camera/camera_info")
        .unwrap_err()
        .to_string();
    assert!(said.contains("ends at byte"), "{said}");

    write(&log, images.0, images.1, &frames);
    let said = track_log(&log, &without, &out, None)
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("CameraInfo") && said.contains("camera.matrix"),
        "{said}"
    );
}

#[test]
fn a_camera_info_that_contradicts_the_rig_file_is_told() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let [fx, fy, cx, cy] = Optics::of(&rig, [320, 240]).unwrap().matrix;
    let frames = frames(&pictures(&rig, 2));
    let images = ("sensor_msgs/msg/CompressedImage", "cdr");
    let notes = |data: &[u8]| {
        let first = ("/camera/camera_info", "sensor_msgs/msg/CameraInfo", data);
        write_with(&log, images, &frames, Some(first));
        let outcome = track_log(&log, &rig, &out, None).unwrap();
        assert_eq!(outcome.centroids, 2, "{outcome:?}");
        outcome.notes.join("\n")
    };
    let size = [320, 240];
    let near = [1.005 * fx, fy, cx + 1.0, cy];
    assert_eq!(notes(&info("plumb_bob", &[0.0; 5], near, size)), "");
    assert_eq!(notes(&info("", &[], [0.0; 4], size)), "", "not calibrated");
    let far = [1.02 * fx, 1.02 * fy, cx, cy];
    let said = notes(&info("plumb_bob", &[0.0; 5], far, size));
    assert!(
        said.contains("contradicts") && said.contains("matrix"),
        "{said}"
    );
    let said = notes(&info("equidistant", &[0.1; 4], near, size));
    assert!(said.contains("equidistant"), "{said}");
    let said = notes(&info("plumb_bob", &[0.0; 5], near, [640, 480]));
    assert!(said.contains("640 × 480"), "{said}");
}

#[test]
fn a_lens_of_the_images_before_they_were_rectified_is_not_used_of_those_after() {
    const TOPIC: &str = "/camera/image_rect/compressed";
    let (mut rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let after = Optics::of(&rig, [320, 240]).unwrap().matrix;
    let places = pictures(&rig, 2);
    let frames = frames(&places);
    rig.topics.image.as_mut().unwrap().name = TOPIC.into();
    let [fx, fy, cx, cy] = after;
    let before = [1.04 * fx, 1.04 * fy, cx - 3.0, cy + 2.0];
    let distortion = [-0.2, 0.05, 0.001, -0.001, 0.0];
    let mut track = |matrix: [f64; 4], distortion: [f64; 5], first: Option<&[u8]>| {
        rig.camera.matrix = Some(matrix);
        rig.camera.distortion = Some(distortion);
        let images = ("sensor_msgs/msg/CompressedImage", "cdr");
        let first = first.map(|data| ("/camera/camera_info", "sensor_msgs/msg/CameraInfo", data));
        write_on(TOPIC, &log, images, &frames, first);
        track_log(&log, &rig, &out, None)
    };
    let info = rectified(&distortion, before, after);
    let outcome = track(before, distortion, Some(&info)).unwrap();
    let notes = outcome.notes.join("\n");
    assert!(
        notes.contains("rectified") && notes.contains("matrix"),
        "{notes}"
    );
    let found = centroids(&out, &small());
    assert_eq!(found.len(), 2);
    for ((_, found), (at, _)) in found.iter().zip(&places) {
        let off = found.distance(Point::new(at.x, at.y));
        assert!(off < 0.0015, "{off}");
    }
    // The right one needs no CameraInfo.
    for info in [None, Some(&info[..])] {
        let outcome = track(after, [0.0; 5], info).unwrap();
        assert_eq!(
            (outcome.centroids, outcome.notes.len()),
            (2, 0),
            "{outcome:?}"
        );
    }
    let said = track(before, distortion, None).unwrap_err().to_string();
    assert!(said.contains(TOPIC) && said.contains("rectified"), "{said}");
}

#[test]
fn images_of_another_size_than_the_rig_files_are_refused() {
    let (mut rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let frames = frames(&pictures(&rig, 2));
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &frames);
    rig.camera.size = Some([320, 240]);
    assert_eq!(track_log(&log, &rig, &out, None).unwrap().centroids, 2);
    rig.camera.size = Some([640, 480]);
    let said = track_log(&log, &rig, &out, None).unwrap_err().to_string();
    assert!(
        said.contains("320 × 240") && said.contains("640 × 480"),
        "{said}"
    );
}

#[test]
fn an_image_of_another_size_and_video_of_another_format_are_not_looked_at() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let (log, out) = (dir.path().join("in.mcap"), dir.path().join("out.mcap"));
    let mut shots = pictures(&rig, 2);
    let (_, cut) = &mut shots[1];
    cut.rgb.truncate(3 * 320 * 200);
    cut.height = 200;
    let frames = frames(&shots);
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &frames);
    let outcome = track_log(&log, &rig, &out, None).unwrap();
    assert_eq!(outcome.centroids, 1);
    assert_eq!(outcome.reasons[&Reason::Undecodable], 1);
    assert!(outcome.notes[0].contains("320 × 200"), "{outcome:?}");

    for (format, named) in [("h264", "H.264"), ("h265", "JPEG")] {
        let video = [&[26, 4][..], &[0, 0, 0, 1], &[34, 4], format.as_bytes()].concat();
        write(&log, "foxglove.CompressedVideo", "protobuf", &[video]);
        let said = track_log(&log, &rig, &out, None).unwrap_err().to_string();
        assert!(said.contains(named), "{said}");
    }
}

#[test]
fn a_log_for_viewers_has_each_image_and_each_pose() {
    let (rig, dir) = (small(), tempfile::tempdir().unwrap());
    let file = |name: &str| dir.path().join(name);
    let frames = frames(&pictures(&rig, 3));
    let log = file("in.mcap");
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &frames);
    let view = file("view.mcap");
    track_log(&log, &rig, &file("out.mcap"), Some(&view)).unwrap();

    let bytes = std::fs::read(&view).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let kinds: BTreeSet<_> = messages
        .iter()
        .map(|message| {
            let schema = message.channel.schema.as_ref().unwrap();
            (message.channel.topic.clone(), schema.name.clone())
        })
        .collect();
    let kind = |topic: &str, schema: &str| (topic.to_owned(), schema.to_owned());
    let expected = [
        kind("/carom/track/image", "sensor_msgs/msg/CompressedImage"),
        kind("/carom/track/object", "geometry_msgs/msg/PoseStamped"),
    ];
    assert_eq!(kinds, expected.into());
    assert_eq!(messages.len(), 6);
    // What is drawn is green, of which the scene has nothing.
    let image = messages
        .iter()
        .find(|message| message.channel.topic == "/carom/track/image")
        .unwrap();
    let message = track::ImageMessage::parse("sensor_msgs/msg/CompressedImage", "cdr", &image.data);
    let mut decoder = track::Decoder::default();
    let drawn = decoder.decode(&message.unwrap()).unwrap();
    let is_green = |pixel: &&[u8]| pixel[1] > 150 && pixel[0] < 120 && pixel[2] < 120;
    let green = drawn.rgb.chunks(3).filter(is_green).count();
    assert!(green > 20, "{green}");
}
