//! Universal Robots' e-Series: status and poses by RTDE, lines by URScript, identity by the dashboard. Stopping is `stopl`.
//!
//! Nothing here powers an arm on, releases a brake or clears a protective stop: that is its pendant's.

mod rtde;

use std::io::{self, ErrorKind, Read, Write};
use std::net::{IpAddr, Shutdown, SocketAddr, TcpStream, ToSocketAddrs};
use std::thread;
use std::time::{Duration, Instant};

use super::arm::{
    Arm, ArmLimits, CONNECT, Condition, Identity, LineRequest, Outlet, Pose, Report, Reports, Said,
    Status, Turn, connect,
};
use crate::epoch::Epoch;
pub use rtde::RTDE_PORT;
use rtde::Stream;

/// Ports of scripts (primary and secondary interface), and of the dashboard.
pub const SCRIPT_PORTS: [u16; 2] = [30_001, 30_002];
/// Port of the dashboard.
pub const DASHBOARD_PORT: u16 = 29_999;
/// The reader of reports comes back this often, so that it ends with the program's use of the arm.
const SILENT: Duration = Duration::from_secs(1);
/// How the arm brakes when it is stopped, in m/s².
const BRAKE: f64 = 8.0;
/// Modes and states in which an arm takes lines.
const RUNNING: i32 = 7;
const NORMAL: i32 = 1;
const NO_PROGRAM: i32 = 1;
const PROGRAM: i32 = 2;
/// The oldest software whose RTDE gives the tool and whose scripts answer about kinematics.
const SOFTWARE: (u32, u32) = (5, 11);

/// Addresses of an arm's ports.
#[derive(Clone, Copy, Debug)]
pub struct Ports {
    /// Two that take scripts.
    pub scripts: [SocketAddr; 2],
    /// RTDE.
    pub rtde: SocketAddr,
    /// The dashboard.
    pub dashboard: SocketAddr,
}

impl Ports {
    /// The maker's ports of a host. Errors where the name is not known.
    pub fn of(host: &str) -> io::Result<Self> {
        let address = (host, RTDE_PORT)
            .to_socket_addrs()?
            .next()
            .ok_or_else(|| io::Error::other("the name has no address"))?;
        let ip: IpAddr = address.ip();
        Ok(Self {
            scripts: SCRIPT_PORTS.map(|port| SocketAddr::new(ip, port)),
            rtde: address,
            dashboard: SocketAddr::new(ip, DASHBOARD_PORT),
        })
    }
}

/// An arm, connected.
#[derive(Debug)]
pub struct Ur {
    ports: Ports,
    patience: Duration,
    script: TcpStream,
    spare: TcpStream,
    outlet: Outlet,
    /// Number of the last question that a script was to answer.
    question: i32,
}

impl Reports for Stream {
    fn next(&mut self) -> io::Result<Report> {
        let sample = Stream::next(self)?;
        let [x, y, z, ..] = sample.speed;
        Ok(Report {
            clock: sample.clock,
            pose: pose(sample.pose),
            velocity: [x, y, z],
            condition: condition(&sample),
        })
    }
}

/// What the maker's numbers mean.
fn condition(sample: &rtde::Sample) -> Condition {
    if sample.robot_mode != RUNNING {
        return Condition::Held(Said("robot mode", sample.robot_mode.into()));
    }
    if sample.safety_mode != NORMAL {
        return Condition::Held(Said("safety mode", sample.safety_mode.into()));
    }
    match sample.runtime {
        // A program that stops is one that ends.
        0 | PROGRAM => Condition::Moving,
        NO_PROGRAM => Condition::Ready,
        other => Condition::Held(Said("its program is held, runtime state", other.into())),
    }
}

fn pose([x, y, z, a, b, c]: [f64; 6]) -> Pose {
    Pose {
        at: [x, y, z],
        turn: Turn::vector([a, b, c]),
    }
}

