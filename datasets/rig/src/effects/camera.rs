//! Effects on what the camera reports.

use values::Point;

use super::acts::Acts;
use crate::StrikeIndex;
use crate::declare::declare;

declare! {
    /// The camera is turned about the point it looks down on.
    CameraRotation = "camera_rotation" {
        /// Counter-clockwise turn of what it reports, in rad.
        angle: 0.015, "rad", Some(0.0);
    }

    fn see(&self, at: Point, centre: Point, _when: StrikeIndex) -> Point {
        centre + (at - centre).rotated(self.angle)
    }
}

declare! {
    /// The lens stretches outwards: r → r/(1 − k1·r²), the division model, r·(1 + k1·r²) to first order.
    CameraDistortion = "camera_distortion" {
        /// In 1/m².
        k1: 0.08, "1/m2", Some(0.0);
    }

    fn see(&self, at: Point, centre: Point, _when: StrikeIndex) -> Point {
        let arm = at - centre;
        centre + arm * (1.0 / (1.0 - self.k1 * arm.dot(arm)).max(0.1))
    }
}

declare! {
    /// The camera does not look straight down: the perspective of a pinhole that leans about the point it looks at.
    CameraLean = "camera_lean" {
        /// How far its axis leans, in rad.
        lean: 0.035, "rad", Some(0.0);
        bearing: 0.6, "rad", None;
        /// Distance from the camera to the table, in m.
        height: 1.2, "m", None;
    }

    fn see(&self, at: Point, centre: Point, _when: StrikeIndex) -> Point {
        let arm = (at - centre).rotated(-self.bearing);
        // Depth along the optical axis: what lies farther is seen smaller, and foreshortened along the lean.
        let depth = (self.height + arm.x * self.lean.sin()).max(0.1 * self.height);
        let scale = self.height / depth;
        centre + Point::new(arm.x * self.lean.cos() * scale, arm.y * scale).rotated(self.bearing)
    }
}

declare! {
    /// A lens after Brown and Conrady: two radial orders, and the tangential ones of a lens that is not centred.
    BrownLens = "brown_lens" {
        /// Radial, second order, in 1/m².
        k1: -0.10, "1/m2", Some(0.0);
        /// Radial, fourth order, in 1/m⁴.
        k2: 0.08, "1/m4", Some(0.0);
        p1: 0.003, "1/m", Some(0.0);
        p2: -0.002, "1/m", Some(0.0);
    }

    fn see(&self, at: Point, centre: Point, _when: StrikeIndex) -> Point {
        let arm = at - centre;
        let square = arm.dot(arm);
        let radial = 1.0 + square * (self.k1 + square * self.k2);
        let aside = Point::new(
            2.0 * self.p1 * arm.x * arm.y + self.p2 * (square + 2.0 * arm.x * arm.x),
            self.p1 * (square + 2.0 * arm.y * arm.y) + 2.0 * self.p2 * arm.x * arm.y,
        );
        centre + arm * radial + aside
    }
}

declare! {
    /// A lens whose middle is not where the camera looks: it stretches outwards from there, r·(1 + k1·r²).
    OffCentreLens = "off_centre_lens" {
        /// In 1/m².
        k1: 0.08, "1/m2", Some(0.0);
        /// From the camera's centre to the lens's, in m.
        off_x: 0.10, "m", None;
        /// From the camera's centre to the lens's, in m.
        off_y: -0.08, "m", None;
    }

    fn see(&self, at: Point, centre: Point, _when: StrikeIndex) -> Point {
        let middle = centre + Point::new(self.off_x, self.off_y);
        let arm = at - middle;
        middle + arm * (1.0 + self.k1 * arm.dot(arm)).max(0.1)
    }
}

declare! {
    /// The camera was calibrated with a board of another size: all that it reports is larger by a share.
    CameraScale = "camera_scale" {
        /// Share by which lengths are too long.
        excess: 0.03, "1", Some(0.0);
    }

    fn see(&self, at: Point, centre: Point, _when: StrikeIndex) -> Point {
        centre + (at - centre) * (1.0 + self.excess)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_stays_and_the_rest_turns_or_stretches() {
        let centre = Point::new(0.45, 0.0);
        let at = Point::new(0.95, 0.0);
        let turned = CameraRotation { angle: 0.1 }.see(at, centre, StrikeIndex::default());
        assert!(turned.distance(centre + Point::polar(0.5, 0.1)) < 1e-12);
        let stretched = CameraDistortion { k1: 0.08 }.see(at, centre, StrikeIndex::default());
        assert!((stretched.x - (0.45 + 0.5 / (1.0 - 0.02))).abs() < 1e-12);
        assert_eq!(
            CameraDistortion::default().see(centre, centre, StrikeIndex::default()),
            centre
        );
    }

    fn seen(effect: &dyn Acts, x: f64, y: f64) -> Point {
        effect.see(
            Point::new(0.45 + x, y),
            Point::new(0.45, 0.0),
            StrikeIndex::default(),
        ) - Point::new(0.45, 0.0)
    }

    #[test]
    fn what_lies_farther_from_a_leaning_camera_looks_smaller() {
        let lean = CameraLean {
            bearing: 0.0,
            ..CameraLean::default()
        };
        assert_eq!(seen(&lean, 0.0, 0.0), Point::default());
        let (far, near) = (seen(&lean, 0.3, 0.1).y, seen(&lean, -0.3, 0.1).y);
        assert!((far - 0.1 / (1.0 + 0.3 * 0.035f64.sin() / 1.2)).abs() < 1e-12);
        assert!(near > 0.1);
    }

    #[test]
    fn a_lens_follows_its_polynomial_and_a_scale_stretches() {
        let lens = BrownLens {
            p1: 0.0,
            p2: 0.0,
            ..BrownLens::default()
        };
        assert!((seen(&lens, 0.5, 0.0).x - 0.5 * (1.0 - 0.025 + 0.005)).abs() < 1e-12);
        assert!((seen(&CameraScale::default(), 0.2, -0.1).x - 0.206).abs() < 1e-12);
    }
}
