//! Frames in order: images that were seen before, stamps of no use, and an object that jumps there and back.

use values::Point;

use crate::Reason;

/// A tracked frame in its sequence, with what its caller keeps beside it.
#[derive(Clone, Debug)]
pub(crate) struct SequenceFrame<T> {
    /// Middle of the exposure of the object's rows, in ns.
    pub(crate) stamp: i64,
    /// Hash of its pixels as they came; none where nothing can be said.
    pub(crate) hash: Option<u64>,
    pub(crate) centre: Result<Point, Reason>,
    pub(crate) with: T,
}

/// Decides on frames whose stamp is of no use, and on frames that repeat the one before: a camera that froze while the object moved, or a
/// clean picture of rest.
///
/// Frames that repeat are held back until the next image that differs: if the object is elsewhere in it, the camera froze.
#[derive(Debug)]
pub(crate) struct Sequence<T> {
    stamps: Stamps<SequenceFrame<T>>,
    repeats: Repeats<T>,
    jumps: Jumps<T>,
}

/// An object that rests before a frame and behind it has not jumped in between: what is seen in that frame is something else.
#[derive(Debug)]
struct Jumps<T> {
    still: f64,
    /// Where it was in the frame before the last, and that frame's stamp.
    before: Option<(i64, Point)>,
    last: Option<SequenceFrame<T>>,
}

#[derive(Debug)]
struct Repeats<T> {
    /// An object that moves by more than this (m) does not rest.
    still: f64,
    last_hash: Option<u64>,
    /// Where it was in the last image, and in the one before that differed.
    last: Option<Point>,
    before: Option<Point>,
    held: Vec<SequenceFrame<T>>,
}

/// Frames that are held back at the most; a camera of 240 frames a second rests for a minute.
const MOST_HELD: usize = 15_000;

impl<T> Sequence<T> {
    pub(crate) fn new(still: f64) -> Self {
        Self {
            stamps: Stamps::new(),
            repeats: Repeats {
                still,
                last_hash: None,
                last: None,
                before: None,
                held: Vec::new(),
            },
            jumps: Jumps {
                still,
                before: None,
                last: None,
            },
        }
    }

    /// Takes a frame, and gives those that are decided.
    pub(crate) fn push(&mut self, frame: SequenceFrame<T>, out: &mut dyn FnMut(SequenceFrame<T>)) {
        let Self {
            stamps,
            repeats,
            jumps,
        } = self;
        stamps.push(frame.stamp, frame, &mut |frame, is_stale| {
            repeats.push(marked(frame, is_stale), &mut |frame| jumps.push(frame, out));
        });
    }

    /// Gives what is held back, though nothing has shown whether it is right: there is no more room for what waits behind it. Frames that
    /// repeat may be stale, and are marked.
    pub(crate) fn give_up(&mut self, out: &mut dyn FnMut(SequenceFrame<T>)) {
        self.settle(out);
        let Self { repeats, jumps, .. } = self;
        repeats.release(true, &mut |frame| jumps.push(frame, out));
        jumps.finish(out);
    }

    /// Gives what is still held back, at the end.
    pub(crate) fn finish(&mut self, out: &mut dyn FnMut(SequenceFrame<T>)) {
        self.settle(out);
        let Self { repeats, jumps, .. } = self;
        repeats.finish(&mut |frame| jumps.push(frame, out));
        jumps.finish(out);
    }

    fn settle(&mut self, out: &mut dyn FnMut(SequenceFrame<T>)) {
        let Self {
            stamps,
            repeats,
            jumps,
        } = self;
        stamps.finish(&mut |frame, is_stale| {
            repeats.push(marked(frame, is_stale), &mut |frame| jumps.push(frame, out));
        });
    }
}

/// Frames that are farther apart than this (ns) say nothing of what was between.
const MOST_APART: i64 = 150_000_000;

