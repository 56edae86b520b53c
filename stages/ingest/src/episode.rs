//! The stream of commands cut into episodes, in each of which the commanded speed rises from rest and falls back; how they wait for
//! centroids, and what a cut log leaves of them.

use std::collections::VecDeque;

use logs::Sample;
use values::{Point, RejectReason, Rig};

use crate::identity::AFTER;
use crate::order::{seconds, since};
use crate::rejection::{Detail, Rejection};

/// Share of the speed of the robot's slowest strike below which the arm is idle.
const IDLE: f64 = 0.05;
/// Share of the speed of the slowest strike below which an arm is idle where its speed is measured: an arm that is held still quivers.
const IDLE_MEASURED: f64 = 0.25;
/// Time, in ns, without motion after which the arm is idle again: a single zero within a strike does not end it.
pub(crate) const IDLE_TIME: i64 = 100_000_000;
/// Time, in ns, without a command after which a strike ends, too.
const SILENCE: i64 = 500_000_000;
/// Greatest number of commands of a strike, idle ones within it included: an arm that never stops is not striking.
pub(crate) const MOST_COMMANDS: usize = 200_000;
/// Number of commands the other way that are a motion of their own, though none between was idle.
const REVERSED: usize = 3;
/// Least number of commands, and least time in s, of a strike: an arm that moves for less has made a blip.
const BLIP_COMMANDS: usize = 3;
const BLIP_TIME: f64 = 0.020;

/// A rise and fall of the command.
#[derive(Clone, Debug)]
pub(crate) struct Episode {
    /// Its index among the log's episodes, from 0.
    pub(crate) index: u32,
    /// Commands from the first to the last that is not idle.
    pub(crate) commands: Vec<Sample>,
    /// Sum of the commands, in m/s: the direction that it goes in.
    towards: Point,
    /// Why it is rejected, whatever its centroids show.
    pub(crate) fault: Option<Rejection>,
}

impl Episode {
    /// Stamp at which the command left rest, in ns.
    pub(crate) fn start(&self) -> i64 {
        self.commands.first().map_or(0, |command| command.stamp)
    }

    /// Stamp of the last command before it rested again, in ns.
    pub(crate) fn end(&self) -> i64 {
        self.commands.last().map_or(0, |command| command.stamp)
    }

    /// Whether it is too short to be a strike.
    pub(crate) fn is_blip(&self) -> bool {
        self.commands.len() < BLIP_COMMANDS || since(self.start(), self.end()) < BLIP_TIME
    }

    /// Whether it goes where the arm may strike: going back, or sideways to the next start, it does not.
    pub(crate) fn is_towards_strikes(&self, rig: &Rig) -> bool {
        rig.robot.angle.contains(self.towards.bearing())
    }

    /// Whether the arm goes back: away from where it may strike, and slower than it strikes.
    pub(crate) fn is_way_back(&self, rig: &Rig) -> bool {
        let is_slow = |command: &Sample| speed(command) < rig.robot.speed.low;
        !self.is_blip()
            && self.fault.is_none()
            && !self.is_towards_strikes(rig)
            && self.commands.iter().all(is_slow)
    }

    /// Adds a command, as long as there is room.
    fn add(&mut self, command: Sample) {
        if is_finite(&command) {
            self.towards = self.towards + Point::new(command.x, command.y);
        }
        if self.commands.len() < MOST_COMMANDS {
            self.commands.push(command);
            return;
        }
        if let Some(last) = self.commands.last_mut() {
            *last = command;
        }
        self.fault.get_or_insert_with(|| {
            let messages = MOST_COMMANDS;
            let detail = Detail::CommandGoesOn { messages };
            Rejection::new(RejectReason::NoPlateau, detail)
        });
    }
}

/// Commanded speed, in m/s.
pub(crate) fn speed(command: &Sample) -> f64 {
    command.x.hypot(command.y)
}

/// Whether both coordinates are numbers.
pub(crate) fn is_finite(command: &Sample) -> bool {
    command.x.is_finite() && command.y.is_finite()
}

/// Cuts the stream of commands into episodes.
#[derive(Debug)]
pub(crate) struct Episodes {
    idle_below: f64,
    current: Option<Episode>,
    /// Commands since the last active one that are idle or go the other way, which are part of the episode if it goes on.
    idle: Vec<Sample>,
    /// Number of commands at the end of `idle` that go the other way.
    against: usize,
    seen: u32,
}

