//! Arms whose delivered speed or heading is a bent function of the command.

use values::{Command, Point};

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

declare! {
    /// The arm's speed saturates as a hyperbolic tangent: tanh(s·v)/s.
    TanhSpeed = "tanh_speed" {
        /// One over the highest speed, in s/m.
        saturation: 0.9, "s/m", Some(0.0);
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        let reach = self.saturation * command.speed;
        let share = if reach.abs() < 1e-6 {
            1.0
        } else {
            reach.tanh() / reach
        };
        Command::new(command.speed * share, command.angle)
    }
}

declare! {
    /// The arm's speed bends into a ceiling: v/(1 + (s·v)^sharpness)^(1/sharpness).
    RoundedSpeed = "rounded_speed" {
        /// One over the highest speed, in s/m.
        saturation: 1.1, "s/m", Some(0.0);
        /// How sharp the bend is.
        sharpness: 5.0, "1", None;
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        let bend = 1.0 + (self.saturation.abs() * command.speed).powf(self.sharpness);
        Command::new(
            command.speed * bend.powf(-1.0 / self.sharpness),
            command.angle,
        )
    }
}

declare! {
    /// The arm's heading is off by a share of its angle, by a constant, with its speed, and bends at wide angles.
    StrikerAngleError = "striker_angle_error" {
        /// Share of the angle that is added.
        gain: 0.10, "1", Some(0.0);
        bias: 0.01, "rad", Some(0.0);
        /// For each m/s of speed, in rad·s/m.
        slope: 0.05, "rad s/m", Some(0.0);
        /// For each rad³ of angle, in 1/rad².
        bend: 0.0, "1/rad2", Some(0.0);
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        let error = self.gain * command.angle
            + self.bias
            + self.slope * command.speed
            + self.bend * command.angle.powi(3);
        command.turned(error)
    }
}

declare! {
    /// Play in a joint: the heading is off to one side or the other, by where the arm comes from.
    AngleBacklash = "angle_backlash" {
        play: 0.04, "rad", Some(0.0);
        /// Angle over which it turns over, in rad.
        width: 0.3, "rad", None;
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        command.turned(self.play * (command.angle / self.width).tanh())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn delivered(effect: &dyn Acts, speed: f64, angle: f64) -> Command {
        effect.deliver(
            Command { speed, angle },
            Point::default(),
            StrikeIndex::default(),
        )
    }

    #[test]
    fn saturating_speeds_stay_below_their_ceiling_and_start_as_commanded() {
        let tanh = TanhSpeed::default();
        assert!((delivered(&tanh, 0.01, 0.0).speed - 0.01).abs() < 1e-6);
        assert!((delivered(&tanh, 1.0, 0.0).speed - 0.9f64.tanh() / 0.9).abs() < 1e-12);
        let rounded = RoundedSpeed::default();
        assert!((delivered(&rounded, 0.2, 0.0).speed - 0.2).abs() < 1e-3);
        assert!(delivered(&rounded, 3.0, 0.0).speed < 1.0 / 1.1);
        let none = TanhSpeed { saturation: 0.0 };
        assert_eq!(delivered(&none, 0.8, 0.0).speed, 0.8);
    }

    #[test]
    fn heading_errors_add_up() {
        let error = StrikerAngleError {
            bend: 0.1,
            ..StrikerAngleError::default()
        };
        let expected = 0.5 + 0.05 + 0.01 + 0.04 + 0.1 * 0.125;
        assert!((delivered(&error, 0.8, 0.5).angle - expected).abs() < 1e-12);
        let play = AngleBacklash::default();
        assert!((delivered(&play, 0.8, 2.0).angle - 2.04).abs() < 1e-3);
        assert_eq!(delivered(&play, 0.8, 0.0).angle, 0.0);
    }
}
