//! Frames of UFACTORY's private TCP protocol: requests and replies of the control port, and the real-time report.
//!
//! Source: the maker's documents (xArm-Developer/ufactory_docs) and the published Python SDK, whose bytes for the same calls are
//! kept beside the tests. Numbers of a header are big-endian, those of a payload little-endian 32-bit floats; lengths are mm.

use std::io::{self, ErrorKind, Read};

use crate::robot::arm::{garbage, read_frame};

/// The private protocol's number in a header.
const PROTOCOL: u16 = 2;
const HEADER: usize = 7;
/// Longest reply that is read, in bytes: the longest of those used here has 50.
const LONGEST_REPLY: usize = 1024;
/// Bytes of a real-time report up to the last field that is read; whole ones have 804.
const LEAST_REALTIME: usize = 520;
/// Bytes of a rich report up to the last field that is read.
const LEAST_REPORT: usize = 573;
/// Longest report that is read, in bytes.
const LONGEST_REPORT: usize = 4096;

/// The registers that a strike needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Register {
    /// Model, axes, serial numbers and firmware, as text.
    Version = 1,
    /// Enables the motors.
    MotionEnable = 11,
    /// Sets the state: 0 ready, 4 stop.
    SetState = 12,
    /// Error and warning code.
    GetError = 15,
    /// A straight line to a pose.
    MoveLine = 21,
    /// Jerk of straight lines, in mm/s³.
    TcpJerk = 31,
    /// Greatest acceleration of straight lines, in mm/s².
    TcpAcceleration = 32,
    /// The tip's pose.
    GetPose = 41,
}

impl Register {
    /// What a request to it asks for, in words.
    pub(super) fn asks(self) -> &'static str {
        match self {
            Self::Version => "tell its version",
            Self::MotionEnable => "switch the motors on",
            Self::SetState => "set its state",
            Self::GetError => "tell its errors",
            Self::MoveLine => "move a line",
            Self::TcpJerk => "set the jerk",
            Self::TcpAcceleration => "set the acceleration",
            Self::GetPose => "tell the tip's pose",
        }
    }
}

/// A request, ready to send.
pub fn request(transaction: u16, register: Register, payload: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(HEADER + payload.len());
    frame.extend(transaction.to_be_bytes());
    frame.extend(PROTOCOL.to_be_bytes());
    frame.extend((payload.len() as u16 + 1).to_be_bytes());
    frame.push(register as u8);
    frame.extend(payload);
    frame
}

/// Floats as a payload; an error where one is no finite number, which never goes on the wire.
pub fn floats(numbers: &[f64]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::with_capacity(4 * numbers.len());
    for number in numbers {
        let number = *number as f32;
        if !number.is_finite() {
            let why = format!("{number} is not sent to an arm");
            return Err(io::Error::new(ErrorKind::InvalidInput, why));
        }
        bytes.extend(number.to_le_bytes());
    }
    Ok(bytes)
}

/// The payload of a straight line to a pose (mm, rad) at a speed (mm/s) and acceleration (mm/s²); `only_check` is 0 for one that is moved.
/// Errors where a number is not finite.
pub fn line_payload(
    pose: [f64; 6],
    speed: f64,
    acceleration: f64,
    only_check: u8,
) -> io::Result<Vec<u8>> {
    /// No blending into the next line.
    const NO_RADIUS: f64 = -1.0;
    /// No fixed duration: as fast as speed and acceleration allow.
    const NO_TIME: f64 = 0.0;
    let mut numbers = pose.to_vec();
    numbers.extend([speed, acceleration, NO_TIME, NO_RADIUS]);
    let mut payload = floats(&numbers)?;
    // In the base's frame, roll-pitch-yaw, moved or only checked.
    payload.extend([0, 0, only_check]);
    Ok(payload)
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reply {
    /// Number of the request.
    pub transaction: u16,
    pub register: u8,
    /// Bits: 0x40 an error is set, 0x20 a warning, 0x10 not ready to move, 0x08 the request is invalid.
    pub status: u8,
    pub payload: Vec<u8>,
}

impl Reply {
    /// Bytes of the payload from `at` as a float.
    pub fn float(&self, at: usize) -> Option<f64> {
        float(&self.payload, at)
    }
}

/// Takes the first reply out of what came; none where it is not whole yet. Errors where it makes no sense: what follows cannot be trusted
/// either.
pub fn take_reply(came: &mut Vec<u8>) -> io::Result<Option<Reply>> {
    let number = |at: usize| Some(u16::from_be_bytes([*came.get(at)?, *came.get(at + 1)?]));
    let (Some(transaction), Some(protocol), Some(length)) = (number(0), number(2), number(4))
    else {
        return Ok(None);
    };
    let length = usize::from(length);
    if protocol != PROTOCOL || !(2..=LONGEST_REPLY).contains(&length) {
        return Err(garbage(format!("a reply begins with {:02x?}", &came[..6])));
    }
    if came.len() < 6 + length {
        return Ok(None);
    }
    let frame: Vec<u8> = came.drain(..6 + length).collect();
    Ok(Some(Reply {
        transaction,
        register: frame[6],
        status: frame[7],
        payload: frame[8..].to_vec(),
    }))
}

/// A sample of the real-time report: pose and speed as measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Realtime {
    /// The controller's clock, in µs.
    pub clock: u64,
    /// 1 in motion, 2 ready, 3 paused, 4 stopped.
    pub state: u8,
    /// 0 takes positions.
    pub mode: u8,
    /// Requests that the controller holds, the one that it moves on among them.
    pub held: u16,
    /// x, y, z in mm, roll, pitch, yaw in rad.
    pub pose: [f64; 6],
    /// Velocity along x, y, z in mm/s.
    pub velocity: [f64; 3],
}

