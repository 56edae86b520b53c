//! Velocities of an arm that logs its place alone.
//!
//! Many trackers of a mallet fill in a pose and leave the velocity at zero. An arm that is elsewhere than it was, and has never moved by its
//! velocity, does not measure it: from there on it is taken from the places.

use values::Point;

use crate::arm::State;
use crate::order::since;

/// Distance, in m, from which an arm has moved.
const MOVED: f64 = 0.05;
/// Longest time between states, in s, that tell a velocity; and the shortest.
const LONGEST: f64 = 0.1;
const SHORTEST: f64 = 0.001;

/// Fills in velocities that were not measured.
#[derive(Debug, Default)]
pub(crate) struct Unmeasured {
    first: Option<Point>,
    last: Option<State>,
    is_measured: bool,
    has_moved: bool,
    /// Whether any was filled in.
    pub(crate) any: bool,
}

impl Unmeasured {
    /// The state with a velocity, where that can be told.
    pub(crate) fn filled(&mut self, state: State) -> State {
        self.is_measured |= state.velocity.norm() > 0.0;
        if self.is_measured || !state.position.is_finite() {
            return state;
        }
        let first = *self.first.get_or_insert(state.position);
        self.has_moved |= state.position.distance(first) > MOVED;
        let last = self.last;
        let time = last.map_or(0.0, |last| since(last.stamp, state.stamp));
        if last.is_some() && time < SHORTEST {
            return State {
                velocity: last.map_or(state.velocity, |last| last.velocity),
                ..state
            };
        }
        let velocity = match last {
            Some(last) if time < LONGEST => (state.position - last.position) * (1.0 / time),
            _ => Point::default(),
        };
        let filled = State { velocity, ..state };
        self.last = Some(filled);
        self.any |= self.has_moved;
        if self.has_moved { filled } else { state }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Velocities along x of an arm that goes 0.2 m/s, told so or not, 120 times a second.
    fn velocities(told: impl Fn(u32) -> f64) -> Vec<f64> {
        let mut unmeasured = Unmeasured::default();
        (0..120)
            .map(|i| {
                let t = f64::from(i) / 120.0;
                let state = State {
                    stamp: (t * 1e9) as i64,
                    velocity: Point::new(told(i), 0.0),
                    position: Point::new(0.2 * t, 0.0),
                };
                unmeasured.filled(state).velocity.x
            })
            .collect()
    }

    #[test]
    fn a_place_that_moves_without_a_velocity_gives_one_and_what_is_measured_stays() {
        for nothing in [0.0, f64::NAN] {
            let found = velocities(|_| nothing);
            assert!(
                found[40..].iter().all(|v| (v - 0.2).abs() < 1e-6),
                "{found:?}"
            );
        }
        // Its second half is told to stand still.
        let told = |i: u32| if i < 60 { 0.19 } else { 0.0 };
        assert_eq!(velocities(told), (0..120).map(told).collect::<Vec<_>>());
    }
}
