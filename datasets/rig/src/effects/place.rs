//! Friction that differs from place to place, in forms that are no disc.

use values::Point;

use super::acts::Acts;
use crate::declare::declare;

/// A share that rises from 0 to 1 over an edge: `distance` past it and `width` in m.
fn across_edge(distance: f64, width: f64) -> f64 {
    1.0 / (1.0 + (-2.0 * distance / width.max(1e-4)).exp())
}

declare! {
    /// A rectangular patch of the table with another friction; its edges are soft.
    RectangularPatch = "rectangular_patch" {
        center_x: 0.50, "m", None;
        center_y: 0.04, "m", None;
        half_length: 0.10, "m", None;
        half_width: 0.06, "m", None;
        bearing: 0.4, "rad", None;
        /// Relative change of friction inside.
        change: 0.35, "1", Some(0.0);
        edge: 0.006, "m", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, at: Point, _speed: f64) -> f64 {
        let arm = (at - Point::new(self.center_x, self.center_y)).rotated(-self.bearing);
        let inside = across_edge(self.half_length - arm.x.abs(), self.edge)
            * across_edge(self.half_width - arm.y.abs(), self.edge);
        1.0 + self.change * inside
    }
    fn grain_size(&self) -> f64 {
        self.edge.max(0.004)
    }
}

/// Where a gradient leaves friction as the rig's own: the middle of the demo's strikes, in m.
const MIDDLE: Point = Point { x: 0.45, y: 0.0 };

declare! {
    /// Friction grows by the same factor over each metre of the table: exp(g·(p − p₀)).
    FrictionGradient = "friction_gradient" {
        g_x: 0.15, "1/m", Some(0.0);
        g_y: 0.25, "1/m", Some(0.0);
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, at: Point, _speed: f64) -> f64 {
        Point::new(self.g_x, self.g_y).dot(at - MIDDLE).exp()
    }
}

declare! {
    /// Two sheets lie on the table: friction differs on the far side of an edge that may be bent.
    FrictionStep = "friction_step" {
        /// Where the edge crosses the x axis, in m.
        x: 0.46, "m", None;
        /// Its lean: x grows by this for each metre of y.
        lean: 0.3, "1", None;
        /// Its bend: x grows by this for each square metre of y², in 1/m.
        bend: 0.0, "1/m", None;
        /// Relative change of friction beyond it.
        change: 0.2, "1", Some(0.0);
        edge: 0.005, "m", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, at: Point, _speed: f64) -> f64 {
        let beyond = at.x - self.x - self.lean * at.y - self.bend * at.y * at.y;
        let slope = self.lean + 2.0 * self.bend * at.y;
        1.0 + self.change * across_edge(beyond / (1.0 + slope * slope).sqrt(), self.edge)
    }
    fn grain_size(&self) -> f64 {
        self.edge.max(0.004)
    }
}

/// Waves that a random field is the sum of.
const WAVES: usize = 7;

/// Waves whose sum is a random field of unit variance that changes over a length of 1 m: wave vector (1/m), phase (rad), amplitude. The
/// lengths are those at equal steps of the Rayleigh distribution, as a Gaussian spectrum has them; the directions go round in golden
/// angles from one that the seed sets.
pub(super) fn waves(seed: f64) -> impl Iterator<Item = (Point, f64, f64)> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let from_seed = move |step: f64| (seed * step).fract() * std::f64::consts::TAU;
    (0..WAVES).map(move |wave| {
        let share = (wave as f64 + 0.5) / WAVES as f64;
        let bearing = from_seed(0.618_034) + golden * wave as f64;
        (
            Point::polar((-2.0 * share.ln()).sqrt(), bearing),
            from_seed(0.754_878 + 0.569_84 * wave as f64),
            (2.0 / WAVES as f64).sqrt(),
        )
    })
}

declare! {
    /// Friction varies smoothly over the whole table: a factor exp(amplitude·f), with f a random field of unit variance.
    FrictionMap = "friction_map" {
        /// Standard deviation of the logarithm of friction.
        amplitude: 0.12, "1", Some(0.0);
        /// Length over which it changes, in m.
        length: 0.18, "m", None;
        /// Which field, any number.
        seed: 1.0, "1", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, at: Point, _speed: f64) -> f64 {
        let field: f64 = waves(self.seed)
            .map(|(vector, phase, size)| size * (vector.dot(at) / self.length + phase).cos())
            .sum();
        (self.amplitude * field).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_changes_friction_inside_and_half_of_it_on_its_edge() {
        let patch = RectangularPatch {
            bearing: 0.0,
            ..RectangularPatch::default()
        };
        let at = |x, y| patch.local_friction(Point::new(x, y), 0.5);
        assert!((at(0.50, 0.04) - 1.35).abs() < 1e-6);
        assert!((at(0.60, 0.04) - (1.0 + 0.35 / 2.0)).abs() < 1e-6);
        assert!((at(0.50, 0.10) - (1.0 + 0.35 / 2.0)).abs() < 1e-6);
        // A disc would not reach into the corner.
        assert!((at(0.59, 0.09) - 1.35).abs() < 0.03);
        assert!((at(0.8, 0.3) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_second_sheet_begins_at_the_bent_edge() {
        let step = FrictionStep {
            lean: 0.0,
            bend: 2.0,
            ..FrictionStep::default()
        };
        let at = |x, y| step.local_friction(Point::new(x, y), 0.5);
        assert!((at(0.46, 0.0) - 1.1).abs() < 1e-9);
        assert!((at(0.52, 0.0) - 1.2).abs() < 1e-6);
        assert!((at(0.48, 0.1) - 1.1).abs() < 1e-9);
        assert!((at(0.40, 0.1) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_field_has_its_standard_deviation_and_is_smooth() {
        let field = FrictionMap::default();
        let logs: Vec<f64> = (0..100)
            .flat_map(|i| (0..100).map(move |j| Point::new(0.1 * f64::from(i), 0.1 * f64::from(j))))
            .map(|at| field.local_friction(at, 0.5).ln())
            .collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let sd = (logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / logs.len() as f64).sqrt();
        assert!((sd / 0.12 - 1.0).abs() < 0.15, "{sd}");
        let near = |x| field.local_friction(Point::new(x, 0.0), 0.5);
        assert!((near(0.4) - near(0.41)).abs() < 0.02);
    }
}
