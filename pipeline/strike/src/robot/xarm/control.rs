//! The control port: one request after another.

use std::io;
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use super::wire::{self, Register, Reply};
use crate::robot::arm::{Outlet, connect};

/// Enabling the motors takes the controller some seconds more than other requests.
const ENABLE: Duration = Duration::from_secs(6);
/// Time that the maker's SDK waits for a line that is only checked.
const CHECK: Duration = Duration::from_secs(10);
/// The state that stops. The maker's `emergency_stop` enables motion again after it; this does not.
const STOP: u8 = 4;
/// Number of the stop's request: no other request has it.
const STOP_TRANSACTION: u16 = u16::MAX;
/// Bits of a reply's status that refuse a request, and what each says.
const REFUSALS: [(u8, &str); 3] = [
    (0x40, "it has an error"),
    (0x20, "it has a warning"),
    (0x08, "it finds the request invalid"),
];

/// A connection to the control port, and a second one that nothing but a stop goes out over: what ails the first does not ail it.
#[derive(Debug)]
pub(super) struct Control {
    stream: TcpStream,
    pub(super) outlet: Outlet,
    patience: Duration,
    transaction: u16,
    waiting: Vec<u8>,
}

impl Control {
    pub(super) fn connect(address: SocketAddr, patience: Duration) -> io::Result<Self> {
        let stream = connect(address, patience)?;
        let spare = connect(address, patience)?;
        let stop = wire::request(STOP_TRANSACTION, Register::SetState, &[STOP]);
        let outlet = Outlet::new(vec![(stream.try_clone()?, stop.clone()), (spare, stop)]);
        Ok(Self {
            stream,
            outlet,
            patience,
            transaction: 0,
            waiting: Vec::new(),
        })
    }

    pub(super) fn version(&mut self) -> io::Result<String> {
        let reply = self.ask(Register::Version, &[], self.patience)?;
        let text = String::from_utf8_lossy(&reply.payload);
        Ok(text.trim_end_matches('\0').to_owned())
    }

    /// Error and warning code.
    pub(super) fn error(&mut self) -> io::Result<(u8, u8)> {
        let reply = self.ask(Register::GetError, &[], self.patience)?;
        match reply.payload[..] {
            [error, warning, ..] => Ok((error, warning)),
            _ => Err(short(&reply)),
        }
    }

    /// The tip's pose: x, y, z in mm, roll, pitch, yaw in rad.
    pub(super) fn pose(&mut self) -> io::Result<[f64; 6]> {
        let reply = self.ask(Register::GetPose, &[], self.patience)?;
        let mut pose = [0.0; 6];
        for (i, number) in pose.iter_mut().enumerate() {
            *number = reply
                .float(4 * i)
                .filter(|number| number.is_finite())
                .ok_or_else(|| short(&reply))?;
        }
        Ok(pose)
    }

    pub(super) fn enable(&mut self) -> io::Result<()> {
        /// Number that stands for all axes.
        const ALL: u8 = 8;
        self.request(Register::MotionEnable, &[ALL, 1], self.patience + ENABLE)
    }

    pub(super) fn set_state(&mut self, state: u8) -> io::Result<()> {
        self.request(Register::SetState, &[state], self.patience)
    }

    /// Jerk in mm/s³ of the lines that follow.
    pub(super) fn set_jerk(&mut self, jerk: f64) -> io::Result<()> {
        self.request(Register::TcpJerk, &wire::floats(&[jerk])?, self.patience)
    }

    /// Greatest acceleration in mm/s² of the lines that follow.
    pub(super) fn set_acceleration(&mut self, acceleration: f64) -> io::Result<()> {
        let payload = wire::floats(&[acceleration])?;
        self.request(Register::TcpAcceleration, &payload, self.patience)
    }

    /// A straight line to a pose (mm, rad) at a speed (mm/s) and acceleration (mm/s²); returns once it is accepted.
    pub(super) fn move_line(
        &mut self,
        pose: [f64; 6],
        speed: f64,
        acceleration: f64,
    ) -> io::Result<()> {
        let payload = wire::line_payload(pose, speed, acceleration, 0)?;
        self.request(Register::MoveLine, &payload, self.patience)
    }

    /// Asks whether the arm can move along a straight line to a pose (mm, rad) at a speed (mm/s) and acceleration (mm/s²), without moving it: 0 where
    /// it can, else the controller's error code. `kind` says where the line begins (`only_check_type` of the maker's SDK).
    pub(super) fn check_line(
        &mut self,
        pose: [f64; 6],
        speed: f64,
        acceleration: f64,
        kind: u8,
    ) -> io::Result<u8> {
        let payload = wire::line_payload(pose, speed, acceleration, kind)?;
        let reply = self.ask(Register::MoveLine, &payload, CHECK)?;
        if refusal(&reply).is_some() {
            return Ok(reply.status);
        }
        // Two bytes of waiting requests, and the code.
        reply.payload.get(2).copied().ok_or_else(|| short(&reply))
    }

    /// Sends a request whose reply is its status alone.
    fn request(
        &mut self,
        register: Register,
        payload: &[u8],
        patience: Duration,
    ) -> io::Result<()> {
        let reply = self.ask(register, payload, patience)?;
        refusal(&reply).map_or(Ok(()), |said| {
            let why = format!("the controller refused to {}: {said}", register.asks());
            Err(io::Error::other(why))
        })
    }

    fn ask(&mut self, register: Register, payload: &[u8], patience: Duration) -> io::Result<Reply> {
        // From 1 up to the stop's number, which is left out.
        self.transaction = self.transaction % (STOP_TRANSACTION - 1) + 1;
        let frame = wire::request(self.transaction, register, payload);
        self.outlet.send(&self.stream, &frame)?;
        let until = Instant::now() + patience;
        loop {
            while let Some(reply) = wire::take_reply(&mut self.waiting)? {
                // An answer that came too late.
                if reply.transaction != self.transaction {
                    continue;
                }
                if reply.register == register as u8 {
                    return Ok(reply);
                }
                let why = format!(
                    "asked to {}, the controller answered about register {} of its protocol",
                    register.asks(),
                    reply.register
                );
                return Err(io::Error::new(io::ErrorKind::InvalidData, why));
            }
            let more = self.outlet.read(&self.stream, until)?;
            self.waiting.extend(more);
        }
    }
}

/// The reason in a reply that refuses a request; none of one that does not.
fn refusal(reply: &Reply) -> Option<&'static str> {
    let is_set = |(bit, _): &&(u8, &str)| reply.status & bit != 0;
    REFUSALS.iter().find(is_set).map(|(_, said)| *said)
}

fn short(reply: &Reply) -> io::Error {
    let why = format!(
        "the reply to register {} is too short, or holds no numbers",
        reply.register
    );
    io::Error::new(io::ErrorKind::InvalidData, why)
}
