//! What the controller is in, and what each request does to it.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::frames::{Reported, Request, numbers};
use values::Point;

use crate::model::Model;
use crate::motion::Motion;
use crate::table::Table;
use crate::{Fault, Step};

/// How late reports are, and a line begins.
const LATE: Duration = Duration::from_millis(300);
const DELAY: Duration = Duration::from_millis(1_500);
/// No script is shown for so long where one replaces another.
const REPLACED: Duration = Duration::from_millis(12);
/// Signs of life may be missing for so long in a line, and where a script waits.
const LIFELESS: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(1)];
/// Between two looks at where the tip is before a table.
const STEP: Duration = Duration::from_millis(1);
const LOST: u32 = 2;

#[derive(Clone, Debug)]
pub enum Event {
    Request(Request),
    /// A line came that is to be moved, of whatever maker.
    Line,
    /// A line came that is to be checked only: whence and whither, x in mm.
    Checked(f64, f64),
    /// Signs of life ceased, and the controller stopped by itself.
    Lifeless,
    Stop,
    Cleared,
    Fault,
}

const MOVING: u8 = 1;
const READY: u8 = 2;
const PAUSED: u8 = 3;
const STOPPED: u8 = 4;

#[derive(Debug)]
struct Script {
    begun: Instant,
    /// Whether the program waits for signs of life after its lines.
    waits: bool,
    /// Whether the program writes the last sign of life that it read.
    echoes: bool,
    /// Lines that it moves once their numbers come, as the queue holds them.
    lines: Vec<(i32, [f64; 8])>,
}

/// A line as the queue holds it, mm and rad, of a script's numbers: x to c, acceleration and speed, m and rad.
fn queued(numbers: &[f64]) -> Option<[f64; 8]> {
    let [x, y, z, a, b, c, acceleration, speed] = *numbers.first_chunk()?;
    let [x, y, z, speed, acceleration] = [x, y, z, speed, acceleration].map(|length| length * 1e3);
    Some([x, y, z, a, b, c, speed, acceleration])
}

fn numbered(text: &str) -> Option<(i32, [f64; 8])> {
    let (number, line) = numbers(text)
        .split_first()
        .map(|(n, rest)| (*n as i32, queued(rest)))?;
    line.map(|line| (number, line))
}

#[derive(Debug)]
pub(crate) struct State {
    pub(crate) model: Model,
    begun: Instant,
    state: u8,
    mode: u8,
    enabled: bool,
    codes: [u8; 2],
    /// Jerk in mm/s³ and greatest acceleration in mm/s².
    pub(crate) ramp: [f64; 2],
    pose: [f64; 6],
    motion: Option<(Instant, Motion)>,
    queue: VecDeque<[f64; 8]>,
    lines: u32,
    pub(crate) fault: Option<(Step, Fault)>,
    pub(crate) made: Option<(Instant, Fault)>,
    pub(crate) events: Vec<(Instant, Event)>,
    /// Greatest distance (mm) that the tip moved since a stop was requested.
    pub(crate) moved_after_stop: f64,
    stop_pose: Option<[f64; 6]>,
    /// Reports of the last second, for faults that show an old one.
    shown: VecDeque<(Instant, Reported)>,
    frozen: Option<Reported>,
    lost: u32,
    script: Option<Script>,
    /// What scripts wrote: an answer, and the last sign of life that they read.
    registers: [i32; 2],
    /// The last sign of life, and when it came; whether a program has claimed to give it.
    life: (Instant, i32),
    pub(crate) is_claimed: bool,
    /// Where lines that are checked only have come to, in mm.
    checked: Option<f64>,
    /// When the next line begins at the earliest.
    not_before: Option<Instant>,
    /// Up to when time has passed.
    passed: Instant,
    /// What lies before the arm, whose base is the origin of the table.
    pub(crate) table: Option<Table>,
}

