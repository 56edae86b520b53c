//! How long a camera takes from its first row to its last, where nobody has told it: by how much a moving object is sheared.
//!
//! A shutter that rolls sees a row later than the one above it. Of an object that moves by v, the edges of a row that lies a share s of the
//! image below its middle are seen v·s·readout further on. What shadows and sides do to the edges alike, whether it moves or rests, is
//! fitted beside that.

use std::path::Path;

use logs::read::{RawMessage, read_raw};
use logs::{Limits, LogError};
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};
use values::Point;

use crate::change::PatternSums;
use crate::frame::TrackedFrame;
use crate::learned::Learned;
use crate::message_queue::{FrameTracker, MessageQueue, Processed};
use crate::{Tracker, is_image};

/// A readout in s, and its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Readout {
    pub(crate) seconds: f64,
    pub(crate) deviation: f64,
}

/// Greatest time (s) between frames that tell a velocity, and greatest share by which it may change between them.
const APART: f64 = 0.08;
const STEADY: f64 = 0.3;
/// Speeds (m/s) at which an object counts as moving, and the speed below which it rests.
const MOVES: std::ops::Range<f64> = 0.15..3.0;
const RESTS: f64 = 0.02;
/// Standard deviation (s) below which a readout is known; to that, no more frames are looked at.
const KNOWN: f64 = 0.008;
const ENOUGH: f64 = 0.0006;
/// What is not known of it beside the scatter of frames: this (s), and this share.
const UNSEEN: f64 = 0.001;
const UNSEEN_SHARE: f64 = 0.15;
/// Edges are taken to be blurred by so many px: of an edge whose blur is cut off only a part of its shift is seen.
const BLUR: f64 = 3.0;
/// A frame that is farther off than so many times the median, squared, is left out.
const FAR: f64 = 9.0;
/// Frames that move, at the least, and every how many of them are looked at together.
const FEWEST: usize = 8;
const EVERY: usize = 200;
/// No camera takes longer than from one image to the next, by more than the rate is off.
const MOST: f64 = 1.05;

/// What one frame says: how the edges are sheared at a velocity (m/s).
struct Sheared {
    velocity: [f64; 2],
    sums: PatternSums<2>,
}

impl Sheared {
    fn moves(&self) -> bool {
        self.velocity != [0.0; 2]
    }

    /// How the shear depends on the readout and on what is there at rest.
    fn slope(&self) -> Matrix2x3<f64> {
        let [x, y] = self.velocity;
        Matrix2x3::new(x, 1.0, 0.0, y, 0.0, 1.0)
    }

    /// The square of what is left, of what it scatters by.
    fn left(&self, parts: Vector3<f64>) -> f64 {
        let off = self.sums.right - self.sums.normal * (self.slope() * parts);
        let inverse = self.sums.normal.try_inverse();
        inverse.map_or(f64::INFINITY, |inverse| off.dot(&(inverse * off)))
    }
}

/// The frames of a log in their order.
#[derive(Default)]
struct Frames {
    last: Vec<(f64, Point, PatternSums<2>)>,
    sheared: Vec<Sheared>,
    moving: usize,
}

impl Frames {
    fn add(&mut self, tracked: &TrackedFrame) {
        let Ok(centre) = tracked.observation.centre else {
            self.last.clear();
            return;
        };
        let seconds = 1e-9 * tracked.stamp as f64;
        self.last.push((seconds, centre, tracked.shear));
        let [(t0, a, _), (t1, b, sums), (t2, c, _)] = self.last[..] else {
            return;
        };
        self.last.remove(0);
        if !(t0 < t1 && t1 < t2 && t2 - t0 < 2.0 * APART) {
            return;
        }
        let between = |from: Point, to: Point, seconds: f64| {
            Vector2::new((to.x - from.x) / seconds, (to.y - from.y) / seconds)
        };
        let velocity = between(a, c, t2 - t0);
        let change = between(b, c, t2 - t1) - between(a, b, t1 - t0);
        let speed = velocity.norm();
        let moves = MOVES.contains(&speed) && change.norm() < STEADY * speed;
        if moves || speed < RESTS {
            self.moving += usize::from(moves);
            let velocity = if moves { velocity.into() } else { [0.0; 2] };
            self.sheared.push(Sheared { velocity, sums });
        }
    }

