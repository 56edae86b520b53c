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
}

impl Acts for CameraRotation {
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
}

impl Acts for CameraDistortion {
    fn see(&self, at: Point, centre: Point, _when: StrikeIndex) -> Point {
        let arm = at - centre;
        centre + arm * (1.0 / (1.0 - self.k1 * arm.dot(arm)).max(0.1))
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
}
