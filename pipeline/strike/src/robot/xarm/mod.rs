//! UFACTORY's xArm7 over its private TCP protocol.
//!
//! The driver connects, checks, enables, moves at travel height and at most 100 mm/s to the start, down, along one straight line
//! through the strike point, and up. It never clears an error, never clamps a value, and stops with state 4. While anything
//! moves, every report is compared with the line that was commanded ([`guard`]); what does not keep to it is stopped from the thread
//! that reads the reports. None of this is safety-rated.

mod control;
mod guard;
mod ports;
mod record;
mod setup;
mod version;
mod watch;
mod wire;

use std::net::TcpStream;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};
use std::{fmt, io};

use values::Rig;

pub use control::StopHandle;
use control::{CONNECT, Control};
use guard::{Line, norm};
pub use ports::Ports;
use record::samples;
use setup::{Setup, TRAVEL};
use version::check_version;
use watch::Watch;
pub use wire::{Register, line_payload, request};

use super::{Robot, RobotError, StrikeRecord};
use crate::{Plan, Ramp};

/// A line may take this share and this many seconds longer than planned.
const LONGER: (f64, f64) = (0.5, 1.0);
/// The controller settles after it was enabled within this time.
const READY_TIMEOUT: Duration = Duration::from_secs(2);
/// A report comes within this time, and after a stop the arm rests within it.
const PATIENCE: Duration = Duration::from_secs(1);
/// States of the controller: in motion, ready.
const READY: [u8; 2] = [0, 2];
/// Another program has paused its motion.
const PAUSED: u8 = 3;
/// The delivered speed may differ from the commanded one by this share before it is reported.
const SPEED_WARNING: f64 = 0.01;
/// Shorter lines than this, in mm, are not moved.
const SHORTEST: f64 = 0.2;

/// What is checked last, when the tip is down at the start of the strike; it returns why the strike must not be made.
struct LastCheck(Box<dyn FnMut() -> Result<(), String> + Send>);

impl fmt::Debug for LastCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("LastCheck")
    }
}

/// An xArm7, connected.
#[derive(Debug)]
pub struct XArm {
    name: String,
    ports: Ports,
    setup: Setup,
    control: Control,
    watch: Watch,
    stop: StopHandle,
    interrupted: Arc<AtomicBool>,
    is_moving: bool,
    last_check: Option<LastCheck>,
}

impl XArm {
    /// Connects; moves nothing. `interrupted` stops the arm once it is set, as from a signal's handler. Errors where the rig file
    /// lacks what an arm needs, or nothing answers.
    pub fn connect(
        name: &str,
        ports: Ports,
        rig: &Rig,
        interrupted: Arc<AtomicBool>,
    ) -> Result<Self, RobotError> {
        let setup = Setup::of(rig).map_err(|why| not_ready(name, why))?;
        let failed = |error: io::Error| unreachable_arm(name, &error);
        let control = Control::connect(ports.control).map_err(failed)?;
        let stop = control.stop_handle();
        let watch =
            Watch::start(ports.realtime, stop.clone(), interrupted.clone()).map_err(failed)?;
        Ok(Self {
            name: name.into(),
            ports,
            setup,
            control,
            watch,
            stop,
            interrupted,
            is_moving: false,
            last_check: None,
        })
    }

    /// The same with a last check, made when the tip is down at the start of the strike: that the object still lies where it was
    /// planned for, say. Where it errors, nothing is struck.
    pub fn with_last_check(
        mut self,
        check: impl FnMut() -> Result<(), String> + Send + 'static,
    ) -> Self {
        self.last_check = Some(LastCheck(Box::new(check)));
        self
    }

    /// Stops the arm from any thread, while it strikes too.
    pub fn stop_handle(&self) -> StopHandle {
        self.stop.clone()
    }

    fn not_ready(&self, why: impl Into<String>) -> RobotError {
        not_ready(&self.name, why)
    }

    fn unreachable(&self, error: &io::Error) -> RobotError {
        unreachable_arm(&self.name, error)
    }

    /// The tool and the errors that the controller reports.
    fn status(&self) -> io::Result<wire::Status> {
        let mut stream = TcpStream::connect_timeout(&self.ports.report, CONNECT)?;
        stream.set_read_timeout(Some(CONNECT))?;
        wire::read_status(&mut stream)
    }