impl Episodes {
    /// `measured`: velocities are the arm's state, not its commands.
    pub(crate) fn new(rig: &Rig, measured: bool) -> Self {
        let idle = if measured { IDLE_MEASURED } else { IDLE };
        Self {
            idle_below: idle * rig.robot.speed.low,
            current: None,
            idle: Vec::new(),
            against: 0,
            seen: 0,
        }
    }

    /// Takes the next command; the episode that it ends, if it ends one.
    pub(crate) fn take(&mut self, command: Sample) -> Option<Episode> {
        // A command that is not a number is not known to be idle.
        let active = speed(&command) > self.idle_below || !is_finite(&command);
        let silent = self.current.as_ref().is_some_and(|episode| {
            let since = command.stamp.saturating_sub(episode.end());
            since > SILENCE || (!active && since > IDLE_TIME)
        });
        let mut ended = if silent { self.finish() } else { None };
        let towards = self
            .current
            .as_ref()
            .map_or(Point::default(), |e| e.towards);
        let opposes = active && Point::new(command.x, command.y).dot(towards) < 0.0;
        match &mut self.current {
            Some(_) if opposes && self.against + 1 == REVERSED => {
                let back = self.idle.split_off(self.idle.len() - self.against);
                ended = self.finish();
                for command in back.into_iter().chain([command]) {
                    self.add(command);
                }
            }
            Some(_) if active && !opposes => self.add(command),
            Some(_) => {
                self.against = if opposes { self.against + 1 } else { 0 };
                if self.idle.len() < MOST_COMMANDS {
                    self.idle.push(command);
                }
            }
            None if active => self.add(command),
            None => {}
        }
        ended
    }

    /// Adds a command to the current episode, with those that were set aside before it; begins one where there is none.
    fn add(&mut self, command: Sample) {
        self.against = 0;
        if self.current.is_none() {
            self.current = Some(Episode {
                index: self.seen,
                commands: Vec::new(),
                towards: Point::default(),
                fault: None,
            });
            self.seen += 1;
        }
        if let Some(episode) = &mut self.current {
            for idle in self.idle.drain(..) {
                episode.add(idle);
            }
            episode.add(command);
        }
    }

    /// Takes the next index among the log's episodes for a strike that no episode shows.
    pub(crate) fn place(&mut self) -> u32 {
        self.seen += 1;
        self.seen - 1
    }

    /// The episode that has not ended.
    pub(crate) fn current(&mut self) -> Option<&mut Episode> {
        self.current.as_mut()
    }

    /// Ends the episode that has not ended.
    pub(crate) fn finish(&mut self) -> Option<Episode> {
        self.idle.clear();
        self.against = 0;
        self.current.take()
    }
}

/// Why no more samples that belong to the present ones will come.
pub(crate) enum EndOfData {
    /// The log ends.
    End,
    /// Messages are missing from here on.
    Lost(String),
    /// A clock was set back.
    Clock(Detail),
}

impl EndOfData {
    /// Whether the data holds all that a strike's id is made of: one that is cut off before would be another strike than the whole one.
    pub(crate) fn leaves_whole(
        ending: Option<&Self>,
        episode: &Episode,
        last_centroid: Option<i64>,
    ) -> Result<(), Rejection> {
        let needed = episode.end().saturating_add(AFTER);
        match ending {
            Some(Self::Lost(why)) if last_centroid.is_none_or(|last| last <= needed) => {
                let (after, why) = (seconds(AFTER), why.clone());
                let detail = Detail::CutAfterCommand { after, why };
                Err(Rejection::new(RejectReason::Truncated, detail))
            }
            _ => Ok(()),
        }
    }

    /// Blames a rejection on what ended the data, if anything did: what has not been seen to its end is the fault of what ended it.
    pub(crate) fn blame(ending: Option<&Self>, rejection: Rejection) -> Rejection {
        let unseen = matches!(
            rejection.reason,
            RejectReason::NoRestAfter | RejectReason::NoMotion | RejectReason::FramesMissing
        );
        let seen = Box::new(rejection.detail.clone());
        match ending {
            Some(Self::Lost(why)) if unseen => {
                let why = why.clone();
                Rejection::new(RejectReason::Truncated, Detail::CutHere { seen, why })
            }
            Some(Self::Clock(clock)) if unseen => {
                let clock = Box::new(clock.clone());
                let detail = Detail::ClockEndsHere { seen, clock };
                Rejection::new(RejectReason::ClockBackwards, detail)
            }
            _ => rejection,
        }
    }
}

