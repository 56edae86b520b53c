//! Frames that are left out: far from where the strike's own launch, clock and friction put them.

use nalgebra::DVector;
use values::median;

use super::Frames;

/// How far out a frame must lie, in robust standard deviations, and whether only across the heading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rule {
    limit: f64,
    is_across_only: bool,
}

impl Rule {
    /// Before noise and friction are known: along the heading the world itself may be far off.
    pub(crate) const FIRST: Self = Self {
        limit: 8.0,
        is_across_only: true,
    };
    /// For a fitted world. Six standard deviations leave out one good frame in 10⁸.
    pub(crate) const FITTED: Self = Self {
        limit: 6.0,
        is_across_only: false,
    };
}

/// Median absolute deviation to standard deviation, of a normal distribution.
const NORMAL: f64 = 1.48;
/// Speed in m/s above which stamps show in positions.
const MOVING: f64 = 0.3;
/// Share of a strike's frames that stay. Of a strike of which more lies far out only the worst go, those of more than half the
/// greatest distance: a stray frame far away has bent the whole strike.
const LEAST: f64 = 0.7;
const WORST: f64 = 0.5;

/// Which frames of each strike stay. `left` is what a strike's own nuisances leave of its residual, all x, then all y.
pub(crate) fn kept_frames(frames: &[Frames], left: &[DVector<f64>], rule: Rule) -> Vec<Vec<bool>> {
    let split = |i: usize, k: usize| {
        let (n, heading) = (frames[i].kept.len(), frames[i].heading);
        let (x, y) = (left[i][k], left[i][n + k]);
        let along = x * heading.x + y * heading.y;
        (along.abs(), (y * heading.x - x * heading.y).abs())
    };
    let each = || (0..frames.len()).flat_map(|i| (0..frames[i].kept.len()).map(move |k| (i, k)));
    let across = each().map(|(i, k)| split(i, k).1);
    let camera = NORMAL * median(across.collect()).unwrap_or(0.0);
    let moving = each().filter(|(i, k)| frames[*i].speeds[*k] > MOVING);
    let late = moving.map(|(i, k)| split(i, k).0 / frames[i].speeds[k]);
    let stamps = NORMAL * median(late.collect()).unwrap_or(0.0);
    frames
        .iter()
        .enumerate()
        .map(|(i, strike)| {
            let kept: Vec<bool> = (0..strike.kept.len())
                .map(|k| {
                    let (along, across) = split(i, k);
                    let scale = camera.hypot(stamps * strike.speeds[k]);
                    across <= rule.limit * camera
                        && (rule.is_across_only || along <= rule.limit * scale)
                })
                .collect();
            let share = |kept: &[bool]| {
                kept.iter().filter(|kept| **kept).count() as f64 / kept.len() as f64
            };
            if share(&kept) >= LEAST {
                return kept;
            }
            let distance = |k: usize| {
                let (along, across) = split(i, k);
                if rule.is_across_only {
                    across
                } else {
                    along.hypot(across)
                }
            };
            let worst = (0..kept.len()).map(distance).fold(0.0, f64::max);
            let kept: Vec<bool> = (0..kept.len())
                .map(|k| distance(k) <= WORST * worst)
                .collect();
            if share(&kept) < LEAST {
                vec![true; kept.len()]
            } else {
                kept
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::*;

    #[test]
    fn a_stray_frame_is_left_out_and_late_stamps_of_fast_frames_are_not() {
        let n = 40;
        let frames: Vec<Frames> = (0..5)
            .map(|_| Frames {
                heading: Point::new(1.0, 0.0),
                gaps: vec![1.0; n],
                speeds: (0..n).map(|k| 1.0 - k as f64 / n as f64).collect(),
                kept: vec![true; n],
            })
            .collect();
        let mut left: Vec<DVector<f64>> = (0..5)
            .map(|i| {
                DVector::from_fn(2 * n, |row, _| {
                    let wave = 1e-3 * ((row * (i + 3)) as f64).sin();
                    // Stamps are off by 5 ms.
                    let late = 5e-3 * ((row + i) as f64 * 1.7).sin();
                    wave + if row < n {
                        frames[i].speeds[row] * late
                    } else {
                        0.0
                    }
                })
            })
            .collect();
        left[2][n + 7] += 0.05;
        left[3][12] -= 0.08;
        let kept = kept_frames(&frames, &left, Rule::FITTED);
        let out: Vec<(usize, usize)> = (0..5)
            .flat_map(|i| (0..n).map(move |k| (i, k)))
            .filter(|(i, k)| !kept[*i][*k])
            .collect();
        assert_eq!(out, [(2, 7), (3, 12)]);
        let first = kept_frames(&frames, &left, Rule::FIRST);
        assert!(!first[2][7] && first[3][12]);
    }
}
