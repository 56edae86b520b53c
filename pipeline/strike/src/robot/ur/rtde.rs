//! Universal Robots' real-time data exchange (RTDE): a recipe of quantities, a stream of them, and for each that is read a sign of life and
//! the number of the line that is to be moved.
//!
//! Source: the maker's guide to RTDE, protocol version 2. All numbers are big-endian.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering::Relaxed};

use crate::robot::arm::{Condition, Outlet, Pose, Report, Reports, Said, garbage, read_frame};

/// Samples a second.
const RATE: f64 = 250.0;
/// Longest package that is read, in bytes.
const LONGEST: usize = 4_096;
/// The kind of packages that hold data.
const DATA: u8 = b'U';
/// Output recipe: quantities that the controller sends, and their types. The last two are what a program writes for carom to read: an answer, and the
/// last sign of life that it read.
const TOLD: [&str; 2] = [
    "timestamp,actual_TCP_pose,actual_TCP_speed,target_TCP_pose,robot_mode,safety_mode,runtime_state,robot_status_bits,\
     target_speed_fraction,payload,tcp_offset,output_int_register_24,output_int_register_25",
    "DOUBLE,VECTOR6D,VECTOR6D,VECTOR6D,INT32,INT32,UINT32,UINT32,DOUBLE,DOUBLE,VECTOR6D,INT32,INT32",
];
/// Input recipe: a sign of life, and the number of a line. One program can claim them.
const GIVEN: [&str; 2] = ["input_int_register_24,input_int_register_25", "INT32,INT32"];
/// Number of last signs of life one of which a program that waits for carom's lines echoes.
const ECHOES: i32 = 12;
/// Number of samples without a running program where one replaces another, and longer where somebody stopped it: 0.1 s.
const REPLACED: u32 = 25;

/// One sample: what the arm does, the share of its speed that the slider lets pass, the tool and its mass (kg), and a script's last answer.
pub(super) struct Sample {
    pub(super) report: Report,
    pub(super) slider: f64,
    pub(super) payload: f64,
    pub(super) tool: Pose,
    pub(super) answer: i32,
}

/// Signs of life are given until the outlet is stopped, with the number of the line that is to be moved.
pub(super) type Alive = (Outlet, Arc<AtomicI32>);

#[derive(Debug)]
pub(super) struct Stream {
    stream: TcpStream,
    /// Numbers of the output recipe and of the input recipe.
    recipes: [u8; 2],
    alive: Option<Alive>,
    life: i32,
    without_program: u32,
}

impl Stream {
    /// Agrees on both recipes, and starts the stream. Errors where the controller does not know a quantity, or where another program gives signs of
    /// life.
    pub(super) fn start(mut stream: TcpStream, alive: Option<Alive>) -> io::Result<Self> {
        if ask(&mut stream, b'V', &2u16.to_be_bytes())?.first() != Some(&1) {
            return Err(garbage("it does not speak version 2 of RTDE"));
        }
        let told = [&RATE.to_be_bytes(), TOLD[0].as_bytes()].concat();
        let told = agree(&mut stream, b'O', &told, TOLD[1])?;
        let mut claim = || agree(&mut stream, b'I', GIVEN[0].as_bytes(), GIVEN[1]);
        let given = alive.as_ref().map_or(Ok(0), |_| claim())?;
        if ask(&mut stream, b'S', &[])?.first() != Some(&1) {
            return Err(garbage("it does not start its stream"));
        }
        Ok(Self {
            stream,
            recipes: [told, given],
            life: alive.as_ref().map_or(0, |(_, line)| line.load(Relaxed)),
            alive,
            without_program: REPLACED,
        })
    }

    /// The next sample, for which a sign of life is given.
    pub(super) fn next(&mut self) -> io::Result<Sample> {
        let body = loop {
            match read(&mut self.stream)? {
                (DATA, body) if body.first() == Some(&self.recipes[0]) => break body,
                (DATA, _) => return Err(garbage("a sample is of another recipe")),
                _ => {}
            }
        };
        if let Some((outlet, line)) = &self.alive {
            self.life = self.life.wrapping_add(1);
            let [life, line] = [self.life, line.load(Relaxed)].map(i32::to_be_bytes);
            let sign = package(DATA, &[&self.recipes[1..], &life, &line].concat());
            let sent = outlet.send(&self.stream, &sign);
            sent.or_else(|error| outlet.is_stopped().then_some(()).ok_or(error))?;
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

/// Agrees on a recipe; gives its number. Errors where other kinds of numbers are given: `ResourceBusy` where another program claims one.
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
    stream.write_all(&package(kind, body))?;
    loop {
        let (answer, body) = read(stream)?;
        if answer == kind {
            return Ok(body);
        }
    }
}

fn package(kind: u8, body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u16 + 3).to_be_bytes();
    [&length, &[kind][..], body].concat()
}

fn read(stream: &mut impl Read) -> io::Result<(u8, Vec<u8>)> {
    let length = |[high, low, _]: [u8; 3]| usize::from(u16::from_be_bytes([high, low]));
    let mut package = read_frame(stream, length, 3..=LONGEST)?;
    let body = package.split_off(3);
    Ok((package[2], body))
}
