//! What the controller is in, and what each request does to it.

use std::collections::VecDeque;
use std::time::Instant;

use crate::frames::{Reported, Request};
use values::Point;

use crate::motion::Motion;
use crate::table::Table;
use crate::{Fault, Step};

/// The arm that is emulated.
#[derive(Clone, Debug)]
pub struct Model {
    /// As the controller reports it.
    pub version: String,
    /// Where the tip is at first: mm and rad.
    pub pose: [f64; 6],
    /// mm and rad.
    pub tool_offset: [f64; 6],
    /// kg.
    pub payload: f64,
    /// Error and warning code at first.
    pub codes: [u8; 2],
}

impl Default for Model {
    fn default() -> Self {
        Self {
            version: "7,7,XI1305,AC1305,v1.12.10".into(),
            pose: [200.0, 0.0, 100.0, std::f64::consts::PI, 0.0, 0.0],
            tool_offset: [0.0, 0.0, 100.0, 0.0, 0.0, 0.0],
            payload: 0.3,
            codes: [0, 0],
        }
    }
}

/// What happened, and when.
#[derive(Clone, Debug)]
pub enum Event {
    /// A request came.
    Request(Request),
    /// The fault was made.
    Fault,
}

/// States in reports.
const MOVING: u8 = 1;
const READY: u8 = 2;
const PAUSED: u8 = 3;
const STOPPED: u8 = 4;

/// The controller.
#[derive(Debug)]
pub(crate) struct State {
    pub(crate) model: Model,
    begun: Instant,
    state: u8,
    mode: u8,
    enabled: bool,
    codes: [u8; 2],
    jerk: f64,
    pose: [f64; 6],
    motion: Option<(Instant, Motion)>,
    queue: VecDeque<[f64; 8]>,
    lines: u32,
    fault: Option<(Step, Fault)>,
    /// The fault that was made.
    pub(crate) made: Option<(Instant, Fault)>,
    pub(crate) events: Vec<(Instant, Event)>,
    /// Greatest distance (mm) that the tip moved since a stop was requested.
    pub(crate) moved_after_stop: f64,
    stop_pose: Option<[f64; 6]>,
    /// What lies before the arm, whose base is the origin of the table.
    pub(crate) table: Option<Table>,
}

impl State {
    pub(crate) fn new(model: Model, fault: Option<(Step, Fault)>) -> Self {
        let mut state = Self {
            begun: Instant::now(),
            state: READY,
            mode: 0,
            enabled: false,
            codes: model.codes,
            jerk: 1_000.0,
            pose: model.pose,
            motion: None,
            queue: VecDeque::new(),
            lines: 0,
            fault,
            made: None,
            events: Vec::new(),
            moved_after_stop: 0.0,
            stop_pose: None,
            table: None,
            model,
        };
        if fault.is_some_and(|(step, _)| step == Step::Connect) {
            state.make_fault();
        }
        state
    }

    /// The fault that was made, of those that the wire shows.
    pub(crate) fn is_made(&self, fault: Fault) -> bool {
        self.made.is_some_and(|(_, made)| made == fault)
    }

    fn make_fault(&mut self) {
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
            _ => {}
        }
    }

    fn halt(&mut self) {
        self.state = STOPPED;
        self.queue.clear();
        if let Some((begun, motion)) = &mut self.motion {
            motion.stop(begun.elapsed().as_secs_f64());
        }
    }

    /// Lets time pass up to now, for the arm and for what lies before it.
    pub(crate) fn pass(&mut self) {
        self.move_on();
        let now = Instant::now();
        let (pose, velocity) = self
            .motion
            .map_or((self.pose, [0.0; 3]), |(begun, motion)| {
                motion.at(now.saturating_duration_since(begun).as_secs_f64())
            });
        if let Some(table) = &mut self.table {
            let flat = |[x, y, _]: [f64; 3]| Point::new(x * 1e-3, y * 1e-3);
            let at = flat([pose[0], pose[1], pose[2]]);
            table.tip(at, pose[2], flat(velocity), now);
        }
    }

    fn move_on(&mut self) {
        let Some((begun, motion)) = self.motion else {
            if self.enabled
                && self.state == READY
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
        let motion = Motion::line(self.pose, to, share * speed, acceleration, self.jerk);
        self.motion = Some((Instant::now(), motion));
        self.state = MOVING;
    }

    /// What the reports hold now.
    pub(crate) fn reported(&self) -> Reported {
        let (mut pose, mut velocity) = self
            .motion
            .map_or((self.pose, [0.0; 3]), |(begun, motion)| {
                motion.at(begun.elapsed().as_secs_f64())
            });
        let mut clock = self.begun.elapsed().as_micros() as u64;
        if let Some((since, fault)) = self.made {
            let later = since.elapsed().as_secs_f64();
            match fault {
                Fault::OffLine => pose[2] += (200.0 * later).min(30.0),
                Fault::Jump => pose[0] -= 80.0,
                Fault::Lag => clock -= (0.5 * later * 1e6) as u64,
                Fault::NotANumber => velocity[0] = f64::NAN,
                _ => {}
            }
        }
        let waiting = self.queue.len() as u16 + u16::from(self.motion.is_some());
        Reported {
            clock,
            state: self.state,
            mode: self.mode,
            waiting,
            enabled: self.enabled,
            codes: self.codes,
            pose,
            velocity,
            tool_offset: self.model.tool_offset,
            payload: self.model.payload,
        }
    }

    /// Does what a request asks; gives the reply.
    pub(crate) fn answer(&mut self, request: &Request) -> Vec<u8> {
        self.events
            .push((Instant::now(), Event::Request(request.clone())));
        self.pass();
        let first = request.payload().first().copied().unwrap_or(0);
        let content = match request.register() {
            1 => {
                let mut text = self.model.version.clone().into_bytes();
                text.resize(40.max(text.len()), 0);
                text
            }
            2 => vec![0; 40],
            11 => {
                self.enabled = request.payload().get(1) == Some(&1);
                if self.fault.is_some_and(|(step, _)| step == Step::Enable) {
                    self.make_fault();
                }
                Vec::new()
            }
            12 => {
                self.set_state(first);
                Vec::new()
            }
            13 => vec![self.state],
            14 => (self.queue.len() as u16).to_be_bytes().to_vec(),
            15 => {
                if self.fault.is_some_and(|(step, _)| step == Step::Check) {
                    self.make_fault();
                }
                self.codes.to_vec()
            }
            16 => {
                self.codes[0] = 0;
                Vec::new()
            }
            17 => {
                self.codes[1] = 0;
                Vec::new()
            }
            19 => {
                self.mode = first;
                Vec::new()
            }
            21 => {
                if self.codes[0] == 0 && self.enabled && self.state <= READY {
                    let mut line = [0.0; 8];
                    for (i, number) in line.iter_mut().enumerate() {
                        *number = request.float(i);
                    }
                    self.queue.push_back(line);
                    self.pass();
                }
                self.queue.len().to_be_bytes()[6..].to_vec()
            }
            31 => {
                self.jerk = request.float(0);
                Vec::new()
            }
            41 => self
                .reported()
                .pose
                .iter()
                .flat_map(|number| (*number as f32).to_le_bytes())
                .collect(),
            _ => vec![0; 32],
        };
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

    fn set_state(&mut self, state: u8) {
        match state {
            0 if self.codes[0] == 0 && self.motion.is_none() => self.state = READY,
            3 => self.state = PAUSED,
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
