//! Where the tip may go: the disc that it sweeps along a path, against the table, the base, the reach and the obstacles. And where the object may
//! slide: beside the obstacles.

use values::{Interval, Obstacle, Point, Rig};

use crate::Reason;
use crate::limits::{BrokenLimit, place, range, refuse_if};
use crate::robot::arm::MARGIN;

/// Radius in m about the base's axis that the tip keeps clear of where the rig file states none: the foot of a small arm.
const KEEP_OUT: f64 = 0.1;

/// Checks that a tip of the rig's radius may move along this path: straight lines between points (m). `what` names the path's points.
pub(crate) fn path(rig: &Rig, what: &[(&str, Point)]) -> Result<(), BrokenLimit> {
    what.iter()
        .try_for_each(|(name, at)| point(rig, name, *at))?;
    what.windows(2).try_for_each(|ends| {
        let [(from, a), (to, b)] = [ends[0], ends[1]];
        segment(
            rig,
            &format!("from its `{from}` {} to its `{to}` {}", place(a), place(b)),
            a,
            b,
        )
    })
}

/// Checks what holds for a path if it holds for its corners: the area, and the farthest reach.
fn point(rig: &Rig, name: &str, at: Point) -> Result<(), BrokenLimit> {
    let (table, robot, radius) = (&rig.table, &rig.robot, rig.striker.radius);
    let base = robot.base.unwrap_or_default();
    // An arm that says where it stands may reach out from there to the table.
    let low = if robot.is_placed() {
        table.x.low.min(base.x)
    } else {
        table.x.low
    };
    let x = Interval {
        low,
        high: table.x.high,
    };
    let is_inside = |bounds: Interval, value: f64| {
        bounds.low <= value - radius && value + radius <= bounds.high
    };
    let is_inside = is_inside(x, at.x) && is_inside(table.y, at.y);
    refuse_if(!is_inside, Reason::Reach, || {
        let area = if robot.is_placed() {
            "the table, and up to the arm's base"
        } else {
            "the table; a rig file that states robot.base and robot.keep_out lets the tip reach out from the base"
        };
        format!(
            "the tip, of radius {radius} m, leaves its area at its `{name}` {}, x in {} and y in {} m ({area})",
            place(at),
            range(x),
            range(table.y)
        )
    })?;
    let distance = at.distance(base);
    robot.reach.map_or(Ok(()), |reach| {
        refuse_if(distance > reach.high, Reason::Reach, || {
            format!(
                "the tip's `{name}` {} is {distance:.4} m from the base's axis, robot.reach is {} m",
                place(at),
                range(reach)
            )
        })
    })
}

/// Checks what must hold at every point of a straight line.
fn segment(rig: &Rig, line: &str, a: Point, b: Point) -> Result<(), BrokenLimit> {
    let (robot, radius) = (&rig.robot, rig.striker.radius);
    let base = robot.base.unwrap_or_default();
    let nearest = to_segment(base, a, b);
    let (keep_out, margin) = robot
        .keep_out
        .map_or((KEEP_OUT, 0.0), |keep_out| (keep_out, MARGIN));
    let is_near = nearest < keep_out + radius + margin;
    refuse_if(is_near, Reason::KeepOut, || {
        let from = match robot.keep_out {
            Some(_) => "robot.keep_out is",
            None => "robot.keep_out is not stated, and then",
        };
        format!(
            "{line} the tip, of radius {radius} m, comes within {:.4} m of the base's axis; {from} {keep_out} m, and {margin} m more for \
             what the arm may be off its line",
            (nearest - radius).max(0.0)
        )
    })?;
    if let Some(reach) = robot.reach {
        refuse_if(nearest < reach.low, Reason::Reach, || {
            format!(
                "{line} the tip's centre comes within {nearest:.4} m of the base's axis, robot.reach is {} m",
                range(reach)
            )
        })?;
    }
    for (number, obstacle) in robot.obstacles.iter().enumerate() {
        let gap = beside(*obstacle, a, b);
        refuse_if(gap < radius + MARGIN, Reason::Obstacle, || {
            format!(
                "{line} the tip, of radius {radius} m, meets obstacle {} of robot.obstacles ({obstacle}): its centre comes \
                 within {:.4} m, and {MARGIN} m beside the tip are kept for what the arm may be off its line",
                number + 1,
                gap.max(0.0)
            )
        })?;
    }
    Ok(())
}

