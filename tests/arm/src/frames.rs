//! The bytes of the controller's side: requests read, replies and reports written.

use std::io::{self, Read};

use crate::Model;

#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// All of its bytes.
    pub bytes: Vec<u8>,
}

impl Request {
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

    pub fn register(&self) -> u8 {
        self.bytes[6]
    }

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

    pub fn reply(&self, status: u8, content: &[u8]) -> Vec<u8> {
        let mut bytes = self.bytes[..4].to_vec();
        bytes.extend((content.len() as u16 + 2).to_be_bytes());
        bytes.extend([self.register(), status]);
        bytes.extend(content);
        bytes
    }
}

#[derive(Clone, Debug)]
pub struct Reported {
    /// In µs.
    pub clock: u64,
    /// 1 in motion, 2 ready, 3 paused, 4 stopped.
    pub state: u8,
    pub mode: u8,
    pub waiting: u16,
    pub enabled: bool,
    /// Error and warning code.
    pub codes: [u8; 2],
    /// mm and rad.
    pub pose: [f64; 6],
    /// Where the controller wants the tip: mm and rad.
    pub wanted: [f64; 6],
    /// mm/s.
    pub velocity: [f64; 3],
    /// What the arm is and was set to.
    pub model: Model,
    /// Jerk in mm/s³ and greatest acceleration in mm/s² of lines.
    pub ramp: [f64; 2],
    pub is_running: bool,
    pub is_led: bool,
    /// What scripts wrote: an answer, and the last sign of life that they read.
    pub registers: [i32; 2],
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
        for (at, pose, speed) in [(424, &self.wanted, 448), (472, &self.pose, 496)] {
            put(&mut frame, at, pose);
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
        let motors = if self.enabled {
            0x7f & !self.model.off
        } else {
            0
        };
        frame[87] = motors;
        frame[88] = motors;
        frame[89..91].copy_from_slice(&self.codes);
        put(&mut frame, 91, &self.model.tool_offset);
        put(&mut frame, 115, &[self.model.payload]);
        frame[131] = self.model.sensitivity;
        put(&mut frame, 133, &self.model.gravity);
        frame
    }

    /// Port 30002's report: the ordinary one, and what the controller is set to.
    pub fn rich(&self) -> Vec<u8> {
        let mut frame = self.ordinary();
        frame.resize(587, 0);
        frame[..4].copy_from_slice(&587u32.to_be_bytes());
        frame[145..147].copy_from_slice(&[7, 7]);
        let [jerk, acceleration] = self.ramp;
        put(&mut frame, 181, &[jerk, 0.0, acceleration, 0.0, 1000.0]);
        put(&mut frame, 288, &self.model.world_offset);
        let [reduced, fence, simulated] = self.model.modes.map(u8::from);
        frame[314] = simulated;
        frame[494] = reduced | fence << 1;
        frame[495] = reduced;
        for (i, number) in self.model.fence.iter().enumerate() {
            frame[496 + 2 * i..498 + 2 * i].copy_from_slice(&number.to_le_bytes());
        }
        frame[572] = fence;
        frame
    }
}

pub(crate) fn numbers(text: &str) -> Vec<f64> {
    text.split(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | 'e')))
        .filter_map(|word| word.parse().ok())
        .collect()
}
