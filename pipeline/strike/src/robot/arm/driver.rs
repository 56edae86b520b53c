//! What a maker's driver is: connect, status, a stream of reports, a line, a stop. All else is [`super::Guarded`]'s, once for every arm.
//!
//! Lengths are m, speeds m/s, angles rad, in the frame of the arm's base.

use std::fmt;
use std::io;
use std::net::{SocketAddr, ToSocketAddrs};
use std::time::Duration;

use super::connection::garbage;
use super::outlet::Outlet;
use super::turn::Turn;

/// Position and orientation of the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// x, y, z in m.
    pub at: [f64; 3],
    /// Its orientation.
    pub turn: Turn,
}

impl Pose {
    /// A pose from x, y, z in m and a rotation vector in rad.
    pub(crate) fn by_vector([x, y, z, turn @ ..]: [f64; 6]) -> Self {
        Self {
            at: [x, y, z],
            turn: Turn::vector(turn),
        }
    }

    /// Itself if every number is finite; an error otherwise.
    pub(crate) fn checked(self) -> io::Result<Self> {
        let is_finite = self.at.iter().all(|v| v.is_finite()) && self.turn.is_finite();
        is_finite
            .then_some(self)
            .ok_or_else(|| garbage("a pose of it is no number"))
    }
}

/// Distance in m of two places.
pub(crate) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm(std::array::from_fn(|i| a[i] - b[i]))
}

pub(crate) fn norm(vector: [f64; 3]) -> f64 {
    vector.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Numbers as a person reads them: to a tenth of a mm, or of a mrad.
pub(crate) fn shown(numbers: &[f64]) -> String {
    // Nothing is below nothing.
    let rounded = |number: &f64| format!("{:.4}", (number * 1e4).round() / 1e4 + 0.0);
    let numbers: Vec<String> = numbers.iter().map(rounded).collect();
    format!("({})", numbers.join(", "))
}

/// A state or mode of a controller, in its maker's words and number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Said(pub &'static str, pub i64);

impl fmt::Display for Said {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.0, self.1)
    }
}

/// Whether a controller takes lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The controller takes lines, and moves on none.
    Ready,
    /// The controller moves the arm.
    Moving,
    /// The controller was stopped, or not made ready yet: a new call may make it ready.
    Stopped(Said),
    /// Another program, a pause or a fault holds the controller: a person must release it.
    Held(Said),
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ready => f.write_str("it takes lines"),
            Self::Moving => f.write_str("it moves"),
            Self::Stopped(said) => write!(f, "it is stopped ({said})"),
            Self::Held(said) => write!(f, "it is held ({said})"),
        }
    }
}

/// One report of the stream: what the arm does, as measured.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// The controller's clock, in s.
    pub clock: f64,
    /// Where the tip is.
    pub pose: Pose,
    /// Its velocity along x, y, z, in m/s.
    pub velocity: [f64; 3],
    /// Whether the controller takes lines.
    pub condition: Condition,
    /// Where the controller wants the tip by then, in m; none where its reports do not hold that.
    pub wanted: Option<[f64; 3]>,
}

impl Report {
    /// Itself if every number is finite; an error otherwise.
    pub(crate) fn checked(self) -> io::Result<Self> {
        self.pose.checked()?;
        let mut numbers = self.velocity.iter().chain(self.wanted.iter().flatten());
        let is_finite = numbers.all(|v| v.is_finite()) && self.clock.is_finite();
        is_finite
            .then_some(self)
            .ok_or_else(|| garbage("a report of it holds what is no number"))
    }
}

/// A stream of reports.
pub trait Reports: Send {
    /// The next one; it may wait for a second. Errors where it makes no sense or none comes any more.
    fn next(&mut self) -> io::Result<Report>;
}

/// Greatest speed, acceleration and jerk of an arm's lines. Controllers clamp in silence what is above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmLimits {
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: f64,
    /// Greatest jerk, in m/s³; none for an arm whose lines change their acceleration at once.
    pub jerk: Option<f64>,
    /// Time within which a line begins after it was sent.
    pub start: Duration,
}

/// Which arm it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Identity {
    /// Its serial number.
    pub serial: String,
    /// What it can do.
    pub limits: ArmLimits,
}

/// Settings and state of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// Whether motors are enabled and brakes released.
    pub is_enabled: bool,
    /// The tip's centre in the flange's frame.
    pub tool: Pose,
    /// The tool's mass, in kg.
    pub payload: f64,
    /// Why it must not strike as it is set, in the maker's words, with what to mend: errors, reduced mode, a shifted frame, detection of
    /// collisions that is off.
    pub wrong: Vec<String>,
    /// Corners, low and high, of the box that its own fence holds the tip in, in m; none where it has none on.
    pub fence: Option<[[f64; 3]; 2]>,
    /// Settings that a strike changes, to be put back as they were: the driver's own numbers.
    pub changed: Vec<f64>,
}

