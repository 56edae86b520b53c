//! Logs of the embedded rig, as they should be and as labs make them on their first day: each message is read, changed and written anew.

use std::path::{Path, PathBuf};

use logs::write::{RecordingWriter, Samples, Stamped, StateSample};
use logs::{Event, Limits, TopicRequest};
use rig::{Hide, PlannedStrike, demo};
use values::{Point, Rig, Shape};

/// A rig file and the sessions that were logged with it.
#[derive(Clone, Debug)]
pub struct Lab {
    pub rig: Rig,
    pub sessions: Vec<Samples>,
}

/// What a lab does wrong.
pub const MISTAKES: [&str; 12] = [
    "the camera's y axis is mirrored",
    "the camera's x axis is mirrored",
    "the tracker's axes are swapped",
    "the arm's base is turned by 30°",
    "the arm's base is turned by −90°",
    "commands are in the tool's frame",
    "the camera is 3 s late",
    "the camera is 2 s early",
    "commands belong to other strikes",
    "the camera is another session's",
    "centroids are in feet",
    "the rig file states another arm's limits",
];

/// A lab whose logs are as they should be.
pub fn lab(
    shape: Shape,
    strikes: usize,
    seed: u64,
    hide: &[&str],
    plan: Option<Vec<PlannedStrike>>,
) -> Lab {
    logged(shape, strikes, seed, hide, plan, false)
}

/// A lab whose arm's state is logged, too, if it is to be.
pub fn logged(
    shape: Shape,
    strikes: usize,
    seed: u64,
    hide: &[&str],
    plan: Option<Vec<PlannedStrike>>,
    log_state: bool,
) -> Lab {
    let folder = tempfile::tempdir().expect("a folder");
    let hide = Hide::parse(hide).expect("known effects");
    let mut settings = demo::Settings::new(shape, strikes, seed, Some(hide.hidden));
    settings.truth.noise = hide.noise;
    settings.plan = plan;
    settings.log_state = log_state;
    let written = demo::write(&settings, folder.path()).expect("writes");
    let rig = Rig::load(&written.rig).expect("a rig file");
    let sessions = written.logs.iter().map(|log| read(log, &rig)).collect();
    Lab { rig, sessions }
}

fn read(log: &Path, rig: &Rig) -> Samples {
    let topics = &rig.topics;
    let position = [
        topics.state.position_x.clone(),
        topics.state.position_y.clone(),
    ];
    let wanted = |topic, more, required| TopicRequest {
        topic,
        more,
        required,
    };
    let topics: [TopicRequest<'_>; 3] = [
        wanted(&topics.centroid, &[][..], true),
        wanted(&topics.command, &[], true),
        wanted(&topics.state.topic, &position, false),
    ];
    let mut samples = Samples::default();
    logs::read(log, &topics, Limits::default(), &mut |event| match event {
        Event::Sample(topic, sample) => {
            let stamped = Stamped {
                stamp: sample.stamp as u64,
                x: sample.x,
                y: sample.y,
            };
            if topic == 0 {
                samples.centroids.push(stamped);
            } else {
                samples.commands.push(stamped);
            }
        }
        Event::Extended(_, sample, more) => samples.states.push(StateSample {
            stamp: sample.stamp as u64,
            position: [more[0], more[1]],
            velocity: [sample.x, sample.y],
        }),
        Event::Lost(_) => panic!("a demo's log is whole"),
    })
    .expect("a demo's log");
    samples
}

impl Lab {
    /// Writes the logs into a folder, and gives their paths.
    pub fn write(&self, folder: &Path) -> Vec<PathBuf> {
        std::fs::create_dir_all(folder).expect("a folder");
        let write = |(number, samples): (usize, &Samples)| {
            let path = folder.join(format!("session_{number}.mcap"));
            let mut writer = RecordingWriter::create(&path, &self.rig.topics).expect("creates");
            writer.write(samples).expect("writes");
            writer.finish().expect("finishes");
            path
        };
        self.sessions.iter().enumerate().map(write).collect()
    }

