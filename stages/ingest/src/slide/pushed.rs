//! Where an object that the arm has left is pushed on: it speeds up again, or leaves its line. A table does neither.

use values::{Point, Shape};

use super::frames::Frame;
use crate::robust::median_point;

/// Time, in s, over which velocities are taken, and over as many frames at the least.
const TIME: f64 = 0.08;
const FRAMES: usize = 4;
/// Standard errors that a change must have, twice in a row, to be no noise.
const ERRORS: f64 = 5.0;
const IN_A_ROW: usize = 2;
/// Rate, in m/s², below which slopes, seams or spin may change a velocity aside or ahead.
const PUSHED: f64 = 1.0;
/// Greatest rise of the speed on a slope, or as a shape turns: in m/s, and as a part of the greatest one.
const RISES: f64 = 0.06;
const RISES_BY: f64 = 0.1;

/// Speed, in m/s, below which an object has as good as stopped.
const STANDS: f64 = 0.1;

/// Where an object is pushed on.
pub(super) struct Push {
    /// The last frame before which nothing shows that it was pushed.
    pub(super) at: usize,
    /// Its place, where it had as good as stopped there.
    pub(super) stands: Option<Point>,
}

/// Velocity over some frames.
struct Velocity {
    frames: std::ops::Range<usize>,
    /// Middle of their times, in s.
    t: f64,
    v: Point,
    /// Standard error of a coordinate.
    error: f64,
}

impl Velocity {
    /// The velocity by a line through these frames (least squares); stamps that are off show as noise.
    fn over(all: &[Frame], frames: std::ops::Range<usize>, noise: f64) -> Option<Self> {
        let used = all.get(frames.clone())?;
        let count = used.len() as f64;
        let t = used.iter().map(|frame| frame.t).sum::<f64>() / count;
        let sum =
            |of: &dyn Fn(&Frame) -> Point| used.iter().map(of).fold(Point::default(), |a, b| a + b);
        let middle = sum(&|frame| frame.point) * (1.0 / count);
        let square: f64 = used.iter().map(|frame| (frame.t - t).powi(2)).sum();
        let v = sum(&|frame| (frame.point - middle) * (frame.t - t)) * (1.0 / square);
        let off = |frame: &Frame| frame.point.distance(middle + v * (frame.t - t)).powi(2);
        let scatter = used.iter().map(off).sum::<f64>() / (2.0 * count - 4.0);
        let error = scatter.sqrt().max(noise) / square.sqrt();
        Some(Self {
            frames,
            t,
            v,
            error,
        })
    }
}

/// Where an object is pushed on, of frames from the moment on at which the arm has let go of the object; none where it slides as on a table. What
/// pushes it on `ahead`, as it was struck, may be the arm that goes on behind it: that is the command's own doing.
pub(super) fn pushed(frames: &[Frame], ahead: Point, noise: f64, shape: Shape) -> Option<Push> {
    // Spin drives a ball.
    if shape == Shape::Sphere {
        return None;
    }
    let later = |at: usize| {
        let to = frames.partition_point(|frame| frame.t <= frames[at].t + TIME);
        Velocity::over(frames, at..to.max(at + FRAMES), noise)
    };
    let velocities: Vec<Velocity> = (0..frames.len()).map_while(later).collect();
    let aside = aside(&velocities, ahead).map(|at| Push { at, stands: None });
    let risen = speeds_up(&velocities, ahead).map(|slowest| {
        let places: Vec<Point> = frames[slowest.frames.clone()]
            .iter()
            .map(|frame| frame.point)
            .collect();
        let stands = (slowest.v.norm() < STANDS).then(|| median_point(&places));
        Push {
            at: slowest.frames.start,
            stands,
        }
    });
    aside.into_iter().chain(risen).min_by_key(|push| push.at)
}

/// Whether a velocity is changed within 45° of where the arm struck.
fn is_ahead(change: Point, struck: Point) -> bool {
    change.dot(struck) > std::f64::consts::FRAC_1_SQRT_2 * change.norm() * struck.norm()
}

