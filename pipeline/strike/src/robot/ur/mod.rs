//! Universal Robots' e-Series: status and poses by RTDE, lines by URScript, identity by the dashboard. Stopping is `stopl`.
//!
//! Nothing here powers an arm on, releases a brake or clears a protective stop. While carom has the arm, a program of carom's waits on it,
//! and moves each line of a strike when its number comes: Stop on its pendant is seen, and where signs of life cease, the controller itself
//! ends that program and the line that it moves.

mod rtde;

use std::io::{self, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering::Relaxed};
use std::time::{Duration, Instant};

use rtde::{Alive, Stream};

use super::arm::{
    Arm, ArmLimits, CONNECT, Identity, LineRequest, Outlet, Ports, Pose, Reports, Status, connect,
    connect_unread, distance, garbage, listen, version_in,
};
use crate::epoch::Epoch;

/// Deceleration of the arm when it is stopped, in m/s².
const BRAKE: f64 = 8.0;
/// Greatest distance, in m, between places that the controller is asked about, and greatest speed of a joint between them, in rad/s.
const APART: f64 = 0.05;
const FASTEST: f64 = std::f64::consts::PI;
/// A program of carom's replaces the one that runs. It can ask whether a place has a solution, within safety limits as a place and by its
/// joints, and move a line once its number comes; while it waits for that it echoes signs of life. Without ten of these a second in a line,
/// and one while it waits, the controller stops it (URScript's manual; tried on an emulator alone).
const PROGRAM: &str = include_str!("program.script");
/// Step of the questions' numbers: each is a multiple of it, and each line that it asks about has one of the numbers after it.
const TEN: i32 = 10;
/// The oldest software that is driven: its RTDE gives the tool.
const SOFTWARE: (u32, u32) = (5, 11);

/// An arm, connected. Its ports: two that take scripts (primary and secondary interface), RTDE, and the dashboard.
#[derive(Debug)]
pub struct Ur {
    ports: Ports,
    patience: Duration,
    script: TcpStream,
    /// The signs of life, with the number of the line to be moved, or of the last question.
    alive: Alive,
    /// Lines that its program waits for.
    asked: Vec<LineRequest>,
}

fn written(pose: &Pose) -> String {
    let ([x, y, z], [a, b, c]) = (pose.at, pose.turn.to_vector());
    format!("p[{x:.6},{y:.6},{z:.6},{a:.6},{b:.6},{c:.6}]")
}

impl Ur {
    /// A stream of samples over a connection of its own.
    fn samples(&self) -> io::Result<Stream> {
        Stream::start(listen(self.ports[2], self.patience)?, None)
    }

    /// Runs these steps of a program, which then waits for a number that no line has.
    fn run(&self, steps: &str) -> io::Result<()> {
        let text = format!("{PROGRAM}{steps}  wait({})\nend\n", i32::MAX);
        self.alive.0.send(&self.script, text.as_bytes())
    }

    /// The dashboard's answers to these questions.
    fn dashboard<const N: usize>(&self, questions: [&str; N]) -> io::Result<[String; N]> {
        let stream = connect(self.ports[3], self.patience)?;
        let until = Instant::now() + self.patience;
        // It greets first.
        self.alive.0.read_line(&stream, until)?;
        let mut answers = [const { String::new() }; N];
        for (question, answer) in questions.into_iter().zip(&mut answers) {
            (&stream).write_all(format!("{question}\n").as_bytes())?;
            *answer = self.alive.0.read_line(&stream, until)?;
        }
        Ok(answers)
    }
}

impl Arm for Ur {
    const PORTS: [u16; 4] = [30_001, 30_002, 30_004, 29_999];

    fn connect(ports: &Ports, patience: Duration) -> io::Result<Self> {
        let stop = format!("def carom_stop():\n  stopl({BRAKE})\nend\n").into_bytes();
        let [first, spare] = [ports[0], ports[1]].map(|port| connect_unread(port, patience));
        let (first, spare) = (first?, spare?);
        let outlet = Outlet::new(vec![(first.try_clone()?, stop.clone()), (spare, stop)]);
        // No earlier program used it: what that wrote still stands in its registers.
        let now = Epoch::now().stamp(Instant::now()) / 1_000_000 % 100_000_000;
        Ok(Self {
            ports: *ports,
            patience,
            script: first,
            alive: (outlet, Arc::new(AtomicI32::new(TEN * now as i32))),
            asked: Vec::new(),
        })
    }