impl<T> Jumps<T> {
    fn push(&mut self, frame: SequenceFrame<T>, out: &mut dyn FnMut(SequenceFrame<T>)) {
        if let (Some((stamp, before)), Some(last), Ok(behind)) =
            (self.before, &mut self.last, frame.centre)
        {
            let middle = Point::new(0.5 * (before.x + behind.x), 0.5 * (before.y + behind.y));
            let is_near = frame.stamp - stamp < MOST_APART;
            let rests = before.distance(behind) < 0.5 * self.still;
            if is_near && rests && last.centre.is_ok_and(|at| at.distance(middle) > self.still) {
                last.centre = Err(Reason::Jumped);
            }
        }
        self.finish(out);
        self.last = Some(frame);
    }

    fn finish(&mut self, out: &mut dyn FnMut(SequenceFrame<T>)) {
        if let Some(last) = self.last.take() {
            if let Ok(centre) = last.centre {
                self.before = Some((last.stamp, centre));
            }
            out(last);
        }
    }
}

fn marked<T>(frame: SequenceFrame<T>, is_stale: bool) -> SequenceFrame<T> {
    let centre = if is_stale {
        Err(Reason::Stale)
    } else {
        frame.centre
    };
    SequenceFrame { centre, ..frame }
}

impl<T> Repeats<T> {
    fn push(&mut self, frame: SequenceFrame<T>, out: &mut dyn FnMut(SequenceFrame<T>)) {
        if frame.hash.is_some() && frame.hash == self.last_hash {
            self.held.push(frame);
            if self.held.len() > MOST_HELD {
                self.release(false, out);
            }
            return;
        }
        let centre = frame.centre.ok();
        let moved = match (self.last, centre) {
            (Some(last), Some(centre)) => last.distance(centre) > self.still,
            // Where it is now is not known: what was held may be stale.
            _ => true,
        };
        self.release(moved, out);
        self.last_hash = frame.hash;
        if centre.is_some() {
            self.before = self.last;
            self.last = centre;
        }
        out(frame);
    }

    fn finish(&mut self, out: &mut dyn FnMut(SequenceFrame<T>)) {
        let moved = match (self.before, self.last) {
            (Some(before), Some(last)) => before.distance(last) > self.still,
            _ => false,
        };
        self.release(moved, out);
    }

    fn release(&mut self, moved: bool, out: &mut dyn FnMut(SequenceFrame<T>)) {
        for mut frame in self.held.drain(..) {
            if moved && frame.centre.is_ok() {
                frame.centre = Err(Reason::Repeated);
            }
            out(frame);
        }
    }
}

/// Decides stamp by stamp, two behind at the most: where a stamp is not after the one before, it is the next that shows which of the two
/// is wrong.
#[derive(Debug)]
pub(crate) struct Stamps<T> {
    /// The last stamp that is right, in ns. None is before 1970.
    last: i64,
    /// A stamp after the last one, and one behind it that is not after it.
    first: Option<(i64, T)>,
    second: Option<(i64, T)>,
}

impl<T> Stamps<T> {
    pub(crate) fn new() -> Self {
        Self {
            last: -1,
            first: None,
            second: None,
        }
    }

    /// Takes a stamp (ns) and what belongs to it, and gives those that are decided, each with whether its stamp is of no use.
    pub(crate) fn push(&mut self, stamp: i64, item: T, out: &mut dyn FnMut(T, bool)) {
        if let (Some((first, _)), Some((second, _))) = (&self.first, &self.second) {
            let is_first_ahead = self.last < *second && *second < stamp && stamp < *first;
            self.settle(is_first_ahead, out);
        }
        match &self.first {
            Some((first, _)) if stamp <= *first => self.second = Some((stamp, item)),
            None if stamp <= self.last => out(item, true),
            _ => {
                self.settle(false, out);
                self.first = Some((stamp, item));
            }
        }
    }

    /// Gives what is left, at the end.
    pub(crate) fn finish(&mut self, out: &mut dyn FnMut(T, bool)) {
        self.settle(false, out);
    }

