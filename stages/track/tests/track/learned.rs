//! What a log's own images teach: the table without the object, so that what hides a part of it is known, and a camera that was pushed.

use std::path::Path;

use crate::common::messages::{SECOND, compressed, write};
use crate::common::{Case, rig, tall};
use logs::read::{RawMessage, read_raw};
use logs::{Limits, LogError};
use render::{Cover, Moment, Optics, Renderer, Scene};
use track::{FrameReport, QUALITY_TOPIC, Reason, TrackOutcome, track_log};
use values::{Camera, Point, Rig, Shape};

/// Where the object lies in each frame, and what is between it and the camera.
type Frame = (Moment, Option<Cover>);

/// Six places, five frames each.
fn frames() -> Vec<Frame> {
    let place = |k: usize| Moment {
        x: 0.35 + 0.05 * (k / 5) as f64,
        y: -0.2 + 0.08 * (k / 5) as f64,
        yaw: 0.0,
    };
    (0..30).map(|k| (place(k), None)).collect()
}

fn lab() -> Rig {
    let case = Case {
        pixels: [640, 480],
        ..Case::flat()
    };
    rig(&tall(Shape::Cylinder), &case)
}

/// Renders frames, those from `pushed` on by a camera that was moved, and tracks their log.
fn tracked(
    frames: &[Frame],
    pushed: usize,
    push: impl Fn(&mut Camera),
) -> (TrackOutcome, Vec<FrameReport>) {
    tracked_with(&lab(), &[], frames, pushed, push)
}

/// The same with what a rig file says, and where others like the object lie.
fn tracked_with(
    stated: &Rig,
    others: &[Moment],
    frames: &[Frame],
    pushed: usize,
    push: impl Fn(&mut Camera),
) -> (TrackOutcome, Vec<FrameReport>) {
    let rig = lab();
    let mut aside = rig.clone();
    push(&mut aside.camera);
    let scene = Scene::laboratory(&rig.object).unwrap();
    let messages: Vec<Vec<u8>> = frames
        .iter()
        .enumerate()
        .map(|(k, (at, cover))| {
            let seen_by = if k < pushed { &rig } else { &aside };
            let mut scene = scene.clone();
            scene.others.extend(others);
            scene.covers.extend(*cover);
            let optics = Optics::of(seen_by, [640, 480]).unwrap();
            let shot = Renderer::new(optics, scene, 2.0, 4).render(&|_| *at, k as u64);
            compressed(&shot.picture.jpeg(90).unwrap(), 33_000_000 * k as u32)
        })
        .collect();
    let dir = tempfile::tempdir().unwrap();
    let (log, out) = (dir.path().join("log.mcap"), dir.path().join("out.mcap"));
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &messages);
    let outcome = track_log(&log, stated, &out, None).unwrap();
    (outcome, reports(&out))
}

fn reports(path: &Path) -> Vec<FrameReport> {
    let mut reports = Vec::new();
    read_raw(path, Limits::default(), &mut |message: RawMessage<'_>| {
        if message.channel.topic == QUALITY_TOPIC {
            reports.push(serde_json::from_slice(message.data).unwrap());
        }
        Ok::<_, LogError>(())
    })
    .unwrap();
    reports
}

/// How far off a frame's centre is, in m; none where it has none.
fn off(report: &FrameReport, at: &Moment) -> Option<f64> {
    Some(Point::new(report.x?, report.y?).distance(Point::new(at.x, at.y)))
}

#[test]
fn a_height_that_the_images_do_not_show_is_told_and_makes_centres_less_sure() {
    let (frames, true_rig) = (frames(), lab());
    let told = |outcome: &TrackOutcome| {
        let notes = outcome.notes.iter();
        notes.filter(|note| note.contains("mm tall")).count()
    };
    let (outcome, as_it_is) = tracked_with(&true_rig, &[], &frames, frames.len(), |_| {});
    assert_eq!(told(&outcome), 0, "{:?}", outcome.notes);
    let mut stated = true_rig.clone();
    let values::Solid::Cylinder { half_height, .. } = &mut stated.object.solid else {
        panic!("a cylinder");
    };
    *half_height += 0.008;
    let (outcome, reports) = tracked_with(&stated, &[], &frames, frames.len(), |_| {});
    assert_eq!(told(&outcome), 1, "{:?}", outcome.notes);
    for ((report, sure), (at, _)) in reports.iter().zip(&as_it_is).zip(&frames) {
        let (off, deviation) = (off(report, at).unwrap(), report.deviation.unwrap());
        assert!(off < 3.0 * deviation, "{off} {deviation}");
        assert!(deviation > sure.deviation.unwrap(), "{report:?}");
    }
}

