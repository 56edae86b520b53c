//! Effects that no candidate has: a diagnosis must call them unexplained.

use values::Point;

use super::acts::Acts;
use crate::declare::declare;

declare! {
    /// A jet of air blows across one place: a Gaussian of acceleration in one direction.
    AirJet = "air_jet" {
        center_x: 0.50, "m", None;
        center_y: 0.05, "m", None;
        /// Standard deviation of its profile, in m.
        radius: 0.05, "m", None;
        /// Acceleration in its middle, in m/s².
        acceleration: 1.2, "m/s2", Some(0.0);
        bearing: 1.2, "rad", None;
    }

    fn acceleration(&self, at: Point, _velocity: Point, _time: f64) -> Point {
        let distance = at.distance(Point::new(self.center_x, self.center_y)) / self.radius;
        Point::polar(
            self.acceleration * (-0.5 * distance * distance).exp(),
            self.bearing,
        )
    }
}

declare! {
    /// A line of glue across the table: whatever crosses it loses kinetic energy.
    StickyLine = "sticky_line" {
        /// Where it crosses the x axis, in m.
        x: 0.48, "m", None;
        /// Its lean: x grows by this for each metre of y.
        lean: 0.3, "1", None;
        /// Energy lost over mass, in m²/s².
        loss: 0.12, "m2/s2", Some(0.0);
        /// Standard deviation of its profile, in m.
        width: 0.006, "m", None;
    }

    fn acceleration(&self, at: Point, velocity: Point, _time: f64) -> Point {
        let speed = velocity.norm();
        if speed < 1e-6 {
            return Point::default();
        }
        let across =
            (at.x - self.x - self.lean * at.y) / (1.0 + self.lean * self.lean).sqrt() / self.width;
        let peak = self.loss / (self.width * std::f64::consts::TAU.sqrt());
        velocity * (-peak * (-0.5 * across * across).exp() / speed)
    }
    fn grain_size(&self) -> f64 {
        self.width
    }
}

declare! {
    /// The impact makes the table ring: an acceleration that oscillates and dies away.
    Vibration = "vibration" {
        /// At the impact, in m/s².
        amplitude: 3.0, "m/s2", Some(0.0);
        frequency: 3.0, "Hz", None;
        /// Time in which it falls to 1/e, in s.
        decay: 0.5, "s", None;
        bearing: 1.3, "rad", None;
    }

    fn acceleration(&self, _at: Point, _velocity: Point, time: f64) -> Point {
        let ringing =
            (std::f64::consts::TAU * self.frequency * time).cos() * (-time / self.decay).exp();
        Point::polar(self.amplitude * ringing, self.bearing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jet_blows_where_it_is_and_nowhere_else() {
        let jet = AirJet::default();
        let here = jet.acceleration(Point::new(0.50, 0.05), Point::default(), 0.0);
        assert!(here.distance(Point::polar(1.2, 1.2)) < 1e-12);
        assert!(
            jet.acceleration(Point::new(0.9, 0.4), Point::default(), 0.0)
                .norm()
                < 1e-12
        );
    }

    #[test]
    fn crossing_the_line_head_on_costs_its_loss() {
        let line = StickyLine {
            lean: 0.0,
            ..StickyLine::default()
        };
        let step = 1e-5;
        let work: f64 = (0..20_000)
            .map(|i| {
                line.acceleration(
                    Point::new(0.38 + f64::from(i) * step, 0.1),
                    Point::new(0.5, 0.0),
                    0.0,
                )
                .x * step
            })
            .sum();
        assert!((work + 0.12).abs() < 1e-6, "work {work}");
    }

    #[test]
    fn ringing_dies_away() {
        let vibration = Vibration::default();
        let at = |time| {
            vibration
                .acceleration(Point::default(), Point::default(), time)
                .norm()
        };
        assert!((at(0.0) - 3.0).abs() < 1e-12);
        assert!((at(1.0) - 3.0 * (-2f64).exp()).abs() < 1e-9);
    }
}
