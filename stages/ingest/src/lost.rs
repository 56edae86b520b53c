//! Frames in which the tracker saw nothing: without a number, at zero, or at a place off the table to which no object gets.
//!
//! Trackers write a place of their own where they see nothing, such as (-1, -1): off the table, again and again the same to the last digit, and farther from
//! where the object was, and is next, than anything gets from one frame to the next.

use logs::Sample;
use values::{Point, Rig};

use crate::order::since;

/// Greatest speed of anything on a table, in m/s; and the distance, in m, below which noise may be what moves it.
const FASTEST: f64 = 15.0;
const FAR: f64 = 0.03;
/// Number of frames in a row of which it is asked: more of them are an object that lies somewhere.
const MOST_HELD: usize = 100_000;

/// Whether the second place lies farther from the first than any object gets in the time between.
pub(crate) fn is_out_of_reach(one: (i64, Point), other: (i64, Point)) -> bool {
    one.1.distance(other.1) > FAR.max(FASTEST * since(one.0, other.0))
}

/// A stream of centroids without those in which the tracker saw nothing.
#[derive(Default)]
pub(crate) struct Lost {
    /// Frames off the table, at one place, of which the next one at another tells.
    held: Vec<Sample>,
    /// Where the tracker last wrote a place off the table that no object gets to.
    nowhere: Option<Point>,
    /// The last frame in which the object was seen.
    last: Option<Sample>,
}

impl Lost {
    /// Takes the next frame; hands on those in which the object was seen, in order, and gives the number of those in which it was not.
    pub(crate) fn take(&mut self, sample: Sample, rig: &Rig, mut see: impl FnMut(Sample)) -> usize {
        let is_zero = sample.x == 0.0 && sample.y == 0.0;
        if is_zero || !place(&sample).is_finite() {
            return 1;
        }
        let is_on = |sample: &Sample| rig.table.contains(place(sample));
        let jumps =
            |one: &Sample| is_out_of_reach((one.stamp, place(one)), (sample.stamp, place(&sample)));
        let mut lost = 0;
        if let Some(held) = self.held.last() {
            if place(held) == place(&sample) && self.held.len() < MOST_HELD {
                self.held.push(sample);
                return 0;
            }
            if is_on(&sample) && jumps(held) {
                let at = Some(place(held));
                // One frame alone is a stray one.
                if self.held.len() > 1 || self.nowhere == at {
                    lost = self.held.len();
                    self.held.clear();
                }
                self.nowhere = at;
            }
            self.last = self.held.last().copied().or(self.last);
            self.held.drain(..).for_each(&mut see);
        }
        if !is_on(&sample) && self.last.is_none_or(|last| is_on(&last) && jumps(&last)) {
            self.held.push(sample);
        } else {
            self.last = Some(sample);
            see(sample);
        }
        lost
    }

    /// Number of the frames at the end of the data that no later one told of: off the table, where no object gets.
    pub(crate) fn finish(self) -> usize {
        self.held.len()
    }
}

fn place(sample: &Sample) -> Point {
    Point::new(sample.x, sample.y)
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    /// Number of the frames, at 60 Hz, that are lost and that are seen.
    fn counts(places: &[[f64; 2]]) -> (usize, usize) {
        let (rig, mut lost) = (Rig::demo(Shape::Cylinder), Lost::default());
        let (mut unseen, mut seen) = (0, Vec::new());
        for (i, [x, y]) in (0_i64..).zip(places) {
            let sample = Sample {
                stamp: i * 16_666_667,
                x: *x,
                y: *y,
            };
            unseen += lost.take(sample, &rig, |sample| seen.push(sample.stamp));
        }
        assert!(seen.is_sorted());
        (unseen + lost.finish(), seen.len())
    }

    #[test]
    fn a_place_off_the_table_that_no_object_gets_to_is_a_lost_frame() {
        let at = |x: f64| [x, 0.1];
        let nowhere = [-1.0, -1.0];
        assert_eq!(
            counts(&[at(0.3), nowhere, nowhere, at(0.31), at(0.32)]),
            (2, 3)
        );
        // One alone is a stray frame, until it comes again; so where no number comes in between.
        let mixed = [
            nowhere,
            at(0.3),
            [9999.0; 2],
            [f64::NAN; 2],
            [9999.0; 2],
            at(0.3),
        ];
        assert_eq!(counts(&mixed), (3, 3));
        let again = [at(0.3), nowhere, at(0.3), nowhere, at(0.3)];
        assert_eq!(counts(&again), (1, 4));
        assert_eq!(counts(&[at(0.3), [0.0; 2], at(0.3)]), (1, 2));
        // Nor is one lost without a word where the log ends with it.
        assert_eq!(counts(&[at(0.3), nowhere, nowhere]), (2, 1));
    }

    #[test]
    fn an_object_that_lies_off_the_table_is_seen_there() {
        // It slides over the edge, and is put back.
        let falls = (0..40).map(|i| [0.9 + 0.005 * f64::from(i), 0.1]);
        let falls: Vec<[f64; 2]> = falls
            .chain([[1.095, 0.1]; 30])
            .chain([[0.3, 0.1]; 5])
            .collect();
        assert_eq!(counts(&falls), (0, 75));
        // A hand puts it beyond the stated bounds, from where it is struck; the tracker's places are coarse.
        let struck = (0..20).map(|i| [0.05 + 0.01 * f64::from(i), 0.1]);
        let struck: Vec<[f64; 2]> = [[0.6, 0.1]; 5]
            .into_iter()
            .chain([[0.05, 0.1]; 30])
            .chain(struck)
            .collect();
        assert_eq!(counts(&struck), (0, 55));
        // All places are in mm, and coarse.
        let in_mm: Vec<[f64; 2]> = (0..30)
            .map(|i| [400.0 + 12.0 * f64::from(i / 3), 100.0])
            .collect();
        assert_eq!(counts(&in_mm).0, 0);
    }
}
