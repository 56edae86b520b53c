//! Where a slide is deflected so little that it is no bounce: by a fence that it grazes, or one that gives nothing back and leads it along.
//!
//! A table bends a path by slopes, evenly. So each moment of a slide is tried for a velocity that changes there at once, beside a constant
//! acceleration of the whole: of all frames together, for the few about it are too noisy. One such place decides nothing
//! ([`crate::fences`]).

use values::{Point, Track};

use crate::bounces::Bounce;

/// Least number of frames before and after a deflection.
const FRAMES: usize = 5;
/// Least change of velocity aside of a deflection: in standard errors (at five, one of 240 free slides seemed to be deflected), and in m/s.
const SURE: f64 = 6.0;
const LEAST: f64 = 0.03;
/// Root mean square of the frames about what was fitted, in deviations of the camera's noise, where it is a slide that was deflected.
const FITS: f64 = 2.0;
/// Nearer to where it stops than this, in m and in deviations of the camera's noise, it may have stopped.
const NEAR_STOP: f64 = 0.005;
const NEAR_STOP_NOISE: f64 = 8.0;

/// Where a slide that nothing was seen to end is deflected, if it surely is. `noise`: of a centroid's coordinate, in m.
pub(crate) fn graze(track: &Track, noise: f64) -> Option<Bounce> {
    let stop = track.point(track.len().checked_sub(1)?);
    let near = NEAR_STOP.max(NEAR_STOP_NOISE * noise);
    // A track has a corner at the impact.
    let moving = (1..track.len()).take_while(|i| track.point(*i).distance(stop) > near);
    let frames: Vec<(f64, Point)> = moving.map(|i| (track.t[i], track.point(i))).collect();
    let last = frames.len().checked_sub(FRAMES)?;
    let tried = (FRAMES..=last).filter_map(|at| Deflection::at(&frames, at));
    let best = tried.min_by(|one, other| one.left.total_cmp(&other.left))?;
    let noise = noise.max(best.left);
    let is_sure = best.aside.abs() > LEAST.max(SURE * noise * best.error);
    (is_sure && best.left <= FITS * noise).then_some(best.bounce)
}

/// A slide whose velocity changes once.
struct Deflection {
    bounce: Bounce,
    /// Its velocity's change across the way before, in m/s, and the standard deviation of that for a noise of one.
    aside: f64,
    error: f64,
    /// Root mean square of what is left of a coordinate, in m.
    left: f64,
}

impl Deflection {
    /// The deflection in the middle between the frame `at` and the one before.
    fn at(frames: &[(f64, Point)], at: usize) -> Option<Self> {
        let then = 0.5 * (frames[at - 1].0 + frames[at].0);
        let times: Vec<f64> = frames.iter().map(|(t, _)| t - then).collect();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let shapes: [fn(f64) -> f64; 4] = [|_| 1.0, |t| t, |t| t * t, |t| t.max(0.0)];
        let mut inverse = [[0.0; 4]; 4];
        // Gram and Schmidt: the last one is what is left of a change beside a constant acceleration.
        for (column, shape) in shapes.iter().enumerate() {
            let mut rest: Vec<f64> = times.iter().map(|t| shape(*t)).collect();
            for (row, one) in basis.iter().enumerate() {
                let part = dot(one, &rest);
                inverse[row][column] = part;
                rest.iter_mut().zip(one).for_each(|(r, o)| *r -= part * o);
            }
            let norm = dot(&rest, &rest).sqrt();
            if norm <= 1e-9 {
                return None;
            }
            inverse[column][column] = norm;
            basis.push(rest.into_iter().map(|r| r / norm).collect());
        }
        let fitted = |of: fn(Point) -> f64| {
            let values: Vec<f64> = frames.iter().map(|(_, point)| of(*point)).collect();
            let parts: Vec<f64> = basis.iter().map(|one| dot(one, &values)).collect();
            let square = dot(&values, &values) - dot(&parts, &parts);
            let mut solved = [0.0; 4];
            for row in (0..4).rev() {
                let known: f64 = (row + 1..4).map(|c| inverse[row][c] * solved[c]).sum();
                solved[row] = (parts[row] - known) / inverse[row][row];
            }
            (solved, square.max(0.0))
        };
        let ((x, x_left), (y, y_left)) = (fitted(|p| p.x), fitted(|p| p.y));
        let of = |i: usize| Point::new(x[i], y[i]);
        let (before, change) = (of(1), of(3));
        let across = before.rotated(std::f64::consts::FRAC_PI_2) * (1.0 / before.norm().max(1e-9));
        Some(Self {
            bounce: Bounce {
                place: of(0),
                before,
                after: before + change,
            },
            aside: change.dot(across),
            error: 1.0 / inverse[3][3],
            left: ((x_left + y_left) / (2.0 * frames.len() as f64 - 8.0)).sqrt(),
        })
    }
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOISE: f64 = 0.0007;

    /// At 60 Hz, of an object that brakes by 2 m/s² along its heading, on a slope of this acceleration aside; at a fence at y = 0.04 what
    /// remains of its velocity towards it is this part of it.
    fn slide(heading: f64, slope: f64, back: Option<f64>, seed: u64) -> Track {
        let (mut at, mut velocity) = (Point::default(), Point::polar(0.9, heading));
        let mut track = Track::default();
        for i in 0..800_u64 {
            if i % 17 == 0 {
                let wobble = |k: f64| {
                    let part = |j: f64| ((j + (seed * 1000 + i) as f64) * k).sin() * 43758.5453;
                    // Six parts: about normal.
                    let sum: f64 = (0..6)
                        .map(|j| part(17.0 * f64::from(j)).rem_euclid(1.0))
                        .sum();
                    NOISE * 1.414 * (sum - 3.0)
                };
                track.t.push(i as f64 / 1000.0);
                track.x.push(at.x + wobble(12.9898));
                track.y.push(at.y + wobble(78.233));
            }
            let speed = velocity.norm();
            let braked = (speed - 0.002).max(0.0);
            velocity = velocity * (braked / speed.max(1e-9));
            if braked > 0.0 {
                velocity.y += 0.001 * slope;
            }
            at = at + velocity * 0.001;
            if let Some(back) = back
                && at.y > 0.04
                && velocity.y > 0.0
            {
                velocity.y *= -back;
            }
        }
        track
    }

    #[test]
    fn a_fence_that_is_grazed_is_seen_and_slopes_and_straight_slides_are_not() {
        let mut seen = [0; 2];
        for seed in 0..40 {
            for slope in [0.0, 0.3] {
                for heading in [-0.3, 0.0, 0.2] {
                    let free = graze(&slide(heading, slope, None, seed), NOISE);
                    assert_eq!(free, None, "{seed}, {slope}, {heading}");
                }
            }
            for (count, back) in seen.iter_mut().zip([0.4, 0.0]) {
                let Some(found) = graze(&slide(0.3, 0.0, Some(back), seed), NOISE) else {
                    continue;
                };
                assert!(
                    (found.place.y - 0.04).abs() < 0.006,
                    "{seed}, {back}: {found:?}"
                );
                // One that is led along may be seen at a later touch.
                *count += usize::from(found.before.y > 0.08 && found.after.y < 0.1);
            }
        }
        // Half of those that are led along: a fence shows in several.
        assert!(seen[0] > 35 && seen[1] > 15, "{seen:?}");
    }
}
