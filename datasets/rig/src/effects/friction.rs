//! Effects on friction.

use values::Point;

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

declare! {
    /// Friction is higher at low speed (Stribeck): a factor 1 + delta·exp(−(v/v_s)^exponent).
    SpeedWeakeningFriction = "speed_weakening_friction" {
        /// Relative rise at rest.
        delta: 0.3, "1", Some(0.0);
        /// Speed at which the rise has fallen to 1/e, in m/s.
        v_s: 0.4, "m/s", None;
        /// 2 is the usual Stribeck curve.
        exponent: 1.5, "1", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, _at: Point, speed: f64) -> f64 {
        // A power by exp and ln: half the time of `powf`, whose last digits nothing here needs.
        let power = (self.exponent * (speed / self.v_s).ln()).exp();
        1.0 + self.delta * (-power).exp()
    }
}

declare! {
    /// Friction differs along and across a grain: an elliptic limit surface, friction opposing motion at most power.
    AnisotropicFriction = "anisotropic_friction" {
        /// Friction across less friction along, over their mean.
        contrast: 0.12, "1", Some(0.0);
        /// Bearing of the grain, in rad.
        direction: 0.5, "rad", None;
    }

    fn grain(&self) -> Option<(f64, [f64; 2])> {
        Some((
            self.direction,
            [1.0 - self.contrast / 2.0, 1.0 + self.contrast / 2.0],
        ))
    }
}

/// Beyond this many edge widths a patch is all or nothing (to 1e-4).
const PATCH_EDGES: f64 = 5.0;

declare! {
    /// A patch of the table with another friction: an ellipse whose edge is soft.
    FrictionPatch = "friction_patch" {
        center_x: 0.50, "m", None;
        center_y: 0.04, "m", None;
        /// Radius of the disc of equal area, in m.
        radius: 0.09, "m", None;
        /// Relative change of friction inside.
        change: 0.35, "1", Some(0.0);
        /// Long axis (along y) over the short one.
        stretch: 1.3, "1", None;
        edge: 0.012, "m", None;
    }

    fn is_local(&self) -> bool {
        true
    }
    fn local_friction(&self, at: Point, _speed: f64) -> f64 {
        let stretch = self.stretch.sqrt();
        let (x, y) = (
            (at.x - self.center_x) * stretch,
            (at.y - self.center_y) / stretch,
        );
        let outside = ((x * x + y * y).sqrt() - self.radius) / self.edge.max(1e-4);
        if outside > PATCH_EDGES {
            1.0
        } else {
            1.0 + self.change / (1.0 + (2.0 * outside).exp())
        }
    }
    fn grain_size(&self) -> f64 {
        self.edge
    }
}

declare! {
    /// Friction changes from strike to strike and settles: factor 1 + change·(1 − e^(−n/over))/(1 − 1/e).
    FrictionDrift = "friction_drift" {
        /// Relative change after `over` strikes.
        change: 0.2, "1", Some(0.0);
        /// Number of strikes.
        over: 120.0, "1", None;
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        let settled = 1.0 - (-(index.order as f64) / self.over).exp();
        1.0 + self.change * settled / (1.0 - (-1f64).exp())
    }
}

declare! {
    /// Friction differs from session to session: factor 1 + spread·z with a fixed series z in [−1, 1].
    FrictionBySession = "friction_by_session" {
        /// Relative size of the differences.
        spread: 0.12, "1", Some(0.0);
    }

    fn strike_friction(&self, index: StrikeIndex) -> f64 {
        // Steps of the golden ratio visit [−1, 1] without a pattern; the first sessions are 1, −0.36, −0.74, 0.90.
        let golden = (5f64.sqrt() - 1.0) / 2.0;
        1.0 + self.spread * (std::f64::consts::PI * golden * index.session as f64).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weakening_adds_delta_at_rest_and_a_share_of_1_over_e_at_its_speed() {
        let effect = SpeedWeakeningFriction::default();
        let at = |speed| effect.local_friction(Point::default(), speed);
        assert!((at(0.0) - 1.3).abs() < 1e-12);
        assert!((at(0.4) - (1.0 + 0.3 / std::f64::consts::E)).abs() < 1e-12);
        assert!((at(3.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_patch_changes_friction_inside_an_ellipse_of_its_radius() {
        let patch = FrictionPatch::default();
        let at = |x, y| patch.local_friction(Point::new(x, y), 0.5);
        assert!((at(0.50, 0.04) - 1.35).abs() < 1e-3);
        let long = 0.09 * 1.3f64.sqrt();
        assert!((at(0.50, 0.04 + long) - (1.0 + 0.35 / 2.0)).abs() < 1e-9);
        assert!((at(0.50 + 0.09 / 1.3f64.sqrt(), 0.04) - (1.0 + 0.35 / 2.0)).abs() < 1e-9);
        assert_eq!(at(0.8, 0.3), 1.0);
    }

    #[test]
    fn drift_reaches_its_change_after_its_strikes() {
        let drift = FrictionDrift::default();
        let at = |order| drift.strike_friction(StrikeIndex { session: 0, order });
        assert_eq!(at(0), 1.0);
        assert!((at(120) - 1.2).abs() < 1e-12);
        assert!(at(60) > 1.1, "more of it in the first half");
    }

    #[test]
    fn sessions_differ_within_the_spread() {
        let effect = FrictionBySession::default();
        let factors: Vec<f64> = (0..4)
            .map(|session| effect.strike_friction(StrikeIndex { session, order: 0 }))
            .collect();
        assert_eq!(factors[0], 1.12);
        assert!(factors.iter().all(|f| (f - 1.0).abs() <= 0.12 + 1e-12));
        assert!(factors[1] < 1.0 && factors[2] < factors[1] && factors[3] > 1.0);
    }
}
