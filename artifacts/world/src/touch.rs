//! Where the tip's centre is when it first touches the resting object.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use values::{Interval, Object, Point, Shape, Solid, Striker};

/// Distance in metres, back along the line of approach, from the point of the line nearest the object's centre to the
/// tip's centre at touch. `direction` is a unit vector; `offset` (m) shifts the line to the left of the object's centre.
/// `None` where the line misses the object.
pub(crate) fn standoff(
    object: &Object,
    striker: &Striker,
    direction: Point,
    offset: f64,
) -> Option<f64> {
    match object.solid {
        // A rod touches a ball at its equator; a ball-shaped tip travels at the height of the centre too.
        Solid::Cylinder { radius, .. } | Solid::Sphere { radius } => {
            chord(radius + striker.radius, offset)
        }
        Solid::Box {
            half_size: [half_x, half_y, _],
        } => rounded_box(half_x, half_y, striker.radius, direction, offset),
    }
}

fn chord(radius: f64, offset: f64) -> Option<f64> {
    let square = radius * radius - offset * offset;
    (square > 0.0).then(|| square.sqrt())
}

/// A line against the box grown by the tip's radius: the first point at which the distance to the box is the radius.
fn rounded_box(
    half_x: f64,
    half_y: f64,
    radius: f64,
    direction: Point,
    offset: f64,
) -> Option<f64> {
    let gap = |back: f64| {
        let point = direction * -back + Point::new(-direction.y, direction.x) * offset;
        let outside = Point::new(
            (point.x.abs() - half_x).max(0.0),
            (point.y.abs() - half_y).max(0.0),
        );
        outside.norm() - radius
    };
    let far = half_x + half_y + 2.0 * radius + offset.abs();
    // The grown box is convex: walking in from afar the gap falls to its least, which must be reached below zero.
    let steps = 400;
    let inside = (0..=steps)
        .map(|i| far * (1.0 - i as f64 / steps as f64))
        .find(|&back| gap(back) < 0.0)?;
    let (mut low, mut high) = (inside, far);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gap(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(high)
}

/// Share of its radius by which a tip stays clear of a face's edge, so as not to slip over it.
const CLEAR: f64 = 0.5;

/// Angles of approach (rad, around `bearing`) at which the tip meets the face of a box that faces a path of this bearing;
/// `offset` (m) as in [`standoff`]. `None` for a round object.
pub(crate) fn face(
    object: &Object,
    striker: &Striker,
    offset: f64,
    bearing: f64,
) -> Option<Interval> {
    let [half_x, half_y] = object.solid.half_sides()?;
    let faces = [
        (half_x, half_y),
        (half_y, half_x),
        (half_x, half_y),
        (half_y, half_x),
    ];
    let limits = faces.iter().zip(0..).map(|((depth, width), quarter)| {
        // The tip touches `width` beside the middle where depth·sin θ ∓ width·cos θ = offset.
        let depth = depth + striker.radius;
        let width = width - CLEAR * striker.radius;
        let middle = (offset / depth.hypot(width)).clamp(-1.0, 1.0).asin();
        let half = width.atan2(depth);
        let aside = (bearing - f64::from(quarter) * FRAC_PI_2 - middle + PI).rem_euclid(TAU) - PI;
        (aside, half)
    });
    limits
        .min_by(|a, b| (a.0.abs() - a.1).total_cmp(&(b.0.abs() - b.1)))
        .map(|(aside, half)| Interval::new(bearing - aside - half, bearing - aside + half))
}

/// Where tip and object are nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Width of the gap in m; below zero where they overlap.
    pub(crate) gap: f64,
    /// From the object's centre to its point next to the tip, in m.
    pub(crate) arm: Point,
    pub(crate) normal: Point,
}