/// Checks that an object may slide from here to there (m), whatever way it is turned.
pub(crate) fn object(rig: &Rig, from: Point, to: Point) -> Result<(), BrokenLimit> {
    let half_width = rig.object.solid.reach();
    for (number, obstacle) in rig.robot.obstacles.iter().enumerate() {
        let gap = beside(*obstacle, from, to);
        refuse_if(gap < half_width, Reason::Obstacle, || {
            format!(
                "on its way from {} to {} the object, {half_width:.4} m from its centre to its edge at the most, meets obstacle {} of \
                 robot.obstacles ({obstacle}): its centre comes within {:.4} m; lay it elsewhere, or take another target",
                place(from),
                place(to),
                number + 1,
                gap.max(0.0)
            )
        })?;
    }
    Ok(())
}

/// Distance in m from an obstacle to the line between two points; 0 or less where the line enters it.
fn beside(obstacle: Obstacle, a: Point, b: Point) -> f64 {
    match obstacle {
        Obstacle::Disc { centre, radius } => to_segment(centre, a, b) - radius,
        Obstacle::Box { x, y } => box_to_segment(x, y, a, b),
    }
}

/// Distance in m from a point to the line between two.
fn to_segment(point: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let share = (point - a).dot(along) / along.dot(along).max(f64::MIN_POSITIVE);
    point.distance(a + along * share.clamp(0.0, 1.0))
}

/// Distance in m from a box to the line between two points; 0 where the line enters it.
fn box_to_segment(x: Interval, y: Interval, a: Point, b: Point) -> f64 {
    if enters(x, y, a, b) {
        return 0.0;
    }
    let outside = |at: Point| at.distance(Point::new(x.clamp(at.x), y.clamp(at.y)));
    let corners = [
        Point::new(x.low, y.low),
        Point::new(x.low, y.high),
        Point::new(x.high, y.low),
        Point::new(x.high, y.high),
    ];
    corners
        .into_iter()
        .map(|corner| to_segment(corner, a, b))
        .chain([outside(a), outside(b)])
        .fold(f64::INFINITY, f64::min)
}

