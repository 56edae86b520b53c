//! What the arm's state and the object's pose add to strikes that were found from commands and centroids.
//!
//! A log need not hold these topics, and which it holds is not known before its end. So a strike waits until the states and poses of
//! its time have come, or until more wait than are held; then it goes on with what is there.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use logs::Sample;
use values::{Rig, Strike};

use crate::arm::{
    LaunchContext, Meeting, State, TouchDelay, behind, delay, delivered, meeting, pushes_on,
};
use crate::notes::Note;
use crate::order::Stamped;
use crate::robust::median;
use crate::yaw::{YawSample, yaw};

/// Greatest number of strikes that wait (some 3 MB).
const MOST_STRIKES: usize = 200;
/// Greatest number of states, and of poses, that are held (20 MB and 8 MB): more come too long before the commands of their time.
const MOST_HELD: usize = 500_000;
/// Time, in ns, before a command rises, and after a track ends, for which states and poses are needed.
const MARGIN: i64 = 500_000_000;

/// Time, in s, after the arm began to brake from which an object that moves was met before; it is told where at least one strike in this many is so.
const AFTER: f64 = 0.002;
const SHARE: usize = 4;

/// A strike that waits.
pub(crate) struct Waiting {
    pub(crate) strike: Strike,
    /// Commands from rise to fall.
    pub(crate) commands: Vec<Sample>,
    /// Stamp of first motion, in ns, and seconds from the frame before to it.
    pub(crate) first_motion: i64,
    pub(crate) gap: f64,
}

impl Waiting {
    /// States and poses are needed from this stamp on.
    fn from(&self) -> i64 {
        let start = self.commands.first().map_or(0, |command| command.stamp);
        start.min(self.first_motion).saturating_sub(MARGIN)
    }

    /// States and poses are needed up to this stamp.
    fn until(&self) -> i64 {
        let last = self.strike.track.t.last().copied().unwrap_or(0.0);
        self.first_motion
            .saturating_add((1e9 * last) as i64)
            .saturating_add(MARGIN)
    }
}

/// The states, the poses, and the strikes that wait for them.
#[derive(Default)]
pub(crate) struct Extras {
    pub(crate) states: RecentSamples<State>,
    pub(crate) turns: RecentSamples<YawSample>,
    waiting: VecDeque<Waiting>,
    /// Strikes that went on before the states or poses of their time came.
    early: u64,
    /// Seconds from the tip's touching the object to its first motion.
    pub(crate) delays: Vec<TouchDelay>,
    /// Where the tip was when the object began to move.
    pub(crate) meetings: Vec<Meeting>,
    /// Seconds by which the arm's measured speed lies behind the commanded one.
    pub(crate) behind: Vec<f64>,
    /// Seconds from the end of the arm's plateau to the object's first motion, one a strike of which the arm's state is known.
    late: Vec<f64>,
}

/// The last samples of a topic that may be absent.
pub(crate) struct RecentSamples<T> {
    samples: VecDeque<T>,
    latest: Option<i64>,
}

impl<T> Default for RecentSamples<T> {
    fn default() -> Self {
        Self {
            samples: VecDeque::new(),
            latest: None,
        }
    }
}

impl<T: Stamped + Copy> RecentSamples<T> {
    fn push(&mut self, sample: T) {
        self.latest = Some(sample.stamp());
        self.samples.push_back(sample);
        if self.samples.len() > MOST_HELD {
            self.samples.drain(..MOST_HELD / 2);
        }
    }

    fn has_passed(&self, stamp: i64) -> bool {
        self.latest.is_some_and(|latest| latest > stamp)
    }

    fn between(&self, from: i64, until: i64) -> Vec<T> {
        let place = |stamp: i64| self.samples.partition_point(|s| s.stamp() < stamp);
        let (from, until) = (place(from), place(until));
        self.samples.range(from..until.max(from)).copied().collect()
    }

    /// Forgets all: the clock was set back, or the log ends.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    fn forget_before(&mut self, stamp: i64) {
        let gone = self.samples.partition_point(|s| s.stamp() < stamp);
        self.samples.drain(..gone);
    }
}