/// What the controller is set to, as the rich report gives it. Its layout is that of the maker's SDK.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Bits of the motors that are enabled and free of their brakes.
    pub enabled: u8,
    /// Error code; 0 where there is none.
    pub error: u8,
    /// Warning code; 0 where there is none.
    pub warning: u8,
    /// x, y, z in mm, roll, pitch, yaw in rad.
    pub tool_offset: [f64; 6],
    /// Mass of the tool, in kg.
    pub payload: f64,
    /// Sensitivity of the detection of collisions; 0 is off.
    pub sensitivity: u8,
    /// Direction of gravity in the base's frame.
    pub gravity: [f64; 3],
    /// mm/s³.
    pub jerk: f64,
    /// Greatest acceleration of lines, in mm/s².
    pub acceleration: f64,
    /// Where the base's frame lies in the one that poses are given in: mm and rad.
    pub world_offset: [f64; 6],
    /// Whether motions are only simulated.
    pub is_simulated: bool,
    /// Whether speeds are held below those of reduced mode.
    pub is_reduced: bool,
    /// x high and low, y high and low, z high and low, in mm, where the fence is on.
    pub fence: Option<[f64; 6]>,
}

/// Reads one real-time report.
pub fn read_realtime(stream: &mut impl Read) -> io::Result<Realtime> {
    let frame = read_report(stream, LEAST_REALTIME)?;
    let mut clock = [0; 8];
    clock.copy_from_slice(&frame[4..12]);
    let vector = |at: usize| std::array::from_fn(|i| float(&frame, at + 4 * i).unwrap_or(f64::NAN));
    let sample = Realtime {
        clock: u64::from_be_bytes(clock),
        state: frame[12] & 0x0f,
        mode: frame[12] >> 4,
        held: u16::from_be_bytes([frame[13], frame[14]]),
        pose: vector(472),
        velocity: {
            let velocity: [f64; 6] = vector(496);
            [velocity[0], velocity[1], velocity[2]]
        },
    };
    Ok(sample)
}

/// Reads one rich report. Errors where a number of it is none.
pub fn read_settings(stream: &mut impl Read) -> io::Result<Settings> {
    let frame = read_report(stream, LEAST_REPORT)?;
    let number = |at: usize| float(&frame, at).unwrap_or(f64::NAN);
    let six = |at: usize| std::array::from_fn(|i| number(at + 4 * i));
    let short = |at: usize| f64::from(i16::from_le_bytes([frame[at], frame[at + 1]]));
    let settings = Settings {
        enabled: frame[87] & frame[88],
        error: frame[89],
        warning: frame[90],
        tool_offset: six(91),
        payload: number(115),
        sensitivity: frame[131],
        gravity: [number(133), number(137), number(141)],
        jerk: number(181),
        acceleration: number(189),
        world_offset: six(288),
        is_simulated: frame[314] != 0,
        is_reduced: frame[495] != 0 || frame[494] & 1 != 0,
        fence: (frame[572] != 0).then(|| std::array::from_fn(|i| short(496 + 2 * i))),
    };
    let [x, y, z] = settings.gravity;
    let is_finite = [
        settings.payload,
        settings.jerk,
        settings.acceleration,
        x,
        y,
        z,
    ]
    .iter()
    .chain(&settings.tool_offset)
    .all(|number| number.is_finite());
    if is_finite {
        Ok(settings)
    } else {
        Err(garbage("a report of its settings holds what is no number"))
    }
}

fn read_report(stream: &mut impl Read, least: usize) -> io::Result<Vec<u8>> {
    let length = |size: [u8; 4]| u32::from_be_bytes(size) as usize;
    read_frame(stream, length, least..=LONGEST_REPORT)
}

fn float(bytes: &[u8], at: usize) -> Option<f64> {
    let four = bytes.get(at..at + 4)?;
    Some(f64::from(f32::from_le_bytes(four.try_into().ok()?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_number_that_is_not_finite_goes_on_the_wire() {
        for number in [f64::NAN, f64::INFINITY, 1e39] {
            assert!(floats(&[0.0, number]).is_err());
        }
        assert_eq!(floats(&[1.5]).expect("finite"), [0, 0, 0xc0, 0x3f]);
    }

    #[test]
    fn replies_and_reports_of_any_bytes_are_read_or_reported() {
        // Short, cut off, and of lengths that nothing has.
        for bytes in [
            &[][..],
            &[0, 1, 0, 2],
            &[0, 1, 0, 2, 0, 1, 13],
            &[0, 1, 0, 2, 0xff, 0xff, 13],
            &[0xff; 64],
            &[0, 0, 0, 0],
        ] {
            assert!(!matches!(take_reply(&mut bytes.to_vec()), Ok(Some(_))));
            assert!(read_realtime(&mut &*bytes).is_err());
            assert!(read_settings(&mut &*bytes).is_err());
        }
        assert!(take_reply(&mut vec![0xff; 64]).is_err());
        let mut came = vec![0, 9, 0, 2, 0, 3, 13, 0x10, 4, 7];
        let reply = take_reply(&mut came).expect("sound").expect("whole");
        assert_eq!(came, [7]);
        assert_eq!(
            (reply.transaction, reply.status, &*reply.payload),
            (9, 0x10, &[4][..])
        );
    }
}
