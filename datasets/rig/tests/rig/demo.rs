//! What a demo folder holds, read back by the `mcap` crate.
use std::path::Path;
use std::time::Instant;

use rig::demo::{Settings, write};
use rig::{Effect, Hidden, PlannedStrike, Sim, StrikeIndex, Truth};
use values::{Command, Point, Rig, Shape};

fn bytes(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = std::fs::read_dir(folder.join("logs"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.extend([folder.join("rig.toml"), folder.join("truth.json")]);
    files.sort();
    files
        .iter()
        .map(|path| (path.display().to_string(), std::fs::read(path).unwrap()))
        .collect()
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let write = |seed| {
        let folder = tempfile::tempdir().unwrap();
        write(&Settings::new(Shape::Box, 12, seed, None), folder.path()).unwrap();
        bytes(folder.path())
            .into_iter()
            .map(|(_, bytes)| bytes)
            .collect::<Vec<_>>()
    };
    assert_eq!(write(3), write(3));
    assert_ne!(write(3)[0], write(4)[0]);
}

#[test]
fn of_an_earlier_demo_nothing_is_left_and_what_is_no_session_stays() {
    let folder = tempfile::tempdir().unwrap();
    let logs = |strikes| {
        write(
            &Settings::new(Shape::Cylinder, strikes, 1, Some(Hidden::none())),
            folder.path(),
        )
        .unwrap();
        let mut names: Vec<_> = std::fs::read_dir(folder.path().join("logs"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    assert_eq!(logs(20), ["session_000.mcap", "session_001.mcap"]);
    std::fs::write(folder.path().join("logs/session_of_mine.mcap"), "").unwrap();
    assert_eq!(logs(3), ["session_000.mcap", "session_of_mine.mcap"]);
}

#[test]
fn a_filmed_demo_that_is_stopped_leaves_no_log_without_images() {
    let folder = tempfile::tempdir().unwrap();
    let mut settings = Settings::new(Shape::Cylinder, 2, 1, Some(Hidden::none()));
    settings.sessions = Some(2);
    settings.truth.rig = rig::film::with_camera(settings.truth.rig);
    assert_eq!(settings.truth.rig.camera.size, Some([640, 480]));
    // What stands in the place of the second log stops it there.
    let second = folder.path().join("logs/session_001.mcap");
    std::fs::create_dir_all(second.join("something")).unwrap();
    write(&settings, folder.path()).unwrap_err();
    assert!(!folder.path().join("rig.toml").exists());
    std::fs::remove_dir_all(&second).unwrap();
    let topic = |topic: &str, log: &Path| {
        let log = std::fs::read(log).unwrap();
        let mut messages = mcap::MessageStream::new(&log).unwrap();
        messages.any(|message| message.unwrap().channel.topic == topic)
    };
    let logs = std::fs::read_dir(folder.path().join("logs")).unwrap();
    let logs = logs.map(|log| log.unwrap().path());
    let logs: Vec<_> = logs
        .filter(|log| log.extension().is_some_and(|end| end == "mcap"))
        .collect();
    assert_eq!(logs.len(), 1);
    assert!(topic("/camera/image/compressed", &logs[0]));
    assert!(!topic(&settings.truth.rig.topics.centroid.name, &logs[0]));
}

#[test]
fn a_log_reads_back_with_every_frame_and_command() {
    let folder = tempfile::tempdir().unwrap();
    let settings = Settings {
        log_state: true,
        log_pose: false,
        ..Settings::new(Shape::Cylinder, 60, 1, None)
    };
    let written = write(&settings, folder.path()).unwrap();
    assert_eq!(written.logs.len(), 4);
    let truth = Truth::load(&written.truth).unwrap();
    assert_eq!(truth.strikes.len(), 60);
    let mut sim = Sim::from_truth(&written.truth).unwrap().logging_state();
    let mut expected = 0;
    for strike in &truth.strikes {
        let recording = sim.strike(truth.see(strike.initial, strike.index()), strike.command);
        expected += recording.samples.centroids.len()
            + recording.samples.commands.len()
            + recording.samples.states.len();
    }
    let mut found = 0;
    for log in &written.logs {
        let data = std::fs::read(log).unwrap();
        let mut last = 0;
        for message in mcap::MessageStream::new(&data).unwrap() {
            let message = message.unwrap();
            assert!(message.log_time >= last, "messages stand in order of time");
            last = message.log_time;
            found += 1;
        }
    }
    assert_eq!(found, expected);
    assert_eq!(Rig::load(&written.rig).unwrap(), truth.rig);
}

#[test]
fn random_strikes_start_where_the_arm_reaches_and_stay_on_the_table() {
    for shape in [Shape::Cylinder, Shape::Box, Shape::Sphere] {
        let folder = tempfile::tempdir().unwrap();
        let written = write(&Settings::new(shape, 80, 5, None), folder.path()).unwrap();
        let truth = Truth::load(&written.truth).unwrap();
        for strike in &truth.strikes {
            let seen = truth.see(strike.initial, strike.index());
            assert!((0.2..=0.4).contains(&seen.x) && (-0.2..=0.2).contains(&seen.y));
            assert!(truth.rig.robot.speed.contains(strike.command.speed));
            assert!(truth.rig.table.contains(strike.stop) && strike.rest_time > 0.1);
        }
    }
}

#[test]
fn a_plan_is_made_as_it_stands_and_a_wrong_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let strike = PlannedStrike {
        x0: 0.3,
        y0: 0.05,
        speed: 0.7,
        angle: 0.1,
    };
    let plan = |plan| Settings {
        plan: Some(plan),
        ..Settings::new(Shape::Cylinder, 9, 1, Some(Hidden::none()))
    };
    let written = write(&plan(vec![strike, strike]), folder.path()).unwrap();
    let truth = Truth::load(&written.truth).unwrap();
    assert_eq!(truth.strikes.len(), 2);
    assert_eq!(truth.strikes[1].command, Command::new(0.7, 0.1));
    let error = write(
        &plan(vec![PlannedStrike {
            x0: f64::NAN,
            ..strike
        }]),
        folder.path(),
    )
    .unwrap_err();
    assert!(error.to_string().contains("strike 0"), "{error}");
}

#[test]
fn five_hundred_strikes_take_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let start = Instant::now();
    write(&Settings::new(Shape::Box, 500, 1, None), folder.path()).unwrap();
    let size: u64 = bytes(folder.path())
        .iter()
        .map(|(_, bytes)| bytes.len() as u64)
        .sum();
    println!(
        "500 strikes: {:.2} s, {:.1} MB",
        start.elapsed().as_secs_f64(),
        size as f64 / 1e6
    );
    assert!(start.elapsed().as_secs_f64() < 20.0);
}

#[test]
fn launches_scatter_by_what_the_truth_says() {
    let rig = Truth::demo_rig(Shape::Cylinder);
    let mut truth = Truth {
        hidden: Hidden::none(),
        ..Truth::demo(&rig, 11)
    };
    truth.rig.camera.rate = 5.0;
    let mut sim = Sim::from(truth).unwrap();
    let command = Command::new(0.7, 0.2);
    let delivered: Vec<Command> = (0..2000)
        .map(|_| sim.strike(Point::new(0.3, 0.0), command).truth.delivered)
        .collect();
    let sd = |of: fn(&Command) -> f64| {
        let mean = delivered.iter().map(of).sum::<f64>() / 2000.0;
        (
            mean,
            (delivered
                .iter()
                .map(|d| (of(d) - mean).powi(2))
                .sum::<f64>()
                / 1999.0)
                .sqrt(),
        )
    };
    let ((speed, speed_sd), (angle, angle_sd)) = (sd(|d| d.speed), sd(|d| d.angle));
    assert!((speed - 0.7).abs() < 4e-4 && (angle - 0.2).abs() < 5e-4);
    assert!((speed_sd / 0.7 / 0.006 - 1.0).abs() < 0.06, "{speed_sd}");
    assert!(
        (angle_sd / 0.3f64.to_radians() - 1.0).abs() < 0.06,
        "{angle_sd}"
    );
}

#[test]
fn frames_are_lost_and_noisy_as_the_truth_says() {
    let truth = Truth {
        hidden: Hidden::none(),
        ..Truth::demo(&Truth::demo_rig(Shape::Cylinder), 2)
    };
    let mut sim = Sim::from(truth).unwrap();
    let (mut seen, mut possible, mut squares, mut resting) = (0usize, 0.0, 0.0, 0.0);
    for _ in 0..300 {
        let recording = sim.strike(Point::new(0.3, 0.0), Command::new(0.6, 0.0));
        let frames = &recording.samples.centroids;
        seen += frames.len() - 1;
        possible += ((frames[frames.len() - 1].stamp - frames[0].stamp) as f64 * 60e-9).round();
        for frame in frames
            .iter()
            .filter(|frame| frame.stamp < recording.truth.impact)
        {
            squares += (frame.x - 0.3).powi(2) + frame.y.powi(2);
            resting += 2.0;
        }
    }
    let lost: f64 = 1.0 - seen as f64 / possible;
    assert!((lost - 0.01).abs() < 0.003, "{lost}");
    assert!(((squares / resting).sqrt() / 0.0007 - 1.0).abs() < 0.03);
}

#[test]
fn every_hidden_effect_moves_what_the_camera_sees() {
    let rig = Truth::demo_rig(Shape::Cylinder);
    let plain = Truth {
        hidden: Hidden::none(),
        ..Truth::demo(&rig, 1)
    };
    let (middle, aside) = (Point::new(0.3, 0.0), Point::new(0.25, 0.08));
    let strikes = [
        (middle, 0.9, 0.15),
        (middle, 0.6, 0.0),
        (middle, 1.0, -0.4),
        (aside, 0.9, -0.1),
    ];
    for effect in Effect::all() {
        let truth = Truth {
            hidden: Hidden(vec![effect]),
            ..plain.clone()
        };
        let moved = strikes.iter().map(|&(initial, speed, angle)| {
            let index = StrikeIndex {
                session: 1,
                order: 67,
            };
            let command = Command { speed, angle };
            let stop = |truth: &Truth| truth.expected_stop(initial, command, index).unwrap();
            stop(&truth).distance(stop(&plain))
        });
        let most = moved.fold(0.0, f64::max);
        println!(
            "{:28} moves the stop by up to {:5.1} mm",
            effect.name(),
            most * 1e3
        );
        assert!(most > 2e-3, "{} moves the stop by {most} m", effect.name());
    }
}