impl Extras {
    /// Takes the next state of the arm.
    pub(crate) fn state(&mut self, state: State) {
        self.states.push(state);
    }

    /// Takes the next turn of the object.
    pub(crate) fn turn(&mut self, turn: YawSample) {
        self.turns.push(turn);
    }

    /// Takes a strike, which goes on when what it waits for has come.
    pub(crate) fn strike(&mut self, waiting: Waiting) {
        self.waiting.push_back(waiting);
    }

    /// Hands on the strikes that need not wait any more.
    pub(crate) fn advance(&mut self, rig: &Rig, keep: &mut dyn FnMut(Strike)) {
        while let Some(first) = self.waiting.front() {
            let until = first.until();
            let has_come = self.states.has_passed(until) && self.turns.has_passed(until);
            if !has_come && self.waiting.len() <= MOST_STRIKES {
                break;
            }
            let is_late = |latest: Option<i64>| latest.is_some_and(|latest| latest <= until);
            self.early += u64::from(is_late(self.states.latest) || is_late(self.turns.latest));
            self.release(rig, keep);
        }
    }

    /// Hands on all strikes with what is there, and forgets states and poses: a clock was set back, or the log ends.
    pub(crate) fn close(&mut self, rig: &Rig, keep: &mut dyn FnMut(Strike)) {
        while !self.waiting.is_empty() {
            self.release(rig, keep);
        }
        self.states.forget();
        self.turns.forget();
    }

    /// Forgets what lies before this stamp and before all that the waiting strikes need.
    pub(crate) fn forget_before(&mut self, stamp: i64) {
        let needed = self.waiting.front().map_or(i64::MAX, Waiting::from);
        let stamp = stamp.saturating_sub(MARGIN).min(needed);
        self.states.forget_before(stamp);
        self.turns.forget_before(stamp);
    }

    /// Notes on the log's states and poses.
    pub(crate) fn notes(&self) -> impl Iterator<Item = Note> + use<> {
        let early = (self.early > 0).then_some(Note::StatesLate(self.early));
        let late: Vec<f64> = self
            .late
            .iter()
            .copied()
            .filter(|late| *late > AFTER)
            .collect();
        let (count, of) = (late.len(), self.late.len());
        let is_told = SHARE * count >= of.max(SHARE);
        let late = is_told.then(|| Note::MotionsLate {
            count,
            of,
            by: median(late),
        });
        early.into_iter().chain(late)
    }

    fn release(&mut self, rig: &Rig, keep: &mut dyn FnMut(Strike)) {
        let Some(mut waiting) = self.waiting.pop_front() else {
            return;
        };
        let (from, until) = (waiting.from(), waiting.until());
        let turns = self.turns.between(from, until);
        let states = self.states.between(from, until);
        let strike = &mut waiting.strike;
        let symmetry = rig.object.solid.period().unwrap_or(TAU);
        strike.track.yaw = yaw(&turns, waiting.first_motion, &strike.track.t, symmetry);
        let context = LaunchContext {
            commands: &waiting.commands,
            command: strike.command,
            first_motion: waiting.first_motion,
            gap: waiting.gap,
            initial: strike.initial,
            track: &strike.track,
            noise: rig.camera.noise,
        };
        let delay = delay(&states, &context, rig);
        self.delays.extend(delay);
        self.behind.extend(behind(&states, &waiting.commands));
        let found = delivered(&states, &context);
        let met = meeting(&states, &context, delay).map(|meeting| Meeting {
            delivered: found.map(|(of, _)| of.tip_speed / context.command.speed),
            ..meeting
        });
        self.meetings.extend(met);
        self.late.extend(found.map(|(_, late)| late));
        strike.conditions.is_pushed_on =
            found.is_none() && strike.has_stop() && pushes_on(&context, strike.stop);
        strike.delivered = found.map(|(delivered, _)| delivered);
        keep(waiting.strike);
    }
}