    /// This lab making one of [`MISTAKES`], or another one that a test of the check makes.
    pub fn mistaken(mut self, mistake: &str) -> Self {
        match mistake {
            "the camera's y axis is mirrored" => self.each_centroid(|p| Point::new(p.x, -p.y)),
            "the camera's x axis is mirrored" => self.each_centroid(|p| Point::new(1.1 - p.x, p.y)),
            "the tracker's axes are swapped" => self.each_centroid(|p| Point::new(p.y, p.x)),
            "the arm's base is turned by 30°" => {
                self.each_command(|v| v.rotated(-30f64.to_radians()))
            }
            "the arm's base is turned by −90°" => {
                self.each_command(|v| v.rotated(90f64.to_radians()))
            }
            "commands are in the tool's frame" => self.each_command(|v| Point::new(v.norm(), 0.0)),
            "the camera is 3 s late" => self.each_camera_stamp(3_000_000_000),
            "the camera is 2 s early" => self.each_camera_stamp(-2_000_000_000),
            "commands belong to other strikes" => self.sessions.iter_mut().for_each(shuffle),
            "the camera is another session's" => {
                // Its strikes came as often, and in another rhythm.
                for samples in &mut self.sessions {
                    let first = samples.centroids.first().map_or(0, |c| c.stamp);
                    for (i, centroid) in samples.centroids.iter_mut().enumerate() {
                        let since = centroid.stamp - first;
                        centroid.stamp = first + since * 11 / 10 + (i as u64 % 2);
                    }
                }
            }
            "centroids are in feet" => self.each_centroid(|p| p * (1.0 / 0.3048)),
            "commands are a speed and an angle" => self.each_command(|v| polar(v, 1.0)),
            "commands are a speed and an angle in degrees" => {
                self.each_command(|v| polar(v, 180.0 / std::f64::consts::PI));
            }
            "commands are an angle and a speed" => self.each_command(|v| {
                let polar = polar(v, 1.0);
                Point::new(polar.y, polar.x)
            }),
            "the tracker gives means of nine frames" => self.sessions.iter_mut().for_each(smooth),
            "the tracker's places follow slowly" => self.sessions.iter_mut().for_each(follow),
            "the camera is 60 ms late in one log" => {
                let centroids = self.sessions[1].centroids.iter_mut();
                centroids.for_each(|c| c.stamp += 60_000_000);
            }
            "the arm's state is 0.2 s late" => {
                let states = self.sessions.iter_mut().flat_map(|s| &mut s.states);
                states.for_each(|state| state.stamp += 200_000_000);
            }
            "no command is logged, and the camera is 80 ms late" => {
                self.sessions.iter_mut().for_each(|s| s.commands.clear());
                self.each_camera_stamp(80_000_000);
            }
            "the commands of one log are in km/h" => {
                for command in &mut self.sessions[1].commands {
                    (command.x, command.y) = (3.6 * command.x, 3.6 * command.y);
                }
            }
            "the camera's scale is 6 % too great" => self.each_centroid(|p| p * 1.06),
            "the camera was moved between sessions" => {
                for centroid in &mut self.sessions[1].centroids {
                    (centroid.x, centroid.y) = (centroid.x + 0.06, centroid.y + 0.03);
                }
            }
            "the camera was turned between sessions" => {
                let moved = self.sessions.iter_mut().skip(1).take(1);
                for centroid in moved.flat_map(|s| &mut s.centroids) {
                    let turned = Point::new(centroid.x, centroid.y).rotated(0.2);
                    (centroid.x, centroid.y) = (turned.x, turned.y);
                }
            }
            "the camera was turned while a log ran" => {
                let centroids = &mut self.sessions[0].centroids;
                let half = centroids.len() / 2;
                for centroid in &mut centroids[half..] {
                    let turned = Point::new(centroid.x, centroid.y).rotated(0.3);
                    (centroid.x, centroid.y) = (turned.x, turned.y);
                }
            }
            "commands are in the tool's frame from the middle of a log on" => {
                let commands = &mut self.sessions[0].commands;
                let half = commands.len() / 2;
                for command in &mut commands[half..] {
                    (command.x, command.y) = (command.x.hypot(command.y), 0.0);
                }
            }
            "the camera's clock was set while a log ran" => {
                let centroids = &mut self.sessions[0].centroids;
                let half = centroids.len() / 2;
                let late = centroids[half..].iter_mut();
                late.for_each(|c| c.stamp += 2_000_000_000);
            }
            "the mass is in grams over ten" => self.rig.object.mass *= 100.0,
            "a log was played back and recorded again" => {
                let mut again = self.sessions[0].clone();
                let later = |stamp: &mut u64| *stamp += 40_000_000_000_000;
                again.centroids.iter_mut().for_each(|c| later(&mut c.stamp));
                again.commands.iter_mut().for_each(|c| later(&mut c.stamp));
                again.states.iter_mut().for_each(|s| later(&mut s.stamp));
                self.sessions.push(again);
            }
            "the table's bounds are exchanged" => {
                let table = &mut self.rig.table;
                std::mem::swap(&mut table.x, &mut table.y);
            }
            "two objects are tracked in turns" => self.another_object(2),
            "another object is seen in every third frame" => self.another_object(3),
            "the rig file states another arm's limits" => self.rig.robot.speed = [1.2, 2.5].into(),
            other => panic!("no mistake is called {other}"),
        }
        self
    }

