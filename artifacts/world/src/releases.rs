//! How the object leaves the tip in one world: a table that fills where it is asked.
//!
//! In one world a release depends on the delivered speed alone and, for a box, on the angle. Relative to that speed it
//! changes little, so MuJoCo's impact at a few speeds and angles serves all strikes, by cubic interpolation. An entry depends
//! on its place only: which strike asked first, and on which thread, changes no bit.

use std::collections::BTreeMap;
use std::sync::{PoisonError, RwLock};

use values::{Command, Interval, Point};

/// Steps of the table: logarithm of the speed, and rad.
pub(crate) const STEPS: [f64; 2] = [0.3, 0.04];

/// Releases by their place in the table.
#[derive(Default)]
pub(crate) struct Releases(RwLock<BTreeMap<[i64; 2], Option<Scaled>>>);

impl Releases {
    /// The entry at this place, filled in by `simulate` when it is first needed.
    pub(crate) fn entry(
        &self,
        place: [i64; 2],
        simulate: impl FnOnce() -> Option<Scaled>,
    ) -> Option<Scaled> {
        let read = self.0.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(entry) = read.get(&place) {
            return *entry;
        }
        drop(read);
        let entry = simulate();
        let mut write = self.0.write().unwrap_or_else(PoisonError::into_inner);
        write.insert(place, entry);
        entry
    }
}

/// Places of four entries within `range` and their weights, of the cubic through them; `None` where the range holds fewer.
pub(crate) fn cubic(at: f64, range: Interval, step: f64) -> Option<[(i64, f64); 4]> {
    let at = at / step;
    // A cast of what is infinite saturates.
    let (least, most) = (
        (range.low / step).ceil() as i64,
        (range.high / step).floor() as i64,
    );
    let last_first = most.saturating_sub(3);
    if last_first < least {
        return None;
    }
    let first = (at.floor() as i64 - 1).clamp(least, last_first);
    let places = [0, 1, 2, 3].map(|i| first + i);
    Some(places.map(|place| {
        let others = places.iter().filter(|other| **other != place);
        let weight = others.fold(1.0, |weight, other| {
            weight * (at - *other as f64) / (place - other) as f64
        });
        (place, weight)
    }))
}

/// The object as it leaves the tip, in the frame of the impact: x along the tip's velocity, y to its left, the object at rest
/// in the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Release {
    /// Seconds since touch.
    pub time: f64,
    /// Position of the object in m.
    pub position: Point,
    /// Its velocity in m/s.
    pub velocity: Point,
    /// Its rate of turning in rad/s.
    pub spin: f64,
}

/// The numbers of a release that vary from impact to impact: time, position and velocity in the frame of the impact, spin; positions per m,
/// velocities and spin per m/s of the tip's speed.
pub(crate) type Scaled = [f64; 6];

impl Release {
    /// This release divided by the tip's speed (m/s).
    pub(crate) fn scaled(&self, speed: f64) -> Scaled {
        [
            self.time,
            self.position.x,
            self.position.y,
            self.velocity.x / speed,
            self.velocity.y / speed,
            self.spin / speed,
        ]
    }

    /// The release after an impact with this command, in the table's frame.
    pub(crate) fn of(scaled: Scaled, command: Command) -> Self {
        let [time, x, y, vx, vy, spin] = scaled;
        let Command { speed, angle } = command;
        Self {
            time,
            position: Point::new(x, y).rotated(angle),
            velocity: Point::new(vx, vy).rotated(angle) * speed,
            spin: spin * speed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_met_within_and_at_the_ends() {
        let cube = |x: f64| 1.0 - 2.0 * x + 3.0 * x * x - 0.5 * x * x * x;
        let range = Interval::new(0.31, 1.0);
        for at in [0.31, 0.35, 0.52, 0.777, 0.99] {
            let places = cubic(at, range, 0.1).expect("wide enough");
            let sum: f64 = places
                .iter()
                .map(|(i, weight)| weight * cube(*i as f64 * 0.1))
                .sum();
            assert!((sum - cube(at)).abs() < 1e-12, "{at}: {sum}");
            assert!(
                places.iter().all(|(i, _)| (4..=10).contains(i)),
                "{places:?}"
            );
        }
        assert!(cubic(0.5, range, 0.3).is_none());
    }
}