    fn settle(&mut self, is_first_ahead: bool, out: &mut dyn FnMut(T, bool)) {
        let waiting = [
            (self.first.take(), is_first_ahead),
            (self.second.take(), !is_first_ahead),
        ];
        for (waiting, is_stale) in waiting {
            if let Some((stamp, item)) = waiting {
                if !is_stale {
                    self.last = stamp;
                }
                out(item, is_stale);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reasons of frames given as (stamp, hash, x in mm).
    fn reasons(frames: &[(i64, u64, f64)]) -> Vec<Option<Reason>> {
        let mut sequence = Sequence::new(0.001);
        let mut given = Vec::new();
        let out = &mut |frame: SequenceFrame<()>| given.push(frame.centre.err());
        for &(stamp, hash, x) in frames {
            let centre = Ok(Point::new(1e-3 * x, 0.0));
            let frame = SequenceFrame {
                stamp,
                hash: Some(hash),
                centre,
                with: (),
            };
            sequence.push(frame, out);
        }
        sequence.finish(out);
        given
    }

    #[test]
    fn a_camera_that_froze_while_the_object_moved_is_found() {
        let repeated = Some(Reason::Repeated);
        let frames = [
            (1, 1, 0.0),
            (2, 2, 5.0),
            (3, 2, 5.0),
            (4, 2, 5.0),
            (5, 3, 20.0),
        ];
        assert_eq!(reasons(&frames), [None, None, repeated, repeated, None]);
        assert_eq!(reasons(&frames[..4]), [None, None, repeated, repeated]);
    }

    #[test]
    fn a_clean_picture_of_rest_may_repeat() {
        let frames = [
            (1, 1, 5.0),
            (2, 1, 5.0),
            (3, 1, 5.0),
            (4, 2, 5.2),
            (5, 2, 5.2),
        ];
        assert_eq!(reasons(&frames), [None; 5]);
    }

    #[test]
    fn an_object_at_rest_does_not_jump_there_and_back() {
        let jumped = Some(Reason::Jumped);
        let frames = [
            (1, 1, 5.0),
            (2, 2, 5.2),
            (3, 3, 8.0),
            (4, 4, 5.1),
            (5, 5, 8.0),
            (6, 6, 11.0),
        ];
        assert_eq!(reasons(&frames), [None, None, jumped, None, None, None]);
    }

    #[test]
    fn a_stamp_that_goes_back_is_stale() {
        let frames = [(5, 1, 0.0), (5, 2, 5.0), (4, 3, 9.0), (6, 4, 12.0)];
        let stale = Some(Reason::Stale);
        assert_eq!(reasons(&frames), [None, stale, stale, None]);
    }

    /// The stamps that are of no use; all come out in the order in which they went in.
    fn stale(stamps: &[i64]) -> Vec<i64> {
        let (mut given, mut stale) = (Vec::new(), Vec::new());
        let out = &mut |stamp: i64, is_stale: bool| {
            given.push(stamp);
            if is_stale {
                stale.push(stamp);
            }
        };
        let mut sequence = Stamps::new();
        for stamp in stamps {
            sequence.push(*stamp, *stamp, out);
        }
        sequence.finish(out);
        assert_eq!(given, stamps);
        stale
    }

    #[test]
    fn one_stamp_far_ahead_costs_one_frame() {
        assert_eq!(stale(&[1, 2, 1000, 3, 4, 5]), [1000]);
        assert_eq!(stale(&[1000, 1, 2, 3]), [1000]);
        assert_eq!(stale(&[1, 900, 2, 3, 800, 4, 5, 700]), [900, 800]);
    }

    #[test]
    fn stamps_that_go_back_or_stay_are_of_no_use() {
        assert_eq!(stale(&[5, 5, 4, 6]), [5, 4]);
        assert_eq!(stale(&[1, 3, 2, 4, 6, 5, 7]), [2, 5]);
        assert_eq!(stale(&[10, 11, 12, 3, 4, 5, 13]), [3, 4, 5]);
        assert_eq!(stale(&[1, 2, 2, 3]), [2]);
        assert_eq!(stale(&[3, 2]), [2]);
    }

    #[test]
    fn a_stamp_before_1970_is_of_no_use() {
        assert_eq!(stale(&[-5, -4, 1, 2, -3, 3]), [-5, -4, -3]);
        assert!(stale(&[0, 1]).is_empty());
    }
}