    /// One in so many frames sees another object.
    fn another_object(&mut self, one_in: usize) {
        for samples in &mut self.sessions {
            for centroid in samples.centroids.iter_mut().step_by(one_in) {
                (centroid.x, centroid.y) = (0.85, -0.3);
            }
        }
    }

    fn each_centroid(&mut self, change: impl Fn(Point) -> Point) {
        for centroid in self.sessions.iter_mut().flat_map(|s| &mut s.centroids) {
            let changed = change(Point::new(centroid.x, centroid.y));
            (centroid.x, centroid.y) = (changed.x, changed.y);
        }
    }

    fn each_command(&mut self, change: impl Fn(Point) -> Point) {
        for command in self.sessions.iter_mut().flat_map(|s| &mut s.commands) {
            let changed = change(Point::new(command.x, command.y));
            (command.x, command.y) = (changed.x, changed.y);
        }
    }

    fn each_camera_stamp(&mut self, by: i64) {
        for centroid in self.sessions.iter_mut().flat_map(|s| &mut s.centroids) {
            centroid.stamp = centroid.stamp.saturating_add_signed(by);
        }
    }
}

/// Each centroid is the mean of the last nine.
fn smooth(samples: &mut Samples) {
    let seen = samples.centroids.clone();
    for (last, centroid) in samples.centroids.iter_mut().enumerate() {
        let of = &seen[last.saturating_sub(8)..=last];
        let count = of.len() as f64;
        centroid.x = of.iter().map(|c| c.x).sum::<f64>() / count;
        centroid.y = of.iter().map(|c| c.y).sum::<f64>() / count;
    }
}

/// Each centroid follows the last one by an exponential mean of 50 ms.
fn follow(samples: &mut Samples) {
    for i in 1..samples.centroids.len() {
        let last = samples.centroids[i - 1];
        let centroid = &mut samples.centroids[i];
        let gone = (centroid.stamp - last.stamp) as f64 * 1e-9;
        let gain = 1.0 - f64::exp(-gone / 0.05);
        centroid.x = last.x + gain * (centroid.x - last.x);
        centroid.y = last.y + gain * (centroid.y - last.y);
    }
}

/// A velocity as its norm and its angle, in units of which so many are one rad; zero while it is idle.
fn polar(velocity: Point, unit: f64) -> Point {
    match velocity.norm() {
        speed if speed > 0.0 => Point::new(speed, unit * velocity.bearing()),
        _ => velocity,
    }
}