    fn reports(&self) -> io::Result<Box<dyn Reports>> {
        let stream = listen(self.ports[2], CONNECT)?;
        Ok(Box::new(Stream::start(stream, Some(self.alive.clone()))?))
    }

    fn outlet(&self) -> &Outlet {
        &self.alive.0
    }

    fn identify(&mut self) -> io::Result<Result<Identity, String>> {
        let [software, serial, model] =
            self.dashboard(["PolyscopeVersion", "get serial number", "get robot model"])?;
        let is_new = version_in(&software).is_some_and(|found| found >= SOFTWARE);
        if serial.is_empty() || !model.starts_with("UR") || !is_new {
            let (major, minor) = SOFTWARE;
            return Ok(Err(format!(
                "the controller says that it is `{model}` with the serial number `{serial}` and `{software}`: this drives a UR with \
                 software {major}.{minor} or later"
            )));
        }
        let limits = ArmLimits {
            speed: 1.0,
            acceleration: 10.0,
            jerk: None,
            start: Duration::from_millis(60),
        };
        Ok(Ok(Identity { serial, limits }))
    }

    fn status(&mut self) -> io::Result<Status> {
        let [remote] = self.dashboard(["is in remote control"])?;
        let sample = self.samples()?.next()?;
        let slider = sample.slider * 100.0;
        let wrong = [
            (remote != "true").then(|| {
                "the arm is not in remote control: whoever has its pendant is in charge; set it so there".into()
            }),
            (slider.is_nan() || slider < 99.9).then(|| {
                format!("its speed slider stands at {slider:.0} %; set it to 100 % on its pendant")
            }),
        ];
        let wrong = wrong.into_iter().flatten().collect();
        Ok(Status::enabled(sample.tool, sample.payload, wrong))
    }

    fn pose(&mut self) -> io::Result<Pose> {
        Ok(self.samples()?.next()?.report.pose)
    }

    fn enable(&mut self, go_on: &mut dyn FnMut() -> io::Result<()>) -> io::Result<()> {
        go_on()?;
        self.run("")
    }

    /// Has carom's program on the arm ask about places along the lines and write the answer into a register; the program then waits for the lines.
    fn can_move(&mut self, lines: &[LineRequest]) -> io::Result<Result<(), (usize, String)>> {
        let mut samples = self.samples()?;
        let mut from = samples.next()?.report.pose.at;
        let question = (self.alive.1.load(Relaxed) / TEN + 1) * TEN;
        self.alive.1.store(question, Relaxed);
        let (mut asks, mut moves) = (String::new(), String::new());
        self.asked = lines.to_vec();
        for (number, line) in (1..).zip(lines) {
            for at in line.places(from, APART) {
                let most = FASTEST * distance(from, at) / line.speed;
                let place = written(&Pose { at, ..line.to });
                asks += &format!("  ask({place}, {number}, {most:.4})\n");
                from = at;
            }
            let (number, to) = (question + number, written(&line.to));
            let (acceleration, speed) = (line.acceleration, line.speed);
            moves += &format!("  line({number}, {to}, {acceleration:.6}, {speed:.6})\n");
        }
        self.run(&format!(
            "{asks}  write_output_integer_register(24, {question} + wrong)\n{moves}"
        ))?;
        let until = Instant::now() + self.patience;
        while Instant::now() < until {
            // The line's number, from 1.
            let wrong = samples.next()?.answer.wrapping_sub(question);
            if (0..=lines.len() as i32).contains(&wrong) {
                let why = "it leaves the arm's reach, safety planes or joint limits, or a joint would turn too fast; lay the object elsewhere";
                let line = (wrong as usize).checked_sub(1);
                return Ok(line.map_or(Ok(()), |line| Err((line, why.into()))));
            }
        }
        Err(io::ErrorKind::TimedOut.into())
    }

    /// Moves a line that the controller was asked about: its number goes out with the next sign of life.
    fn line(&mut self, line: &LineRequest) -> io::Result<()> {
        let at = self.asked.iter().position(|asked| asked == line);
        let at = at.ok_or_else(|| garbage("the controller was not asked about this line"))?;
        let question = self.alive.1.load(Relaxed) / TEN * TEN;
        self.alive.1.store(question + 1 + at as i32, Relaxed);
        Ok(())
    }
}