    fn fit(&self) -> Option<Readout> {
        if self.moving < FEWEST {
            return None;
        }
        let fitted = |frames: &[&Sheared]| {
            let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
            for frame in frames {
                let slope = frame.slope();
                normal += slope.transpose() * frame.sums.normal * slope;
                right += slope.transpose() * frame.sums.right;
            }
            let inverse = normal.try_inverse()?;
            Some((inverse * right, inverse[(0, 0)]))
        };
        // Those that move scatter otherwise than those that rest.
        let scatter = |frames: &[&Sheared], parts, moves: bool| {
            let of_kind = frames.iter().filter(|frame| frame.moves() == moves);
            let mut left: Vec<f64> = of_kind.map(|frame| frame.left(parts)).collect();
            left.sort_by(f64::total_cmp);
            // Of two numbers that scatter by 1, the median of the squares' sum is 1.39.
            left.get(left.len() / 2).map_or(0.0, |left| left / 1.386)
        };
        let mut frames: Vec<&Sheared> = self.sheared.iter().collect();
        let (parts, _) = fitted(&frames)?;
        let [rests, moves] = [false, true].map(|moves| FAR * scatter(&frames, parts, moves));
        frames.retain(|frame| frame.left(parts) <= if frame.moves() { moves } else { rests });
        let (parts, variance) = fitted(&frames)?;
        let scatter = scatter(&frames, parts, true).max(1.0);
        let seconds = parts[0];
        let unseen = UNSEEN.hypot(UNSEEN_SHARE * seconds);
        Some(Readout {
            seconds,
            deviation: (scatter * variance).sqrt().hypot(unseen),
        })
    }
}

/// Why the reading of a log ended.
enum Ended {
    Log(LogError),
    Enough,
}

impl From<LogError> for Ended {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

impl Readout {
    /// The readout time of a log's camera; none where its images do not tell it to 8 ms. `period` is from one image to the next, in s.
    ///
    /// # Errors
    /// The log cannot be read.
    pub(crate) fn of_log(
        log: &Path,
        topic: &str,
        (tracker, learned): (&Tracker, &Learned),
        period: f64,
    ) -> Result<Option<Self>, LogError> {
        let tracker = tracker.clone().with_least_blur(BLUR);
        let tracking = FrameTracker::new(&tracker, learned, false);
        let mut frames = Frames::default();
        let ended = rayon::scope_fifo(|scope| -> Result<(), Ended> {
            let mut queue = MessageQueue::new(scope, &tracking);
            let mut asked = EVERY;
            let mut take = |processed: Processed| {
                let Processed::Frame(_, tracked) = processed else {
                    return Ok(());
                };
                frames.add(&tracked);
                if frames.moving >= asked {
                    asked += EVERY;
                    let known = frames.fit();
                    if known.is_some_and(|known| known.deviation < UNSEEN.hypot(ENOUGH)) {
                        return Err(Ended::Enough);
                    }
                }
                Ok(())
            };
            read_raw::<Ended>(log, Limits::default(), &mut |message: RawMessage<'_>| {
                if message.channel.topic == topic && is_image(&message.channel.schema) {
                    queue.add_image(&message);
                }
                while let Some(processed) = queue.next_if_full() {
                    take(processed)?;
                }
                Ok(())
            })?;
            while let Some(processed) = queue.next() {
                take(processed)?;
            }
            Ok(())
        });
        match ended {
            Err(Ended::Log(error)) => Err(error),
            Err(Ended::Enough) | Ok(()) => Ok(frames.fit().and_then(|found| {
                let most = MOST * period;
                let seconds = found.seconds.clamp(0.0, most);
                // What no camera does was no readout.
                let is_one = (found.seconds - seconds).abs() < 3.0 * found.deviation;
                (is_one && found.deviation < KNOWN).then_some(Self { seconds, ..found })
            })),
        }
    }
}
