//! What something stopped slowly, or on its last way, which shows only beside other strikes.
//!
//! A hand that takes a tenth of a second to stop an object leaves the track of a table that brakes harder; so does one that stops a slow object at
//! once. So the braking before each stop is held beside that before the stops of the same log which lie nearest, and before all: what a map of the
//! table's friction does it does to neighbours, too.

use serde::{Deserialize, Serialize};
use values::{Point, Strike};

use crate::robust::median;
use crate::slide::stood;

/// The last part of a track, with the frames at rest, in s, and the fewest frames of it.
const LAST: f64 = 0.3;
const FEWEST: usize = 6;
/// The fewest frames of it in which the object moves: one alone is met by any braking.
const MOVING: usize = 3;
/// The moment of the stop is looked for in these steps, up to this long after the last frame, in s.
const STEP: f64 = 0.004;
const LATER: f64 = 0.05;
/// What moves less in it, in m, tells nothing.
const LEAST: f64 = 0.004;
/// Of so many strikes that stop nearest, one may have been stopped, too: the second hardest says what the table does there.
const NEAREST: usize = 8;
/// What brakes so many times as hard as that, and by so many standard errors harder, was not braked by the table alone.
const HARDER: f64 = 1.4;
const ERRORS: f64 = 4.0;
/// Of the nearest, more may have been stopped at once than were not: the third least hard says what the table does there. Where no table stops an
/// object so that brakes this many times as hard, none did.
const AT_ONCE: usize = 2;
const NO_TABLE: f64 = 1.6;

/// How an object was braked to its stop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Braking {
    /// Where it stopped, in m.
    stop: Point,
    /// In m/s².
    by: f64,
    /// Its standard error.
    error: f64,
    /// Where it stood as if at once: the number of frames before, and the least braking, in m/s², that can have done it.
    stood: Option<(usize, f64)>,
}

/// What stopped an object beside the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Caught {
    /// It was braked so many times as hard as others.
    Slowly(f64),
    /// It stood from one frame to the next, after so many frames of its track.
    AtOnce(usize),
}

impl Braking {
    /// Of a strike that came to rest: the even braking whose way to the stop its last frames follow best.
    pub(crate) fn of(strike: &Strike) -> Option<Self> {
        let track = &strike.track;
        let end = *track.t.last().filter(|_| strike.has_stop())?;
        let from = track.t.partition_point(|t| *t < end - LAST);
        if track.len() - from < FEWEST {
            return None;
        }
        let before = |frame: usize| strike.stop - track.point(frame);
        let far = before(from).norm();
        if far < LEAST {
            return None;
        }
        let ahead = before(from) * (1.0 / far);
        let frames: Vec<(f64, f64)> = (from..track.len())
            .map(|frame| (track.t[frame], before(frame).dot(ahead)))
            .collect();
        let steps = ((end + LATER - track.t[from]) / STEP) as u32;
        let fits = (1..steps).filter_map(|step| {
            let way = |t: f64| {
                0.5 * (track.t[from] + STEP * f64::from(step) - t)
                    .max(0.0)
                    .powi(2)
            };
            let moving = frames.iter().filter(|(t, _)| way(*t) > 0.0).count();
            let squares: f64 = frames.iter().map(|(t, _)| way(*t).powi(2)).sum();
            let by = frames.iter().map(|(t, d)| way(*t) * d).sum::<f64>() / squares;
            let left = |(t, d): &(f64, f64)| (d - by * way(*t)).powi(2);
            let left: f64 = frames.iter().map(left).sum();
            (by.is_finite() && moving >= MOVING).then_some((left, by, squares))
        });
        let (left, by, squares) = fits.min_by(|one, other| one.0.total_cmp(&other.0))?;
        let square = left / (frames.len() - 2) as f64;
        Some(Self {
            stop: strike.stop,
            by,
            error: (square / squares).sqrt(),
            stood: stood(track, strike.stop),
        })
    }
}