    /// All motions of a strike. Errors with the line that was not ended, and why.
    fn move_all(&mut self, plan: &Plan) -> Result<Instant, (&'static str, String)> {
        let during = |what| move |error: io::Error| (what, error.to_string());
        let control = &mut self.control;
        control.enable().map_err(during("enable"))?;
        control.set_mode(0).map_err(during("enable"))?;
        control.set_state(0).map_err(during("enable"))?;
        self.wait_until_ready().map_err(|why| ("enable", why))?;
        let (jerk, acceleration) = (self.setup.jerk, self.setup.acceleration);
        self.control.set_jerk(jerk).map_err(during("enable"))?;
        self.control
            .set_acceleration(acceleration.max(TRAVEL.1))
            .map_err(during("enable"))?;

        let here = self.control.pose().map_err(during("travel"))?;
        let above = self
            .setup
            .high(self.setup.on_table([here[0], here[1], here[2]]));
        let (start, stop) = (plan.start, plan.stop);
        self.travel("lift", above)?;
        self.travel("travel", self.setup.high(start))?;
        self.travel("lower", self.setup.low(start))?;
        self.watch.record();
        if let Some(LastCheck(check)) = &mut self.last_check {
            check().map_err(|why| ("strike", why))?;
        }
        let begun = self.strike_line(plan)?;
        self.travel("raise", self.setup.high(stop))?;
        Ok(begun)
    }

