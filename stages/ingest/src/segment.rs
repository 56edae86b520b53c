//! Strikes out of two streams that run side by side.
//!
//! Commands cut time into episodes; each waits until the centroids around it have come, whichever topic runs ahead. Between
//! episodes only the last seconds are held, so that memory does not grow with the log.

use std::collections::VecDeque;

use logs::Sample;
use values::{
    Command, CommandFrame, Conditions, Point, Reject, RejectReason, Rig, Sentence, Strike, split_of,
};

use crate::arm::{Meeting, State, TouchDelay};
use crate::bounces::{Break, Breaks, Flight, Touch};
use crate::counts::Counts;
use crate::episode::{EndOfData, Episode, Episodes, IDLE_TIME, Queue, is_finite};
use crate::extras::{Extras, Waiting};
use crate::identity::strike_id;
use crate::lost::Lost;
use crate::notes::Note;
use crate::order::{ClockSetBack, Ordered, seconds};
use crate::outcome::StrikeSummary;
use crate::plateau::{at_contact, plateau};
use crate::pushes::Pushes;
use crate::rejection::{Detail, Rejection};
use crate::seen::{CommandSeen, MotionSeen, Seen, Watch, gathered, risen, smeared};
use crate::slide::{self, Frames};
use crate::touched::{self, TouchedFlight, TouchedStrike};
use crate::yaw::YawSample;

/// Time, in ns, before a strike for which centroids are held.
const BEFORE: i64 = 3_000_000_000;
/// Longest time from the command's fall to the object's rest, in ns.
const HORIZON: i64 = 20_000_000_000;
/// Greatest number of centroids that wait for commands to come (48 MB).
const MOST_WAITING: usize = 2_000_000;
/// Latest time of a tip's touch after its command fell back, in ns.
const AFTER_FALL: i64 = 300_000_000;
/// Number of centroids after which the held ones are trimmed.
const TRIM_EVERY: u32 = 512;

/// What was found in a log, beside the strikes that were handed over.
#[derive(Default)]
pub(crate) struct Segmented {
    pub(crate) strikes: Vec<StrikeSummary>,
    pub(crate) rejects: Vec<Reject<Sentence<Detail>>>,
    pub(crate) notes: Vec<Note>,
    pub(crate) seen: Seen,
}

/// The last messages of each topic, which may yet be overtaken.
#[derive(Default)]
struct ReorderBuffers {
    centroids: Ordered<Sample>,
    commands: Ordered<Sample>,
    states: Ordered<State>,
    turns: Ordered<YawSample>,
}

/// Where the commands of a log come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CommandSource {
    /// The topic of commands.
    Topic,
    /// The measured state: what was delivered stands for what was commanded, of which nothing is known.
    State,
}

/// Strikes and rejects that one way of looking finds in a log without commands.
#[derive(Default)]
struct ByState {
    strikes: Vec<Strike>,
    rejects: Vec<Reject<Sentence<Detail>>>,
    commands: Vec<CommandSeen>,
    motions: Vec<MotionSeen>,
    delays: Vec<TouchDelay>,
    meetings: Vec<Meeting>,
}

