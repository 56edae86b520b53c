//! A strike as it was logged, and why one was not kept.

use serde::{Deserialize, Serialize};

use crate::{Point, Split};

/// What the robot was commanded to do: the plateau of the commanded end-effector velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// Speed of the plateau in m/s.
    pub speed: f64,
    /// Direction of the plateau in rad, from +x, counter-clockwise.
    pub angle: f64,
}

impl Command {
    /// A speed in m/s and a direction in rad.
    pub const fn new(speed: f64, angle: f64) -> Self {
        Self { speed, angle }
    }

    /// The same speed, `by` rad further left.
    pub fn turned(self, by: f64) -> Self {
        Self::new(self.speed, self.angle + by)
    }
}

/// What the arm did at contact, from its measured state: what the object met, whatever was commanded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Delivered {
    /// Speed of the tip at contact, in m/s.
    pub tip_speed: f64,
    /// Direction in which the tip moved at contact, in rad, from +x, counter-clockwise.
    pub tip_angle: f64,
    /// Time of contact in s on the track's clock, whose zero is first motion: mostly within a frame before zero.
    pub contact: f64,
    /// Whether the tip reached the object again after it had left.
    pub pushed_again: bool,
}

impl Delivered {
    /// The launch that was delivered, in place of the one that was commanded.
    pub fn command(&self) -> Command {
        Command::new(self.tip_speed, self.tip_angle)
    }
}

/// How an object is turned about the vertical, in rad, counter-clockwise; a turn by a full circle is counted, not wrapped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Yaw {
    /// While it rests before the strike; within ±π.
    pub initial: f64,
    /// At each frame of the track.
    pub track: Vec<f64>,
}

/// The centroids of one strike from first motion to rest, or to what ends it earlier; `t`, `x` and `y` have one length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Seconds since first motion; the impact lies within one frame before zero.
    pub t: Vec<f64>,
    /// Metres in frame `table`.
    pub x: Vec<f64>,
    /// Metres in frame `table`.
    pub y: Vec<f64>,
    /// The object's yaw, where it was tracked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw: Option<Yaw>,
    /// What ends it.
    #[serde(default, skip_serializing_if = "End::is_rest")]
    pub end: End,
}

crate::named! {
    /// What ends a track.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum End {
        /// The object rests.
        #[default]
        Rest = "rest",
        /// The object meets something: a fence, a hand.
        Contact = "contact",
        /// The object leaves the part of the table that is seen.
        LeftView = "left_view",
    }
}

impl End {
    /// The end of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|end| end.name() == name)
    }

    fn is_rest(&self) -> bool {
        *self == Self::Rest
    }
}

impl Track {
    /// Number of frames.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether no frame was seen.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Centroid of one frame, in metres.
    pub fn point(&self, frame: usize) -> Point {
        Point::new(self.x[frame], self.y[frame])
    }
}

/// When and in which log a strike was made, what drifting or session-wise effects depend on; and how its object was turned.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// The log (session) that the strike comes from; empty for a strike yet to be made.
    pub session: String,
    /// Number of strikes before this one, over all logs, in order of time.
    pub order: f64,
    /// How the object is seen turned at rest before the strike, in rad; none where that was not tracked, and a box is taken to stand
    /// with its faces along the table's axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw: Option<f64>,
    /// The object's velocity right before the impact, in m/s; none where it rested. The command is then the tip's velocity beside it, along
    /// the line of their centres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moving: Option<Point>,
    /// Whether no strike began the slide, such as a hand's push. The command is then the object's own velocity at the track's beginning.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_unstruck: bool,
    /// Whether the arm, whose state is not known, went on pushing after the impact, by its command and the track.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_pushed_on: bool,
}

/// One strike that was kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strike {
    /// Hash of what was measured (16 hex digits): the same strike has the same id in any file.
    pub id: String,
    /// File name of its log, without folder.
    pub log: String,
    /// Its place among the strikes seen in that log, from 0, rejected ones included.
    pub index: u32,
    /// Stamp of first motion, in seconds since the epoch of the log's clock.
    pub t_start: f64,
    /// Where the object rested before, in metres.
    pub initial: Point,
    /// Where it first came to rest after, in metres; where its track ends otherwise, the track's end, which is no stop
    /// ([`Strike::has_stop`]).
    pub stop: Point,
    /// What was commanded.
    pub command: Command,
    /// Every centroid from first motion to rest.
    pub track: Track,
    /// Which part of learning and testing it belongs to.
    pub split: Split,
    /// Session and order, for effects that depend on them.
    pub conditions: Conditions,
    /// What the arm delivered, where its state was logged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delivered: Option<Delivered>,
}

impl Strike {
    /// A strike to learn from, of which no more is known than what was commanded, and where the object lay before and after.
    pub fn bare(command: Command, initial: Point, stop: Point) -> Self {
        Self {
            id: String::new(),
            log: String::new(),
            index: 0,
            t_start: 0.0,
            initial,
            stop,
            command,
            track: Track::default(),
            split: Split::Train,
            conditions: Conditions::default(),
            delivered: None,
        }
    }

