//! Universal Robots' real-time data exchange (RTDE): a recipe of quantities, a stream of them, and a sign of life for each that is read.
//!
//! Source: the maker's guide to RTDE, protocol version 2. All numbers are big-endian.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use crate::epoch::Epoch;
use crate::robot::arm::{Condition, Outlet, Pose, Report, Reports, Said, garbage, read_frame};

/// Samples a second.
const RATE: f64 = 250.0;
/// Longest package that is read, in bytes.
const LONGEST: usize = 4_096;
/// The kind of packages that hold data.
const DATA: u8 = b'U';

/// What is asked for, and how each is written.
const RECIPE: [(&str, &str); 13] = [
    ("timestamp", "DOUBLE"),
    ("actual_TCP_pose", "VECTOR6D"),
    ("actual_TCP_speed", "VECTOR6D"),
    ("target_TCP_pose", "VECTOR6D"),
    ("robot_mode", "INT32"),
    ("safety_mode", "INT32"),
    ("runtime_state", "UINT32"),
    ("robot_status_bits", "UINT32"),
    ("target_speed_fraction", "DOUBLE"),
    ("payload", "DOUBLE"),
    ("tcp_offset", "VECTOR6D"),
    // What a script writes for carom to read: an answer, and the last sign of life that it read.
    ("output_int_register_24", "INT32"),
    ("output_int_register_25", "INT32"),
];
/// Where the sign of life goes. One program can claim it.
pub(super) const LIFE: &str = "input_int_register_24";
/// A program that waits for carom's lines echoes one of so many last signs of life.
const ECHOES: i32 = 12;
/// No program is shown for so many samples where one replaces another, and longer where somebody stopped it: 0.1 s.
const REPLACED: u32 = 25;

/// One sample: what the arm does, the share of its speed that the slider lets pass, the tool and its mass (kg), and a script's last answer.
pub(super) struct Sample {
    pub(super) report: Report,
    pub(super) slider: f64,
    pub(super) payload: f64,
    pub(super) tool: Pose,
    pub(super) answer: i32,
}

/// A number that no earlier program used: what it wrote still stands in its register.
pub(super) fn number() -> i32 {
    (Epoch::now().stamp(Instant::now()) / 1_000_000 % 100_000_000) as i32
}

/// A stream of samples.
#[derive(Debug)]
pub(super) struct Stream {
    stream: TcpStream,
    recipe: u8,
    /// The recipe of the sign of life, which is given until that outlet was stopped; none where none is given.
    alive: Option<(u8, Outlet)>,
    life: i32,
    without_program: u32,
}

impl Stream {
    /// Agrees on the recipe, and starts. Errors where the controller does not know a quantity, or where another program gives the sign
    /// of life.
    pub(super) fn start(mut stream: TcpStream, alive: Option<&Outlet>) -> io::Result<Self> {
        if ask(&mut stream, b'V', &2u16.to_be_bytes())?.first() != Some(&1) {
            return Err(garbage("it does not speak version 2 of RTDE"));
        }
        let (names, kinds): (Vec<_>, Vec<_>) = RECIPE.into_iter().unzip();
        let wanted = [&RATE.to_be_bytes(), names.join(",").as_bytes()].concat();
        let recipe = agree(&mut stream, b'O', &wanted, &kinds.join(","))?;
        let inputs = alive
            .map(|_| agree(&mut stream, b'I', LIFE.as_bytes(), "INT32"))
            .transpose()?;
        if ask(&mut stream, b'S', &[])?.first() != Some(&1) {
            return Err(garbage("it does not start its stream"));
        }
        Ok(Self {
            stream,
            recipe,
            alive: inputs.zip(alive.cloned()),
            life: number(),
            without_program: REPLACED,
        })
    }

    /// The next sample, for which a sign of life is given.
    pub(super) fn next(&mut self) -> io::Result<Sample> {
        let body = loop {
            match package(&mut self.stream)? {
                (DATA, body) if body.first() == Some(&self.recipe) => break body,
                (DATA, _) => return Err(garbage("a sample is of another recipe")),
                _ => {}
            }
        };
        if let Some((inputs, _)) = self.alive.as_ref().filter(|alive| !alive.1.is_stopped()) {
            self.life = self.life.wrapping_add(1);
            let sign = [&[*inputs][..], &self.life.to_be_bytes()].concat();
            send(&mut self.stream, DATA, &sign)?;
        }
        self.sample(&body[1..])
    }