pub(crate) struct Segmenter<'a> {
    log: &'a str,
    rig: &'a Rig,
    source: CommandSource,
    seed: u64,
    /// Receives each strike when it is found.
    keep: &'a mut dyn FnMut(Strike),
    episodes: Episodes,
    /// The last command that is a number, and those since that are none.
    last_number: Option<i64>,
    not_numbers: Vec<Sample>,
    /// Episodes whose centroids have not all come.
    waiting: Queue,
    centroids: VecDeque<Sample>,
    extras: Extras,
    lost: Lost,
    watch: Watch,
    breaks: Breaks,
    pushes: Pushes,
    /// Frames before the flight that comes next; none after a pause.
    before: Vec<Sample>,
    /// In a log without commands: strikes by the tip's touch, and motions of the arm at whose time the object began to move. If the tip is where its
    /// state says, the former are the strikes, and the latter are what a hand did meanwhile.
    touched: ByState,
    untouched: ByState,
    is_touched: bool,
    /// Flights that the tip began, and touches about all that were begun, until it is known how far in time the camera lies behind the tip.
    flights: Vec<TouchedFlight>,
    touches: Vec<TouchDelay>,
    /// In a log with commands: commands at which the object moved before, pushes of an object that moved, and those that the tip's touch began.
    restless: Vec<(Episode, Reject<Sentence<Detail>>)>,
    pushed: Vec<MotionSeen>,
    moved: Vec<(TouchedStrike, TouchedFlight)>,
    reordered: ReorderBuffers,
    last_centroid: Option<i64>,
    last_command: Option<i64>,
    since_trim: u32,
    /// The last fault of the centroids' clock, for episodes that find no centroids.
    clock: Option<Detail>,
    found: Segmented,
    counts: Counts,
}

impl<'a> Segmenter<'a> {
    pub(crate) fn new(
        log: &'a str,
        rig: &'a Rig,
        source: CommandSource,
        seed: u64,
        keep: &'a mut dyn FnMut(Strike),
    ) -> Self {
        Self {
            log,
            rig,
            source,
            seed,
            keep,
            episodes: Episodes::new(rig, source == CommandSource::State),
            last_number: None,
            not_numbers: Vec::new(),
            waiting: Queue::default(),
            centroids: VecDeque::new(),
            extras: Extras::default(),
            lost: Lost::default(),
            watch: Watch::new(rig),
            breaks: Breaks::new(rig, rig.camera.noise),
            pushes: Pushes::new(rig),
            before: Vec::new(),
            touched: ByState::default(),
            untouched: ByState::default(),
            is_touched: false,
            flights: Vec::new(),
            touches: Vec::new(),
            restless: Vec::new(),
            pushed: Vec::new(),
            moved: Vec::new(),
            reordered: ReorderBuffers::default(),
            last_centroid: None,
            last_command: None,
            since_trim: 0,
            clock: None,
            found: Segmented::default(),
            counts: Counts::default(),
        }
    }

    /// Takes the next centroid.
    pub(crate) fn centroid(&mut self, sample: Sample) {
        let mut next = Vec::new();
        let taken = self.reordered.centroids.take(sample, &mut next);
        next.into_iter().for_each(|sample| self.see(sample));
        if let Err(ClockSetBack { by, since }) = taken {
            let back = seconds(by);
            self.close(EndOfData::Clock(Detail::CentroidSetBack { by: back }));
            since.into_iter().for_each(|sample| self.centroid(sample));
        }
    }

    /// Takes the next command.
    pub(crate) fn command(&mut self, sample: Sample) {
        let mut next = Vec::new();
        let taken = self.reordered.commands.take(sample, &mut next);
        next.into_iter().for_each(|sample| self.obey(sample));
        if let Err(ClockSetBack { by, since }) = taken {
            let back = seconds(by);
            self.close(EndOfData::Clock(Detail::CommandSetBack { by: back }));
            since.into_iter().for_each(|sample| self.command(sample));
        }
    }

    /// Takes the next state of the arm. Its clock takes nothing but states with it.
    pub(crate) fn state(&mut self, state: State) {
        let mut next = Vec::new();
        let taken = self.reordered.states.take(state, &mut next);
        next.into_iter().for_each(|state| self.tell(state));
        if let Err(ClockSetBack { since, .. }) = taken {
            self.reordered.states.drain();
            self.extras.states.forget();
            since.into_iter().for_each(|state| self.state(state));
        }
        self.hand_on();
    }

