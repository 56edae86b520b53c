//! A Universal Robots controller: RTDE, the ports that take scripts, and the dashboard, before the same arm and the same faults.
//!
//! Poses of the arm are mm and, in place of roll, pitch and yaw, a rotation vector.

use std::io::Write;
use std::net::{Shutdown, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use crate::frames::Reported;
use crate::shared::{Shared, is_cut, is_dead, is_held, is_shut, more};
use crate::{Fault, Step};

/// What a script is looked for so often.
const TICK: Duration = Duration::from_millis(5);
/// Kinds of quantities by their names, as the maker's guide lists them; those that are not named are vectors of six.
fn kind(name: &str) -> &'static str {
    match name {
        "timestamp"
        | "actual_execution_time"
        | "speed_scaling"
        | "target_speed_fraction"
        | "actual_momentum"
        | "actual_main_voltage"
        | "actual_robot_voltage"
        | "actual_robot_current"
        | "standard_analog_input0"
        | "standard_analog_input1"
        | "standard_analog_output0"
        | "standard_analog_output1"
        | "payload" => "DOUBLE",
        "actual_digital_input_bits" | "actual_digital_output_bits" => "UINT64",
        "robot_mode" | "safety_mode" => "INT32",
        "runtime_state"
        | "robot_status_bits"
        | "safety_status_bits"
        | "output_bit_registers0_to_31"
        | "output_bit_registers32_to_63" => "UINT32",
        "joint_mode" => "VECTOR6INT32",
        "actual_tool_accelerometer" | "payload_cog" => "VECTOR3D",
        _ if name.starts_with("output_int_register_") => "INT32",
        _ if name.starts_with("output_double_register_") => "DOUBLE",
        _ if name.contains("input") => "NOT_FOUND",
        _ => "VECTOR6D",
    }
}

/// The bytes of a quantity.
fn value(name: &str, shown: &Reported) -> Vec<u8> {
    let doubles = |numbers: &[f64]| numbers.iter().flat_map(|v| v.to_be_bytes()).collect();
    let metres = |mut pose: [f64; 6]| {
        pose[..3].iter_mut().for_each(|length| *length *= 1e-3);
        pose
    };
    let [x, y, z] = shown.velocity.map(|speed| speed * 1e-3);
    match name {
        "timestamp" => doubles(&[shown.clock as f64 * 1e-6]),
        "actual_TCP_pose" => doubles(&metres(shown.pose)),
        "target_TCP_pose" => doubles(&metres(shown.wanted)),
        "actual_TCP_speed" | "target_TCP_speed" => doubles(&[x, y, z, 0.0, 0.0, 0.0]),
        "tcp_offset" => doubles(&metres(shown.model.tool_offset)),
        "payload" => doubles(&[shown.model.payload]),
        "target_speed_fraction" | "speed_scaling" => {
            doubles(&[if shown.model.modes[0] { 0.5 } else { 1.0 }])
        }
        "robot_mode" => (if shown.enabled { 7i32 } else { 3 }).to_be_bytes().into(),
        "safety_mode" => {
            let mode = match (shown.codes[0], shown.mode) {
                (0, 0) => 1i32,
                (0, _) if shown.is_led => 1,
                (0, _) => 5,
                (2, _) => 7,
                _ => 3,
            };
            mode.to_be_bytes().into()
        }
        "runtime_state" => {
            let state = match shown.state {
                3 => 4u32,
                _ if shown.is_running => 2,
                _ => 1,
            };
            state.to_be_bytes().into()
        }
        "robot_status_bits" => (u32::from(shown.is_led) << 2).to_be_bytes().into(),
        "output_int_register_24" => shown.registers[0].to_be_bytes().into(),
        "output_int_register_25" => shown.registers[1].to_be_bytes().into(),
        _ => match kind(name) {
            "DOUBLE" | "UINT64" => vec![0; 8],
            "INT32" | "UINT32" => vec![0; 4],
            "VECTOR3D" | "VECTOR6INT32" => vec![0; 24],
            _ => vec![0; 48],
        },
    }
}

fn package(kind: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = (body.len() as u16 + 3).to_be_bytes().to_vec();
    bytes.push(kind);
    bytes.extend(body);
    bytes
}

pub(crate) fn rtde(shared: &Shared, mut stream: TcpStream) {
    let since = Instant::now();
    let _ = stream.set_read_timeout(Some(TICK));
    let (mut waiting, mut recipes): (Vec<u8>, Vec<(f64, Vec<String>)>) = Default::default();
    let mut claims = false;
    while !shared.ends() && !is_cut(shared, since) {
        let Some(came) = more(&mut stream) else {
            return;
        };
        if is_dead(shared, since) {
            continue;
        }
        waiting.extend(came);
        while waiting.len() >= 3 {
            let length = usize::from(u16::from_be_bytes([waiting[0], waiting[1]]));
            if length < 3 || waiting.len() < length {
                break;
            }
            let body: Vec<u8> = waiting.drain(..length).skip(2).collect();
            let (kind_of, body) = (body[0], &body[1..]);
            let answer = match kind_of {
                b'v' => [5u32, 11, 1, 0]
                    .iter()
                    .flat_map(|v| v.to_be_bytes())
                    .collect(),
                // One program at a time gives signs of life, and lines.
                b'I' => {
                    let mut state = shared.lock();
                    let is_free = !std::mem::replace(&mut state.is_claimed, true);
                    claims |= is_free;
                    let kind = if is_free { "INT32" } else { "IN_USE" };
                    let names = body.split(|byte| *byte == b',');
                    let kinds: Vec<&str> = names.map(|_| kind).collect();
                    [&[1][..], kinds.join(",").as_bytes()].concat()
                }
                b'O' if body.len() > 8 => {
                    let rate = f64::from_be_bytes(body[..8].try_into().unwrap_or_default());
                    let names = String::from_utf8_lossy(&body[8..]).into_owned();
                    let names: Vec<String> = names.split(',').map(str::to_owned).collect();
                    let kinds: Vec<&str> = names.iter().map(|name| kind(name)).collect();
                    recipes.push((rate.clamp(1.0, 500.0), names));
                    let mut answer = vec![recipes.len() as u8];
                    answer.extend(kinds.join(",").bytes());
                    answer
                }
                _ => vec![1],
            };
            if stream.write_all(&package(kind_of, &answer)).is_err() {
                return;
            }
            if let (b'S', Some((rate, names))) = (kind_of, recipes.last()) {
                let recipe = recipes.len() as u8;
                let signs = stream.try_clone();
                thread::scope(|scope| {
                    if let (true, Ok(signs)) = (claims, signs) {
                        scope.spawn(move || signs_of_life(shared, signs, since));
                    }
                    samples(shared, &stream, since, (recipe, *rate, names));
                    let _ = stream.shutdown(Shutdown::Both);
                });
                return;
            }
        }
    }
}