/// Where a tip whose centre is at `tip` and an object at `centre`, turned by `yaw` (rad), are nearest. A tip's centre inside
/// the object has no normal: zero.
pub(crate) fn nearest(
    object: &Object,
    striker: &Striker,
    centre: Point,
    yaw: f64,
    tip: Point,
) -> Nearest {
    let away = (tip - centre).rotated(-yaw);
    let arm = match object.solid {
        Solid::Cylinder { radius, .. } | Solid::Sphere { radius } => {
            away * (radius / away.norm().max(1e-12))
        }
        Solid::Box {
            half_size: [x, y, _],
        } => Point::new(away.x.clamp(-x, x), away.y.clamp(-y, y)),
    };
    let outwards = away - arm;
    let outside = match object.shape() {
        Shape::Cylinder | Shape::Sphere => away.norm() - arm.norm(),
        Shape::Box => outwards.norm(),
    };
    Nearest {
        gap: outside - striker.radius,
        arm: arm.rotated(yaw),
        normal: (outwards * (-1.0 / outside.abs().max(1e-12))).rotated(yaw),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use values::Rig;

    #[test]
    fn a_tip_touches_a_box_at_its_face() {
        let rig = Rig::demo(Shape::Box);
        let [half_x, _] = rig.object.solid.half_sides().expect("a box");
        let head_on = standoff(&rig.object, &rig.striker, Point::new(1.0, 0.0), 0.0).expect("hits");
        assert!((head_on - half_x - rig.striker.radius).abs() < 1e-9);
        let angle: f64 = 0.4;
        let oblique =
            standoff(&rig.object, &rig.striker, Point::polar(1.0, angle), 0.0).expect("hits");
        assert!((oblique - (half_x + rig.striker.radius) / angle.cos()).abs() < 1e-9);
    }

    #[test]
    fn a_box_is_struck_on_the_face_that_the_path_leaves_behind() {
        let rig = Rig::demo(Shape::Box);
        let [half_x, half_y] = rig.object.solid.half_sides().expect("a box");
        let face = |offset, bearing| {
            face(&rig.object, &rig.striker, offset, bearing).expect("a box has faces")
        };
        let clear = half_y - CLEAR * rig.striker.radius;
        let edge = (clear / (half_x + rig.striker.radius)).atan();
        assert!((face(0.0, 0.2).high - edge).abs() < 1e-9);
        assert!((face(0.0, -0.7).low + edge).abs() < 1e-9);
        assert!((face(0.0, 1.2).low - (FRAC_PI_2 - edge)).abs() < 1e-9);
        assert!((face(0.0, 3.1).low - (PI - edge)).abs() < 1e-9);
        // Where a tip that is led 4 mm to the left of the centre meets the face.
        let aside = face(0.004, 0.0);
        let touched =
            |angle: f64| -(half_x + rig.striker.radius) * angle.tan() + 0.004 / angle.cos();
        assert!((touched(aside.low) - clear).abs() < 1e-9);
        assert!((touched(aside.high) + clear).abs() < 1e-9);
    }

    #[test]
    fn a_line_beside_the_object_misses() {
        let rig = Rig::demo(Shape::Cylinder);
        assert!(standoff(&rig.object, &rig.striker, Point::new(1.0, 0.0), 0.05).is_none());
    }

    #[test]
    fn the_gap_of_a_turned_box_is_that_to_its_corner() {
        let rig = Rig::demo(Shape::Box);
        let [half_x, half_y] = rig.object.solid.half_sides().expect("a box");
        let centre = Point::new(0.4, 0.1);
        let yaw = std::f64::consts::FRAC_PI_4;
        let reach = half_x.hypot(half_y);
        let tip = centre - Point::new(reach + rig.striker.radius + 0.003, 0.0);
        let Nearest { gap, arm, normal } = nearest(&rig.object, &rig.striker, centre, yaw, tip);
        assert!((gap - 0.003).abs() < 1e-9, "{gap}");
        assert!(arm.distance(Point::new(-reach, 0.0)) < 1e-9, "{arm:?}");
        assert!(normal.distance(Point::new(1.0, 0.0)) < 1e-9, "{normal:?}");
    }
}