/// Greatest number of commands that wait (24 MB), and the number that each episode counts as on top.
const MOST_WAITING: usize = 1_000_000;
const EPISODE: usize = 8;

/// Episodes in their order.
#[derive(Default)]
pub(crate) struct Queue {
    episodes: VecDeque<Episode>,
    /// Index and start of those that strike, the first one left out.
    striking: VecDeque<(u32, i64)>,
    commands: usize,
}

impl Queue {
    /// Adds an episode. Blips do not strike, nor does an arm that goes back.
    pub(crate) fn push(&mut self, episode: Episode, rig: &Rig) {
        if !self.episodes.is_empty() && !episode.is_blip() && episode.is_towards_strikes(rig) {
            self.striking.push_back((episode.index, episode.start()));
        }
        self.commands += episode.commands.len() + EPISODE;
        self.episodes.push_back(episode);
    }

    /// The episode that waits longest.
    pub(crate) fn first(&self) -> Option<&Episode> {
        self.episodes.front()
    }

    /// Stamp at which the next episode after the first one strikes.
    pub(crate) fn next_strike(&self) -> Option<i64> {
        self.striking.front().map(|(_, start)| *start)
    }

    /// Takes the first episode.
    pub(crate) fn pop(&mut self) -> Option<Episode> {
        let episode = self.episodes.pop_front()?;
        self.commands -= episode.commands.len() + EPISODE;
        let first = self.episodes.front().map(|first| first.index);
        if self.striking.front().map(|(index, _)| *index) == first {
            self.striking.pop_front();
        }
        Some(episode)
    }

    /// Whether more waits than may.
    pub(crate) fn is_full(&self) -> bool {
        self.commands > MOST_WAITING
    }
}

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;

    /// Commands at 100 Hz with these speeds at 0.5 rad.
    fn episodes(speeds: &[f64]) -> Vec<Episode> {
        let mut episodes = Episodes::new(&Rig::demo(Shape::Cylinder), false);
        let mut ended = Vec::new();
        for (i, speed) in (0_i64..).zip(speeds) {
            let (x, y) = (speed * 0.5_f64.cos(), speed * 0.5_f64.sin());
            ended.extend(
                episodes.take(Sample::at(1_000_000_000 + i * 10_000_000, Point::new(x, y))),
            );
        }
        ended.extend(episodes.finish());
        ended
    }

    #[test]
    fn rises_and_falls_are_counted_and_single_zeros_do_not_part_them() {
        let strike = [0.7, 0.7, 0.0, 0.7, 0.7];
        let rest = [0.0; 30];
        let seen = episodes(&[&rest[..], &strike, &rest, &strike, &rest].concat());
        assert_eq!(
            seen.iter().map(|episode| episode.index).collect::<Vec<_>>(),
            [0, 1]
        );
        assert!(seen.iter().all(|episode| episode.commands.len() == 5));
    }

    #[test]
    fn an_arm_that_creeps_below_its_slowest_strike_is_idle() {
        assert!(episodes(&[0.0, 0.01, 0.015, 0.01, 0.0]).is_empty());
    }

    #[test]
    fn an_arm_that_never_stops_is_held_within_bounds_and_is_no_strike() {
        // Idle commands between active ones count, too: their stamps stand still, so that no time ends the episode.
        let mut episodes = Episodes::new(&Rig::demo(Shape::Cylinder), false);
        let command = |x: f64| Sample::at(1_000_000_000, Point::new(x, 0.0));
        for _ in 0..5 {
            assert!(episodes.take(command(0.7)).is_none());
            for _ in 0..MOST_COMMANDS - 1 {
                assert!(episodes.take(command(0.0)).is_none());
            }
        }
        assert!(episodes.take(command(0.7)).is_none());
        let episode = episodes.finish().expect("an episode");
        assert!(episode.commands.len() <= MOST_COMMANDS);
        let fault = episode.fault.expect("a fault");
        assert_eq!(fault.reason, RejectReason::NoPlateau);
    }
}
