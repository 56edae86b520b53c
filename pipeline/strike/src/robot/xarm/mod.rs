//! UFACTORY's xArm5, 6 and 7 and Lite6 over their private TCP protocol. Stopping is state 4.

mod control;
mod wire;

use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use std::{io, thread};

use control::Control;

use super::arm::{
    Arm, ArmLimits, CONNECT, Condition, Identity, LineRequest, Outlet, Ports, Pose, Report,
    Reports, Said, Status, Turn, listen, shown, start, version_in,
};

pub use wire::{Register, line_payload, request};

/// mm in a metre.
const MM: f64 = 1e3;
/// Gravity's direction in the frame of an upright base, and by how much it may differ.
const UPRIGHT: ([f64; 3], f64) = ([0.0, 0.0, -1.0], 0.01);
/// Greatest shift of the controller's frame, in mm and rad.
const SHIFTED: (f64, f64) = (0.05, 0.001);

/// An arm, connected. Its ports: requests and replies, the real-time report at up to 250 Hz, the ordinary one, which is not read, and the
/// rich one at 5 Hz, which holds what the controller is set to.
#[derive(Debug)]
pub struct XArm {
    control: Control,
    ports: Ports,
    axes: u32,
}

/// The real-time report, and whether the rich one has shown that a motor was switched off.
struct Stream {
    reports: TcpStream,
    is_off: Arc<AtomicBool>,
}

impl Stream {
    /// Watches the motors' state, which only the rich report holds, until the stream is dropped.
    fn watch_motors(is_off: &Arc<AtomicBool>, address: SocketAddr) {
        let mut before = 0;
        let mut rich = None;
        while Arc::strong_count(is_off) > 1 {
            let stream = match rich.take() {
                Some(stream) => Ok(stream),
                None => listen(address, CONNECT),
            };
            let read = stream.and_then(|mut stream| {
                let settings = wire::read_settings(&mut stream)?;
                Ok((stream, settings.enabled))
            });
            match read {
                Ok((stream, on)) => {
                    is_off.fetch_or(before & !on != 0, Ordering::Relaxed);
                    (rich, before) = (Some(stream), on);
                }
                // Without it motors are looked at before each strike alone.
                Err(_) => thread::sleep(CONNECT / 10),
            }
        }
    }
}

impl Reports for Stream {
    fn next(&mut self) -> io::Result<Report> {
        let report = wire::read_realtime(&mut self.reports)?;
        let condition = match self.is_off.load(Ordering::Relaxed) {
            true => Condition::Held(Said("motors were switched off, state", report.state.into())),
            false => condition(report.mode, report.state, report.held),
        };
        Ok(Report {
            clock: report.clock as f64 * 1e-6,
            pose: pose(report.pose),
            velocity: report.velocity.map(|speed| speed / MM),
            condition,
            wanted: None,
        })
    }
}

/// The condition by the maker's numbers of mode and state, and of lines held. One line is sent at a time: where more are held, others are another
/// program's.
fn condition(mode: u8, state: u8, held: u16) -> Condition {
    match (mode, state) {
        (0, 0 | 2) => Condition::Ready,
        (0, 1) if held > 1 => {
            Condition::Held(Said("another program sends lines, held are", held.into()))
        }
        (0, 1) => Condition::Moving,
        (0, 4 | 5) => Condition::Stopped(Said("state", state.into())),
        (0, 3) => Condition::Held(Said("paused, state", 3)),
        (0, _) => Condition::Held(Said("state", state.into())),
        _ => Condition::Held(Said("mode", mode.into())),
    }
}

fn pose([x, y, z, roll, pitch, yaw]: [f64; 6]) -> Pose {
    Pose {
        at: [x, y, z].map(|length| length / MM),
        turn: Turn::rpy([roll, pitch, yaw]),
    }
}

/// The maker's numbers of a line: pose in mm and rad, mm/s, mm/s².
fn numbers(line: &LineRequest) -> ([f64; 6], f64, f64) {
    let [x, y, z] = line.to.at.map(|length| length * MM);
    let [roll, pitch, yaw] = line.to.turn.to_rpy();
    (
        [x, y, z, roll, pitch, yaw],
        line.speed * MM,
        line.acceleration * MM,
    )
}

impl Arm for XArm {
    const PORTS: [u16; 4] = [502, 30_000, 30_001, 30_002];
    const ANSWERS: bool = true;

