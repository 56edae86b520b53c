//! The impact: an impulse from a tip of infinite mass, with restitution and Coulomb friction.
//!
//! Newton's restitution along the contact normal; along the face the contact sticks if the impulse for that stays in the
//! friction cone, else it slips (Routh's solution without a reversal of slip, which one contact of compact bodies does not show).

use values::Point;

use crate::body::{Body, Outline};

/// Spin below this (rad/s) is rounding.
const NO_SPIN: f64 = 1e-9;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Tip {
    /// Radius in m.
    pub radius: f64,
    /// How far to the left of the object's centre its line passes, in m.
    pub offset: f64,
    /// Coefficient of friction between tip and object.
    pub friction: f64,
}

/// Velocity and spin after the impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Launch {
    /// Velocity of the centre in m/s.
    pub velocity: Point,
    /// Spin in rad/s, counter-clockwise.
    pub spin: f64,
    /// Distance from the tip's centre to the object's at the impact, along the line of motion, in m.
    pub gap: f64,
}

/// An impact at this velocity (m/s) along a line past the resting object's centre; `None` where the tip misses.
/// `restitution` is asked for with the speed of approach along the normal.
pub(crate) fn strike(
    body: &Body,
    tip: Tip,
    velocity: Point,
    restitution: impl Fn(f64) -> f64,
) -> Option<Launch> {
    let contact = touch(body.outline, tip, velocity.bearing())?;
    let Contact { arm, normal, gap } = contact;
    let tangent = normal.rotated(std::f64::consts::FRAC_PI_2);
    let (approach, along) = (velocity.dot(normal), velocity.dot(tangent));
    if approach <= 0.0 {
        return None;
    }
    // Velocity that an impulse over the mass (jn, jt) gives the touched point: K j.
    let lever = (cross(arm, normal), cross(arm, tangent));
    let knn = 1.0 + lever.0 * lever.0 / body.gyration;
    let knt = lever.0 * lever.1 / body.gyration;
    let ktt = 1.0 + lever.1 * lever.1 / body.gyration;
    let wanted = (1.0 + restitution(approach)) * approach;
    let determinant = knn * ktt - knt * knt;
    let stick = (
        (wanted * ktt - along * knt) / determinant,
        (along * knn - wanted * knt) / determinant,
    );
    let (jn, jt) = if stick.1.abs() <= tip.friction * stick.0 {
        stick
    } else {
        let slope = tip.friction.copysign(stick.1);
        let jn = wanted / (knn + slope * knt);
        (jn, slope * jn)
    };
    let spin = (lever.0 * jn + lever.1 * jt) / body.gyration;
    Some(Launch {
        velocity: normal * jn + tangent * jt,
        // A centred impact on a disc leaves no spin but rounding's, and without spin the slide is exact.
        spin: if spin.abs() < NO_SPIN { 0.0 } else { spin },
        gap,
    })
}

struct Contact {
    /// From the object's centre to the touched point, in m.
    arm: Point,
    /// Unit vector from the tip into the object.
    normal: Point,
    gap: f64,
}

/// Where a tip that comes along this bearing first touches.
fn touch(outline: Outline, tip: Tip, bearing: f64) -> Option<Contact> {
    let ahead = Point::polar(1.0, bearing);
    let aside = ahead.rotated(std::f64::consts::FRAC_PI_2) * tip.offset;
    match outline {
        Outline::Disc(radius) => {
            let reach = radius + tip.radius;
            let gap = (reach * reach - tip.offset * tip.offset).sqrt();
            if gap.is_nan() {
                return None;
            }
            let normal = (ahead * gap - aside) * (1.0 / reach);
            Some(Contact {
                arm: normal * -radius,
                normal,
                gap,
            })
        }
        Outline::Rectangle(x, y) => {
            let nearest = |p: Point| Point::new(p.x.clamp(-x, x), p.y.clamp(-y, y));
            // The distance to a convex outline is 1-Lipschitz, so stepping by it never jumps over the contact.
            let mut gap = 2.0 * (x.hypot(y) + tip.radius) + tip.offset.abs();
            for _ in 0..400 {
                let centre = aside - ahead * gap;
                let near = nearest(centre);
                let free = centre.distance(near) - tip.radius;
                if free < 1e-10 {
                    let inward = near - centre;
                    return Some(Contact {
                        arm: near,
                        normal: inward * (1.0 / inward.norm()),
                        gap,
                    });
                }
                gap -= free;
                if gap < 0.0 {
                    return None;
                }
            }
            None
        }
    }
}

fn cross(a: Point, b: Point) -> f64 {
    a.x * b.y - a.y * b.x
}

#[cfg(test)]
mod tests {
    use values::{Rig, Shape};