    /// Waits until the controller is ready to move.
    fn wait_until_ready(&mut self) -> Result<(), String> {
        let until = Instant::now() + READY_TIMEOUT;
        loop {
            let state = self.control.state().map_err(|error| error.to_string())?;
            if READY.contains(&state) {
                return Ok(());
            }
            if Instant::now() > until {
                return Err(format!(
                    "the controller does not become ready, state {state}"
                ));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn travel(
        &mut self,
        what: &'static str,
        to: [f64; 3],
    ) -> Result<Instant, (&'static str, String)> {
        let (speed, acceleration) = TRAVEL;
        self.line(what, to, speed, acceleration, None)
    }

    fn strike_line(&mut self, plan: &Plan) -> Result<Instant, (&'static str, String)> {
        let (speed, to) = (plan.speed * 1e3, self.setup.low(plan.stop));
        let reached_at = plan.start.distance(plan.pre_strike) * 1e3;
        self.line(
            "strike",
            to,
            speed,
            self.setup.acceleration,
            Some(reached_at),
        )
    }

    /// One straight line from where the tip is to a place in the arm's frame (mm), guarded. Gives when it was accepted.
    fn line(
        &mut self,
        what: &'static str,
        to: [f64; 3],
        speed: f64,
        acceleration: f64,
        reached_at: Option<f64>,
    ) -> Result<Instant, (&'static str, String)> {
        let failed = |why: String| (what, why);
        if self.interrupted.load(Ordering::Relaxed) {
            return Err(failed("it was interrupted by a signal".into()));
        }
        let last = self
            .watch
            .next(PATIENCE)
            .ok_or_else(|| failed("its reports ceased before the line".into()))?;
        let [x, y, z, ..] = last.report.pose;
        let line = Line {
            from: [x, y, z],
            to,
            speed,
            reached_at,
        };
        if line.length() < SHORTEST {
            return Ok(Instant::now());
        }
        self.is_moving = true;
        self.watch.guard(line);
        let [roll, pitch, yaw] = self.setup.orientation;
        self.control
            .move_line([to[0], to[1], to[2], roll, pitch, yaw], speed, acceleration)
            .map_err(|error| failed(self.watch.fault().unwrap_or_else(|| error.to_string())))?;
        let begun = Instant::now();
        let ramps = 2.0 * Ramp::to(speed, acceleration, Some(self.setup.jerk)).duration;
        let (share, more) = LONGER;
        let patience = (line.length() / speed + ramps) * (1.0 + share) + more;
        self.watch
            .wait_for_end(Duration::from_secs_f64(patience))
            .map_err(failed)?;
        Ok(begun)
    }

    /// How far (m) the tip has come since recording began.
    fn moved(&self) -> f64 {
        let record = self.watch.recorded();
        let place = |sample: &guard::Sample| {
            let [x, y, z, ..] = sample.report.pose;
            [x, y, z]
        };
        record
            .windows(2)
            .map(|pair| guard::distance(place(&pair[0]), place(&pair[1])))
            .sum::<f64>()
            * 1e-3
    }
}

impl Robot for XArm {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn check(&mut self, plan: &Plan) -> Result<(), RobotError> {
        let version = self.control.version().map_err(|e| self.unreachable(&e))?;
        check_version(&version).map_err(|why| self.not_ready(why))?;
        let (error, warning) = self.control.error().map_err(|e| self.unreachable(&e))?;
        let status = self.status().map_err(|e| self.unreachable(&e))?;
        for (error, warning) in [(error, warning), (status.error, status.warning)] {
            if error != 0 || warning != 0 {
                return Err(self.not_ready(format!(
                    "the controller reports error {error} and warning {warning}; look them up in the arm's manual, mend the cause, and \
                     clear them by the arm's own program"
                )));
            }
        }
        self.setup
            .check_tool(&status)
            .map_err(|why| self.not_ready(why))?;
        let Some(last) = self.watch.next(PATIENCE) else {
            return Err(self.not_ready("no real-time report comes"));
        };
        if norm(last.report.velocity) > 1.0 || last.report.state == 1 {
            return Err(self.not_ready("the arm is moving"));
        }
        if last.report.mode != 0 || last.report.state == PAUSED {
            return Err(self.not_ready(format!(
                "another program uses the arm: mode {}, state {}; end it first",
                last.report.mode, last.report.state
            )));
        }
        let pose = self.control.pose().map_err(|e| self.unreachable(&e))?;
        self.setup
            .check_orientation(pose)
            .map_err(|why| self.not_ready(why))?;
        let here = self.setup.on_table([pose[0], pose[1], pose[2]]);
        plan.check_approach(here).map_err(|why| self.not_ready(why))
    }

    fn strike(&mut self, plan: &Plan) -> Result<Option<StrikeRecord>, RobotError> {
        let clock = (SystemTime::now(), Instant::now());
        // The motion has a thread of its own; a panic of it stops the arm like any other failure.
        let outcome = std::thread::scope(|scope| {
            let motion = AssertUnwindSafe(|| self.move_all(plan));
            let thread = scope.spawn(move || panic::catch_unwind(motion));
            thread.join().unwrap_or_else(Err)
        });
        let record = self.watch.recorded();
        match outcome {
            Ok(Ok(begun)) => {
                self.is_moving = false;
                let (samples, delivered) = samples(&record, plan, &self.setup, clock, begun);
                let warning = delivered
                    .filter(|delivered| (delivered / plan.speed - 1.0).abs() > SPEED_WARNING)
                    .map(|delivered| {
                        format!(
                            "the arm delivered {delivered:.4} m/s of {:.4} m/s at the impact: look at its load, reach and jerk",
                            plan.speed
                        )
                    });
                Ok(Some(StrikeRecord {
                    samples,
                    stop: None,
                    delivered_speed: delivered,
                    warning,
                }))
            }
            failed => {
                let stopped = self.stop.stop();
                let (what, why) = match failed {
                    Ok(Err(line_and_why)) => line_and_why,
                    _ => ("strike", "the driver panicked".to_owned()),
                };
                let unsent = stopped.err().map_or(String::new(), |error| {
                    format!("; the stop could not be sent: {error}")
                });
                let (samples, _) = samples(&record, plan, &self.setup, clock, clock.1);
                Err(RobotError::Interrupted {
                    robot: self.name.clone(),
                    why: format!(
                        "{why}, while it was to `{what}`; since the record began the tip had moved {:.3} m{unsent}",
                        self.moved()
                    ),
                    samples: (!record.is_empty()).then(|| Box::new(samples)),
                })
            }
        }
    }

    /// Sends the stop, again over a new connection where the arm is not seen at rest after it.
    fn abort(&mut self) -> Result<(), RobotError> {
        let sent = self.stop.stop();
        self.is_moving = false;
        if sent.is_ok() && self.watch.rests_within(PATIENCE) {
            return Ok(());
        }
        let again = Control::connect(self.ports.control).and_then(|mut control| {
            control.set_state(4)?;
            control.state()
        });
        match again {
            Ok(4 | 5) => Ok(()),
            Ok(state) => Err(RobotError::Connection {
                robot: self.name.clone(),
                why: format!("the controller was sent a stop and is in state {state}"),
            }),
            Err(error) => Err(self.unreachable(&error)),
        }
    }
}

impl Drop for XArm {
    /// Whatever ends the program's use of it: what moves is stopped.
    fn drop(&mut self) {
        if self.is_moving {
            // Nobody is left to report an error to.
            let _ = self.stop.stop();
        }
    }
}

fn not_ready(name: &str, why: impl Into<String>) -> RobotError {
    RobotError::NotReady {
        robot: name.into(),
        why: why.into(),
    }
}

fn unreachable_arm(name: &str, error: &io::Error) -> RobotError {
    RobotError::Connection {
        robot: name.into(),
        why: format!("{error}; check its power and network, and that no other program drives it"),
    }
}