impl State {
    pub(crate) fn new(model: Model, fault: Option<(Step, Fault)>) -> Self {
        let mut state = Self {
            begun: Instant::now(),
            state: match model.is_stopped || !(model.is_enabled || model.keeps_state) {
                true => STOPPED,
                false => READY,
            },
            mode: 0,
            enabled: model.is_enabled,
            codes: model.codes,
            ramp: [1_000.0, 50_000.0],
            pose: model.pose,
            motion: None,
            queue: VecDeque::new(),
            lines: 0,
            fault,
            made: None,
            events: Vec::new(),
            moved_after_stop: 0.0,
            stop_pose: None,
            shown: VecDeque::new(),
            frozen: None,
            lost: 0,
            script: None,
            registers: [0; 2],
            life: (Instant::now(), 0),
            is_claimed: false,
            checked: None,
            not_before: None,
            passed: Instant::now(),
            table: None,
            model,
        };
        if state.is_next(Step::Connect) {
            state.make_fault();
        }
        state
    }

    /// The fault that was made, of those that the wire shows.
    pub(crate) fn is_made(&self, fault: Fault) -> bool {
        self.made.is_some_and(|(_, made)| made == fault)
    }

    pub(crate) fn make_fault(&mut self) {
        let Some((_, fault)) = self.fault.take() else {
            return;
        };
        let now = Instant::now();
        self.made = Some((now, fault));
        self.events.push((now, Event::Fault));
        match fault {
            Fault::Error(code) => {
                self.codes[0] = code;
                self.halt();
            }
            Fault::EmergencyStop => {
                self.codes[0] = 2;
                self.halt();
            }
            Fault::OtherController => {
                self.mode = 2;
                self.halt();
            }
            Fault::Paused => {
                self.halt();
                self.state = PAUSED;
            }
            Fault::Stuck => {
                if let Some((begun, motion)) = &mut self.motion {
                    motion.stop(begun.elapsed().as_secs_f64());
                }
            }
            Fault::Frozen | Fault::Stale | Fault::Repeated => self.frozen = Some(self.reported()),
            Fault::OperatorStop => self.halt(),
            Fault::MotorsOff => {
                self.enabled = false;
                self.halt();
            }
            Fault::LostStop => self.lost = LOST,
            Fault::NoStop => self.lost = u32::MAX,
            Fault::Jogged if self.motion.is_none() => self.pose[0] = 60.0,
            Fault::OtherLine => {
                let [x, y, z, roll, pitch, yaw] = self.pose;
                let line = [x, y + 60.0, z, roll, pitch, yaw, 50.0, 500.0];
                self.queue.push_back(line);
                if let Some(script) = &mut self.script {
                    script.waits = false;
                }
            }
            Fault::OtherProgram if self.script.is_some() => {
                self.run("def other():\n  while (True):\n    sync()\n  end\nend\n");
            }
            Fault::SlowedDown => {
                self.model.modes[0] = true;
                if let Some((begun, motion)) = &mut self.motion {
                    motion.slow_down(begun.elapsed().as_secs_f64());
                }
            }
            Fault::ToolChanged => self.model.tool_offset[2] += 50.0,
            Fault::FreeDrive => self.halt(),
            Fault::Rebooted => {
                self.begun = now;
                self.enabled = false;
                self.halt();
            }
            _ => {}
        }
    }

    pub(crate) fn halt(&mut self) {
        self.state = STOPPED;
        self.script = None;
        self.queue.clear();
        if let Some((begun, motion)) = &mut self.motion {
            motion.stop(begun.elapsed().as_secs_f64());
        }
    }

    /// Lets time pass up to now, for the arm and for what lies before it.
    pub(crate) fn pass(&mut self) {
        self.move_on();
        self.run_on();
        let now = Instant::now();
        let mut at = std::mem::replace(&mut self.passed, now);
        let Some(table) = &mut self.table else {
            return;
        };
        // In small steps: an object is met where it lies, also by an arm whose computer stood still for some milliseconds.
        while at < now {
            at = now.min(at + STEP);
            let (pose, velocity) = self
                .motion
                .map_or((self.pose, [0.0; 3]), |(begun, motion)| {
                    motion.at(at.saturating_duration_since(begun).as_secs_f64())
                });
            let flat = |[x, y, _]: [f64; 3]| Point::new(x * 1e-3, y * 1e-3);
            table.tip(
                flat([pose[0], pose[1], pose[2]]),
                pose[2],
                flat(velocity),
                at,
            );
        }
    }