#[test]
fn an_arm_that_hides_half_of_it_is_seen_past() {
    let mut frames = frames();
    for (at, cover) in &mut frames[12..15] {
        // A grey arm from the robot's side, its round end over the middle.
        *cover = Some(Cover {
            from: [at.x - 0.04, at.y],
            to: [at.x - 0.6, at.y],
            radius: 0.04,
            height: 0.05,
            colour: [0.5; 3],
        });
    }
    let (_, reports) = tracked(&frames, usize::MAX, |_| {});
    for (k, report) in reports.iter().enumerate() {
        let off = off(report, &frames[k].0);
        assert!(
            off.is_some_and(|off| off < 0.0015),
            "{k}: {off:?} {report:?}"
        );
    }
}

#[test]
fn what_always_lies_there_and_a_cable_that_moves_are_no_other_object() {
    let mut frames = frames();
    let object = Scene::laboratory(&lab().object).unwrap().object;
    for (k, (_, cover)) in frames.iter_mut().enumerate() {
        // Of the object's colour, and half as much of it.
        let y = -0.35 + 0.004 * k as f64;
        *cover = Some(Cover {
            from: [0.75, y],
            to: [0.95, -y],
            radius: 0.003,
            height: 0.002,
            colour: object,
        });
    }
    let others = [[0.75, 0.3], [0.3, 0.3]].map(|[x, y]| Moment { x, y, yaw: 0.0 });
    let (_, reports) = tracked_with(&lab(), &others, &frames, usize::MAX, |_| {});
    for (k, report) in reports.iter().enumerate() {
        let off = off(report, &frames[k].0);
        assert!(
            off.is_some_and(|off| off < 0.0015),
            "{k}: {off:?} {report:?}"
        );
    }
}

#[test]
fn a_camera_that_was_pushed_is_told_and_its_centres_corrected() {
    /// By so many px.
    fn aside(x: f64, y: f64) -> impl Fn(&mut Camera) {
        move |camera| {
            let matrix = camera.matrix.as_mut().unwrap();
            matrix[2] += x;
            matrix[3] += y;
        }
    }
    /// About its optical axis, by 1.2 degrees.
    fn rolled(camera: &mut Camera) {
        let [x, y, z, w] = camera.orientation.unwrap();
        let (sin, cos) = 0.0105f64.sin_cos();
        let turned = [
            x * cos + y * sin,
            y * cos - x * sin,
            z * cos + w * sin,
            w * cos - z * sin,
        ];
        camera.orientation = Some(turned);
    }
    type Push = Box<dyn Fn(&mut Camera)>;
    let frames = frames();
    // A little, early, and turned.
    let pushes: [(usize, Push); 3] = [
        (20, Box::new(aside(2.0, 0.0))),
        (4, Box::new(aside(-1.5, 1.5))),
        (17, Box::new(rolled)),
    ];
    for (pushed, push) in pushes {
        let (outcome, reports) = tracked(&frames, pushed, push);
        let note = outcome.notes.iter().find(|note| note.contains("moved"));
        let note = note.unwrap_or_else(|| panic!("{pushed}: {outcome:?}"));
        let begun = format!("{SECOND}.{:03}", 33 * pushed);
        assert!(note.contains(&begun), "{begun}: {note}");
        for (k, report) in reports.iter().enumerate() {
            let off = off(report, &frames[k].0);
            assert!(
                off.is_some_and(|off| off < 0.0015),
                "{pushed}, {k}: {off:?} {report:?}"
            );
        }
    }
    // Far, over a grain that repeats: where it lies cannot be told.
    let (outcome, reports) = tracked(&frames, 13, aside(14.0, -9.0));
    assert_eq!(
        outcome.reasons.get(&Reason::Moved),
        Some(&17),
        "{outcome:?}"
    );
    assert!(reports.iter().skip(13).all(|report| report.x.is_none()));
}

#[test]
fn a_deviation_is_about_what_centres_are_off_by() {
    let frames = frames();
    let (outcome, reports) = tracked(&frames, usize::MAX, |_| {});
    assert_eq!(outcome.centroids, 30, "{outcome:?}");
    let squares = reports.iter().zip(&frames).map(|(report, (at, _))| {
        0.5 * (off(report, at).unwrap() / report.deviation.unwrap()).powi(2)
    });
    let mean = squares.sum::<f64>() / 30.0;
    assert!((0.05..3.0).contains(&mean), "{mean}");
}
