//! What depends on the order of strikes otherwise than by wear: a table that is sanded or wiped, a room that warms, an arm that
//! warms up each morning, a camera that is pushed.

use values::{Command, Point};

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

/// Strikes since the last one whose number `every` divides.
fn since(index: StrikeIndex, every: f64) -> f64 {
    (index.order as f64).rem_euclid(every.max(1.0))
}

declare! {
    /// Another sheet is laid: friction changes from one strike on.
    FrictionChange = "friction_change" {
        change: 0.12, "1", Some(0.0);
        /// The first strike on the new sheet.
        from: 50.0, "1", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        if (index.order as f64) < self.from {
            1.0
        } else {
            1.0 + self.change
        }
    }
}

declare! {
    /// The table is sanded: friction changes at one strike, and wears back.
    SandedTable = "sanded_table" {
        /// Relative change just after.
        change: 0.25, "1", Some(0.0);
        /// The first strike after it.
        from: 40.0, "1", None;
        /// Strikes in which it falls to 1/e.
        over: 25.0, "1", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        let strikes = index.order as f64 - self.from;
        if strikes < 0.0 {
            1.0
        } else {
            1.0 + self.change * (-strikes / self.over).exp()
        }
    }
}

declare! {
    /// Friction goes up and down with the order, as a room that is heated in turns makes it.
    FrictionCycle = "friction_cycle" {
        /// Relative size.
        amplitude: 0.10, "1", Some(0.0);
        /// Strikes from crest to crest.
        period: 30.0, "1", None;
        /// Phase of the first strike, in rad.
        phase: 0.0, "rad", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        let turn = std::f64::consts::TAU * index.order as f64 / self.period + self.phase;
        1.0 + self.amplitude * turn.sin()
    }
}

declare! {
    /// The table wears, and is wiped after so many strikes: friction is a saw's teeth.
    WipedTable = "wiped_table" {
        /// Relative change just before it is wiped.
        change: 0.2, "1", Some(0.0);
        /// Strikes from one wiping to the next.
        every: 25.0, "1", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        (1.0 + self.change * since(index, self.every) / self.every).max(0.1)
    }
}

declare! {
    /// The arm warms up each morning: its speed is off at the first strike of a session, and settles.
    WarmingArm = "warming_arm" {
        /// Share of the speed at the first strike.
        change: -0.06, "1", Some(0.0);
        /// Strikes in which it falls to 1/e.
        over: 8.0, "1", None;
        /// Strikes a session.
        every: 25.0, "1", None;
    }

    fn deliver(&self, command: Command, _from: Point, index: StrikeIndex) -> Command {
        let off = self.change * (-since(index, self.every) / self.over).exp();
        Command::new(command.speed * (1.0 + off), command.angle)
    }
}

declare! {
    /// Somebody pushes the camera: from one strike on, what it reports is turned and shifted.
    PushedCamera = "pushed_camera" {
        /// Turn about the point it looks down on, in rad.
        turn: 0.02, "rad", Some(0.0);
        shift_x: 0.004, "m", Some(0.0);
        shift_y: -0.003, "m", Some(0.0);
        /// The first strike after it.
        from: 50.0, "1", None;
    }

    fn see(&self, at: Point, centre: Point, index: StrikeIndex) -> Point {
        if (index.order as f64) < self.from {
            return at;
        }
        centre + (at - centre).rotated(self.turn) + Point::new(self.shift_x, self.shift_y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(order: usize) -> StrikeIndex {
        StrikeIndex { session: 0, order }
    }

    #[test]
    fn tables_change_when_they_say() {
        let change = FrictionChange::default();
        assert_eq!(change.strike_friction(at(49)), 1.0);
        assert_eq!(change.strike_friction(at(50)), 1.12);
        let sanded = SandedTable::default();
        assert_eq!(sanded.strike_friction(at(39)), 1.0);
        assert_eq!(sanded.strike_friction(at(40)), 1.25);
        assert!((sanded.strike_friction(at(65)) - 1.0 - 0.25 * (-1f64).exp()).abs() < 1e-12);
        let cycle = FrictionCycle::default();
        assert!((cycle.strike_friction(at(7)) - cycle.strike_friction(at(37))).abs() < 1e-12);
        assert!((cycle.strike_friction(at(7)) - cycle.strike_friction(at(22))).abs() > 0.1);
        let wiped = WipedTable::default();
        assert_eq!(wiped.strike_friction(at(25)), 1.0);
        assert!((wiped.strike_friction(at(24)) - 1.192).abs() < 1e-12);
    }

    #[test]
    fn the_arm_is_slow_each_morning_and_the_camera_is_pushed_once() {
        let arm = WarmingArm::default();
        let command = Command::new(1.0, 0.0);
        let speed = |order| arm.deliver(command, Point::default(), at(order)).speed;
        assert_eq!((speed(0), speed(25)), (0.94, 0.94));
        assert!(speed(24) > 0.99);
        let camera = PushedCamera::default();
        let centre = Point::new(0.45, 0.0);
        let see = |order| camera.see(centre, centre, at(order));
        assert_eq!(see(49), centre);
        assert!(see(50).distance(centre + Point::new(0.004, -0.003)) < 1e-12);
    }
}
