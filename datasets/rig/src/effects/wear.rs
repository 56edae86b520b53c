//! What changes from strike to strike or from session to session.

use values::{Command, Point};

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

declare! {
    /// Friction runs in: it starts off and settles within some strikes, a factor 1 + change·e^(−n/over).
    RunningIn = "running_in" {
        /// Relative change of the first strike.
        change: 0.25, "1", Some(0.0);
        /// Number of strikes.
        over: 30.0, "1", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        1.0 + self.change * (-(index.order as f64) / self.over).exp()
    }
}

declare! {
    /// Friction rises or falls by the same amount with each strike: a factor 1 + change·n/over.
    LinearWear = "linear_wear" {
        /// Relative change after `over` strikes.
        change: 0.2, "1", Some(0.0);
        /// Number of strikes.
        over: 120.0, "1", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        (1.0 + self.change * index.order as f64 / self.over).max(0.1)
    }
}

declare! {
    /// Restitution changes as the tip wears, and settles: a factor 1 + change·(1 − e^(−n/over))/(1 − 1/e).
    RestitutionDrift = "restitution_drift" {
        /// Relative change after `over` strikes.
        change: -0.25, "1", Some(0.0);
        /// Number of strikes.
        over: 90.0, "1", None;
    }

    fn restitution(&self, _speed: f64, index: StrikeIndex) -> f64 {
        let settled = 1.0 - (-(index.order as f64) / self.over).exp();
        1.0 + self.change * settled / (1.0 - (-1f64).exp())
    }
}

/// A number in [−1, 1] for each session, other ones for each seed: steps of the golden ratio, which show no pattern.
fn of_session(seed: f64, session: usize) -> f64 {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let place = (seed * 0.754_877_666 + session as f64 * golden).fract();
    // Not all on one side of 0 where sessions are few: neighbours in the series lie 0.38 of the whole apart.
    2.0 * place - 1.0
}

declare! {
    /// Friction differs from session to session, by any series: a factor 1 + spread·z with z in [−1, 1] for each session.
    FrictionOfSessions = "friction_of_sessions" {
        /// Relative size of the differences.
        spread: 0.12, "1", Some(0.0);
        /// Which series, any number.
        seed: 1.0, "1", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        (1.0 + self.spread * of_session(self.seed, index.session)).max(0.1)
    }
}

declare! {
    /// The arm was mounted anew before each session: its heading differs by session.
    StrikerAngleBySession = "striker_angle_by_session" {
        /// Size of the differences, in rad.
        spread: 0.04, "rad", Some(0.0);
        /// Which series, any number.
        seed: 1.0, "1", None;
    }

    fn deliver(&self, command: Command, _from: Point, index: StrikeIndex) -> Command {
        command.turned(self.spread * of_session(self.seed, index.session))
    }
}

declare! {
    /// The camera was touched between sessions: it is turned about the point it looks down on, by session.
    CameraAngleBySession = "camera_angle_by_session" {
        /// Size of the differences, in rad.
        spread: 0.03, "rad", Some(0.0);
        /// Which series, any number.
        seed: 2.0, "1", None;
    }

    fn see(&self, at: Point, centre: Point, index: StrikeIndex) -> Point {
        centre + (at - centre).rotated(self.spread * of_session(self.seed, index.session))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(order: usize) -> StrikeIndex {
        StrikeIndex { session: 0, order }
    }

    #[test]
    fn wear_begins_and_ends_where_it_says() {
        let running = RunningIn::default();
        assert_eq!(running.strike_friction(at(0)), 1.25);
        assert!((running.strike_friction(at(300)) - 1.0).abs() < 1e-4);
        let linear = LinearWear::default();
        assert!((linear.strike_friction(at(60)) - 1.1).abs() < 1e-12);
        let tip = RestitutionDrift::default();
        assert_eq!(tip.restitution(0.7, at(0)), 1.0);
        assert!((tip.restitution(0.7, at(90)) - 0.75).abs() < 1e-12);
    }

    #[test]
    fn sessions_differ_and_so_do_seeds() {
        let series = |seed| -> Vec<f64> { (0..4).map(|s| of_session(seed, s)).collect() };
        for seed in [0.0, 1.0, 17.0, 1234.0] {
            let values = series(seed);
            assert!(
                values.iter().all(|z| (-1.0..=1.0).contains(z)),
                "{values:?}"
            );
            let spread = values.iter().fold(f64::MIN, |a, b| a.max(*b))
                - values.iter().fold(f64::MAX, |a, b| a.min(*b));
            assert!(spread > 0.7, "{values:?}");
        }
        assert_ne!(series(1.0), series(2.0));
    }
}