    /// Takes the next turn of the object.
    pub(crate) fn turn(&mut self, turn: YawSample) {
        let mut next = Vec::new();
        let taken = self.reordered.turns.take(turn, &mut next);
        next.into_iter().for_each(|turn| self.extras.turn(turn));
        if let Err(ClockSetBack { since, .. }) = taken {
            self.reordered.turns.drain();
            self.extras.turns.forget();
            since.into_iter().for_each(|turn| self.turn(turn));
        }
        self.hand_on();
    }

    /// Hands on the strikes that need not wait any more; of a log without commands they are held until it is known which are strikes.
    fn hand_on(&mut self) {
        match self.source {
            CommandSource::Topic => self.extras.advance(self.rig, self.keep),
            CommandSource::State => {
                let held = &mut self.untouched.strikes;
                self.extras
                    .advance(self.rig, &mut |strike| held.push(strike));
            }
        }
    }

    /// Handles a state of the arm, in order of stamps.
    fn tell(&mut self, state: State) {
        self.breaks.tip(&state);
        self.pushes.tip(&state);
        self.extras.state(state);
        self.fly(false);
    }

    /// Handles a centroid, in order of stamps.
    fn see(&mut self, sample: Sample) {
        match self.last_centroid {
            Some(last) if sample.stamp == last && last == 0 => {
                self.shut(EndOfData::Clock(Detail::StampsStandStill));
            }
            // The same message twice, or two detections in one frame: the first counts.
            Some(last) if sample.stamp == last => {
                self.counts.repeated += 1;
                return;
            }
            _ => {}
        }
        self.last_centroid = Some(sample.stamp);
        let mut seen = Vec::new();
        let lost = self.lost.take(sample, self.rig, |sample| seen.push(sample));
        self.follow(seen, lost);
    }

    /// Handles frames in which the object was seen, after so many in which it was not.
    fn follow(&mut self, seen: Vec<Sample>, lost: usize) {
        self.counts.lost += lost as u64;
        self.found.seen.bursts += self.lost.take_bursts();
        for sample in seen {
            self.found.seen.frames += 1;
            self.watch.take(&sample, &mut self.found.seen);
            self.breaks.see(&sample);
            self.pushes.see(&sample);
            self.fly(false);
            self.centroids.push_back(sample);
        }
        self.advance();
    }

    /// Handles a command, in order of stamps. One that is no number, between others that are, is left out.
    fn obey(&mut self, sample: Sample) {
        let last = *self.last_number.get_or_insert(sample.stamp);
        let is_bridged = sample.stamp.saturating_sub(last) <= IDLE_TIME;
        if is_finite(&sample) {
            self.last_number = Some(sample.stamp);
        } else if is_bridged {
            self.not_numbers.push(sample);
            return;
        }
        let between = std::mem::take(&mut self.not_numbers);
        if is_bridged {
            self.counts.not_numbers += between.len();
        } else {
            between.into_iter().for_each(|sample| self.act(sample));
        }
        self.act(sample);
    }

    /// Handles a command that tells what the arm is to do.
    fn act(&mut self, sample: Sample) {
        self.last_command = Some(sample.stamp);
        if let Some(episode) = self.episodes.take(sample) {
            self.queue(episode);
        }
        self.advance();
    }

    /// An episode that has ended waits; where too much waits, the first is judged with what is there.
    fn queue(&mut self, episode: Episode) {
        // By its state an arm also moves where it is to strike nothing.
        if self.source == CommandSource::Topic {
            if episode.is_way_back(self.rig) {
                self.counts.ways_back += 1;
                return;
            }
            let seen = CommandSeen::of(&episode, self.rig);
            self.found.seen.commands.extend(seen);
        }
        self.waiting.push(episode, self.rig);
        while self.waiting.is_full() {
            self.counts.unseen += 1;
            let next = self.next_strike();
            self.judge_first(next.unwrap_or(i64::MAX), next.is_some(), None);
        }
    }