    /// Lets the script that runs go on.
    fn run_on(&mut self) {
        let Some(script) = &self.script else {
            return;
        };
        let is_idle = self.motion.is_none() && self.queue.is_empty();
        let (at, life) = self.life;
        let [in_line, idle] = LIFELESS;
        match (script.waits, is_idle) {
            (false, true) => self.script = None,
            (true, _) if script.echoes && at.elapsed() > if is_idle { idle } else { in_line } => {
                self.events.push((Instant::now(), Event::Lifeless));
                self.halt();
            }
            // It takes a moment to begin.
            (true, true)
                if script.echoes
                    && !self.is_made(Fault::NeverReady)
                    && script.begun.elapsed() > 2 * REPLACED =>
            {
                self.registers[1] = life;
            }
            _ => {}
        }
    }

    /// A sign of life came, and the number of the line that is to be moved.
    pub(crate) fn is_told_of_life(&mut self, life: i32, number: i32) {
        if self.is_made(Fault::Deaf) {
            return;
        }
        self.life = (Instant::now(), life);
        let is_free = self.motion.is_none() && self.queue.is_empty();
        let script = self.script.as_mut().filter(|_| is_free);
        if let Some(script) = script.filter(|script| script.begun.elapsed() > 2 * REPLACED) {
            let (due, later) = script
                .lines
                .drain(..)
                .partition(|(line, _)| *line <= number);
            let due: Vec<(i32, [f64; 8])> = due;
            script.lines = later;
            if let Some((_, line)) = due.iter().find(|(line, _)| *line == number) {
                self.take_line(*line);
            }
        }
    }

    fn take_line(&mut self, line: [f64; 8]) {
        self.line_came();
        if self.codes[0] == 0 && self.mode == 0 && self.enabled {
            // A program that was stopped does not keep the next one from running.
            self.state = if self.motion.is_some() { MOVING } else { READY };
            self.queue.clear();
            self.queue.push_back(line);
            self.pass();
        }
    }

    fn move_on(&mut self) {
        let Some((begun, motion)) = self.motion else {
            if self.enabled
                && self.state == READY
                && self.not_before.is_none_or(|at| Instant::now() >= at)
                && let Some(next) = self.queue.pop_front()
            {
                self.begin(next);
            }
            return;
        };
        let t = begun.elapsed().as_secs_f64();
        if let Some((Step::Line(number), _)) = self.fault
            && number == self.lines
            && t > 0.4 * motion.duration()
        {
            self.make_fault();
        }
        let (pose, _) = motion.at(t);
        self.pose = pose;
        if let Some(from) = self.stop_pose {
            let moved = (0..3)
                .map(|i| (pose[i] - from[i]).powi(2))
                .sum::<f64>()
                .sqrt();
            self.moved_after_stop = self.moved_after_stop.max(moved);
        }
        let over = self
            .motion
            .is_some_and(|(_, motion)| t >= motion.duration());
        if over {
            self.motion = None;
            if self.state == MOVING && !self.is_made(Fault::Stuck) {
                self.state = READY;
            }
        }
    }

    fn begin(&mut self, line: [f64; 8]) {
        let [x, y, z, roll, pitch, yaw, speed, acceleration] = line;
        self.lines += 1;
        let slow = matches!(self.fault, Some((Step::Line(number), Fault::TooSlow)) if number == self.lines);
        if slow {
            self.make_fault();
        }
        let share = if slow { 0.8 } else { 1.0 };
        let to = [x, y, z, roll, pitch, yaw];
        let motion = Motion::line(self.pose, to, share * speed, acceleration, self.ramp[0]);
        self.motion = Some((Instant::now(), motion));
        self.state = MOVING;
    }

    /// What the real-time report shows now.
    pub(crate) fn shown(&mut self) -> Reported {
        let (now, reported) = (Instant::now(), self.reported());
        self.shown.push_back((now, reported.clone()));
        while let Some((first, _)) = self.shown.front()
            && now.duration_since(*first) > 2 * LATE
        {
            self.shown.pop_front();
        }
        let Some((_, fault)) = self.made else {
            return reported;
        };
        let frozen = self.frozen.clone();
        match (fault, frozen) {
            (Fault::Late, _) => {
                let is_old = |at: &Instant| now.duration_since(*at) >= LATE;
                let old = self.shown.iter().rev().find(|(at, _)| is_old(at));
                let shown = old.or(self.shown.front());
                shown.map_or(reported, |(_, old)| old.clone())
            }
            (Fault::Repeated, Some(frozen)) => frozen,
            (Fault::Stale, Some(frozen)) => Reported {
                clock: reported.clock,
                ..frozen
            },
            (Fault::Frozen, Some(frozen)) => Reported {
                clock: reported.clock,
                wanted: reported.wanted,
                ..frozen
            },
            _ => reported,
        }
    }

