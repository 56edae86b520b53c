//! Universal Robots' e-Series: status and poses by RTDE, lines by URScript, identity by the dashboard. Stopping is `stopl`.
//!
//! Nothing here powers an arm on, releases a brake or clears a protective stop. While carom has the arm, a program of carom's waits on it:
//! Stop on its pendant is seen, and where signs of life cease, the controller itself ends that program and the line that it moves.

mod rtde;

use std::io::{self, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use rtde::{LIFE, Stream, number};

use super::arm::{
    Arm, ArmLimits, CONNECT, Identity, LineRequest, Outlet, Ports, Pose, Reports, Status, connect,
    connect_unread, distance, listen, version_in,
};

/// How the arm brakes when it is stopped, in m/s².
const BRAKE: f64 = 8.0;
/// Signs of life a second, without which the controller stops a line, and ends a program that only waits.
const LEAST_LIFE: (f64, f64) = (10.0, 1.0);
/// The controller is asked about places so far apart at the most, in m, and whether no joint turns faster between them, in rad/s.
const APART: f64 = 0.05;
const FASTEST: f64 = std::f64::consts::PI;
/// A place has a solution, within safety limits as a place and by its joints (URScript's manual; tried on an emulator alone).
const ASK: &str = include_str!("ask.script");
/// The oldest software that is driven: its RTDE gives the tool.
const SOFTWARE: (u32, u32) = (5, 11);

/// An arm, connected. Its ports: two that take scripts (primary and secondary interface), RTDE, and the dashboard.
#[derive(Debug)]
pub struct Ur {
    ports: Ports,
    patience: Duration,
    script: TcpStream,
    outlet: Outlet,
}

/// A script that replaces the one that runs, and after its lines waits for the next one, shown by an echo of the signs of life. Without
/// these, the controller stops it (URScript's manual, `rtde_set_watchdog`).
fn waiting(name: &str, lines: &str) -> Vec<u8> {
    let guarded = |least: f64| format!("  rtde_set_watchdog(\"{LIFE}\", {least}, \"stop\")\n");
    let (on_line, idle) = (guarded(LEAST_LIFE.0), guarded(LEAST_LIFE.1));
    format!(
        "def carom_{name}():\n{on_line}{lines}{idle}  while (True):\n    \
         write_output_integer_register(25, read_input_integer_register(24))\n    sync()\n  end\nend\n"
    )
    .into_bytes()
}

/// A pose as URScript writes it.
fn written(pose: &Pose) -> String {
    let ([x, y, z], [a, b, c]) = (pose.at, pose.turn.to_vector());
    format!("p[{x:.6},{y:.6},{z:.6},{a:.6},{b:.6},{c:.6}]")
}

fn stream(ports: &Ports, patience: Duration, alive: Option<&Outlet>) -> io::Result<Stream> {
    Stream::start(listen(ports[2], patience)?, alive)
}

impl Ur {
    /// What the dashboard answers to each of these.
    fn dashboard<const N: usize>(&self, questions: [&str; N]) -> io::Result<[String; N]> {
        let stream = connect(self.ports[3], self.patience)?;
        let until = Instant::now() + self.patience;
        // It greets first.
        self.outlet.read_line(&stream, until)?;
        let mut answers = [const { String::new() }; N];
        for (question, answer) in questions.into_iter().zip(&mut answers) {
            (&stream).write_all(format!("{question}\n").as_bytes())?;
            *answer = self.outlet.read_line(&stream, until)?;
        }
        Ok(answers)
    }
}

impl Drop for Ur {
    fn drop(&mut self) {
        self.outlet.close();
    }
}

impl Arm for Ur {
    const PORTS: [u16; 4] = [30_001, 30_002, 30_004, 29_999];

    fn connect(ports: &Ports, patience: Duration) -> io::Result<Self> {
        let stop = format!("def carom_stop():\n  stopl({BRAKE})\nend\n").into_bytes();
        let script = |number: usize| connect_unread(ports[number], patience);
        let (first, spare) = (script(0)?, script(1)?);
        let outlet = Outlet::new(vec![(first.try_clone()?, stop.clone()), (spare, stop)]);
        Ok(Self {
            ports: *ports,
            patience,
            script: first,
            outlet,
        })
    }

    fn reports(ports: &Ports, outlet: &Outlet) -> io::Result<Box<dyn Reports>> {
        Ok(Box::new(stream(ports, CONNECT, Some(outlet))?))
    }

    fn outlet(&self) -> &Outlet {
        &self.outlet
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
            start: Duration::from_millis(100),
        };
        Ok(Ok(Identity { serial, limits }))
    }

    fn status(&mut self) -> io::Result<Status> {
        let [remote] = self.dashboard(["is in remote control"])?;
        let sample = stream(&self.ports, self.patience, None)?.next()?;
        let slider = sample.slider * 100.0;
        let wrong = [
            (remote != "true").then(|| {
                "the arm is not in remote control: whoever has its pendant is in charge; set it so there".into()
            }),
            (slider.is_nan() || slider < 99.9).then(|| {
                format!("its speed slider stands at {slider:.0} %; set it to 100 % on its pendant")
            }),
        ];
        // Where motors are off or brakes closed, reports say that it is held.
        let wrong = wrong.into_iter().flatten().collect();
        Ok(Status::enabled(sample.tool, sample.payload, wrong))
    }

    fn pose(&mut self) -> io::Result<Pose> {
        let sample = stream(&self.ports, self.patience, None)?.next()?;
        Ok(sample.report.pose)
    }

    fn enable(&mut self, go_on: &mut dyn FnMut() -> io::Result<()>) -> io::Result<()> {
        go_on()?;
        self.outlet.send(&self.script, &waiting("wait", ""))
    }

    /// A script asks about places along the lines, and writes the answer into a register.
    fn can_move(&mut self, lines: &[LineRequest]) -> io::Result<Result<(), (usize, String)>> {
        let mut stream = stream(&self.ports, self.patience, None)?;
        let mut from = stream.next()?.report.pose.at;
        let mut text = ASK.to_owned();
        for (number, line) in (1..).zip(lines) {
            for at in line.places(from, APART) {
                let most = FASTEST * distance(from, at) / line.speed;
                let place = written(&Pose { at, ..line.to });
                text += &format!("  ask({place}, {number}, {most:.4})\n");
                from = at;
            }
        }
        // The line's number is the last digit.
        let question = number();
        text += &format!("  write_output_integer_register(24, {question}0 + wrong)\n");
        self.outlet.send(&self.script, &waiting("ask", &text))?;
        let until = Instant::now() + self.patience;
        while Instant::now() < until {
            let answer = stream.next()?.answer;
            if answer / 10 == question {
                let why = "it leaves the arm's reach, safety planes or joint limits, or a joint would turn too fast; lay the object elsewhere";
                let line = ((answer % 10) as usize).checked_sub(1);
                return Ok(line.map_or(Ok(()), |line| Err((line, why.into()))));
            }
        }
        Err(io::ErrorKind::TimedOut.into())
    }

    fn line(&mut self, line: &LineRequest) -> io::Result<()> {
        let (to, speed, acceleration) = (written(&line.to), line.speed, line.acceleration);
        let text = format!("  movel({to}, a={acceleration:.6}, v={speed:.6})\n");
        self.outlet.send(&self.script, &waiting("line", &text))
    }
}