    /// Judges the episodes whose centroids have all come, and lets go of what no episode needs.
    fn advance(&mut self) {
        while let Some(first) = self.waiting.first() {
            let horizon = first.end().saturating_add(HORIZON);
            let current = self.episodes.current();
            // One that has just begun may become a strike.
            let is_open = current.is_some_and(|e| e.is_blip() && e.start() < horizon);
            let next = self.next_strike();
            let until = next.unwrap_or(i64::MAX).min(horizon);
            let commands_came =
                next.is_some() || self.last_command.is_some_and(|last| last >= until);
            if is_open || !commands_came || self.last_centroid.is_none_or(|last| last < until) {
                break;
            }
            self.judge_first(until, next.is_some(), None);
        }
        self.since_trim += 1;
        if self.since_trim >= TRIM_EVERY {
            self.since_trim = 0;
            self.trim();
        }
    }

    /// When the next command after the first one that waits strikes. Blips do not, nor does an arm that goes back while the
    /// object still slides: what the first one did goes on beyond them.
    fn next_strike(&mut self) -> Option<i64> {
        let rig = self.rig;
        self.waiting.next_strike().or_else(|| {
            let current = self.episodes.current().map(|current| &*current);
            current
                .filter(|episode| !episode.is_blip() && episode.is_towards_strikes(rig))
                .map(Episode::start)
        })
    }

    fn trim(&mut self) {
        let first = self.waiting.first().map(Episode::start);
        let needed = first.or_else(|| self.episodes.current().map(|episode| episode.start()));
        let now = || {
            self.last_command
                .unwrap_or(i64::MIN)
                .min(self.last_centroid.unwrap_or(i64::MIN))
        };
        let from = needed.unwrap_or_else(now).saturating_sub(BEFORE);
        self.extras.forget_before(from);
        while self
            .centroids
            .front()
            .is_some_and(|centroid| centroid.stamp < from)
        {
            self.centroids.pop_front();
        }
        if self.centroids.len() > MOST_WAITING {
            let excess = MOST_WAITING / 2;
            self.centroids.drain(..excess);
            self.counts.unheld += excess;
        }
    }

    /// Ends all that has begun: what is whole is kept, what is not is rejected for this reason.
    pub(crate) fn close(&mut self, ending: EndOfData) {
        let ReorderBuffers {
            mut centroids,
            mut commands,
            mut states,
            mut turns,
        } = std::mem::take(&mut self.reordered);
        centroids.drain().into_iter().for_each(|s| self.see(s));
        let mut seen = Vec::new();
        let lost = self.lost.release(self.rig, |sample| seen.push(sample));
        self.follow(seen, lost);
        commands.drain().into_iter().for_each(|s| self.obey(s));
        let between = std::mem::take(&mut self.not_numbers);
        between.into_iter().for_each(|s| self.act(s));
        self.last_number = None;
        states
            .drain()
            .into_iter()
            .for_each(|state| self.tell(state));
        turns.drain().into_iter().for_each(|t| self.extras.turn(t));
        self.shut(ending);
    }

    /// Handles flights that have ended: bounces of the object and, where states alone tell of strikes, touches of the tip.
    fn fly(&mut self, at_end: bool) {
        for (flight, touch) in self.breaks.take(at_end) {
            self.pushed.extend(flight.begun.and_then(pushed));
            match &touch {
                Some(touch) => self.touch(&flight, touch),
                None => self.found.seen.bounces.extend(flight.bounce()),
            }
            self.before = if flight.is_broken {
                flight.frames
            } else {
                Vec::new()
            };
        }
        self.found.seen.hits.append(&mut self.breaks.hits);
        self.touches.append(&mut self.breaks.touches);
        let slides = self.pushes.take(self.log, self.rig, at_end);
        self.counts.carried += self.pushes.take_carried();
        self.counts.untold.extend(self.pushes.take_untold());
        self.found.seen.slides.extend(slides);
    }