    /// This strike up to so many frames of its track, which ends there for another reason than rest.
    pub fn ended(mut self, frames: usize, end: End) -> Self {
        let track = &mut self.track;
        for values in [&mut track.t, &mut track.x, &mut track.y] {
            values.truncate(frames);
        }
        if let Some(yaw) = &mut track.yaw {
            yaw.track.truncate(frames);
        }
        track.end = end;
        if let Some(last) = track.len().checked_sub(1) {
            self.stop = track.point(last);
        }
        self
    }

    /// This strike as one of all logs' strikes: its rank among them, and how its object was turned, complete its conditions.
    pub fn among_all(mut self, order: u32) -> Self {
        self.conditions.order = order.into();
        self.conditions.yaw = self.track.yaw.as_ref().map(|yaw| yaw.initial);
        self
    }

    /// What was commanded, and under which conditions.
    pub fn commanded(&self) -> (Command, &Conditions) {
        (self.command, &self.conditions)
    }

    /// Whether the object came to rest by itself.
    pub fn has_stop(&self) -> bool {
        self.track.end == End::Rest
    }

    /// Whether stops judge models of these strikes: most came to rest. Where most did not, as on an air table, the ends of tracks do.
    pub fn most_rest<'a>(strikes: impl IntoIterator<Item = &'a Self>) -> bool {
        let (mut rest, mut all) = (0, 0);
        for strike in strikes {
            all += 1;
            rest += usize::from(strike.has_stop());
        }
        rest > 0 && 2 * rest >= all
    }

    /// Whether stops can be learnt and aimed at: so many strikes came to rest that these are no chance.
    pub fn many_rest(strikes: &[Self]) -> bool {
        const ONE_IN: usize = 4;
        let rest = strikes.iter().filter(|strike| strike.has_stop()).count();
        rest > 0 && ONE_IN * rest >= strikes.len()
    }

    /// Seconds from the impact to the track's end, where that is no rest. An impact lies within the frame before the track's zero: in its
    /// middle, where it is not known better.
    pub fn ends(&self) -> Option<f64> {
        let last = *self.track.t.last().filter(|_| !self.has_stop())?;
        let frame = last / (self.track.len().max(2) - 1) as f64;
        let contact = self.delivered.map_or(-0.5 * frame, |by| by.contact);
        Some(last - contact)
    }

    /// Displacement from rest to rest, or to the track's end, in metres.
    pub fn path(&self) -> Point {
        self.stop - self.initial
    }

    /// Whether the object was pushed on, or a second time, before it rested: its slide is not a free one. Seen from the arm's state where it was
    /// logged, else from its command, and from the track.
    pub fn is_pushed_again(&self) -> bool {
        self.is_pushed_by_arm() || self.track.is_pushed_again()
    }

    /// Whether the arm's state, or else its command, shows that the tip pushed the object after the impact.
    pub fn is_pushed_by_arm(&self) -> bool {
        let by_state = self.delivered.map(|delivered| delivered.pushed_again);
        by_state.unwrap_or(self.conditions.is_pushed_on)
    }
}

crate::named! {
    /// Why a strike that was seen was not kept.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum RejectReason {
        /// The object was moving, or unseen, before the strike.
        NoRestBefore = "no_rest_before",
        /// The log ends, or the next strike comes, before the object rests.
        NoRestAfter = "no_rest_after",
        /// The object never moved.
        NoMotion = "no_motion",
        /// Too few frames around the impact, the slide or the rest.
        FramesMissing = "frames_missing",
        /// A centroid lies outside the table.
        OffTable = "off_table",
        /// A centroid or command is NaN or infinite.
        NotFinite = "not_finite",
        /// Stamps run backwards or stand still at zero.
        ClockBackwards = "clock_backwards",
        /// Numbers fit millimetres or degrees rather than metres and radians.
        UnitsImplausible = "units_implausible",
        /// An equal strike was read from another log.
        Duplicate = "duplicate",
        /// The file ends or is damaged within the strike.
        Truncated = "truncated",
        /// The command never holds a plateau.
        NoPlateau = "no_plateau",
        /// The stamps of centroids and commands disagree: motion before the arm could have struck.
        ClockSkew = "clock_skew",
    }
}

/// One strike that was seen and not kept; its detail a finding, or in words alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reject<D = String> {
    /// File name of its log, without folder.
    pub log: String,
    /// Its place among the strikes seen in that log, from 0.
    pub index: u32,
    /// Stamp at which the command left rest, in seconds (NaN is never used: 0 where no stamp can be had).
    pub t_start: f64,
    /// Why, from a closed list.
    pub reason: RejectReason,
    /// What was seen, with numbers, for a person.
    pub detail: D,
}

impl<D: ToString> Reject<D> {
    /// This one with its detail in words alone.
    pub fn in_words(self) -> Reject {
        Reject {
            detail: self.detail.to_string(),
            log: self.log,
            index: self.index,
            t_start: self.t_start,
            reason: self.reason,
        }
    }
}