    use super::*;

    fn launch(shape: Shape, angle: f64, offset: f64, friction: f64) -> Launch {
        let body = Body::new(&Rig::demo(shape).object).expect("demo sizes");
        let tip = Tip {
            radius: 0.012,
            offset,
            friction,
        };
        strike(&body, tip, Point::polar(0.8, angle), |_| 0.5).expect("a hit")
    }

    #[test]
    fn a_centred_blow_launches_a_disc_along_its_line() {
        let launch = launch(Shape::Cylinder, 0.4, 0.0, 0.3);
        assert!(launch.velocity.distance(Point::polar(1.2, 0.4)) < 1e-12);
        assert_eq!(launch.spin, 0.0);
    }

    #[test]
    fn a_smooth_tip_passing_left_drives_a_disc_to_the_right_by_the_contact_angle() {
        let launch = launch(Shape::Cylinder, 0.0, 0.004, 0.0);
        let expected = -(0.004f64 / 0.042).asin();
        assert!((launch.velocity.bearing() - expected).abs() < 1e-12);
        assert_eq!(launch.spin, 0.0);
    }

    #[test]
    fn a_rough_tip_turns_a_disc_and_halves_no_more_than_a_third_of_the_tangent_speed() {
        // A solid disc that sticks takes 1/(1 + R²/k²) = 1/3 of the tip's tangential speed.
        let contact = (0.004f64 / 0.042).asin();
        let launch = launch(Shape::Cylinder, 0.0, 0.004, 0.5);
        let normal = Point::polar(1.0, -contact);
        let tangent = normal.rotated(std::f64::consts::FRAC_PI_2);
        assert!((launch.velocity.dot(normal) - 1.2 * contact.cos()).abs() < 1e-12);
        assert!((launch.velocity.dot(tangent) - 0.8 * contact.sin() / 3.0).abs() < 1e-12);
        assert!(
            launch.spin < 0.0,
            "pushed leftwards on its near side, it turns clockwise"
        );
    }

    #[test]
    fn a_box_struck_at_an_angle_by_a_slipping_tip_leaves_along_the_edge_of_the_friction_cone() {
        let slipping = launch(Shape::Box, 0.4, 0.0, 0.2);
        assert!((slipping.velocity.bearing() - 0.2f64.atan()).abs() < 1e-12);
        let smooth = launch(Shape::Box, 0.4, 0.0, 0.0);
        assert!(
            smooth.velocity.bearing().abs() < 1e-12,
            "no friction, no sideways impulse"
        );
        assert!(
            smooth.spin > 0.0,
            "pushed below its centre towards +x, it turns counter-clockwise"
        );
    }

    #[test]
    fn a_box_struck_at_an_angle_by_a_sticking_tip_keeps_its_touched_point_on_the_line() {
        let body = Body::new(&Rig::demo(Shape::Box).object).expect("demo sizes");
        let tip = Tip {
            radius: 0.012,
            offset: 0.0,
            friction: 0.9,
        };
        let launch = strike(&body, tip, Point::polar(0.8, 0.4), |_| 0.5).expect("a hit");
        let arm = touch(body.outline, tip, 0.4).expect("a hit").arm;
        let touched = launch.velocity + arm.rotated(std::f64::consts::FRAC_PI_2) * launch.spin;
        assert!((touched.y - 0.8 * 0.4f64.sin()).abs() < 1e-9);
        assert!(
            (arm.y + 0.042 * 0.4f64.tan()).abs() < 1e-9,
            "it is touched on its near face below the middle"
        );
    }

    #[test]
    fn the_touched_point_leaves_at_the_restitution_speed() {
        let launch = launch(Shape::Box, 0.3, 0.002, 0.2);
        let body = Body::new(&Rig::demo(Shape::Box).object).expect("demo sizes");
        let tip = Tip {
            radius: 0.012,
            offset: 0.002,
            friction: 0.2,
        };
        let contact = touch(body.outline, tip, 0.3).expect("a hit");
        let touched =
            launch.velocity + contact.arm.rotated(std::f64::consts::FRAC_PI_2) * launch.spin;
        let approach = Point::polar(0.8, 0.3).dot(contact.normal);
        assert!((touched.dot(contact.normal) - 1.5 * approach).abs() < 1e-12);
    }

    #[test]
    fn a_tip_that_passes_by_misses() {
        let body = Body::new(&Rig::demo(Shape::Cylinder).object).expect("demo sizes");
        let tip = Tip {
            radius: 0.012,
            offset: 0.05,
            friction: 0.2,
        };
        assert!(strike(&body, tip, Point::new(1.0, 0.0), |_| 0.5).is_none());
    }
}
