//! Arms whose delivered speed or heading depends on where the object lies: on how far the arm reaches, and which way.

use values::{Command, Point};

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

/// The middle of the places at which objects are struck: errors are nothing there, in m.
const MIDDLE: Point = Point { x: 0.30, y: 0.0 };

declare! {
    /// Speed and heading change linearly over the start's place.
    StrikerErrorByPlace = "striker_error_by_place" {
        /// Share of the speed for each metre along x.
        speed_x: -0.3, "1/m", Some(0.0);
        /// Share of the speed for each metre along y.
        speed_y: 0.2, "1/m", Some(0.0);
        /// Heading for each metre along x, in rad/m.
        angle_x: 0.1, "rad/m", Some(0.0);
        /// Heading for each metre along y, in rad/m.
        angle_y: 0.2, "rad/m", Some(0.0);
    }

    fn deliver(&self, command: Command, from: Point, _when: StrikeIndex) -> Command {
        let arm = from - MIDDLE;
        Command::new(
            command.speed * (1.0 + self.speed_x * arm.x + self.speed_y * arm.y),
            command.angle + self.angle_x * arm.x + self.angle_y * arm.y,
        )
    }
}

declare! {
    /// An arm that is slow where it is folded or stretched: its speed falls with the square of the way from its best reach.
    SpeedByReach = "speed_by_reach" {
        /// Share of the speed that is lost 0.1 m from there.
        loss: 0.05, "1", Some(0.0);
        /// The reach at which it is as fast as commanded, in m from its base.
        best: 0.30, "m", None;
    }

    fn deliver(&self, command: Command, from: Point, _when: StrikeIndex) -> Command {
        let off = (from.norm() - self.best) / 0.1;
        Command::new(
            command.speed * (1.0 - self.loss * off * off).max(0.1),
            command.angle,
        )
    }
}

declare! {
    /// The base joint's gear is not round: the heading's error is a wave over the bearing of the object from the base.
    HeadingByBearing = "heading_by_bearing" {
        amplitude: 0.03, "rad", Some(0.0);
        /// From crest to crest, in rad.
        period: 1.2, "rad", None;
        /// Phase straight ahead, in rad.
        phase: 0.5, "rad", None;
    }

    fn deliver(&self, command: Command, from: Point, _when: StrikeIndex) -> Command {
        let wave = (std::f64::consts::TAU * from.bearing() / self.period + self.phase).sin();
        command.turned(self.amplitude * wave)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_follow_the_place_and_are_nothing_in_its_middle() {
        let command = Command::new(0.8, 0.1);
        let at = |effect: &dyn Acts, x, y| {
            effect.deliver(command, Point::new(x, y), StrikeIndex::default())
        };
        let linear = StrikerErrorByPlace::default();
        assert_eq!(at(&linear, 0.3, 0.0), command);
        let there = at(&linear, 0.4, 0.1);
        assert!((there.speed - 0.8 * 0.99).abs() < 1e-12 && (there.angle - 0.13).abs() < 1e-12);
        let reach = SpeedByReach::default();
        assert!((at(&reach, 0.4, 0.0).speed - 0.76).abs() < 1e-12);
        assert!((at(&reach, 0.2, 0.0).speed - 0.76).abs() < 1e-12);
        let wave = HeadingByBearing::default();
        let error = |turn: f64| at(&wave, 0.3 * turn.cos(), 0.3 * turn.sin()).angle - 0.1;
        assert!((error(-0.6) - error(0.6)).abs() < 1e-9 && (error(0.0) - error(0.3)).abs() > 0.01);
    }
}