impl Status {
    /// The status of an arm that is enabled, has a tool of a mass (kg), no fence of its own, and no settings that a strike changes.
    pub(crate) fn enabled(tool: Pose, payload: f64, wrong: Vec<String>) -> Self {
        Self {
            is_enabled: true,
            tool,
            payload,
            wrong,
            fence: None,
            changed: Vec::new(),
        }
    }
}

/// A straight line of the tip, from wherever it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineRequest {
    /// Where it ends.
    pub to: Pose,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: f64,
}

impl LineRequest {
    /// Places (m) on the line at most `apart` (m) from one another, from where it begins on; its end is the last one.
    pub(crate) fn places(&self, from: [f64; 3], apart: f64) -> impl Iterator<Item = [f64; 3]> {
        let to = self.to.at;
        let steps = (distance(from, to) / apart).ceil().max(1.0) as u32;
        (1..=steps).map(move |step| {
            let share = f64::from(step) / f64::from(steps);
            std::array::from_fn(|i| from[i] + share * (to[i] - from[i]))
        })
    }

    /// Whether every number is finite: nothing else goes to an arm.
    pub(crate) fn is_finite(&self) -> bool {
        self.to.checked().is_ok() && self.speed.is_finite() && self.acceleration.is_finite()
    }
}

/// Where a controller listens: an address for each of [`Arm::PORTS`].
pub type Ports = [SocketAddr; 4];

/// The ports of a maker's arm at a host. Errors where the name is not known.
pub fn ports_of<D: Arm>(host: &str) -> io::Result<Ports> {
    let found = (host, D::PORTS[0]).to_socket_addrs()?.next();
    let address = found.ok_or_else(|| io::Error::other("the name has no address"))?;
    Ok(D::PORTS.map(|port| SocketAddr::new(address.ip(), port)))
}

/// An arm of one maker, connected. Nothing here judges, guards or retries.
pub trait Arm: Sized + Send {
    /// The maker's ports.
    const PORTS: [u16; 4];

    /// Whether a line is accepted once [`Self::line`] returns. Where it is not, only reports show it: of the line that the tip moves on it, of a
    /// stop that the controller is stopped, from where no line of before can begin any more.
    const ANSWERS: bool = false;

    /// Connects; changes nothing. A reply may take `patience`.
    fn connect(ports: &Ports, patience: Duration) -> io::Result<Self>;

    /// A stream of its own of reports, at 100 Hz or more. Where the maker's protocol has a sign of life, it is given for each report that
    /// is read, until the outlet was stopped: a stop that is lost is then the controller's own.
    fn reports(&self) -> io::Result<Box<dyn Reports>>;

    /// The connections over which its requests and its stop are sent.
    fn outlet(&self) -> &Outlet;

    /// Which arm it is. The inner error says that this arm or its software is not driven.
    fn identify(&mut self) -> io::Result<Result<Identity, String>>;

    /// The controller's settings and state.
    fn status(&mut self) -> io::Result<Status>;

    /// The tip's pose, asked for apart from the stream of reports.
    fn pose(&mut self) -> io::Result<Pose>;

    /// Makes it ready for lines; moves nothing. `go_on` is asked right before a stop would be taken back: it errors where somebody has
    /// stopped the arm meanwhile.
    fn enable(&mut self, go_on: &mut dyn FnMut() -> io::Result<()>) -> io::Result<()>;

    /// Sets jerk and acceleration of the lines that follow, where the controller keeps them.
    fn set_ramp(&mut self, _acceleration: f64, _jerk: Option<f64>) -> io::Result<()> {
        Ok(())
    }

    /// Sets what [`Status::changed`] holds, as it was.
    fn put_back(&mut self, _before: &Status) -> io::Result<()> {
        Ok(())
    }

    /// Asks the controller whether it can move these lines, one from where the other ends, the first from where the arm is: joint limits,
    /// its own parts, speeds of its joints. Moves nothing. The inner error is the number of a line that it cannot, and the controller's why.
    fn can_move(&mut self, lines: &[LineRequest]) -> io::Result<Result<(), (usize, String)>>;

    /// Sends a line, and returns once it is accepted.
    fn line(&mut self, line: &LineRequest) -> io::Result<()>;
}