    pub(crate) fn reported(&self) -> Reported {
        let (mut pose, mut velocity) = self
            .motion
            .map_or((self.pose, [0.0; 3]), |(begun, motion)| {
                motion.at(begun.elapsed().as_secs_f64())
            });
        let wanted = pose;
        let mut clock = self.begun.elapsed().as_micros() as u64;
        if let Some((since, fault)) = self.made {
            let later = since.elapsed().as_secs_f64();
            match fault {
                Fault::OffLine | Fault::LostStop | Fault::NoStop => {
                    pose[2] += (200.0 * later).min(30.0)
                }
                Fault::Turned => pose[4] += (0.5 * later).min(0.2),
                Fault::ClockBack => clock = clock.saturating_sub(1_000_000),
                Fault::Jump => pose[0] -= 80.0,
                Fault::Lag => clock -= (0.5 * later * 1e6) as u64,
                Fault::NotANumber => velocity[0] = f64::NAN,
                Fault::ToolChanged => pose[2] -= 50.0,
                _ => {}
            }
        }
        let waiting = self.queue.len() as u16 + u16::from(self.motion.is_some());
        Reported {
            clock,
            state: self.state,
            mode: if self.is_made(Fault::FreeDrive) {
                2
            } else {
                self.mode
            },
            waiting,
            enabled: self.enabled,
            codes: self.codes,
            pose,
            wanted,
            velocity,
            model: self.model.clone(),
            ramp: self.ramp,
            is_running: self
                .script
                .as_ref()
                .is_some_and(|script| script.begun.elapsed() > REPLACED)
                || (self.script.is_none() && waiting > 0),
            is_led: self.is_made(Fault::FreeDrive),
            registers: self.registers,
        }
    }

    /// Does what a request asks; gives the reply.
    pub(crate) fn answer(&mut self, request: &Request) -> Vec<u8> {
        self.events
            .push((Instant::now(), Event::Request(request.clone())));
        self.pass();
        let first = request.payload().first().copied().unwrap_or(0);
        let mut content = Vec::new();
        match request.register() {
            1 => {
                content.extend(self.model.version.bytes());
                content.resize(40.max(content.len()), 0);
            }
            2 => content = vec![0; 40],
            11 => {
                let was_enabled = self.enabled;
                self.enabled = request.payload().get(1) == Some(&1);
                if self.enabled && !was_enabled {
                    self.pose[2] -= self.model.sag;
                }
                if !self.model.keeps_state {
                    self.halt();
                }
                if self.is_next(Step::Enable) {
                    self.make_fault();
                }
            }
            12 => self.set_state(first),
            13 => content.push(self.state),
            14 => content.extend((self.queue.len() as u16).to_be_bytes()),
            15 => {
                if self.is_next(Step::Check) {
                    self.make_fault();
                }
                content.extend(self.codes);
            }
            16 => {
                self.events.push((Instant::now(), Event::Cleared));
                self.codes[0] = 0;
            }
            17 => {
                self.events.push((Instant::now(), Event::Cleared));
                self.codes[1] = 0;
            }
            19 => self.mode = first,
            // Only checked, from where the arm is or from what was checked before: two bytes of waiting requests, and the code.
            21 if request.payload().get(42).is_some_and(|only| *only != 0) => {
                let only = request.payload()[42];
                let from = self.checked.filter(|_| only != 1).unwrap_or(self.pose[0]);
                let to = request.float(0);
                self.checked = (only != 2).then_some(to);
                self.events.push((Instant::now(), Event::Checked(from, to)));
                let cannot = self.is_made(Fault::CannotMove) || from.max(to) > self.model.wall;
                content.extend([0, 0, if cannot { 23 } else { 0 }]);
            }
            21 => {
                self.line_came();
                if self.codes[0] == 0 && self.enabled && self.state <= READY {
                    let mut line = [0.0; 8];
                    for (i, number) in line.iter_mut().enumerate() {
                        *number = request.float(i);
                    }
                    self.queue.push_back(line);
                    self.pass();
                }
                content.extend((self.queue.len() as u16).to_be_bytes());
            }
            31 => self.ramp[0] = request.float(0),
            32 => self.ramp[1] = request.float(0),
            41 => {
                let pose = self.answered_pose();
                content.extend(pose.iter().flat_map(|v| (*v as f32).to_le_bytes()));
            }
            _ => content = vec![0; 32],
        }
        let is_ready = self.enabled && self.state <= READY;
        let mut status = if is_ready { 0 } else { 0x10 };
        if self.codes[0] != 0 {
            status |= 0x40;
        }
        if self.codes[1] != 0 {
            status |= 0x20;
        }
        request.reply(status, &content)
    }