/// A pose as URScript writes it. Errors where a number is none: it never goes to an arm.
fn written(pose: &Pose) -> io::Result<String> {
    let [x, y, z] = pose.at;
    let [a, b, c] = pose.turn.to_vector();
    let numbers = [x, y, z, a, b, c];
    if !numbers.iter().all(|number| number.is_finite()) {
        let why = format!("{numbers:?} is not sent to an arm");
        return Err(io::Error::new(ErrorKind::InvalidInput, why));
    }
    Ok(format!("p[{x:.6},{y:.6},{z:.6},{a:.6},{b:.6},{c:.6}]"))
}

/// A program of these lines; a script that is sent replaces the one that runs.
fn program(name: &str, lines: &[String]) -> Vec<u8> {
    let mut text = format!("def carom_{name}():\n");
    for line in lines {
        text += &format!("  {line}\n");
    }
    (text + "end\n").into_bytes()
}

impl Ur {
    fn stream(&self) -> io::Result<Stream> {
        let stream = connect(self.ports.rtde, self.patience)?;
        stream.set_read_timeout(Some(self.patience))?;
        Stream::start(stream)
    }

    /// What the dashboard answers to each of these.
    fn dashboard<const N: usize>(&self, questions: [&str; N]) -> io::Result<[String; N]> {
        let mut stream = connect(self.ports.dashboard, self.patience)?;
        stream.set_read_timeout(Some(self.patience))?;
        line(&mut stream)?;
        let mut answers = Vec::new();
        for question in questions {
            stream.write_all(format!("{question}\n").as_bytes())?;
            answers.push(line(&mut stream)?);
        }
        answers
            .try_into()
            .map_err(|_| io::ErrorKind::UnexpectedEof.into())
    }
}

/// One line of text.
fn line(stream: &mut impl Read) -> io::Result<String> {
    let mut bytes = Vec::new();
    let mut byte = [0];
    while bytes.len() < 256 {
        stream.read_exact(&mut byte)?;
        if byte[0] == b'\n' {
            break;
        }
        bytes.push(byte[0]);
    }
    Ok(String::from_utf8_lossy(&bytes).trim().to_owned())
}

/// A connection for scripts; what the controller tells over it is not read, and thrown away, so that it never waits.
fn script(address: SocketAddr, patience: Duration) -> io::Result<TcpStream> {
    let stream = connect(address, patience)?;
    let mut told = stream.try_clone()?;
    thread::Builder::new()
        .name("ur-told".into())
        .spawn(move || io::copy(&mut told, &mut io::sink()))?;
    Ok(stream)
}

impl Drop for Ur {
    fn drop(&mut self) {
        // Ends the threads that read; that it was closed before does not matter.
        for stream in [&self.script, &self.spare] {
            let _ = stream.shutdown(Shutdown::Read);
        }
    }
}

impl Arm for Ur {
    type Address = Ports;

    fn connect(ports: &Ports, patience: Duration) -> io::Result<Self> {
        let [one, other] = ports.scripts;
        let (first, spare) = (script(one, patience)?, script(other, patience)?);
        let stop = program("stop", &[format!("stopl({BRAKE})")]);
        let outlet = Outlet::new(vec![
            (first.try_clone()?, stop.clone()),
            (spare.try_clone()?, stop),
        ]);
        Ok(Self {
            ports: *ports,
            patience,
            script: first,
            spare,
            outlet,
            // None that an earlier program asked: its answer still stands in the register.
            question: (Epoch::now().stamp(Instant::now()) / 1_000 % 1_000_000_000) as i32,
        })
    }

    fn place(ports: &Ports) -> String {
        ports.rtde.to_string()
    }

    fn reports(ports: &Ports) -> io::Result<Box<dyn Reports>> {
        let stream = connect(ports.rtde, CONNECT)?;
        stream.set_read_timeout(Some(SILENT))?;
        Ok(Box::new(Stream::start(stream)?))
    }