/// Takes signs of life, until the connection is over; then another program may give them.
fn signs_of_life(shared: &Shared, mut stream: TcpStream, since: Instant) {
    let mut waiting = Vec::new();
    while let (false, Some(came)) = (shared.ends(), more(&mut stream)) {
        waiting.extend(came);
        while waiting.len() >= 12 {
            let sign: Vec<u8> = waiting.drain(..12).collect();
            let [life, number] = [4, 8].map(|at| {
                let four = sign[at..].first_chunk();
                four.map_or(0, |four| i32::from_be_bytes(*four))
            });
            if sign[2] == b'U' && !is_dead(shared, since) {
                shared.lock().is_told_of_life(life, number);
            }
        }
    }
    shared.lock().is_claimed = false;
}

fn samples(
    shared: &Shared,
    mut stream: &TcpStream,
    since: Instant,
    (recipe, rate, names): (u8, f64, &[String]),
) {
    let mut next = Instant::now();
    let mut held = Vec::new();
    while !shared.ends() && !is_cut(shared, since) {
        next += Duration::from_secs_f64(1.0 / rate);
        thread::sleep(next.saturating_duration_since(Instant::now()));
        let made = shared.made();
        let shown = shared.lock().shown();
        if made == Some(Fault::Silent) || is_dead(shared, since) {
            continue;
        }
        let mut body = vec![recipe];
        for name in names {
            body.extend(value(name, &shown));
        }
        let bytes = match made {
            Some(Fault::Garbage) => vec![0xff; body.len() + 3],
            Some(Fault::ShortFrame) => {
                let _ = stream.write_all(&package(b'U', &body)[..20]);
                return;
            }
            _ => [std::mem::take(&mut held), package(b'U', &body)].concat(),
        };
        if is_held(shared) {
            held = bytes;
            continue;
        }
        if stream.write_all(&bytes).is_err() {
            return;
        }
    }
}

/// A port that takes scripts: each replaces the one that runs.
pub(crate) fn script(shared: &Shared, mut stream: TcpStream) {
    let since = Instant::now();
    let _ = stream.set_read_timeout(Some(TICK));
    let mut waiting = String::new();
    while !shared.ends() && !is_shut(shared, since) {
        let Some(came) = more(&mut stream) else {
            return;
        };
        if is_dead(shared, since) {
            continue;
        }
        waiting += &String::from_utf8_lossy(&came);
        while let Some(end) = waiting.find("\nend\n") {
            let text: String = waiting.drain(..end + 5).collect();
            shared.lock().run(&text);
        }
    }
}

pub(crate) fn dashboard(shared: &Shared, mut stream: TcpStream) {
    let since = Instant::now();
    let _ = stream.set_read_timeout(Some(TICK));
    let mut waiting = String::new();
    if stream
        .write_all(b"Connected: Universal Robots Dashboard Server\n")
        .is_err()
    {
        return;
    }
    while !shared.ends() && !is_cut(shared, since) {
        let Some(came) = more(&mut stream) else {
            return;
        };
        if is_dead(shared, since) {
            continue;
        }
        waiting += &String::from_utf8_lossy(&came);
        while let Some(end) = waiting.find('\n') {
            let question: String = waiting.drain(..=end).collect();
            let answer = {
                let mut state = shared.lock();
                if state.is_next(Step::Check) {
                    state.make_fault();
                }
                let shown = state.reported();
                match question.trim() {
                    "PolyscopeVersion" => "URSoftware 5.11.1.108318 (Jan 01 2022)".into(),
                    "get serial number" => state.serial().replace(char::is_alphabetic, ""),
                    "get robot model" => "UR5".into(),
                    "is in remote control" => (!state.model.is_local).to_string(),
                    "robotmode" if shown.enabled => "Robotmode: RUNNING".into(),
                    "robotmode" => "Robotmode: POWER_OFF".into(),
                    "safetymode" => "Safetymode: NORMAL".into(),
                    "safetystatus" => "Safetystatus: NORMAL".into(),
                    "running" => format!("Program running: {}", shown.is_running),
                    "programState" => "STOPPED carom.urp".into(),
                    "stop" => {
                        state.halt();
                        "Stopped".into()
                    }
                    other => format!("could not understand: {other}"),
                }
            };
            let made = shared.made();
            if made == Some(Fault::SlowReplies) {
                thread::sleep(Duration::from_secs(3));
            }
            let answer = match made {
                Some(Fault::GarbageReply) => "\u{fffd}".repeat(20),
                _ => answer,
            };
            if stream.write_all(format!("{answer}\n").as_bytes()).is_err() {
                return;
            }
        }
    }
}
