//! A shutter that rolls, of which nobody has told: what a moving object's shear says of it.

use crate::common::messages::{SECOND, compressed, write};
use crate::common::{Case, rig, tall};
use logs::read::{RawMessage, read_raw};
use logs::{Limits, LogError};
use render::{Moment, Optics, Renderer, Scene};
use track::{FrameReport, QUALITY_TOPIC, TrackOutcome, track_log};
use values::{Point, Shape};

/// Time from frame to frame, in s, of a log that lasts less than a second.
const PERIOD: f64 = 1.0 / 65.0;
/// Frames of a strike: it rests, moves and rests.
const FRAMES: usize = 16;
const FIRST: usize = 3;
const LAST: usize = 13;
const SPEED: f64 = 0.75;
/// Starts and headings (rad).
const STRIKES: [(f64, f64, f64); 4] = [
    (0.35, -0.15, 0.3),
    (0.60, 0.20, -2.4),
    (0.40, 0.15, -0.6),
    (0.65, -0.10, 2.9),
];

/// Where the object is, a time (s) after the log began.
fn place(seconds: f64) -> Point {
    let lasts = FRAMES as f64 * PERIOD;
    let strike = ((seconds / lasts) as usize).min(STRIKES.len() - 1);
    let (x, y, heading) = STRIKES[strike];
    let [first, last] = [FIRST, LAST].map(|frame| (frame as f64 - 0.5) * PERIOD);
    let moved = SPEED * ((seconds - strike as f64 * lasts).clamp(first, last) - first);
    Point::new(x + moved * heading.cos(), y + moved * heading.sin())
}

/// Tracks a log of a camera with this readout (s), and does not tell it.
fn tracked(readout: f64) -> (TrackOutcome, Vec<FrameReport>) {
    let case = Case {
        pixels: [640, 480],
        exposure: 0.004,
        readout,
        ..Case::flat()
    };
    let mut rig = rig(&tall(Shape::Cylinder), &case);
    rig.camera.rate = 1.0 / PERIOD;
    let optics = Optics::of(&rig, [640, 480]).unwrap();
    let scene = Scene::laboratory(&rig.object).unwrap();
    let renderer = Renderer::new(optics, scene, 2.0, 4);
    rig.camera.readout = None;
    let messages: Vec<Vec<u8>> = (0..STRIKES.len() * FRAMES)
        .map(|k| {
            let begin = k as f64 * PERIOD + 0.002;
            let path = |t: f64| {
                let Point { x, y } = place(begin + t);
                Moment { x, y, yaw: 0.0 }
            };
            let shot = renderer.render(&path, k as u64);
            compressed(&shot.picture.jpeg(90).unwrap(), (1e9 * begin) as u32)
        })
        .collect();
    let dir = tempfile::tempdir().unwrap();
    let (log, out) = (dir.path().join("log.mcap"), dir.path().join("out.mcap"));
    write(&log, "sensor_msgs/msg/CompressedImage", "cdr", &messages);
    let outcome = track_log(&log, &rig, &out, None).unwrap();
    let mut reports = Vec::new();
    read_raw(&out, Limits::default(), &mut |message: RawMessage<'_>| {
        if message.channel.topic == QUALITY_TOPIC {
            reports.push(serde_json::from_slice(message.data).unwrap());
        }
        Ok::<_, LogError>(())
    })
    .unwrap();
    (outcome, reports)
}

#[test]
fn a_readout_that_nobody_told_is_seen_in_a_moving_object() {
    for readout in [0.0, 0.014] {
        let (outcome, reports) = tracked(readout);
        let note = outcome.notes.iter().find(|note| note.contains("readout"));
        let note = note.expect("it is said");
        assert!(note.contains("sheared"), "{note}");
        let (mut count, mut worst) = (0, 0.0f64);
        for (k, report) in reports.iter().enumerate() {
            let within = k % FRAMES;
            if !(FIRST + 1..LAST - 1).contains(&within) {
                continue;
            }
            let (Some(x), Some(y), Some(deviation)) = (report.x, report.y, report.deviation) else {
                continue;
            };
            let seconds = 1e-9 * (report.stamp - SECOND * 1_000_000_000) as f64;
            let off = place(seconds).distance(Point::new(x, y));
            assert!(
                off < 3.0 * deviation,
                "{readout} s, frame {k}: {off} m, {deviation} m; {note}"
            );
            worst = worst.max(off);
            count += 1;
        }
        assert!(count > 25, "{count} of {outcome:?}");
        // Not taken into account, it puts the object up to 10 mm off.
        assert!(worst < 0.004, "{readout} s: {worst} m; {note}");
    }
}
