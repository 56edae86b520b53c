//! The embedded rig's logs: every strike is kept, and measured as its truth says.

use ingest::{Ingest, assemble, ingest_log};
use rig::{AirTable, Hidden, Hide, Truth, demo};
use values::{Point, Rig, Shape, Strike, median};

struct Demo {
    truth: Truth,
    strikes: Vec<Strike>,
}

/// A demo, written and read again; none of its strikes is rejected.
fn read(settings: &demo::Settings) -> Demo {
    let folder = tempfile::tempdir().expect("a folder");
    let written = demo::write(settings, folder.path()).expect("writes");
    let rig = Rig::load(&written.rig).expect("the rig file is accepted");
    let outcomes = written
        .logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()).expect("the log is read"))
        .collect();
    let (strikes, rejects) = assemble(outcomes);
    assert_eq!(rejects, []);
    Demo {
        truth: Truth::load(&written.truth).expect("the truth"),
        strikes,
    }
}

fn demo(shape: Shape, count: usize, hidden: Option<&str>) -> Demo {
    let hidden = hidden.map(|text| Hidden::parse(&[text]).expect("an effect"));
    read(&demo::Settings::new(shape, count, 3, hidden))
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0_usize, 0.0), |(count, sum), value| {
        (count + 1, sum + value * value)
    });
    (sum / count as f64).sqrt()
}

#[test]
fn every_demo_strike_is_kept_and_measured_within_the_cameras_noise() {
    for shape in [Shape::Cylinder, Shape::Box, Shape::Sphere] {
        // Nothing hidden in the camera, so that what it sees is what is true.
        let Demo { truth, strikes } = demo(shape, 120, Some("viscous_drag"));
        assert_eq!(strikes.len(), truth.strikes.len());
        let noise = truth.rig.camera.noise;
        let both = || strikes.iter().zip(&truth.strikes);
        let initial = rms(both().map(|(strike, truth)| strike.initial.distance(truth.initial)));
        let stop = rms(both().map(|(strike, truth)| strike.stop.distance(truth.stop)));
        let late: Vec<f64> = both()
            .map(|(strike, truth)| strike.t_start - truth.impact as f64 * 1e-9)
            .collect();
        let frame = 1.0 / truth.rig.camera.rate;
        let within = late
            .iter()
            .filter(|late| (-0.1 * frame..1.2 * frame).contains(*late))
            .count();
        println!(
            "{}: {} strikes, initial {:.2} mm, stop {:.2} mm rms, first motion within a frame of the impact for {within}",
            shape.name(),
            strikes.len(),
            1e3 * initial,
            1e3 * stop
        );
        assert!(initial < 0.6 * noise, "{initial}");
        assert!(stop < 0.8 * noise, "{stop}");
        // Dropped frames make it later for a few.
        assert!(within >= 112, "{within} {late:?}");
        for (strike, truth) in both() {
            assert!((strike.command.speed - truth.command.speed).abs() < 1e-6);
            assert!((strike.command.angle - truth.command.angle).abs() < 1e-6);
            let end = strike.track.t.last().copied().unwrap_or_default();
            assert!(
                (end - truth.rest_time).abs() < 0.25,
                "{end} {}",
                truth.rest_time
            );
        }
    }
}

#[test]
fn the_default_demos_are_kept_whole() {
    for shape in [Shape::Cylinder, Shape::Box] {
        let Demo { truth, strikes } = demo(shape, 500, None);
        assert_eq!((strikes.len(), truth.strikes.len()), (500, 500));
        let order = strikes
            .iter()
            .zip(0..)
            .all(|(strike, rank)| strike.conditions.order as i32 == rank);
        assert!(order, "strikes are ranked by time");
    }
}

#[test]
fn what_the_embedded_rigs_arm_delivered_is_measured_where_its_state_is_logged() {
    let hidden = Hidden::parse(&["striker_speed_error"]).expect("an effect");
    let mut settings = demo::Settings::new(Shape::Cylinder, 60, 5, Some(hidden));
    settings.log_state = true;
    let Demo { truth, strikes } = read(&settings);
    let delivered: Vec<_> = strikes
        .iter()
        .zip(&truth.strikes)
        .filter_map(|(strike, truth)| Some((strike.delivered?, truth.delivered)))
        .collect();
    assert_eq!(delivered.len(), 60);
    let speed = rms(delivered
        .iter()
        .map(|(delivered, truth)| delivered.tip_speed - truth.speed));
    let angle = rms(delivered
        .iter()
        .map(|(delivered, truth)| delivered.tip_angle - truth.angle));
    println!(
        "delivered: {:.2} mm/s and {:.2} mrad rms",
        1e3 * speed,
        1e3 * angle
    );
    assert!(speed < 1e-3 && angle < 1e-4, "{speed} {angle}");
    assert!(strikes.iter().all(|strike| !strike.is_pushed_again()));
}

#[test]
fn how_a_box_was_put_down_is_read_from_its_poses() {
    let mut settings = demo::Settings::new(Shape::Box, 40, 6, Some(Hidden::none()));
    settings.truth.noise = Hide::parse(&["yaw_scatter"]).expect("a noise").noise;
    settings.log_pose = true;
    let Demo { truth, strikes } = read(&settings);
    assert_eq!(strikes.len(), 40);
    let off = strikes.iter().zip(&truth.strikes).map(|(strike, truth)| {
        let seen = strike.conditions.yaw.expect("it was tracked");
        seen - truth.yaw.expect("it was turned")
    });
    // Eighteen frames of a tracker that is off by 9 mrad in each.
    let off = rms(off);
    assert!(off < 3e-3, "{off} rad");
    let turned = rms(truth.strikes.iter().filter_map(|truth| truth.yaw));
    assert!((0.05..0.09).contains(&turned), "{turned} rad");
}

#[test]
fn a_late_camera_is_measured_where_every_object_moves() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("game.mcap");
    let table = AirTable {
        friction: 0.002,
        tilt: Point::default(),
        restitution: 0.8,
        wall_restitution: 0.9,
        seed: 9,
    };
    table.write(80.0, 0, &log).expect("written");
    let mut rig = AirTable::rig();
    for late in [0.0, 0.012] {
        // Read as if the camera were ahead, it is seen to be late.
        rig.frames.camera_delay = -late;
        let read = ingest_log(&log, &rig, &Ingest::default()).expect("the log is read");
        let delays: Vec<f64> = read.seen.delays.iter().map(|delay| delay.seconds).collect();
        assert!(delays.len() >= 10, "{} touches", delays.len());
        let delay = median(delays).expect("touches");
        assert!((delay - late).abs() < 0.003, "{delay} for {late}");
    }
}
