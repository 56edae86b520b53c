//! The object's yaw, from poses.

use std::f64::consts::TAU;

use values::Yaw;

use crate::order::{Stamped, since};

/// How the object was turned at a stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct YawSample {
    pub(crate) stamp: i64,
    /// Yaw of the object, in rad, within ±π.
    pub(crate) yaw: f64,
}

impl Stamped for YawSample {
    fn stamp(&self) -> i64 {
        self.stamp
    }
}

impl YawSample {
    /// A sample from a quaternion x, y, z, w; `None` where it is none.
    pub(crate) fn of(stamp: i64, quaternion: [f64; 4]) -> Option<Self> {
        yaw_of(quaternion).map(|yaw| Self { stamp, yaw })
    }
}

/// The yaw (rad) of a quaternion x, y, z, w, be it of unit length or nearly; `None` where it is none.
pub fn yaw_of([x, y, z, w]: [f64; 4]) -> Option<f64> {
    /// Range of the squared length of a quaternion: rounding and filters take it from one; zeros lie outside.
    const LENGTH: std::ops::Range<f64> = 0.5..1.5;
    let length = x * x + y * y + z * z + w * w;
    LENGTH
        .contains(&length)
        .then(|| f64::atan2(2.0 * (w * z + x * y), length - 2.0 * (y * y + z * z)))
}

/// Time, in s, before first motion over which the yaw at rest is taken.
const REST: f64 = 0.3;
/// Two poses with this many usual intervals between them do not show what lies between, in s.
const GAP: f64 = 0.1;

/// Part of the turn that leaves an object as it was, within which a pose is that of the frame before but for such turns: a tracker may take any side of a
/// square for its front.
const SAME: f64 = 0.25;

/// The yaw before first motion and at the track's times; `None` where poses do not cover them. `symmetry`: the turn, in rad, that leaves the object as
/// it was.
pub(crate) fn yaw(
    turns: &[YawSample],
    first_motion: i64,
    times: &[f64],
    symmetry: f64,
) -> Option<Yaw> {
    let within = |angle: f64, turn: f64| (angle + 0.5 * turn).rem_euclid(turn) - 0.5 * turn;
    let timed: Vec<(f64, f64)> = turns
        .iter()
        .map(|turn| (since(first_motion, turn.stamp), turn.yaw))
        .collect();
    let resting = timed.iter().filter(|(t, _)| (-REST..0.0).contains(t));
    let resting: Vec<f64> = resting.map(|(_, yaw)| *yaw).collect();
    let first = *resting.first()?;
    let beside = resting.iter().map(|yaw| within(yaw - first, symmetry));
    let initial = within(first + beside.sum::<f64>() / resting.len() as f64, TAU);
    let mut last = initial;
    let unwound: Vec<(f64, f64)> = timed
        .into_iter()
        .filter(|(t, _)| *t >= -GAP)
        .map(|(t, yaw)| {
            let (turned, whole) = (within(yaw - last, symmetry), within(yaw - last, TAU));
            let is_same = turned.abs() < SAME * symmetry;
            last += if is_same { turned } else { whole };
            (t, last)
        })
        .collect();
    let track = times
        .iter()
        .map(|t| at(&unwound, *t))
        .collect::<Option<_>>()?;
    Some(Yaw { initial, track })
}

/// The yaw at a time: between the poses around it, or that of the nearest where the other is missing.
fn at(unwound: &[(f64, f64)], t: f64) -> Option<f64> {
    let after = unwound.partition_point(|(at, _)| *at <= t);
    let near = |place: Option<usize>| {
        let pose = *unwound.get(place?)?;
        ((pose.0 - t).abs() <= GAP).then_some(pose)
    };
    match (near(after.checked_sub(1)), near(Some(after))) {
        (Some(before), Some(next)) => {
            Some(before.1 + (t - before.0) / (next.0 - before.0) * (next.1 - before.1))
        }
        (Some(only), None) | (None, Some(only)) => Some(only.1),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pose of an object that is turned by an angle.
    fn turn(t: f64, yaw: f64) -> YawSample {
        let (sin, cos) = (yaw / 2.0).sin_cos();
        YawSample::of((t * 1e9) as i64, [0.0, 0.0, sin, cos]).expect("a unit quaternion")
    }

    #[test]
    fn a_turn_past_the_half_circle_goes_on() {
        let yaw_at = |t: f64| 3.0 + f64::max(t, 0.0) * 8.0;
        let turns: Vec<YawSample> = (-40..60)
            .map(|i| f64::from(i) / 100.0)
            .map(|t| turn(t, yaw_at(t)))
            .collect();
        let times = [0.0, 0.105, 0.5];
        let found = yaw(&turns, 0, &times, TAU).expect("covered");
        assert!((found.initial - 3.0).abs() < 1e-9);
        for (t, yaw) in times.iter().zip(&found.track) {
            assert!((yaw - yaw_at(*t)).abs() < 1e-6, "{t} {yaw}");
        }
    }

    #[test]
    fn any_side_of_a_square_may_be_its_front() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let yaw_at = |t: f64| 0.6 + f64::max(t, 0.0) * 5.0;
        let turns: Vec<YawSample> = (-40..60)
            .map(|i| (f64::from(i) / 100.0, f64::from(i * i % 4)))
            .map(|(t, side)| turn(t, yaw_at(t) + side * quarter))
            .collect();
        let times = [0.0, 0.105, 0.5];
        let found = yaw(&turns, 0, &times, quarter).expect("covered");
        let sides = (found.initial - 0.6) / quarter;
        assert!((sides - sides.round()).abs() < 1e-9);
        for (t, yaw) in times.iter().zip(&found.track) {
            let turned = yaw - found.initial;
            assert!((turned - 5.0 * t).abs() < 1e-6, "{t} {turned}");
        }
    }

    #[test]
    fn a_quaternion_of_zeros_is_none_and_a_hole_in_the_poses_is_no_yaw() {
        assert_eq!(YawSample::of(0, [0.0; 4]), None);
        assert_eq!(YawSample::of(0, [f64::NAN; 4]), None);
        let turns: Vec<YawSample> = (-40..10).map(|i| turn(f64::from(i) / 100.0, 0.1)).collect();
        assert!(yaw(&turns, 0, &[0.0, 0.05], TAU).is_some());
        assert_eq!(yaw(&turns, 0, &[0.0, 0.5], TAU), None);
    }
}
