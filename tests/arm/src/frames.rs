//! The bytes of the controller's side: requests read, replies and reports written.

use std::io::{self, Read};

/// A request as it came.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// All of its bytes.
    pub bytes: Vec<u8>,
}

impl Request {
    /// Reads one.
    pub fn read(stream: &mut impl Read) -> io::Result<Self> {
        let mut bytes = vec![0; 6];
        stream.read_exact(&mut bytes)?;
        let length = usize::from(u16::from_be_bytes([bytes[4], bytes[5]]));
        if length == 0 || length > 4096 {
            return Err(io::ErrorKind::InvalidData.into());
        }
        bytes.resize(6 + length, 0);
        stream.read_exact(&mut bytes[6..])?;
        Ok(Self { bytes })
    }

    /// Its register.
    pub fn register(&self) -> u8 {
        self.bytes[6]
    }

    /// The content.
    pub fn payload(&self) -> &[u8] {
        &self.bytes[7..]
    }

    /// The payload's n-th float; NaN where there is none.
    pub fn float(&self, n: usize) -> f64 {
        self.payload()
            .get(4 * n..4 * n + 4)
            .and_then(|four| four.try_into().ok())
            .map_or(f64::NAN, |four| f64::from(f32::from_le_bytes(four)))
    }

    /// The reply with this status and content.
    pub fn reply(&self, status: u8, content: &[u8]) -> Vec<u8> {
        let mut bytes = self.bytes[..4].to_vec();
        bytes.extend((content.len() as u16 + 2).to_be_bytes());
        bytes.extend([self.register(), status]);
        bytes.extend(content);
        bytes
    }
}

/// What a report holds.
#[derive(Clone, Copy, Debug)]
pub struct Reported {
    /// In µs.
    pub clock: u64,
    /// 1 in motion, 2 ready, 3 paused, 4 stopped.
    pub state: u8,
    /// Mode of control.
    pub mode: u8,
    /// Requests that wait.
    pub waiting: u16,
    /// Whether motors are enabled.
    pub enabled: bool,
    /// Error and warning code.
    pub codes: [u8; 2],
    /// mm and rad.
    pub pose: [f64; 6],
    /// mm/s.
    pub velocity: [f64; 3],
    /// mm and rad.
    pub tool_offset: [f64; 6],
    /// kg.
    pub payload: f64,
}

fn put(frame: &mut [u8], at: usize, numbers: &[f64]) {
    for (i, number) in numbers.iter().enumerate() {
        frame[at + 4 * i..at + 4 * i + 4].copy_from_slice(&(*number as f32).to_le_bytes());
    }
}

impl Reported {
    /// Port 30000's report.
    pub fn realtime(&self) -> Vec<u8> {
        let mut frame = vec![0; 804];
        frame[..4].copy_from_slice(&804u32.to_be_bytes());
        frame[4..12].copy_from_slice(&self.clock.to_be_bytes());
        frame[12] = self.mode << 4 | self.state;
        frame[13..15].copy_from_slice(&self.waiting.to_be_bytes());
        // Target and measured: the emulated arm has no error of following.
        for (pose, speed) in [(424, 448), (472, 496)] {
            put(&mut frame, pose, &self.pose);
            put(&mut frame, speed, &self.velocity);
        }
        frame
    }

    /// Port 30001's report.
    pub fn ordinary(&self) -> Vec<u8> {
        let mut frame = vec![0; 145];
        frame[..4].copy_from_slice(&145u32.to_be_bytes());
        frame[4] = self.mode << 4 | self.state;
        frame[5..7].copy_from_slice(&self.waiting.to_be_bytes());
        put(&mut frame, 35, &self.pose);
        let motors = if self.enabled { 0x7f } else { 0 };
        frame[87] = motors;
        frame[88] = motors;
        frame[89..91].copy_from_slice(&self.codes);
        put(&mut frame, 91, &self.tool_offset);
        put(&mut frame, 115, &[self.payload]);
        put(&mut frame, 133, &[0.0, 0.0, -1.0]);
        frame
    }
}