/// Whether the line between two points has a point in a box (Liang and Barsky, 1984).
fn enters(x: Interval, y: Interval, a: Point, b: Point) -> bool {
    let along = b - a;
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for (from, step, bounds) in [(a.x, along.x, x), (a.y, along.y, y)] {
        if step == 0.0 {
            if !bounds.contains(from) {
                return false;
            }
            continue;
        }
        let (one, other) = ((bounds.low - from) / step, (bounds.high - from) / step);
        first = first.max(one.min(other));
        last = last.min(one.max(other));
    }
    first <= last
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    fn check(change: impl FnOnce(&mut Rig), a: [f64; 2], b: [f64; 2]) -> Option<Reason> {
        let mut rig = Rig::demo(Shape::Cylinder);
        change(&mut rig);
        path(&rig, &[("start", a.into()), ("stop", b.into())])
            .err()
            .map(|(reason, _)| reason)
    }

    #[test]
    fn the_tip_stays_over_the_table_with_its_whole_radius() {
        // The demo's table is x in [0.1, 1.0], y in [-0.6, 0.6]; its tip has a radius of 12 mm.
        assert_eq!(check(|_| (), [0.3, 0.0], [0.98, 0.0]), None);
        assert_eq!(check(|_| (), [0.3, 0.0], [0.99, 0.0]), Some(Reason::Reach));
        assert_eq!(check(|_| (), [0.11, 0.0], [0.5, 0.0]), Some(Reason::Reach));
        assert_eq!(check(|_| (), [0.3, 0.59], [0.5, 0.0]), Some(Reason::Reach));
    }

    #[test]
    fn an_arm_that_says_where_it_stands_reaches_out_from_there() {
        let placed = |rig: &mut Rig| {
            rig.robot.base = Some(Point::new(-0.3, 0.0));
            rig.robot.keep_out = Some(0.2);
        };
        assert_eq!(check(placed, [-0.05, 0.0], [0.5, 0.0]), None);
        assert_eq!(
            check(placed, [-0.09, 0.0], [0.5, 0.0]),
            Some(Reason::KeepOut)
        );
        assert_eq!(check(placed, [-0.4, 0.3], [0.5, 0.0]), Some(Reason::Reach));
    }

    #[test]
    fn the_base_is_kept_clear_of_between_the_ends_of_a_line_too() {
        let placed = |rig: &mut Rig| rig.robot.base = Some(Point::new(0.5, 0.0));
        assert_eq!(
            check(placed, [0.5, -0.3], [0.5, 0.3]),
            Some(Reason::KeepOut)
        );
        assert_eq!(check(placed, [0.3, -0.3], [0.3, 0.3]), None);
        let reach = |rig: &mut Rig| rig.robot.reach = Some([0.3, 0.6].into());
        assert_eq!(check(reach, [0.4, 0.0], [0.55, 0.0]), None);
        assert_eq!(check(reach, [0.4, 0.0], [0.7, 0.0]), Some(Reason::Reach));
        assert_eq!(check(reach, [0.25, -0.4], [0.25, 0.4]), Some(Reason::Reach));
    }

    #[test]
    fn an_object_slides_beside_obstacles_alone() {
        let mut rig = Rig::demo(Shape::Cylinder);
        let (from, to) = (Point::new(0.3, 0.0), Point::new(0.7, 0.0));
        let reach = rig.object.solid.reach();
        for (gap, is_met) in [(reach - 1e-3, true), (reach + 1e-3, false)] {
            for obstacle in [
                Obstacle::Disc {
                    centre: Point::new(0.5, 0.05 + gap),
                    radius: 0.05,
                },
                Obstacle::Box {
                    x: Interval {
                        low: 0.65,
                        high: 0.9,
                    },
                    y: Interval {
                        low: gap,
                        high: 0.3,
                    },
                },
            ] {
                rig.robot.obstacles = vec![obstacle];
                let met = object(&rig, from, to);
                assert_eq!(met.is_err(), is_met, "{obstacle:?}: {met:?}");
            }
        }
    }

    #[test]
    fn obstacles_are_met_with_the_tips_radius_wherever_the_line_passes() {
        let disc = |rig: &mut Rig| {
            rig.robot.obstacles = vec![Obstacle::Disc {
                centre: Point::new(0.5, 0.06),
                radius: 0.05,
            }];
        };
        assert_eq!(check(disc, [0.3, 0.0], [0.7, 0.0]), Some(Reason::Obstacle));
        // Clear by 6 mm, less than the arm may be off its line and brakes in; and by 8 mm.
        assert_eq!(
            check(disc, [0.3, -0.008], [0.7, -0.008]),
            Some(Reason::Obstacle)
        );
        assert_eq!(check(disc, [0.3, -0.010], [0.7, -0.010]), None);
        let slab = |rig: &mut Rig| {
            rig.robot.obstacles = vec![Obstacle::Box {
                x: [0.4, 0.5].into(),
                y: [0.1, 0.2].into(),
            }];
        };
        for (a, b, met) in [
            ([0.3, 0.15], [0.7, 0.15], true),
            ([0.45, 0.15], [0.46, 0.15], true),
            ([0.3, 0.082], [0.7, 0.082], true),
            ([0.3, 0.080], [0.7, 0.080], false),
            // Past a corner, at 10 mm and at 20 mm.
            ([0.5, 0.21414], [0.51414, 0.2], true),
            ([0.5, 0.2283], [0.5283, 0.2], false),
        ] {
            let expected = met.then_some(Reason::Obstacle);
            assert_eq!(check(slab, a, b), expected, "{a:?} {b:?}");
        }
    }
}