    fn answered_pose(&self) -> [f64; 6] {
        let mut pose = self.reported().pose;
        if self.is_made(Fault::WrongPose) {
            pose[1] += 112.0;
        }
        pose
    }

    /// Notes a line, and makes the fault that is one of its coming.
    fn line_came(&mut self) {
        self.events.push((Instant::now(), Event::Line));
        let is_next = matches!(self.fault, Some((Step::Line(number), Fault::Delayed)) if number == self.lines + 1);
        if is_next {
            self.make_fault();
            self.not_before = Some(Instant::now() + DELAY);
        }
    }

    /// Whether the fault is to be made at this step.
    pub(crate) fn is_next(&self, step: Step) -> bool {
        self.fault.is_some_and(|(at, _)| at == step)
    }

    /// The arm's serial number.
    pub(crate) fn serial(&self) -> String {
        let version = &self.model.version;
        version.split(',').nth(2).unwrap_or_default().to_owned()
    }

    /// A script of URScript, which replaces the one that runs.
    pub(crate) fn run(&mut self, text: &str) {
        self.pass();
        if self.model.is_local {
            return;
        }
        let after = |name: &str| text.find(name).map(|at| numbers(&text[at + name.len()..]));
        if text.contains("stopl(") {
            self.events.push((Instant::now(), Event::Stop));
            if self.lost > 0 {
                self.lost -= 1;
                return;
            }
            self.stop_pose.get_or_insert(self.pose);
            self.halt();
            return;
        }
        let echoes = text.contains("write_output_integer_register(25");
        let waits = echoes || text.contains("while (True)");
        let lines = text.split("  line(").skip(1).filter_map(numbered).collect();
        self.script = Some(Script {
            begun: Instant::now(),
            waits,
            echoes,
            lines,
        });
        if let (false, Some((begun, motion))) = (echoes || !waits, &mut self.motion) {
            // The program that it replaces moves no more.
            self.queue.clear();
            motion.stop(begun.elapsed().as_secs_f64());
        }
        if waits && text.contains("rtde_set_watchdog(") {
            // It begins to count with the script.
            self.life.0 = Instant::now();
        }
        if let Some(question) = after("write_output_integer_register(24") {
            let cannot = self.is_made(Fault::CannotMove).then_some(4);
            let wall = self.model.wall;
            let beyond = text
                .split("  ask(p")
                .skip(1)
                .find_map(|place| match numbers(place)[..] {
                    [x, _, _, _, _, _, line, ..] => (x * 1e3 > wall).then_some(line as i32),
                    _ => None,
                });
            let question = question.first().copied().unwrap_or_default() as i32;
            self.registers[0] = question + cannot.or(beyond).unwrap_or(0);
        } else if let Some(line) = after("movel(p[").and_then(|numbers| queued(&numbers)) {
            self.take_line(line);
        } else if self.is_next(Step::Enable) {
            self.make_fault();
        }
    }

    fn set_state(&mut self, state: u8) {
        if state == STOPPED {
            self.events.push((Instant::now(), Event::Stop));
        }
        match state {
            0 if self.codes[0] == 0 && self.motion.is_none() => self.state = READY,
            3 => self.state = PAUSED,
            4 if self.lost > 0 => self.lost -= 1,
            4 => {
                self.stop_pose.get_or_insert(self.pose);
                self.halt();
            }
            _ => {}
        }
        if self.is_made(Fault::NeverReady) {
            self.state = STOPPED;
        }
    }
}