    /// Handles a flight that the tip began: a strike where states alone tell of strikes.
    fn touch(&mut self, flight: &Flight, touch: &Touch) {
        let Some(begun) = flight.begun else { return };
        let index = match self.source {
            CommandSource::State => self.episodes.place(),
            CommandSource::Topic => 0,
        };
        let touched = TouchedFlight {
            index,
            flight: flight.clone(),
            before: TouchedFlight::last_of(&self.before),
            begun,
            touch: touch.clone(),
        };
        if self.source == CommandSource::State {
            self.flights.push(touched);
            return;
        }
        let found = touched::strike(&touched, 0.0, self.rig).ok();
        let moved = found.filter(|found| found.moving.is_some());
        self.moved.extend(moved.map(|found| (found, touched)));
    }

    /// Makes a strike of a flight that the tip began, in a log without commands.
    fn strike_touched(&mut self, touched: &TouchedFlight, camera_delay: f64) {
        let TouchedFlight {
            index,
            flight,
            begun,
            touch,
            ..
        } = touched;
        let index = *index;
        let found = match touched::strike(touched, camera_delay, self.rig) {
            Ok(found) => found,
            Err(rejection) => {
                let reject = self.reject(index, begun.stamp, rejection);
                self.touched.rejects.push(reject);
                return;
            }
        };
        let commands: Vec<Sample> = touch.states.iter().map(State::as_command).collect();
        let id = strike_id(&commands, &flight.frames);
        let (command, t_start) = (found.command, seconds(found.first));
        self.touched.commands.push(CommandSeen {
            rise: t_start - found.gap,
            fall: t_start,
            speed: command.speed,
            angle: command.angle,
        });
        self.touched.motions.push(motion(&found));
        if self.rig.object.shape().is_round() {
            let meeting = touched.meeting(camera_delay, &found, self.rig);
            self.touched.meetings.extend(meeting);
        }
        let strike = self.strike_by_touch(index, id, command, &found);
        self.touched.strikes.push(strike);
    }

    /// A strike whose touch is known, with what was commanded or stands for it.
    fn strike_by_touch(
        &self,
        index: u32,
        id: String,
        command: Command,
        found: &TouchedStrike,
    ) -> Strike {
        Strike {
            log: self.log.into(),
            index,
            t_start: seconds(found.first),
            initial: found.initial,
            stop: found.stop,
            command,
            track: found.track.clone(),
            split: split_of(&id, self.seed),
            conditions: Conditions {
                session: self.log.into(),
                moving: found.moving,
                ..Conditions::default()
            },
            id,
            delivered: Some(found.delivered()),
        }
    }

    fn reject(&self, index: u32, stamp: i64, rejection: Rejection) -> Reject<Sentence<Detail>> {
        Reject {
            log: self.log.into(),
            index,
            t_start: seconds(stamp),
            reason: rejection.reason,
            detail: rejection.detail.into(),
        }
    }

