//! The control port: one request after another, and a stop that goes out whatever else happens.

use std::io;
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::wire::{self, Register, Reply};

/// How long a connection may take.
pub(super) const CONNECT: Duration = Duration::from_secs(2);
/// How long a reply may take. Enabling the motors takes the controller some seconds.
const REPLY: Duration = Duration::from_secs(2);
const ENABLE: Duration = Duration::from_secs(8);
/// How long the socket may refuse a frame of some fifty bytes.
const SEND: Duration = Duration::from_millis(50);
/// The state that stops. The maker's `emergency_stop` enables motion again after it; this does not.
const STOP: u8 = 4;
/// Number of the stop's request: no other request has it.
const STOP_TRANSACTION: u16 = u16::MAX;
/// Bits of a reply's status: an error or a warning is set, the request is invalid.
const REFUSED: u8 = 0x40 | 0x20 | 0x08;

/// Where frames go out; once stopped, nothing but a stop does.
#[derive(Debug)]
struct Outlet {
    stream: TcpStream,
    is_stopped: bool,
}

/// Stops the arm, from any thread.
#[derive(Clone, Debug)]
pub struct StopHandle {
    outlet: Arc<Mutex<Outlet>>,
}

impl StopHandle {
    /// Sends the stop. From then on nothing else is sent over this connection, by whatever thread.
    pub fn stop(&self) -> io::Result<()> {
        let mut outlet = self.outlet.lock().unwrap_or_else(PoisonError::into_inner);
        outlet.is_stopped = true;
        let frame = wire::request(STOP_TRANSACTION, Register::SetState, &[STOP]);
        io::Write::write_all(&mut outlet.stream, &frame)
    }

    /// Whether a stop was sent.
    pub fn is_stopped(&self) -> bool {
        let outlet = self.outlet.lock().unwrap_or_else(PoisonError::into_inner);
        outlet.is_stopped
    }
}

/// A connection to the control port.
#[derive(Debug)]
pub(super) struct Control {
    stream: TcpStream,
    outlet: Arc<Mutex<Outlet>>,
    transaction: u16,
}

impl Control {
    pub(super) fn connect(address: SocketAddr) -> io::Result<Self> {
        let stream = TcpStream::connect_timeout(&address, CONNECT)?;
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(SEND))?;
        let outlet = Outlet {
            stream: stream.try_clone()?,
            is_stopped: false,
        };
        Ok(Self {
            stream,
            outlet: Arc::new(Mutex::new(outlet)),
            transaction: 0,
        })
    }

    pub(super) fn stop_handle(&self) -> StopHandle {
        StopHandle {
            outlet: self.outlet.clone(),
        }
    }

    pub(super) fn version(&mut self) -> io::Result<String> {
        let reply = self.ask(Register::Version, &[], REPLY)?;
        let text = String::from_utf8_lossy(&reply.payload);
        Ok(text.trim_end_matches('\0').to_owned())
    }

    /// Error and warning code.
    pub(super) fn error(&mut self) -> io::Result<(u8, u8)> {
        let reply = self.ask(Register::GetError, &[], REPLY)?;
        match reply.payload[..] {
            [error, warning, ..] => Ok((error, warning)),
            _ => Err(short(&reply)),
        }
    }

    pub(super) fn state(&mut self) -> io::Result<u8> {
        let reply = self.ask(Register::GetState, &[], REPLY)?;
        reply.payload.first().copied().ok_or_else(|| short(&reply))
    }

    /// The tip's pose: x, y, z in mm, roll, pitch, yaw in rad.
    pub(super) fn pose(&mut self) -> io::Result<[f64; 6]> {
        let reply = self.ask(Register::GetPose, &[], REPLY)?;
        let mut pose = [0.0; 6];
        for (i, number) in pose.iter_mut().enumerate() {
            *number = reply.float(4 * i).ok_or_else(|| short(&reply))?;
        }
        Ok(pose)
    }

    /// Enables all motors.
    pub(super) fn enable(&mut self) -> io::Result<()> {
        /// Stands for all axes.
        const ALL: u8 = 8;
        self.request(Register::MotionEnable, &[ALL, 1], ENABLE)
    }

    pub(super) fn set_mode(&mut self, mode: u8) -> io::Result<()> {
        // The second byte is the maker's detection of collisions while teaching, which is left off.
        self.request(Register::SetMode, &[mode, 0], REPLY)
    }

    pub(super) fn set_state(&mut self, state: u8) -> io::Result<()> {
        self.request(Register::SetState, &[state], REPLY)
    }

    /// Jerk in mm/s³ of the lines that follow.
    pub(super) fn set_jerk(&mut self, jerk: f64) -> io::Result<()> {
        self.request(Register::TcpJerk, &wire::floats(&[jerk])?, REPLY)
    }

    /// Greatest acceleration in mm/s² of the lines that follow.
    pub(super) fn set_acceleration(&mut self, acceleration: f64) -> io::Result<()> {
        self.request(
            Register::TcpAcceleration,
            &wire::floats(&[acceleration])?,
            REPLY,
        )
    }

    /// A straight line to a pose (mm, rad) at a speed (mm/s) and acceleration (mm/s²); returns once it is accepted.
    pub(super) fn move_line(
        &mut self,
        pose: [f64; 6],
        speed: f64,
        acceleration: f64,
    ) -> io::Result<()> {
        let payload = wire::line_payload(pose, speed, acceleration)?;
        self.request(Register::MoveLine, &payload, REPLY)
    }

    /// Sends what has no answer but its status.
    fn request(
        &mut self,
        register: Register,
        payload: &[u8],
        patience: Duration,
    ) -> io::Result<()> {
        let reply = self.ask(register, payload, patience)?;
        if reply.status & REFUSED == 0 {
            return Ok(());
        }
        let why = format!("{register:?} was refused with status {:#04x}", reply.status);
        Err(io::Error::other(why))
    }

    fn ask(&mut self, register: Register, payload: &[u8], patience: Duration) -> io::Result<Reply> {
        // From 1 up to the stop's number, which is left out.
        self.transaction = self.transaction % (STOP_TRANSACTION - 1) + 1;
        let frame = wire::request(self.transaction, register, payload);
        {
            let mut outlet = self.outlet.lock().unwrap_or_else(PoisonError::into_inner);
            if outlet.is_stopped {
                return Err(io::Error::other(
                    "the arm was stopped: nothing more is sent to it",
                ));
            }
            io::Write::write_all(&mut outlet.stream, &frame)?;
        }
        let until = Instant::now() + patience;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            self.stream.set_read_timeout(Some(left))?;
            let reply = wire::read_reply(&mut self.stream)?;
            // An answer to a stop, or one that came too late.
            if reply.transaction != self.transaction {
                continue;
            }
            if reply.register == register as u8 {
                return Ok(reply);
            }
            let why = format!("{register:?} was answered as register {}", reply.register);
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
    }
}

fn short(reply: &Reply) -> io::Error {
    let why = format!("the reply to register {} is too short", reply.register);
    io::Error::new(io::ErrorKind::InvalidData, why)
}