    /// Reads a sample's numbers, in the order of the recipe.
    fn sample(&mut self, mut body: &[u8]) -> io::Result<Sample> {
        let from = &mut body;
        let [clock, place @ .., u, v, w, _, _, _] = numbers::<13, 8, _>(from, f64::from_be_bytes)?;
        let [x, y, z, _, _, _] = numbers(from, f64::from_be_bytes)?;
        let states = numbers(from, i32::from_be_bytes)?;
        let [slider, payload, tool @ ..] = numbers::<8, 8, _>(from, f64::from_be_bytes)?;
        let [answer, echo] = numbers(from, i32::from_be_bytes)?;
        Ok(Sample {
            report: Report {
                clock,
                pose: Pose::by_vector(place),
                velocity: [u, v, w],
                condition: self.condition(states, echo),
                wanted: Some([x, y, z]),
            },
            slider,
            payload,
            tool: Pose::by_vector(tool),
            answer,
        })
    }

    /// What the maker's numbers mean.
    fn condition(&mut self, [robot, safety, runtime, bits]: [i32; 4], echo: i32) -> Condition {
        const RUNNING: i32 = 7;
        const NORMAL: i32 = 1;
        const NO_PROGRAM: i32 = 1;
        const PROGRAM: i32 = 2;
        const FREE_DRIVE: i32 = 4;
        let without = self.without_program + 1;
        self.without_program = if runtime == NO_PROGRAM { without } else { 0 };
        let is_waiting = (0..ECHOES).contains(&self.life.wrapping_sub(echo));
        let held = |what, number: i32| Condition::Held(Said(what, number.into()));
        match (robot, safety, runtime) {
            (RUNNING, NORMAL, _) if bits & FREE_DRIVE != 0 => held("free drive, status bits", bits),
            (RUNNING, NORMAL, PROGRAM) if is_waiting => Condition::Ready,
            (RUNNING, NORMAL, NO_PROGRAM) if without > REPLACED => {
                Condition::Stopped(Said("no program runs, runtime state", NO_PROGRAM.into()))
            }
            // A program that stops is one that ends, or is replaced.
            (RUNNING, NORMAL, 0 | NO_PROGRAM | PROGRAM) => Condition::Moving,
            (RUNNING, NORMAL, _) => held("its program is held, runtime state", runtime),
            (RUNNING, ..) => held("safety mode", safety),
            _ => held("robot mode", robot),
        }
    }
}

impl Reports for Stream {
    fn next(&mut self) -> io::Result<Report> {
        Stream::next(self).map(|sample| sample.report)
    }
}

/// The next numbers, of `B` bytes each.
fn numbers<const N: usize, const B: usize, T: Copy + Default>(
    from: &mut &[u8],
    number: fn([u8; B]) -> T,
) -> io::Result<[T; N]> {
    let mut numbers = [T::default(); N];
    for one in &mut numbers {
        let mut bytes = [0; B];
        from.read_exact(&mut bytes)?;
        *one = number(bytes);
    }
    Ok(numbers)
}

/// Asks for a recipe; gives its number. Errors where other kinds of numbers are given: `ResourceBusy` where another program claims one.
fn agree(stream: &mut TcpStream, kind: u8, wanted: &[u8], kinds: &str) -> io::Result<u8> {
    let reply = ask(stream, kind, wanted)?;
    let (recipe, given) = reply.split_first().unwrap_or((&0, &[]));
    match String::from_utf8_lossy(given) {
        given if given == kinds => Ok(*recipe),
        given if given.contains("IN_USE") => Err(io::ErrorKind::ResourceBusy.into()),
        given => Err(garbage(format!(
            "it gives {given} for {kinds}: its software is too old"
        ))),
    }
}

/// Sends a package, and reads its answer; messages for a person come in between.
fn ask(stream: &mut TcpStream, kind: u8, body: &[u8]) -> io::Result<Vec<u8>> {
    send(stream, kind, body)?;
    loop {
        let (answer, body) = package(stream)?;
        if answer == kind {
            return Ok(body);
        }
    }
}

fn send(stream: &mut TcpStream, kind: u8, body: &[u8]) -> io::Result<()> {
    let length = (body.len() as u16 + 3).to_be_bytes();
    stream.write_all(&[&length, &[kind][..], body].concat())
}

/// One package: its kind and content.
fn package(stream: &mut impl Read) -> io::Result<(u8, Vec<u8>)> {
    let length = |[high, low, _]: [u8; 3]| usize::from(u16::from_be_bytes([high, low]));
    let mut package = read_frame(stream, length, 3..=LONGEST)?;
    let body = package.split_off(3);
    Ok((package[2], body))
}