/// Each strike is commanded what another one was: runs of commands that are not zero exchange their directions and speeds.
fn shuffle(samples: &mut Samples) {
    let is_active = |c: &Stamped| c.x.hypot(c.y) > 1e-9;
    let commands = &mut samples.commands;
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (i, command) in commands.iter().enumerate() {
        if !is_active(command) {
            continue;
        }
        match runs.last_mut() {
            Some((_, end)) if *end == i => *end = i + 1,
            _ => runs.push((i, i + 1)),
        }
    }
    let of = |commands: &[Stamped], (from, to): (usize, usize)| {
        let sum = commands[from..to]
            .iter()
            .fold(Point::default(), |sum, c| sum + Point::new(c.x, c.y));
        let top = commands[from..to]
            .iter()
            .map(|c| c.x.hypot(c.y))
            .fold(0.0, f64::max);
        (top, sum.bearing())
    };
    let all: Vec<(f64, f64)> = runs.iter().map(|run| of(commands, *run)).collect();
    for (i, run) in runs.iter().enumerate() {
        // Far enough to be another's.
        let (speed, angle) = all[(i * 7 + 3) % all.len()];
        let (own_speed, own_angle) = all[i];
        for command in &mut commands[run.0..run.1] {
            let turned =
                Point::new(command.x, command.y).rotated(angle - own_angle) * (speed / own_speed);
            (command.x, command.y) = (turned.x, turned.y);
        }
    }
}

/// Labs that differ in object, effects, noise and sessions.
pub fn labs(strikes: usize, seed: u64) -> Vec<(&'static str, Lab)> {
    let hides: [(&str, Shape, &[&str]); 8] = [
        ("a cylinder, nothing hidden", Shape::Cylinder, &["none"]),
        ("the demo's mixture", Shape::Cylinder, &["demo"]),
        ("a box, the demo's mixture", Shape::Box, &["demo"]),
        ("a ball", Shape::Sphere, &["none"]),
        (
            "an arm that is 3° off",
            Shape::Cylinder,
            &["striker_angle_bias=0.0524"],
        ),
        (
            "a strong tilt and a patch",
            Shape::Cylinder,
            &["table_tilt=0.02,0.015", "friction_patch"],
        ),
        (
            "sessions that differ",
            Shape::Cylinder,
            &[
                "friction_by_session=spread:0.15",
                "striker_angle_by_session=spread:0.03",
            ],
        ),
        (
            "noise of a real table",
            Shape::Cylinder,
            &[
                "friction_scatter=0.03",
                "camera_correlation=0.6",
                "stray_frames",
                "table_bowl",
            ],
        ),
    ];
    hides
        .into_iter()
        .zip(seed..)
        .map(|((name, shape, hide), seed)| (name, lab(shape, strikes, seed, hide, None)))
        .collect()
}

/// The plans of narrow designs: one angle, one speed, one place, repeats of four commands.
pub fn narrow(design: usize, strikes: usize) -> Option<Vec<PlannedStrike>> {
    let part = |i: usize, k: f64| (k * i as f64 + 0.31).fract();
    let planned = |i: usize| {
        let (x0, y0) = (0.25 + 0.15 * part(i, 0.618), -0.12 + 0.24 * part(i, 0.754));
        let (speed, angle) = (0.45 + 0.4 * part(i, 0.414), -0.4 + 0.8 * part(i, 0.732));
        match design {
            1 => PlannedStrike {
                x0,
                y0,
                speed,
                angle: 0.3,
            },
            2 => PlannedStrike {
                x0,
                y0,
                speed: 0.6,
                angle,
            },
            3 => PlannedStrike {
                x0: 0.3,
                y0: 0.0,
                speed,
                angle,
            },
            _ => PlannedStrike {
                x0: 0.3,
                y0: 0.0,
                speed: 0.5 + 0.1 * (i % 4) as f64,
                angle: -0.2 + 0.2 * (i % 3) as f64,
            },
        }
    };
    (design > 0).then(|| (0..strikes).map(planned).collect())
}