    /// In a log with commands: a command at which the object moved before is a strike where the tip's state shows its touch. What was commanded
    /// stands in the place of what the tip did, on the same line of centres.
    fn strike_moved(&mut self) {
        let (moved, pushed) = (
            std::mem::take(&mut self.moved),
            std::mem::take(&mut self.pushed),
        );
        for (episode, reject) in std::mem::take(&mut self.restless) {
            let within = episode.start()..=episode.end().saturating_add(AFTER_FALL);
            let is_within = |motion: &&MotionSeen| {
                (seconds(*within.start())..=seconds(*within.end())).contains(&motion.start)
            };
            let hardest = pushed
                .iter()
                .filter(is_within)
                .max_by(|one, other| one.velocity.norm().total_cmp(&other.velocity.norm()));
            let mut touches = moved
                .iter()
                .filter(|(found, _)| within.contains(&found.first));
            let touch = touches.next().filter(|_| touches.next().is_none());
            let struck = touch.and_then(|(found, touched)| {
                let commanded = plateau(&episode.commands, self.rig).ok()?;
                let touch = Touch {
                    velocity: Point::polar(commanded.speed, commanded.angle),
                    ..touched.touch.clone()
                };
                let moving = found.moving.unwrap_or_default();
                let command = touched::command(&touch, found.initial, moving, self.rig).ok()?;
                Some((command, found, touched))
            });
            let seen = &mut self.found.seen;
            let motion = struck.as_ref().map(|(_, found, _)| motion(found));
            if let Some(motion) = motion.or(hardest.copied()) {
                // How it moved before is no motion from rest.
                seen.motions.retain(|motion| !is_within(&motion));
                seen.motions.push(motion);
            }
            let Some((command, found, touched)) = struck else {
                self.found.rejects.push(reject);
                continue;
            };
            seen.delays.extend(touched.delay(self.rig));
            if self.rig.object.shape().is_round() {
                seen.meetings.extend(touched.meeting(0.0, found, self.rig));
            }
            let id = strike_id(&episode.commands, &touched.flight.frames);
            let strike = self.strike_by_touch(episode.index, id, command, found);
            self.found.strikes.push(StrikeSummary::from(&strike));
            (self.keep)(strike);
        }
    }

    /// In a log without commands: what the tip touched is kept where its state shows it at most strikes; else what moved at its time.
    fn choose(&mut self) {
        /// Number of touches for each unexplained motion from which touches are kept.
        const SHARE: usize = 4;
        let flights = std::mem::take(&mut self.flights);
        let delays = flights.iter().filter_map(|flight| flight.delay(self.rig));
        self.touched.delays = delays.collect();
        // A box's touch is not known to a ms.
        let is_round = self.rig.object.shape().is_round();
        let camera_delay = touched::camera_delay(&self.touched.delays).filter(|_| is_round);
        for flight in flights {
            self.strike_touched(&flight, camera_delay.unwrap_or_default());
        }
        let (touched, untouched) = (
            std::mem::take(&mut self.touched),
            std::mem::take(&mut self.untouched),
        );
        let is_touched = SHARE * touched.strikes.len() >= untouched.strikes.len().max(1);
        let ByState {
            strikes,
            rejects,
            commands,
            motions,
            delays,
            meetings,
        } = if is_touched {
            self.is_touched = true;
            // Those that a touch shows are no idle ones, and from rest to rest hardly one of an object that moves is seen.
            let motions = self.counts.idle_motions as usize + untouched.strikes.len();
            let seen = touched.strikes.len() + touched.rejects.len();
            self.counts.idle_motions = motions.saturating_sub(seen) as u64;
            let touches = touched.delays.len();
            let told = camera_delay.map(|delay| Note::CameraDelay { delay, touches });
            self.found.notes.extend(told);
            touched
        } else {
            untouched
        };
        self.found.seen.commands.extend(commands);
        self.found.seen.motions.extend(motions);
        let far_away = touched::far_away(&std::mem::take(&mut self.touches));
        self.found.seen.delays.extend(far_away.unwrap_or(delays));
        self.found.seen.meetings.extend(meetings);
        self.found.rejects.extend(rejects);
        for strike in strikes {
            self.found.strikes.push(StrikeSummary::from(&strike));
            (self.keep)(strike);
        }
    }

