//! A robot of any maker's driver: what is checked, in which order it moves, and how it is stopped.

use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use std::{fmt, io};

use logs::write::{Samples, Stamped, StateSample};
use values::{Point, Rig};

use super::claim::{Claim, once_free};
use super::connection::{CONNECT, no_thread, what_happened, why_none};
use super::driver::{
    Arm, ArmLimits, Condition, LineRequest, Ports, Pose, Said, Status, distance, norm,
    shown as numbers,
};
use super::guard::{STILL, Sample};
use super::line::{Line, Profile};
use super::outlet::Outlet;
use super::setup::{Height, Setup, TRAVEL};
use super::signals::{alarm, is_read, tell, told};
use super::watch::{RunUp, Watch};
use crate::Plan;
use crate::epoch::Epoch;
use crate::robot::{Robot, RobotError, StrikeRecord};

/// Excess over its planned time that a line may take: as a share, and in s.
const LONGER: (f64, f64) = (0.5, 1.0);
/// Time within which the controller settles after it was made ready.
const READY: Duration = Duration::from_secs(2);
/// Time within which a report must come.
const PATIENCE: Duration = Duration::from_secs(1);
/// After a stop: the time between two questions for rest, that after which a person is told, and that after which it is given up.
const AGAIN: Duration = Duration::from_millis(50);
const TELL: Duration = Duration::from_millis(400);
const GIVE_UP: Duration = Duration::from_millis(1_500);
/// How long an arm that was sent a line and has not answered is watched, and stopped again and again: the line may come late.
const ON_ITS_WAY: Duration = Duration::from_secs(3);
/// How long a new connection may take to ask after a stop.
const QUICK: Duration = Duration::from_millis(100);
/// Differences in m and rad within which a pose that is asked for and the reports agree.
const SAME: (f64, f64) = (0.001, 0.01);
/// Speed, in m/s, below which the arm is at rest.
const SLOW: f64 = 0.001;
/// Greatest distance in m between positions of an arm at rest, and the number of questions for them.
const REST: (f64, u32) = (0.0003, 4);
/// Difference of the delivered speed from the commanded one, as a share, from which it is reported.
const SPEED_WARNING: f64 = 0.01;
/// Length, in m, below which a line is not moved.
const SHORTEST: f64 = 0.0002;

/// When to check that the object still lies where the strike was planned for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Before the tip goes down.
    BeforeDescent,
    /// When the tip is down at the start: the strike is next.
    BeforeStrike,
}

/// The check of the object; errors with why the tip must not go down or strike.
struct LookFirst(Box<dyn FnMut(Look) -> Result<(), String> + Send>);

impl fmt::Debug for LookFirst {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("LookFirst")
    }
}