    fn connect(ports: &Ports, patience: Duration) -> io::Result<Self> {
        Ok(Self {
            control: Control::connect(ports[0], patience)?,
            ports: *ports,
            axes: 7,
        })
    }

    fn reports(&self) -> io::Result<Box<dyn Reports>> {
        let reports = listen(self.ports[1], CONNECT)?;
        let is_off = Arc::new(AtomicBool::new(false));
        let (watched, address) = (is_off.clone(), self.ports[3]);
        start("arm-motors", move || {
            Stream::watch_motors(&watched, address);
        })?;
        Ok(Box::new(Stream { reports, is_off }))
    }

    fn outlet(&self) -> &Outlet {
        &self.control.outlet
    }

    fn identify(&mut self) -> io::Result<Result<Identity, String>> {
        let version = self.control.version()?;
        Ok(identify(&version).map(|(identity, axes)| {
            self.axes = axes;
            identity
        }))
    }

    fn status(&mut self) -> io::Result<Status> {
        let codes = self.control.error()?;
        let settings = wire::read_settings(&mut listen(self.ports[3], CONNECT)?)?;
        let motors = (1u8 << self.axes) - 1;
        Ok(Status {
            is_enabled: settings.enabled & motors == motors,
            tool: pose(settings.tool_offset),
            payload: settings.payload,
            wrong: wrong(codes, &settings),
            fence: settings
                .fence
                .map(|[x_high, x_low, y_high, y_low, z_high, z_low]| {
                    let corner = |corner: [f64; 3]| corner.map(|length| length / MM);
                    [
                        corner([x_low, y_low, z_low]),
                        corner([x_high, y_high, z_high]),
                    ]
                }),
            changed: vec![settings.jerk, settings.acceleration],
        })
    }

    fn pose(&mut self) -> io::Result<Pose> {
        self.control.pose().map(pose)
    }

    fn enable(&mut self, go_on: &mut dyn FnMut() -> io::Result<()>) -> io::Result<()> {
        // Its mode takes positions already: another one is somebody's.
        self.control.enable()?;
        go_on()?;
        self.control.set_state(0)
    }

    fn set_ramp(&mut self, acceleration: f64, jerk: Option<f64>) -> io::Result<()> {
        if let Some(jerk) = jerk {
            self.control.set_jerk(jerk * MM)?;
        }
        self.control.set_acceleration(acceleration * MM)
    }

    fn put_back(&mut self, before: &Status) -> io::Result<()> {
        let [jerk, acceleration] = before.changed[..] else {
            return Ok(());
        };
        self.control.set_jerk(jerk)?;
        self.control.set_acceleration(acceleration)
    }

    fn can_move(&mut self, lines: &[LineRequest]) -> io::Result<Result<(), (usize, String)>> {
        for (number, line) in lines.iter().enumerate() {
            // `only_check_type` of the maker's SDK: 1 from where the arm is, 3 from the end of what was checked last, 2 the same for the
            // last one, after which the controller begins again from where the arm is.
            let kind = match number {
                0 => 1,
                _ if number + 1 < lines.len() => 3,
                _ => 2,
            };
            let (pose, speed, acceleration) = numbers(line);
            let code = self.control.check_line(pose, speed, acceleration, kind)?;
            if code != 0 {
                let why = format!(
                    "code {code} (a joint's limit or speed, or the arm's own parts: look it up in the arm's manual); lay the object \
                     elsewhere, or begin from another pose"
                );
                return Ok(Err((number, why)));
            }
        }
        Ok(Ok(()))
    }

    fn line(&mut self, line: &LineRequest) -> io::Result<()> {
        let (pose, speed, acceleration) = numbers(line);
        self.control.move_line(pose, speed, acceleration)
    }
}