/// Index of the velocity that is changed aside or ahead.
fn aside(velocities: &[Velocity], struck: Point) -> Option<usize> {
    let is_pushed = |one: &Velocity| {
        let next = velocities.get(one.frames.end - 1)?;
        let ahead = one.v * (1.0 / one.v.norm().max(1e-12));
        let change = next.v - one.v;
        let error = one.error.hypot(next.error);
        // Of what hardly moves noise alone gives the direction.
        let aside = match one.v.norm() > 4.0 * one.error {
            true => change.x * ahead.y - change.y * ahead.x,
            false => 0.0,
        };
        let faster = (next.v.norm() - one.v.norm()).max(0.0);
        let pushed = aside.hypot(faster);
        let is_arm = is_ahead(change, struck);
        Some(!is_arm && pushed > ERRORS * error && pushed > PUSHED * (next.t - one.t))
    };
    let pushed: Vec<bool> = velocities.iter().map_while(is_pushed).collect();
    let at = pushed
        .windows(IN_A_ROW)
        .position(|row| row.iter().all(|is| *is))?;
    Some(velocities[at].frames.end - 1)
}

/// The slowest velocity before the object speeds up.
fn speeds_up(velocities: &[Velocity], ahead: Point) -> Option<&Velocity> {
    let speed = |velocity: &Velocity| velocity.v.norm();
    let fastest = velocities.iter().map(speed).fold(0.0, f64::max);
    let mut slowest = velocities.first()?;
    let mut risen = 0;
    for velocity in velocities {
        if speed(velocity) < speed(slowest) {
            slowest = velocity;
        }
        let error = velocity.error.hypot(slowest.error);
        let least = (ERRORS * error).max(RISES).max(RISES_BY * fastest);
        let is_arm = is_ahead(velocity.v - slowest.v, ahead);
        risen = match !is_arm && speed(velocity) - speed(slowest) > least {
            true => risen + 1,
            false => 0,
        };
        if risen == IN_A_ROW {
            return Some(slowest);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: f64 = 0.0006;

    /// Where it may have been pushed, of an object that is at this place at a time, seen for so long at this rate with the camera's noise.
    fn pushed_at(place: impl Fn(f64) -> Point, rate: f64, phase: f64) -> Option<f64> {
        let wobble = |i: u32, k: f64| NOISE * 1.4 * (f64::from(i * i) * k + phase).sin();
        let frames: Vec<Frame> = (0..(0.9 * rate) as u32)
            .map(|i| {
                let t = f64::from(i) / rate;
                Frame {
                    stamp: 0,
                    t,
                    point: place(t) + Point::new(wobble(i, 1.1), wobble(i, 2.3)),
                }
            })
            .collect();
        pushed(&frames, Point::new(1.0, 0.0), NOISE, Shape::Cylinder).map(|push| frames[push.at].t)
    }

    /// 0.8 m/s, braked by 2.5 m/s².
    fn slide(t: f64) -> Point {
        let t = t.min(0.32);
        Point::new(0.8 * t - 1.25 * t * t, 0.0)
    }

    #[test]
    fn what_a_hand_pushes_on_is_found_and_what_slides_is_not() {
        for phase in (0..10).map(f64::from) {
            for rate in [30.0, 60.0, 120.0] {
                assert_eq!(pushed_at(slide, rate, phase), None);
                // Back again, after a tenth of a second at rest, by a hand that speeds up; and aside, half-way.
                let hand = |t: f64| 2.0 * t.clamp(0.0, 0.2).powi(2) + 0.8 * (t - 0.2).max(0.0);
                let on = |t: f64| slide(t) + Point::new(-hand(t - 0.42), 0.0);
                let at = pushed_at(on, rate, phase).expect("pushed on");
                assert!((0.25..0.46).contains(&at), "{rate} {phase}: {at}");
                let aside = |t: f64| slide(t) + Point::new(0.0, 0.4 * (t - 0.16).max(0.0));
                let at = pushed_at(aside, rate, phase).expect("pushed aside");
                assert!((0.05..0.2).contains(&at), "{rate} {phase}: {at}");
            }
        }
    }
}