/// The step that failed, and why.
type Undone = (&'static str, String);

/// An arm, connected and claimed.
#[derive(Debug)]
pub struct Guarded<D: Arm> {
    name: String,
    ports: Ports,
    setup: Setup,
    serial: String,
    limits: ArmLimits,
    driver: D,
    watch: Watch,
    interrupted: Arc<AtomicBool>,
    is_moving: bool,
    /// Whether the arm was found ready, or made so, in this call: whoever stops it from then on is in charge.
    was_ready: bool,
    /// What the controller was set to before a strike changed it.
    before: Option<Status>,
    /// Whether a line was sent and not answered: it may still be on its way.
    is_unanswered: bool,
    /// When the strike's line was accepted.
    begun: Option<Instant>,
    /// Height at which carom left the tip in a strike that was not ended; none where it did not.
    left: Option<Height>,
    /// Whether a line was sent in this strike.
    has_moved: bool,
    look: Option<LookFirst>,
    pause: Duration,
    _claims: [Claim; 2],
}

impl<D: Arm> Guarded<D> {
    /// Connects; moves nothing. `interrupted` stops the arm once it is set, as from a signal's handler. Errors where the rig file
    /// lacks what an arm needs, another program has the arm, it is none that is driven, or nothing answers.
    pub fn connect(
        name: &str,
        ports: &Ports,
        rig: &Rig,
        interrupted: Arc<AtomicBool>,
    ) -> Result<Self, RobotError> {
        let setup = Setup::of(rig).map_err(|why| not_ready(name, why))?;
        let failed = |error: io::Error| match error.kind() {
            io::ErrorKind::ResourceBusy => RobotError::Busy { robot: name.into() },
            _ => unreachable_arm(name, &error),
        };
        let claim = |what: &str| {
            Claim::take(what).map_err(|error| match error.kind() {
                io::ErrorKind::ResourceBusy => failed(error),
                _ => not_ready(name, format!("it could not be claimed: {error}")),
            })
        };
        let by_place = claim(&ports[0].to_string())?;
        let mut driver = D::connect(ports, CONNECT).map_err(failed)?;
        let identity = driver
            .identify()
            .map_err(failed)?
            .map_err(|why| not_ready(name, why))?;
        let by_serial = claim(&identity.serial)?;
        setup
            .check_identity(&identity)
            .map_err(|why| not_ready(name, why))?;
        let reports = once_free(|| driver.reports()).map_err(failed)?;
        let watch =
            Watch::start(reports, driver.outlet().clone(), interrupted.clone()).map_err(failed)?;
        // The first report comes before the arm's state is asked for: a stop from now on shows as a change.
        watch.next(PATIENCE).map_err(|why| not_ready(name, why))?;
        // What moves it from where it is now is somebody else.
        watch.release();
        Ok(Self {
            name: name.into(),
            ports: *ports,
            setup,
            serial: identity.serial,
            limits: identity.limits,
            driver,
            watch,
            interrupted,
            is_moving: false,
            is_unanswered: false,
            was_ready: false,
            before: None,
            begun: None,
            left: None,
            has_moved: false,
            look: None,
            pause: Duration::ZERO,
            _claims: [by_place, by_serial],
        })
    }

    /// Looks at the object before the tip goes down, and before it strikes. Where a look errors, nothing is struck.
    pub fn look_first(
        &mut self,
        look: impl FnMut(Look) -> Result<(), String> + Send + 'static,
    ) -> &mut Self {
        self.look = Some(LookFirst(Box::new(look)));
        self
    }

    /// Sets the time that whoever is told to step back has until anything moves. Where it is not set, a person is told only that the arm moves now.
    pub fn pause(&mut self, pause: Duration) -> &mut Self {
        self.pause = pause;
        self
    }

    /// A handle that stops the arm where the object is seen moved while the tip runs up to it.
    pub(crate) fn run_up(&self) -> RunUp {
        self.watch.run_up()
    }

    /// A handle that stops the arm from any thread, while it strikes too.
    pub fn stop_handle(&self) -> Outlet {
        self.driver.outlet().clone()
    }

    /// The arm's serial number.
    pub fn serial(&self) -> &str {
        &self.serial
    }

    pub(crate) fn not_ready(&self, why: impl Into<String>) -> RobotError {
        not_ready(&self.name, why)
    }

    fn unreachable(&self, error: &io::Error) -> RobotError {
        unreachable_arm(&self.name, error)
    }

    /// Sets the height at which the tip may begin other than travel height: where carom left it.
    pub(crate) fn resumes_from(&mut self, left: Option<Height>) {
        (self.left, self.has_moved) = (left, false);
    }

    /// Height of the tip in a strike.
    pub(crate) fn low_height(&self) -> Height {
        self.setup.low_height()
    }

    /// Whether a line was sent in the last strike.
    pub(crate) fn has_moved(&self) -> bool {
        self.has_moved
    }

    /// Height of the tip, and whether it came to where it was to touch the object, as a person is told; none where no report comes.
    pub(crate) fn left(&self, plan: &Plan) -> Option<(Height, String)> {
        let at = self.watch.next(PATIENCE).ok()?.report.pose.at;
        let on_table = self.setup.on_table(at);
        let short = (plan.strike - on_table).dot(plan.stroke().direction());
        let told = if self.begun.is_none() {
            "the object was not struck".into()
        } else if short > STILL {
            let mm = short * 1e3;
            format!("the tip stopped {mm:.0} mm before where it was to touch the object")
        } else {
            "the tip came to where it was to touch the object, which may have been struck".into()
        };
        Some((self.setup.height(at), told))
    }

    /// Checks whether what is known before there is a plan is as the rig file says: settings, how the tool points, how high it stands. Moves nothing.
    pub(crate) fn is_set_up(&mut self) -> Result<(), RobotError> {
        let status = self.checked_status();
        let status = status.map_err(|error| self.unreachable(&error))?;
        let last = status.and_then(|_| self.watch.next(PATIENCE));
        let checked = last.and_then(|last| match last.report.condition {
            Condition::Held(said) => Err(held(said)),
            _ => self.check_pose(&last.report.pose),
        });
        checked.map_err(|why| self.not_ready(why))
    }

    fn check_pose(&self, pose: &Pose) -> Result<(), String> {
        self.setup.check_orientation(pose)?;
        self.setup.check_height(pose, self.left)
    }

    /// Checks that reports still come, and nobody has stopped or taken it since this program was started. Waits for nothing.
    pub(crate) fn is_free(&self) -> Result<(), RobotError> {
        let comes = self.watch.broken().map_or(Ok(()), Err);
        let free = comes.and_then(|()| self.is_nobodys());
        free.map_err(|why| self.not_ready(why))
    }

    /// Tells a person what must be read before the arm moves. Who holds back what the terminal shows has not read it: it is waited for until
    /// the plan is old.
    fn tells(&self, plan: &Plan, what: &str) -> Result<(), RobotError> {
        let told = told(&format!("{}: {what}", self.name), |_| {
            plan.check_again().is_err() || self.interrupted.load(Ordering::Relaxed)
        });
        told.map_err(|error| {
            self.not_ready(format!(
                "standard error cannot be written ({error}), so that nobody would be told that the arm moves; give it a terminal or a file"
            ))
        })
    }

    /// Tells a person to step back, and gives the time for it.
    fn waits(&self, plan: &Plan) -> Result<(), RobotError> {
        let seconds = self.pause.as_secs_f64();
        self.tells(plan, &format!("step back: the arm moves in {seconds:.1} s"))?;
        let told = Instant::now();
        while told.elapsed() < self.pause {
            self.is_free()?;
            if self.interrupted.load(Ordering::Relaxed) {
                return Err(self.not_ready("it was interrupted by a signal"));
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        Ok(())
    }

    /// Checks that reports show the arm at rest, and that nobody has stopped it since it was ready. Moves nothing.
    fn at_rest(&self) -> Result<Sample, String> {
        let begun = Instant::now();
        loop {
            let last = self.watch.next(PATIENCE)?;
            self.is_nobodys()?;
            let condition = last.report.condition;
            if let Condition::Held(said) = condition {
                return Err(held(said));
            }
            if let (Condition::Stopped(said), true) = (condition, self.was_ready) {
                return Err(stopped_by_somebody(&said.to_string()));
            }
            let is_slow = norm(last.report.velocity) <= SLOW;
            if is_slow && condition != Condition::Moving && self.watch.rests() == Some(true) {
                return Ok(last);
            }
            if begun.elapsed() > PATIENCE {
                return Err(match self.watch.rests() {
                    Some(_) => "the arm is moving",
                    None => {
                        "its reports come less than 80 times a second: end what else asks it for reports, and look at its network"
                    }
                }
                .into());
            }
        }
    }

    /// Checks that nobody else has stopped or taken the arm since this program was started.
    fn is_nobodys(&self) -> Result<(), String> {
        match self.watch.taken() {
            None => Ok(()),
            Some(said) => Err(stopped_by_somebody(&said)),
        }
    }

    /// The tip's pose, checked: what is asked for and what is reported agree, and the strike may be made from there.
    fn here(&mut self, plan: &Plan) -> Result<Pose, String> {
        let asked = self.driver.pose().and_then(Pose::checked);
        let asked = asked.map_err(|error| what_happened(&error))?;
        let shown = self.watch.next(PATIENCE)?.report.pose;
        let (far, turned) = SAME;
        let apart = distance(asked.at, shown.at);
        if apart > far || asked.turn.angle_to(shown.turn) > turned {
            return Err(format!(
                "asked for its pose, the controller answers {} m, and its reports say {} m: they contradict each other",
                numbers(&asked.at),
                numbers(&shown.at)
            ));
        }
        self.check_pose(&shown)?;
        plan.check_approach(self.setup.on_table(shown.at))?;
        Ok(shown)
    }

    /// The lines of a strike from a place (m on the table): what they are called, and where they end.
    fn lines(&self, plan: &Plan, here: Point) -> [(&'static str, LineRequest); 5] {
        let (speed, acceleration) = TRAVEL;
        let travel = |to| LineRequest {
            to,
            speed,
            acceleration,
        };
        let setup = &self.setup;
        [
            ("lift", travel(setup.high(here))),
            ("travel", travel(setup.high(plan.start))),
            ("lower", travel(setup.low(plan.start))),
            (
                "strike",
                LineRequest {
                    to: setup.low(plan.stop),
                    speed: plan.speed,
                    acceleration: setup.acceleration,
                },
            ),
            ("raise", travel(setup.high(plan.stop))),
        ]
    }

    /// Checks that the arm's own fence lets it go along these lines.
    fn check_fence(
        &self,
        status: &Status,
        here: Pose,
        lines: &[(&'static str, LineRequest)],
    ) -> Result<(), String> {
        let ends = lines.iter().map(|(_, line)| line.to.at);
        [here.at]
            .into_iter()
            .chain(ends)
            .try_for_each(|place| self.setup.check_fence(status, place))
    }

    /// All motions of a strike. Errors with the line that was not ended, and why.
    fn move_all(&mut self, plan: &Plan) -> Result<(), Undone> {
        let status = self.make_ready().map_err(|why| ("enable", why))?;
        // What is commanded from here on begins where the arm really is: it may have been moved since it was checked.
        let here = self.here(plan).map_err(|why| ("enable", why))?;
        let mut at = here.at;
        is_read().map_err(|why| ("lift", why))?;
        let lines = self.lines(plan, self.setup.on_table(here.at));
        if let Some((what, line)) = lines.iter().find(|(_, line)| !line.is_finite()) {
            let why = format!("a line to {} m is none", numbers(&line.to.at));
            return Err((what, why));
        }
        self.check_fence(&status, here, &lines)
            .map_err(|why| ("enable", why))?;
        // Whoever stopped it while that was asked is not overridden by the next question.
        self.ready().map_err(|why| ("enable", why))?;
        self.driver
            .can_move(&lines.map(|(_, line)| line))
            .map_err(|error| ("enable", what_happened(&error)))?
            .map_err(|(number, why)| {
                let what = lines.get(number).map_or("strike", |(what, _)| what);
                let why = format!("the controller says that it cannot `{what}`: {why}");
                ("enable", why)
            })?;
        for (what, line) in lines {
            let (look, reached_at) = match what {
                "lower" => (Some(Look::BeforeDescent), None),
                "strike" => {
                    self.watch.record();
                    let run_up = plan.start.distance(plan.pre_strike);
                    (Some(Look::BeforeStrike), Some(run_up))
                }
                _ => (None, None),
            };
            self.line(&line, at, reached_at, (look, plan.epoch()))
                .map_err(|why| (what, why))?;
            at = line.to.at;
        }
        Ok(())
    }

    fn look(&mut self, when: Look) -> Result<(), String> {
        match &mut self.look {
            Some(LookFirst(look)) => look(when),
            None => Ok(()),
        }
    }

    /// The controller's settings and state, if a strike may be made with it. The inner error says why not.
    fn checked_status(&mut self) -> io::Result<Result<Status, String>> {
        let status = self.driver.status()?;
        Ok(self.setup.check_status(&status).map(|()| status))
    }

    /// Makes the controller ready for lines: where it is not, once a call, and not where somebody stops it meanwhile. Gives what it is
    /// set to then.
    fn make_ready(&mut self) -> Result<Status, String> {
        let text = |error: io::Error| what_happened(&error);
        let status = self.checked_status().map_err(text)??;
        self.is_nobodys()?;
        let is_ready =
            status.is_enabled && self.watch.next(PATIENCE)?.report.condition == Condition::Ready;
        if !is_ready {
            if self.was_ready {
                return Err(stopped_by_somebody(
                    "its motors are off, or it is not ready",
                ));
            }
            let (watch, interrupted) = (&self.watch, &self.interrupted);
            watch.brakes_open();
            self.driver
                .enable(&mut || {
                    if interrupted.load(Ordering::Relaxed) {
                        return Err(io::Error::other("it was interrupted by a signal"));
                    }
                    // Two reports: one may have been on its way.
                    for _ in 0..2 {
                        watch.next(PATIENCE).map_err(io::Error::other)?;
                    }
                    match watch.taken() {
                        None => Ok(()),
                        Some(said) => Err(io::Error::other(stopped_by_somebody(&said))),
                    }
                })
                .map_err(text)?;
        }
        self.ready()?;
        self.was_ready = true;
        self.watch.guard_rest();
        let now = if is_ready {
            status.clone()
        } else {
            // Enabling takes seconds, in which somebody may have set something else; and a motor may stay off.
            self.checked_status().map_err(text)??
        };
        if !now.is_enabled {
            return Err("a motor is still off after all were switched on: look at the arm by its own program".into());
        }
        self.before.get_or_insert(status);
        self.driver
            .set_ramp(self.setup.acceleration.max(TRAVEL.1), self.setup.jerk)
            .map_err(text)?;
        Ok(now)
    }

    /// The first report of an arm that takes lines.
    fn ready(&self) -> Result<Sample, String> {
        let until = Instant::now() + READY;
        loop {
            let last = self.watch.next(PATIENCE)?;
            self.is_nobodys()?;
            if let Some(fault) = self.watch.fault() {
                return Err(fault);
            }
            match last.report.condition {
                Condition::Ready => return Ok(last),
                Condition::Moving if norm(last.report.velocity) > SLOW => {
                    return Err(
                        "the arm moves, and no line was sent: another program drives it".into(),
                    );
                }
                condition if Instant::now() > until => {
                    return Err(format!("the controller does not become ready: {condition}"));
                }
                _ => std::thread::sleep(Duration::from_millis(10)),
            }
        }
    }

    /// One straight line from where the tip is, which is to be `from`, guarded. It is looked last of all, right before it is sent: what was
    /// waited for took time, in which the object may have been moved.
    fn line(
        &mut self,
        request: &LineRequest,
        from: [f64; 3],
        reached_at: Option<f64>,
        (look, epoch): (Option<Look>, Epoch),
    ) -> Result<(), String> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Err("it was interrupted by a signal".into());
        }
        let last = self.ready()?;
        let at = last.report.pose.at;
        if distance(at, from) > SAME.0 {
            return Err(format!(
                "the tip is {:.1} mm from where the line is to begin",
                distance(at, from) * 1e3
            ));
        }
        let length = distance(at, request.to.at);
        if length < SHORTEST {
            return Ok(());
        }
        let profile = Profile::new(length, request.speed, request.acceleration, self.setup.jerk);
        if let Some(when) = look {
            self.look(when)?;
            epoch.was_set().map_or(Ok(()), Err)?;
            // Whoever stopped the arm while it was looked is not overridden by the line.
            self.is_nobodys()?;
            if self.watch.shows(|condition| condition != Condition::Ready) {
                return Err(
                    "the controller ceased to be ready while it was looked at the object".into(),
                );
            }
            is_read()?;
        }
        (self.is_moving, self.has_moved) = (true, true);
        self.watch.guard(Line {
            from: at,
            to: request.to,
            speed: request.speed,
            reached_at,
            profile,
            start: self.limits.start.as_secs_f64(),
        });
        let sent = Instant::now();
        self.is_unanswered = true;
        let accepted = self.driver.line(request);
        self.is_unanswered = accepted.is_err() || !D::ANSWERS;
        if reached_at.is_some() {
            self.begun = Some(sent);
        }
        accepted.map_err(|error| self.watch.fault().unwrap_or_else(|| what_happened(&error)))?;
        let (share, more) = LONGER;
        let patience = profile.duration * (1.0 + share) + more;
        let ended = self.watch.wait_for_end(Duration::from_secs_f64(patience));
        self.is_unanswered &= ended.is_err() && !self.watch.has_begun();
        ended
    }

    /// Whether the arm rests, by every source that answers: the reports, and a connection of its own that asks for the pose. None where
    /// neither answers.
    fn is_at_rest(&self, asking: &mut Option<D>) -> Option<bool> {
        let by_reports = self.watch.rests();
        if by_reports == Some(false) {
            return Some(false);
        }
        if asking.is_none() {
            *asking = D::connect(&self.ports, QUICK).ok();
        }
        let by_answers = asking.as_mut().and_then(|driver| {
            let (far, times) = REST;
            let mut asked = || Some(driver.pose().and_then(Pose::checked).ok()?.at);
            let first = asked()?;
            for _ in 1..times {
                std::thread::sleep(AGAIN);
                if distance(asked()?, first) > far {
                    return Some(false);
                }
            }
            Some(true)
        });
        if by_answers.is_none() {
            *asking = None;
        }
        by_answers.or(by_reports)
    }

    /// Sends the stop over the connections that there are, and over new ones: those may be dead, and take it all the same.
    fn stop_everywhere(&self) -> io::Result<()> {
        let sent = self.driver.outlet().stop();
        let anew = D::connect(&self.ports, QUICK).and_then(|driver| driver.outlet().stop());
        sent.or(anew)
    }

    /// Sets the controller as it was before the strike; gives a warning where that fails.
    fn put_back(driver: &mut D, before: Option<Status>) -> Option<String> {
        let error = driver.put_back(&before?).err()?;
        Some(format!(
            "the controller's settings were not put back as they were: {error}"
        ))
    }
}

impl<D: Arm> Robot for Guarded<D> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn check(&mut self, plan: &Plan) -> Result<(), RobotError> {
        let status = self.checked_status();
        let status = status.map_err(|error| self.unreachable(&error))?;
        let status = status.map_err(|why| self.not_ready(why))?;
        self.at_rest().map_err(|why| self.not_ready(why))?;
        let here = self.here(plan).map_err(|why| self.not_ready(why))?;
        let lines = self.lines(plan, self.setup.on_table(here.at));
        self.check_fence(&status, here, &lines)
            .map_err(|why| self.not_ready(why))?;
        if !self.pause.is_zero() {
            self.waits(plan)?;
        }
        self.tells(plan, "the arm moves now: stand clear")
    }

    fn strike(&mut self, plan: &Plan) -> Result<Option<StrikeRecord>, RobotError> {
        self.begun = None;
        // The motion has a thread of its own; a panic of it stops the arm like any other failure.
        let outcome = std::thread::scope(|scope| {
            let motion = AssertUnwindSafe(|| self.move_all(plan));
            let begins = std::thread::Builder::new()
                .spawn_scoped(scope, move || panic::catch_unwind(motion));
            match begins {
                Ok(thread) => thread.join().unwrap_or_else(Err),
                Err(error) => Ok(Err(("enable", no_thread(&error).to_string()))),
            }
        });
        if let Ok(Ok(())) = outcome {
            self.is_moving = false;
            self.watch.release();
            let not_put_back = Self::put_back(&mut self.driver, self.before.take());
            let record = self.watch.recorded();
            let (samples, delivered) =
                samples(&record, plan, &self.setup, plan.epoch(), (self.begun, None));
            let slow = delivered
                .filter(|delivered| (delivered / plan.speed - 1.0).abs() > SPEED_WARNING)
                .map(|delivered| {
                    format!(
                        "the arm delivered {delivered:.4} m/s of {:.4} m/s at the impact: look at its load, reach and jerk",
                        plan.speed
                    )
                });
            let warnings: Vec<String> = [slow, not_put_back, plan.epoch().was_set()]
                .into_iter()
                .flatten()
                .collect();
            return Ok(Some(StrikeRecord {
                samples,
                stop: None,
                delivered_speed: delivered,
                warning: (!warnings.is_empty()).then(|| warnings.join("; ")),
            }));
        }
        let (stopped, at) = (self.driver.outlet().stop(), Instant::now());
        let (what, why) = match outcome {
            Ok(Err(undone)) => undone,
            _ => ("strike", "the driver panicked".to_owned()),
        };
        let unsent = stopped.err().map_or(String::new(), |error| {
            format!("; the stop could not be sent: {error}")
        });
        let record = self.watch.recorded();
        let moved = (self.begun, Some(at));
        let (samples, _) = samples(&record, plan, &self.setup, plan.epoch(), moved);
        Err(RobotError::Interrupted {
            robot: self.name.clone(),
            why: format!("{why}, while it was to `{what}`{unsent}"),
            samples: (!record.is_empty()).then(|| Box::new(samples)),
        })
    }

    /// Sends the stop, again and over new connections until positions show the arm at rest. Where they do not, a person is told before
    /// anything else is waited for.
    fn abort(&mut self) -> Result<(), RobotError> {
        let begun = Instant::now();
        let mut sent = self.stop_everywhere();
        self.is_moving = false;
        self.watch.release();
        let (mut asking, mut is_told) = (None, false);
        loop {
            let rest = self.is_at_rest(&mut asking);
            let is_stopped =
                |condition| matches!(condition, Condition::Stopped(_) | Condition::Held(_));
            self.is_unanswered &= D::ANSWERS || !self.watch.shows(is_stopped);
            let watched = match self.is_unanswered {
                true => ON_ITS_WAY,
                false => Duration::ZERO,
            };
            if rest == Some(true) && begun.elapsed() >= watched {
                let before = self
                    .before
                    .take()
                    .filter(|before| !before.changed.is_empty());
                let warning = match &mut asking {
                    Some(driver) => Self::put_back(driver, before),
                    None => before.map(|_| "the controller's settings were not put back".into()),
                };
                if let Some(warning) = warning {
                    tell(&format!("{}: {warning}", self.name));
                }
                if is_told {
                    alarm(format!(
                        "{}: the arm rests now, as its positions show; look at it before you go near it",
                        self.name
                    ));
                }
                return Ok(());
            }
            if begun.elapsed() >= TELL && !is_told {
                is_told = true;
                alarm(format!(
                    "\u{7}{}: PRESS THE EMERGENCY STOP: the arm was sent a stop, and {}",
                    self.name,
                    match rest {
                        Some(true) => "has not answered the line before it, which may still come",
                        _ => "is not seen at rest",
                    }
                ));
            }
            if begun.elapsed() >= watched + GIVE_UP {
                let seen = match rest {
                    Some(_) => "it still moves",
                    None => "neither reports nor answers come",
                };
                let sent = sent.err().map_or("was sent".into(), |error| {
                    format!("could not be sent ({error})")
                });
                return Err(RobotError::Connection {
                    robot: self.name.clone(),
                    why: format!("a stop {sent}, and {seen}"),
                });
            }
            std::thread::sleep(AGAIN);
            let again = self.stop_everywhere();
            sent = sent.or(again);
        }
    }
}

impl<D: Arm> Drop for Guarded<D> {
    /// Stops what moves, however the program's use of the arm ends.
    fn drop(&mut self) {
        if self.is_moving {
            // Nobody is left to report an error to.
            let _ = self.driver.outlet().stop();
        }
    }
}

fn held(said: Said) -> String {
    format!(
        "the arm is held ({said}): another program, a person or a fault holds it; release it by the arm's own program, and call again"
    )
}

fn stopped_by_somebody(said: &str) -> String {
    format!(
        "somebody stopped the arm, moved it or took it since this program was started ({said}): whoever did is in charge; where it may \
         move again, start the program again"
    )
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
        why: why_none(
            error,
            "check its power and network, and that no other program drives it",
        ),
    }
}

/// Rate of the commands in the log, in Hz.
const COMMAND_RATE: f64 = 250.0;
/// Idle commands before and after the motion, in s.
const IDLE: f64 = 0.3;

/// The log's samples, stamped by this computer's clock, and the speed (m/s) that was delivered where the tip touches; none where
/// it did not come so far. `begun` is when the controller took the line, without which nothing was commanded, `stopped` when it was stopped.
pub(super) fn samples(
    record: &[Sample],
    plan: &Plan,
    setup: &Setup,
    epoch: Epoch,
    (begun, stopped): (Option<Instant>, Option<Instant>),
) -> (Samples, Option<f64>) {
    let state = |sample: &Sample| StateSample {
        stamp: epoch.stamp(sample.made),
        position: setup.on_table(sample.report.pose.at).into(),
        velocity: setup.turned(sample.report.velocity).into(),
    };
    let stroke = plan.stroke();
    let ticks = ((stroke.t_stop + 2.0 * IDLE) * COMMAND_RATE) as u32;
    let command = |begun: Instant, tick: u32| {
        let time = f64::from(tick) / COMMAND_RATE - IDLE;
        let at = begun + Duration::from_secs_f64(time.max(0.0));
        let velocity = if time < 0.0 || stopped.is_some_and(|stopped| at > stopped) {
            Point::default()
        } else {
            stroke.at(time).1
        };
        Stamped::at(
            (epoch.stamp(begun) as i64 + (time * 1e9) as i64).max(0) as u64,
            velocity,
        )
    };
    let samples = Samples {
        states: record.iter().map(state).collect(),
        commands: begun.map_or_else(Vec::new, |begun| {
            (0..=ticks).map(|tick| command(begun, tick)).collect()
        }),
        ..Samples::default()
    };
    (samples, delivered(record, plan, setup))
}

/// The speed (m/s) between the two reports around the place where the tip touches.
fn delivered(record: &[Sample], plan: &Plan, setup: &Setup) -> Option<f64> {
    let direction = plan.stroke().direction();
    let left =
        |sample: &Sample| (plan.strike - setup.on_table(sample.report.pose.at)).dot(direction);
    let speed = |sample: &Sample| norm(sample.report.velocity);
    record.windows(2).find_map(|pair| {
        let (before, after) = (left(&pair[0]), left(&pair[1]));
        let passes = before > 0.0 && after <= 0.0;
        passes.then(|| {
            let share = before / (before - after);
            speed(&pair[0]) + share * (speed(&pair[1]) - speed(&pair[0]))
        })
    })
}