    /// Ends all that has begun, when no message is on its way.
    fn shut(&mut self, ending: EndOfData) {
        // Whether the commands themselves were cut; a clock's fault lets the episode go on, to end as a rejected one.
        match &ending {
            EndOfData::Clock(detail) => {
                if let Some(current) = self.episodes.current() {
                    current.fault.get_or_insert_with(|| {
                        Rejection::new(RejectReason::ClockBackwards, detail.clone())
                    });
                }
                self.clock = Some(detail.clone());
            }
            EndOfData::Lost(why) => {
                if let Some(mut episode) = self.episodes.finish() {
                    let detail = Detail::CutInCommand { why: why.clone() };
                    episode
                        .fault
                        .get_or_insert_with(|| Rejection::new(RejectReason::Truncated, detail));
                    self.queue(episode);
                }
            }
            EndOfData::End => {
                if let Some(episode) = self.episodes.finish() {
                    self.queue(episode);
                }
            }
        }
        while self.waiting.first().is_some() {
            let next = self.next_strike();
            self.judge_first(next.unwrap_or(i64::MAX), next.is_some(), Some(&ending));
        }
        self.fly(true);
        match self.source {
            CommandSource::Topic => {
                self.extras.close(self.rig, self.keep);
                self.strike_moved();
            }
            CommandSource::State => {
                let held = &mut self.untouched.strikes;
                self.extras.close(self.rig, &mut |strike| held.push(strike));
                self.choose();
            }
        }
        self.centroids.clear();
        self.counts.lost += std::mem::take(&mut self.lost).finish() as u64;
        self.watch = Watch::new(self.rig);
        self.breaks = Breaks::new(self.rig, self.rig.camera.noise);
        self.pushes = Pushes::new(self.rig);
        self.before = Vec::new();
        self.last_centroid = None;
        self.last_command = None;
    }

    /// Judges the first waiting episode by the centroids before `until`.
    fn judge_first(&mut self, until: i64, is_next_strike: bool, ending: Option<&EndOfData>) {
        let Some(episode) = self.waiting.pop() else {
            return;
        };
        let judged = self.judge(&episode, until);
        let is_idle = |rejection: &Rejection| {
            let reason = rejection.reason;
            // What a tip did to an object that moved is known from its touch.
            matches!(
                reason,
                RejectReason::NoMotion
                    | RejectReason::NoPlateau
                    | RejectReason::NoRestBefore
                    | RejectReason::ClockSkew
            )
        };
        let by_state = self.source == CommandSource::State;
        if by_state {
            let seen = CommandSeen::of(&episode, self.rig);
            self.untouched.commands.extend(seen);
        }
        let judged = judged.and_then(|strike| {
            EndOfData::leaves_whole(ending, &episode, self.last_centroid).map(|()| strike)
        });
        match judged {
            Ok((strike, first_motion, gap)) => {
                if !by_state {
                    self.found.strikes.push(StrikeSummary::from(&strike));
                }
                self.extras.strike(Waiting {
                    strike,
                    commands: episode.commands,
                    first_motion,
                    gap,
                });
                self.hand_on();
            }
            // An arm that moves and meets nothing has struck nothing: no command says that it was to.
            Err(rejection) if by_state && is_idle(&rejection) => {
                self.counts.idle_motions += 1;
            }
            Err(rejection) => {
                let rejection = if is_next_strike {
                    rejection
                } else {
                    EndOfData::blame(ending, rejection)
                };
                let reject = self.reject(episode.index, episode.start(), rejection);
                if by_state {
                    self.untouched.rejects.push(reject);
                } else if matches!(
                    reject.reason,
                    RejectReason::NoRestBefore | RejectReason::ClockSkew
                ) {
                    self.restless.push((episode, reject));
                } else {
                    self.found.rejects.push(reject);
                }
            }
        }
        self.since_trim = TRIM_EVERY;
    }

