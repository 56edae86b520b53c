//! More that no candidate has: forces, an arm and a camera for which the contract has no name.

use values::{Command, Point};

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

declare! {
    /// A magnet under the table: it pulls towards one place, most at some distance from it.
    Magnet = "magnet" {
        center_x: 0.50, "m", None;
        center_y: 0.05, "m", None;
        /// How deep it lies, in m: the pull is strongest at 0.7 of it.
        depth: 0.07, "m", None;
        /// The strongest pull, in m/s².
        pull: 0.9, "m/s2", Some(0.0);
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let arm = (Point::new(self.center_x, self.center_y) - at) * (1.0 / self.depth);
        // r/(1 + r²)^(3/2) is at most 0.385, where r² is 1/2.
        let field = (1.0 + arm.dot(arm)).powf(-1.5) / 0.384_900_18;
        arm * (self.pull * field)
    }
}

declare! {
    /// A force across the velocity, as on a body that spins in air: a = rate·v, turned to the left.
    SideForce = "side_force" {
        rate: 0.35, "1/s", Some(0.0);
    }

    fn acceleration(&self, _at: Point, velocity: Point, _time: f64) -> Point {
        velocity.rotated(std::f64::consts::FRAC_PI_2) * self.rate
    }
}

declare! {
    /// Air that turns about a place: a push across the line to it, which grows with the distance.
    Swirl = "swirl" {
        /// In 1/s².
        rate: 1.0, "1/s2", Some(0.0);
        center_x: 0.5, "m", None;
        center_y: -0.1, "m", None;
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let arm = at - Point::new(self.center_x, self.center_y);
        arm.rotated(std::f64::consts::FRAC_PI_2) * self.rate
    }
}

declare! {
    /// A liquid in the object sloshes after the impact: its mass swings along the motion and dies away.
    Sloshing = "sloshing" {
        /// Share of the velocity by which it pulls, at the impact, in 1/s.
        amplitude: 3.0, "1/s", Some(0.0);
        frequency: 3.5, "Hz", None;
        /// Time in which it falls to 1/e, in s.
        decay: 0.4, "s", None;
    }

    fn acceleration(&self, _at: Point, velocity: Point, time: f64) -> Point {
        let swing =
            (std::f64::consts::TAU * self.frequency * time).cos() * (-time / self.decay).exp();
        velocity * (-self.amplitude * swing)
    }
}

declare! {
    /// Friction has a memory: it grows with the time since the impact, as that of a felt that warms or picks up dust.
    FrictionAgeing = "friction_ageing" {
        /// Deceleration that is added for each second, in m/s³.
        rate: 0.8, "m/s3", Some(0.0);
    }

    fn acceleration(&self, _at: Point, velocity: Point, time: f64) -> Point {
        let speed = velocity.norm();
        if speed < 1e-6 {
            return Point::default();
        }
        velocity * (-self.rate * time / speed)
    }
}

declare! {
    /// The arm's speed ripples with the commanded one, as a resonance makes it.
    SpeedRipple = "speed_ripple" {
        /// Share of the speed.
        amplitude: 0.05, "1", Some(0.0);
        /// From crest to crest, in m/s.
        period: 0.22, "m/s", None;
        phase: 0.5, "rad", None;
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        let wave = (std::f64::consts::TAU * command.speed / self.period + self.phase).sin();
        Command::new(command.speed * (1.0 + self.amplitude * wave), command.angle)
    }
}

declare! {
    /// A gear's eccentricity: the heading's error ripples with the commanded angle.
    AngleRipple = "angle_ripple" {
        amplitude: 0.03, "rad", Some(0.0);
        /// From crest to crest, in rad.
        period: 0.35, "rad", None;
        /// Phase straight ahead, in rad.
        phase: 1.0, "rad", None;
    }

    fn deliver(&self, command: Command, _from: Point, _when: StrikeIndex) -> Command {
        let wave = (std::f64::consts::TAU * command.angle / self.period + self.phase).sin();
        command.turned(self.amplitude * wave)
    }
}

declare! {
    /// Two cameras share the table and do not agree: what lies beyond a line is seen shifted.
    StitchedCameras = "stitched_cameras" {
        /// Where the second begins, in m.
        x: 0.48, "m", None;
        shift_x: 0.004, "m", Some(0.0);
        shift_y: 0.008, "m", Some(0.0);
    }

    fn see(&self, at: Point, _centre: Point, _when: StrikeIndex) -> Point {
        if at.x < self.x {
            at
        } else {
            at + Point::new(self.shift_x, self.shift_y)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_point_where_their_formulas_say() {
        let v = Point::new(0.6, 0.0);
        let magnet = Magnet::default();
        let beside = Point::new(0.50 + 0.07 / 2f64.sqrt(), 0.05);
        let pull = magnet.acceleration(beside, v, 0.0);
        assert!(pull.distance(Point::new(-0.9, 0.0)) < 1e-6, "{pull:?}");
        let side = SideForce::default().acceleration(Point::default(), v, 0.0);
        assert!(side.distance(Point::new(0.0, 0.21)) < 1e-12);
        let swirl = Swirl::default().acceleration(Point::new(0.6, -0.1), v, 0.0);
        assert!(swirl.distance(Point::new(0.0, 0.1)) < 1e-12);
        let aged = FrictionAgeing::default().acceleration(Point::default(), v, 0.5);
        assert!(aged.distance(Point::new(-0.4, 0.0)) < 1e-12);
        let sloshing = Sloshing::default().acceleration(Point::default(), v, 0.0);
        assert!(sloshing.distance(Point::new(-1.8, 0.0)) < 1e-12);
    }

    #[test]
    fn ripples_come_back_after_a_period() {
        let deliver = |effect: &dyn Acts, speed, angle| {
            effect.deliver(
                Command { speed, angle },
                Point::default(),
                StrikeIndex::default(),
            )
        };
        let speed = SpeedRipple::default();
        let share = |v| deliver(&speed, v, 0.0).speed / v;
        assert!((share(0.5) - share(0.72)).abs() < 1e-9 && (share(0.5) - share(0.61)).abs() > 0.01);
        let angle = AngleRipple::default();
        let error = |a| deliver(&angle, 0.7, a).angle - a;
        assert!((error(0.1) - error(0.45)).abs() < 1e-9 && (error(0.1) - error(0.27)).abs() > 0.01);
    }

    #[test]
    fn the_second_camera_sees_what_lies_beyond_its_line_shifted() {
        let cameras = StitchedCameras::default();
        let see = |x| cameras.see(Point::new(x, 0.1), Point::default(), StrikeIndex::default());
        assert_eq!(see(0.3), Point::new(0.3, 0.1));
        assert!(see(0.6).distance(Point::new(0.604, 0.108)) < 1e-12);
    }
}