    fn outlet(&self) -> &Outlet {
        &self.outlet
    }

    fn identify(&mut self) -> io::Result<Result<Identity, String>> {
        let [software, serial, model, remote] = self.dashboard([
            "PolyscopeVersion",
            "get serial number",
            "get robot model",
            "is in remote control",
        ])?;
        let found = software.split_whitespace().find_map(|word| {
            let mut numbers = word.split('.').map(str::parse::<u32>);
            Some((numbers.next()?.ok()?, numbers.next()?.ok()?))
        });
        if found.is_none_or(|found| found < SOFTWARE) {
            return Ok(Err(format!(
                "the controller says `{software}`: its software must be {}.{} or later",
                SOFTWARE.0, SOFTWARE.1
            )));
        }
        if remote != "true" {
            return Ok(Err(
                "the arm is not in remote control: set it so on its pendant".into(),
            ));
        }
        if serial.is_empty() || !model.starts_with("UR") {
            return Ok(Err(format!(
                "the controller says that it is `{model}` with the serial number `{serial}`"
            )));
        }
        Ok(Ok(Identity {
            serial,
            limits: ArmLimits {
                speed: 1.0,
                acceleration: 10.0,
                jerk: None,
                start: Duration::from_millis(100),
            },
        }))
    }

    fn status(&mut self) -> io::Result<Status> {
        let sample = self.stream()?.next()?;
        let mut wrong = Vec::new();
        if sample.slider < 0.999 {
            wrong.push(format!(
                "the arm's speed slider stands at {:.0} %; set it to 100 % on its pendant",
                sample.slider * 100.0
            ));
        }
        Ok(Status {
            is_enabled: sample.robot_mode == RUNNING,
            tool: pose(sample.tool),
            payload: sample.payload,
            wrong,
            fence: None,
            changed: Vec::new(),
        })
    }

    fn pose(&mut self) -> io::Result<Pose> {
        Ok(pose(self.stream()?.next()?.pose))
    }

    fn enable(&mut self, _: &mut dyn FnMut() -> io::Result<()>) -> io::Result<()> {
        Err(io::Error::other(
            "the arm takes no lines: power it on, release its brakes and end its program on its pendant",
        ))
    }

    fn set_ramp(&mut self, _: f64, _: Option<f64>) -> io::Result<()> {
        Ok(())
    }

    fn put_back(&mut self, _: &Status) -> io::Result<()> {
        Ok(())
    }

    /// A script asks for a solution of the joints at the line's end, and writes the answer into a register.
    fn can_move(&mut self, line: &LineRequest, _: bool) -> io::Result<Result<(), String>> {
        self.question += 1;
        let number = self.question;
        let lines = [
            format!("if get_inverse_kin_has_solution({}):", written(&line.to)?),
            format!("  write_output_integer_register(24, {number})"),
            "else:".to_owned(),
            format!("  write_output_integer_register(24, -{number})"),
            "end".to_owned(),
        ];
        let mut stream = self.stream()?;
        self.outlet.send(&self.script, &program("ask", &lines))?;
        let until = Instant::now() + self.patience;
        loop {
            let sample = stream.next()?;
            // The script's end is waited for too: a line would end it.
            if sample.answer.abs() == number && sample.runtime == NO_PROGRAM {
                return Ok((sample.answer > 0).then_some(()).ok_or_else(|| {
                    "no joints reach its end; lay the object elsewhere".to_owned()
                }));
            }
            if Instant::now() > until {
                return Err(ErrorKind::TimedOut.into());
            }
        }
    }

    fn line(&mut self, line: &LineRequest) -> io::Result<()> {
        let (speed, acceleration) = (line.speed, line.acceleration);
        let text = format!(
            "movel({}, a={acceleration:.6}, v={speed:.6})",
            written(&line.to)?
        );
        self.outlet.send(&self.script, &program("line", &[text]))
    }
}