/// Of each of a log's strikes, in order of time, what stopped it, where no table does that: more suddenly, or harder, than those that stop near it and
/// than all in the middle; and, where it was braked, than the strikes before and after it. A table that is sanded brakes these, too.
pub(crate) fn caught(brakings: &[Option<Braking>]) -> Vec<Option<Caught>> {
    let all: Vec<&Braking> = brakings.iter().flatten().collect();
    let usual = median(all.iter().map(|braking| braking.by));
    let is_harder = |braking: &Braking, than: f64| {
        braking.by > HARDER * than && braking.by - than > ERRORS * braking.error
    };
    let of = |(at, braking): (usize, &&Braking)| {
        let stood = braking.stood.filter(|(_, by)| *by > NO_TABLE * usual);
        if all.len() <= NEAREST || (stood.is_none() && !is_harder(braking, usual)) {
            return None;
        }
        let others = (0..all.len()).filter(|other| *other != at);
        let mut others: Vec<(f64, f64)> = others
            .map(|other| (all[other].stop.distance(braking.stop), all[other].by))
            .collect();
        others.select_nth_unstable_by(NEAREST - 1, |one, other| one.0.total_cmp(&other.0));
        let mut near: Vec<f64> = others[..NEAREST].iter().map(|other| other.1).collect();
        near.sort_by(f64::total_cmp);
        if let Some((frames, _)) = stood.filter(|(_, by)| *by > NO_TABLE * near[AT_ONCE]) {
            return Some(Caught::AtOnce(frames));
        }
        let beside = [at.checked_sub(1), Some(at + 1)];
        let beside = beside
            .into_iter()
            .flatten()
            .filter_map(|other| all.get(other));
        let than = beside.fold(near[NEAREST - 2].max(usual), |most, other| {
            most.max(other.by)
        });
        is_harder(braking, than).then_some(Caught::Slowly(braking.by / than))
    };
    let mut found = all.iter().enumerate().map(of);
    let each = brakings.iter();
    each.map(|braking| braking.as_ref().and_then(|_| found.next().flatten()))
        .collect()
}

#[cfg(test)]
mod tests {
    use values::{Command, Track};

    use super::*;

    fn braked(by: f64, at_last: f64, number: u32) -> Option<Braking> {
        Braking::of(&strike_of(by, at_last, 0.0, number))
    }

    /// A strike that is braked by so much, in m/s², and so much in its last 0.12 s, and held so many seconds before it would have come to rest.
    fn strike_of(by: f64, at_last: f64, sooner: f64, number: u32) -> Strike {
        let wobble = |i: u32, k: f64| 0.0006 * 1.4 * (f64::from(i * i + number) * k).sin();
        let number = f64::from(number);
        let stop = Point::new(0.5 + 0.02 * number, 0.1 * (number % 3.0));
        let mut strike = Strike::bare(Command::new(1.0, 0.0), Point::default(), stop);
        let left = |t: f64| (0.5 - t.min(0.5 - sooner)).max(0.0);
        let way = |t: f64| {
            let (late, early) = (left(t).min(0.12), (left(t) - 0.12).max(0.0));
            0.5 * at_last * late * late + at_last * 0.12 * early + 0.5 * by * early * early
        };
        let frames = 0..35 - (60.0 * sooner) as u32;
        let t: Vec<f64> = frames.clone().map(|i| f64::from(i) / 60.0).collect();
        strike.track = Track {
            x: frames
                .clone()
                .map(|i| stop.x - way(t[i as usize]) + wobble(i, 1.1))
                .collect(),
            y: frames.map(|i| stop.y + wobble(i, 2.3)).collect(),
            t,
            ..Track::default()
        };
        strike.stop = Point::new(stop.x - way(1.0), stop.y);
        strike
    }

    #[test]
    fn what_brakes_as_no_neighbour_does_was_stopped_and_a_patch_of_the_table_stops_all() {
        let mut strikes: Vec<_> = (0..30).map(|i| braked(2.0, 2.0, i)).collect();
        assert_eq!(caught(&strikes), vec![None; 30]);
        strikes[17] = braked(2.0, 6.0, 17);
        let found = caught(&strikes);
        assert!(
            matches!(found[17], Some(Caught::Slowly(times)) if (1.5..3.0).contains(&times)),
            "{:?}",
            found[17]
        );
        assert_eq!(found.iter().flatten().count(), 1);
        // One in three is held from 0.3 m/s, 0.15 s before it would have come to rest.
        let held = |i: u32| i % 3 == 1;
        let at_once: Vec<_> = (0..30)
            .map(|i| strike_of(2.0, 2.0, if held(i) { 0.15 } else { 0.0 }, i))
            .map(|strike| Braking::of(&strike))
            .collect();
        for (i, found) in (0_u32..).zip(caught(&at_once)) {
            let is_found = matches!(found, Some(Caught::AtOnce(20..=22)));
            assert_eq!(is_found, held(i), "{i}: {found:?}");
        }
        // Where the last ones stop, the table brakes three times as hard.
        let patch: Vec<_> = (0..30)
            .map(|i| braked(2.0, if i < 24 { 2.0 } else { 6.0 }, i))
            .collect();
        assert_eq!(caught(&patch), vec![None; 30]);
        // So does a table that is sanded before the last strikes.
        let sanded: Vec<_> = (0..30)
            .map(|i| braked(2.0, if i < 26 { 2.0 } else { 6.0 }, (7 * i) % 30))
            .collect();
        assert_eq!(caught(&sanded), vec![None; 30]);
        // So few tell nothing.
        assert_eq!(caught(&strikes[14..22]), vec![None; 8]);
    }
}