/// Why an arm that is set so must not strike.
fn wrong((error, warning): (u8, u8), settings: &wire::Settings) -> Vec<String> {
    let mut wrong = Vec::new();
    for (error, warning) in [(error, warning), (settings.error, settings.warning)] {
        if error != 0 || warning != 0 {
            wrong.push(format!(
                "the controller reports error {error} and warning {warning}; look them up in the arm's manual, mend the cause, and clear \
                 them by the arm's own program"
            ));
        }
    }
    let (far, turned) = SHIFTED;
    let [x, y, z, turns @ ..] = settings.world_offset;
    let is_shifted =
        [x, y, z].iter().any(|v| v.abs() > far) || turns.iter().any(|v| v.abs() > turned);
    if is_shifted || settings.world_offset.iter().any(|v| !v.is_finite()) {
        wrong.push(format!(
            "the controller shifts its frame by the world offset {} (mm, rad); set it to zero by the arm's own program, and state where \
             the base stands in the rig file: robot.base, base_yaw, base_height",
            shown(&settings.world_offset)
        ));
    }
    let (upright, tilted) = UPRIGHT;
    let is_upright = settings
        .gravity
        .iter()
        .zip(upright)
        .all(|(a, b)| (a - b).abs() <= tilted);
    for (is_wrong, what) in [
        (
            !is_upright,
            "the controller is set to an arm that does not stand upright (mount direction); set it as the arm stands, which must be upright",
        ),
        (
            settings.sensitivity == 0,
            "the arm's detection of collisions is off (sensitivity 0); set it to 1 or more by the arm's own program",
        ),
        (
            settings.is_reduced,
            "the arm is in reduced mode, which lowers speeds in silence; leave it by the arm's own program",
        ),
        (
            settings.is_simulated,
            "the controller only simulates its arm; leave that by the arm's own program",
        ),
    ] {
        if is_wrong {
            wrong.push(what.into());
        }
    }
    wrong
}

/// The oldest firmware whose real-time report is served.
const FIRMWARE: (u32, u32) = (2, 1);
/// Number of the Lite6's kind; an xArm's is the number of its axes.
const LITE6: u32 = 9;

/// An xArm5, 6 or 7, or a Lite6, with a firmware that serves what is read; the text is as `7,7,SN,BOX,v2.4.0`. Gives the arm and its
/// number of axes.
pub(super) fn identify(text: &str) -> Result<(Identity, u32), String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let digits = |text: &str| {
        let digits = text.trim_start_matches(|c: char| !c.is_ascii_digit());
        let end = digits
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(digits.len());
        digits[..end].parse::<u32>().ok()
    };
    let [axes, kind, serial, _, _, ..] = parts[..] else {
        return Err(format!(
            "the controller says `{text}`: it is none of an xArm"
        ));
    };
    let speed = match (digits(axes), digits(kind)) {
        (Some(axes @ 5..=7), Some(kind)) if axes == kind => 1.0,
        (Some(6), Some(LITE6)) => 0.5,
        _ => {
            return Err(format!(
                "the controller says `{text}`: this drives an xArm5, xArm6, xArm7 or Lite6"
            ));
        }
    };
    if parts
        .last()
        .and_then(|text| version_in(text))
        .is_none_or(|found| found < FIRMWARE)
    {
        return Err(format!(
            "the controller says `{text}`: its firmware must be {}.{} or later",
            FIRMWARE.0, FIRMWARE.1
        ));
    }
    if serial.is_empty() {
        return Err(format!(
            "the controller says `{text}`: it states no serial number, by which one program claims it"
        ));
    }
    let limits = ArmLimits {
        speed,
        acceleration: 50.0,
        jerk: Some(100.0),
        start: Duration::from_millis(60),
    };
    let identity = Identity {
        serial: serial.to_owned(),
        limits,
    };
    Ok((identity, digits(axes).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arms_by_their_axes_with_a_new_firmware_are_driven_and_no_others() {
        for (text, axes, speed) in [
            ("7,7,XI1300,AC1300,v2.1.0", 7, 1.0),
            ("v6,6,a,b,V2.10.3", 6, 1.0),
            ("5,5,a,b,v10.0.0", 5, 1.0),
            ("6,9,a,b,v2.4.105", 6, 0.5),
        ] {
            let (identity, found) = identify(text).expect(text);
            assert_eq!((found, identity.limits.speed), (axes, speed), "{text}");
        }
        for (text, said) in [
            ("7,7,XI1300,AC1300,v1.12.10", "firmware"),
            ("7,7,a,b,v2.0.9", "firmware"),
            ("7,7,a,b,vx", "firmware"),
            ("6,12,a,b,v2.4.0", "xArm5"),
            ("8,8,a,b,v2.4.0", "xArm5"),
            ("7,7,,b,v2.4.0", "serial"),
            ("", "none"),
            ("7", "none"),
        ] {
            let error = identify(text).expect_err(text);
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
