//! Universal Robots' real-time data exchange (RTDE): a recipe of quantities, and a stream of them.
//!
//! Source: the maker's guide to RTDE, protocol version 2. All numbers are big-endian.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;

/// Port of the exchange.
pub const RTDE_PORT: u16 = 30_004;
/// Samples a second.
const RATE: f64 = 250.0;
/// Longest package that is read, in bytes.
const LONGEST: usize = 4_096;
/// Kinds of packages.
const PROTOCOL: u8 = b'V';
const OUTPUTS: u8 = b'O';
const START: u8 = b'S';
const DATA: u8 = b'U';

/// What is asked for, and how each is written.
const RECIPE: [(&str, &str); 9] = [
    ("timestamp", "DOUBLE"),
    ("actual_TCP_pose", "VECTOR6D"),
    ("actual_TCP_speed", "VECTOR6D"),
    ("robot_mode", "INT32"),
    ("safety_mode", "INT32"),
    ("runtime_state", "UINT32"),
    ("target_speed_fraction", "DOUBLE"),
    ("payload", "DOUBLE"),
    ("tcp_offset", "VECTOR6D"),
];
/// What a script writes for carom to read.
const ANSWER: (&str, &str) = ("output_int_register_24", "INT32");

/// One sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The controller's clock, in s.
    pub clock: f64,
    /// x, y, z in m, and a rotation vector.
    pub pose: [f64; 6],
    /// Velocity in m/s, and rotation in rad/s.
    pub speed: [f64; 6],
    /// 7 is running.
    pub robot_mode: i32,
    /// 1 is normal.
    pub safety_mode: i32,
    /// 1 no program runs, 2 one runs.
    pub runtime: i32,
    /// Share of the programmed speed that its slider lets pass.
    pub slider: f64,
    /// kg.
    pub payload: f64,
    /// x, y, z in m, and a rotation vector.
    pub tool: [f64; 6],
    /// What a script answered last.
    pub answer: i32,
}

/// A stream of samples.
#[derive(Debug)]
pub struct Stream {
    stream: TcpStream,
    recipe: u8,
}

impl Stream {
    /// Agrees on the recipe, and starts. Errors where the controller does not know a quantity.
    pub fn start(mut stream: TcpStream) -> io::Result<Self> {
        let accepted = ask(&mut stream, PROTOCOL, &2u16.to_be_bytes())?;
        if accepted.first() != Some(&1) {
            return Err(garbage("it does not speak version 2 of RTDE".into()));
        }
        let all = || RECIPE.into_iter().chain([ANSWER]);
        let names: Vec<&str> = all().map(|(name, _)| name).collect();
        let mut wanted = RATE.to_be_bytes().to_vec();
        wanted.extend(names.join(",").bytes());
        let reply = ask(&mut stream, OUTPUTS, &wanted)?;
        let (recipe, kinds) = reply
            .split_first()
            .ok_or_else(|| garbage("it answers with an empty recipe".into()))?;
        let kinds = String::from_utf8_lossy(kinds);
        for ((name, wanted), kind) in all().zip(kinds.split(',').chain(std::iter::repeat(""))) {
            if kind != wanted {
                let why = format!(
                    "it gives `{name}` as `{kind}`, not as {wanted}: its software is too old"
                );
                return Err(garbage(why));
            }
        }
        if ask(&mut stream, START, &[])?.first() != Some(&1) {
            return Err(garbage("it does not start its stream".into()));
        }
        Ok(Self {
            stream,
            recipe: *recipe,
        })
    }

    /// The next sample.
    pub fn next(&mut self) -> io::Result<Sample> {
        loop {
            let (kind, body) = package(&mut self.stream)?;
            if kind != DATA {
                continue;
            }
            if body.first() != Some(&self.recipe) {
                return Err(garbage("a sample is of another recipe".into()));
            }
            return sample(&body[1..]);
        }
    }
}

/// Reads a sample's numbers, in the order of the recipe.
fn sample(mut body: &[u8]) -> io::Result<Sample> {
    let from = &mut body;
    let sample = Sample {
        clock: double(from)?,
        pose: six(from)?,
        speed: six(from)?,
        robot_mode: int(from)?,
        safety_mode: int(from)?,
        runtime: int(from)?,
        slider: double(from)?,
        payload: double(from)?,
        tool: six(from)?,
        answer: int(from)?,
    };
    Ok(sample)
}

fn six(from: &mut &[u8]) -> io::Result<[f64; 6]> {
    let mut six = [0.0; 6];
    for number in &mut six {
        *number = double(from)?;
    }
    Ok(six)
}

fn double(from: &mut &[u8]) -> io::Result<f64> {
    let mut bytes = [0; 8];
    from.read_exact(&mut bytes)?;
    let number = f64::from_be_bytes(bytes);
    number
        .is_finite()
        .then_some(number)
        .ok_or_else(|| garbage("a sample holds what is no number".into()))
}

fn int(from: &mut &[u8]) -> io::Result<i32> {
    let mut bytes = [0; 4];
    from.read_exact(&mut bytes)?;
    Ok(i32::from_be_bytes(bytes))
}

/// Sends a package, and reads its answer; messages for a person come in between.
fn ask(stream: &mut TcpStream, kind: u8, body: &[u8]) -> io::Result<Vec<u8>> {
    let mut package_out = (body.len() as u16 + 3).to_be_bytes().to_vec();
    package_out.push(kind);
    package_out.extend(body);
    stream.write_all(&package_out)?;
    loop {
        let (answer, body) = package(stream)?;
        if answer == kind {
            return Ok(body);
        }
    }
}

/// One package: its kind and content.
fn package(stream: &mut impl Read) -> io::Result<(u8, Vec<u8>)> {
    let mut header = [0; 3];
    stream.read_exact(&mut header)?;
    let length = usize::from(u16::from_be_bytes([header[0], header[1]]));
    if !(3..=LONGEST).contains(&length) {
        return Err(garbage(format!(
            "a package says that it has {length} bytes"
        )));
    }
    let mut body = vec![0; length - 3];
    stream.read_exact(&mut body)?;
    Ok((header[2], body))
}

fn garbage(why: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_and_samples_of_any_bytes_are_read_or_reported() {
        for bytes in [&[][..], &[0, 2, b'U'], &[0xff; 64], &[0, 9, b'U', 1]] {
            assert!(package(&mut &*bytes).is_err());
            assert!(sample(bytes).is_err());
        }
        let (kind, body) = package(&mut &[0, 4, b'S', 1][..]).expect("a package");
        assert_eq!((kind, body), (b'S', vec![1]));
        // NaN is no place.
        assert!(sample(&[0xff; 400]).is_err());
        assert!(sample(&[0; 400]).is_ok());
    }
}