    /// The strike, the stamp of first motion, and the seconds from the frame before to it.
    fn judge(&mut self, episode: &Episode, until: i64) -> Result<(Strike, i64, f64), Rejection> {
        if let Some(fault) = &episode.fault {
            return Err(fault.clone());
        }
        let commanded = match self.source {
            CommandSource::Topic => Some(plateau(&episode.commands, self.rig)?),
            CommandSource::State => None,
        };
        let from = episode.start().saturating_sub(BEFORE);
        let place = |stamp: i64| self.centroids.partition_point(|s| s.stamp < stamp);
        let (first, end) = (place(from), place(until));
        let seen: Vec<Sample> = self
            .centroids
            .range(first..end.max(first))
            .copied()
            .collect();
        if let (true, Some(clock)) = (seen.is_empty(), &self.clock) {
            let clock = Box::new(clock.clone());
            let detail = Detail::NoCentroid { clock };
            return Err(Rejection::new(RejectReason::ClockBackwards, detail));
        }
        let frames = Frames::new(&seen, (episode.start(), episode.end()), self.rig)?;
        self.counts.periods.push(frames.period);
        let slide = slide::find(&frames)?;
        self.counts.outliers += slide.outliers;
        let shown = &mut self.found.seen;
        shown.bounces.extend(slide.grazed);
        shown.gathered.extend(gathered(&slide.track));
        shown.risen.extend(risen(&slide.track));
        shown
            .smeared
            .extend(smeared(&slide.track, slide.initial, slide.gap));
        let command = match commanded {
            Some(command) => command,
            None => at_contact(&episode.commands, slide.first_motion)?,
        };
        let id = strike_id(&episode.commands, &seen);
        let strike = Strike {
            log: self.log.into(),
            index: episode.index,
            t_start: seconds(slide.first_motion),
            initial: slide.initial,
            stop: slide.stop,
            command,
            track: slide.track,
            split: split_of(&id, self.seed),
            conditions: Conditions {
                session: self.log.into(),
                ..Conditions::default()
            },
            id,
            delivered: None,
        };
        Ok((strike, slide.first_motion, slide.gap))
    }

    /// Ends the log, and returns all that was found, by index: episodes are judged in their order.
    pub(crate) fn finish(mut self) -> Segmented {
        self.found.seen.lost = self.counts.lost;
        let (commands, motions) = (&mut self.found.seen.commands, &mut self.found.seen.motions);
        commands.sort_by(|one, other| one.rise.total_cmp(&other.rise));
        motions.sort_by(|one, other| one.start.total_cmp(&other.start));
        self.found.rejects.sort_by_key(|reject| reject.index);
        // Few objects rest where touches alone tell of strikes, and these say more.
        if self.source == CommandSource::Topic || self.found.seen.meetings.is_empty() {
            let meetings = &mut self.extras.meetings;
            self.found.seen.meetings.append(meetings);
        }
        if self.source == CommandSource::Topic {
            self.found.seen.delays.append(&mut self.extras.delays);
            self.found.seen.behind = std::mem::take(&mut self.extras.behind);
        } else {
            self.found.seen.is_by_state = true;
            let are_in_tool_frame = matches!(self.rig.frames.command, CommandFrame::Tool);
            self.found.notes.push(Note::ByState { are_in_tool_frame });
        }
        let rises = self.found.seen.commands.iter().map(|c| c.rise);
        let rises = rises.chain(self.found.strikes.iter().map(|strike| strike.t_start));
        let mut rises: Vec<f64> = rises.collect();
        rises.sort_by(f64::total_cmp);
        self.counts.count_uncommanded(&rises);
        self.found.notes.extend(self.counts.notes());
        if !self.is_touched {
            self.found.notes.extend(self.extras.notes());
        }
        self.found.notes.extend(self.counts.other_rate(self.rig));
        self.found
    }
}

/// What a touch added to the object's velocity, as a motion.
fn motion(found: &TouchedStrike) -> MotionSeen {
    MotionSeen {
        start: seconds(found.first),
        from: found.initial,
        velocity: found.launch,
        at_first: found.launch.norm(),
    }
}

/// What was added to the velocity of an object that moved before.
fn pushed(begun: Break) -> Option<MotionSeen> {
    let velocity = begun.bounce.after - begun.bounce.before;
    (!begun.is_from_rest).then(|| MotionSeen {
        start: seconds(begun.stamp),
        from: begun.bounce.place,
        velocity,
        at_first: velocity.norm(),
    })
}
