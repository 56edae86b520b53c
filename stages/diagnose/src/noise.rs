//! The noise of a table, beside the scatter of strikes ([`crate::mixed`]): camera errors that are correlated from frame to
//! frame, stamps that jitter, and frames that are no measurement at all.
//!
//! Along and across a strike's heading, in units of the camera's variance σ²: R_along = ρ^|k−l| + κ²·v_k²·δ_kl and
//! R_across = ρ^|k−l|, with k the number of the frame, lost frames counted, v_k its speed and κ the jitter of a stamp over σ.
//! ρ and κ are estimated once on the world without effects, and again after an effect was added; they are then the same for
//! every candidate: by maximum likelihood, all else at its best, with Nelder and Mead's simplex (1965) over (atanh ρ, ln κ). Correlated errors
//! become independent ones as a Kalman filter's innovations (Harvey 1989, section 3.4), in one pass over the frames.

use nalgebra::{DMatrix, DVector, DVectorView};
use values::{Point, Strike, median};

/// Correlation and jitter, common to all strikes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameNoise {
    /// ρ: correlation of a centroid's error with that of the frame before.
    pub(crate) correlation: f64,
    /// κ: standard deviation of a stamp over that of a centroid's coordinate, in s/m.
    pub(crate) jitter: f64,
}

impl FrameNoise {
    /// Independent errors, exact stamps.
    pub(crate) const WHITE: Self = Self {
        correlation: 0.0,
        jitter: 0.0,
    };
}

/// Number of frames whose mean is a resting place.
const RESTING_FRAMES: f64 = 10.0;

/// Standard deviation of a resting place over that of a centroid's coordinate: correlated errors average out less.
pub(crate) fn resting(noise: FrameNoise) -> f64 {
    let correlation = noise.correlation;
    ((1.0 + correlation) / (1.0 - correlation) / RESTING_FRAMES)
        .min(1.0)
        .sqrt()
}

/// What whitening needs of one strike.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    /// Unit vector from rest to rest.
    pub(crate) heading: Point,
    /// Frames since the frame before, 1 where none was lost.
    pub(crate) gaps: Vec<f64>,
    /// Speed at each frame, in m/s.
    pub(crate) speeds: Vec<f64>,
    /// Whether each frame is used.
    pub(crate) kept: Vec<bool>,
}

impl Frames {
    /// All frames of a strike, speeds at zero, of a camera that takes one every `frame` s.
    pub(crate) fn new(strike: &Strike, frame: f64) -> Self {
        let path = strike.path();
        let heading = if path.norm() > 1e-6 {
            path * path.norm().recip()
        } else {
            Point::polar(1.0, strike.command.angle)
        };
        let t = &strike.track.t;
        let gap = |k: usize| ((t[k] - t[k - 1]) / frame).round().max(1.0);
        Self {
            heading,
            gaps: (0..t.len())
                .map(|k| if k == 0 { 1.0 } else { gap(k) })
                .collect(),
            speeds: vec![0.0; t.len()],
            kept: vec![true; t.len()],
        }
    }
}

/// One step of the filter: what is carried over from the frame before, what is taken from this one, and one over the
/// innovation's standard deviation.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    carried: f64,
    gain: f64,
    scale: f64,
}

/// Turns columns of a strike (all x, then all y) into columns whose errors are independent and of variance σ²: all frames
/// along the heading, then all across. Frames that are left out become rows of zeros.
#[derive(Clone, Debug)]
pub(crate) struct Whitening {
    cosine: f64,
    sine: f64,
    along: Vec<Step>,
    across: Vec<Step>,
    /// Coordinates that are not left out.
    pub(crate) rows: f64,
    /// Logarithm of R's determinant, in units of σ².
    pub(crate) log_determinant: f64,
}

impl Whitening {
    /// For one strike's frames.
    pub(crate) fn new(frames: &Frames, noise: FrameNoise) -> Self {
        let (along, first) = filter(frames, noise);
        let (across, second) = filter(
            frames,
            FrameNoise {
                jitter: 0.0,
                ..noise
            },
        );
        Self {
            cosine: frames.heading.x,
            sine: frames.heading.y,
            along,
            across,
            rows: 2.0 * frames.kept.iter().filter(|kept| **kept).count() as f64,
            log_determinant: first + second,
        }
    }

    /// All columns of a matrix.
    pub(crate) fn columns(&self, raw: &DMatrix<f64>) -> DMatrix<f64> {
        let mut whitened = DMatrix::zeros(raw.nrows(), raw.ncols());
        for j in 0..raw.ncols() {
            self.pass(
                raw.column(j).as_view(),
                whitened.column_mut(j).as_mut_slice(),
            );
        }
        whitened
    }

    /// One column.
    pub(crate) fn column(&self, raw: &DVector<f64>) -> DVector<f64> {
        let mut whitened = DVector::zeros(raw.len());
        self.pass(raw.as_view(), whitened.as_mut_slice());
        whitened
    }

    /// Back from whitened to measured coordinates: all x, then all y. A frame that was left out comes back as what the frames
    /// before it make likely.
    pub(crate) fn restored(&self, whitened: DVectorView<'_, f64>) -> DVector<f64> {
        let n = self.along.len();
        let mut raw = DVector::zeros(2 * n);
        let (mut along, mut across) = (0.0, 0.0);
        for k in 0..n {
            let restore = |state: &mut f64, step: &Step, innovation: f64| {
                let expected = step.carried * *state;
                let innovation = if step.scale > 0.0 {
                    innovation / step.scale
                } else {
                    0.0
                };
                *state = expected + step.gain * innovation;
                expected + innovation
            };
            let ahead = restore(&mut along, &self.along[k], whitened[k]);
            let aside = restore(&mut across, &self.across[k], whitened[n + k]);
            raw[k] = self.cosine * ahead - self.sine * aside;
            raw[n + k] = self.sine * ahead + self.cosine * aside;
        }
        raw
    }

    /// One column into another.
    pub(crate) fn pass(&self, raw: DVectorView<'_, f64>, whitened: &mut [f64]) {
        let n = self.along.len();
        let (mut along, mut across) = (0.0, 0.0);
        for k in 0..n {
            let (x, y) = (raw[k], raw[n + k]);
            let innovate = |state: &mut f64, step: &Step, seen: f64| {
                let expected = step.carried * *state;
                let innovation = seen - expected;
                *state = expected + step.gain * innovation;
                innovation * step.scale
            };
            let ahead = self.cosine * x + self.sine * y;
            let aside = self.cosine * y - self.sine * x;
            whitened[k] = innovate(&mut along, &self.along[k], ahead);
            whitened[n + k] = innovate(&mut across, &self.across[k], aside);
        }
    }
}

/// The filter's steps over the frames, and the sum of the logarithms of the innovations' variances.
fn filter(frames: &Frames, noise: FrameNoise) -> (Vec<Step>, f64) {
    let mut log_determinant = 0.0;
    let mut variance: f64 = 1.0;
    let steps = (0..frames.kept.len())
        .map(|k| {
            let carried = if k == 0 {
                0.0
            } else {
                noise.correlation.powf(frames.gaps[k])
            };
            variance = carried * carried * variance + 1.0 - carried * carried;
            if !frames.kept[k] {
                return Step {
                    carried,
                    ..Step::default()
                };
            }
            let innovation = variance + (noise.jitter * frames.speeds[k]).powi(2);
            let gain = variance / innovation;
            variance *= 1.0 - gain;
            log_determinant += innovation.ln();
            Step {
                carried,
                gain,
                scale: innovation.sqrt().recip(),
            }
        })
        .collect();
    (steps, log_determinant)
}

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

/// Where the search begins, and how many evaluations it has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    evaluations: usize,
    size: f64,
}

/// The first search, and one that goes on from where an earlier one ended.
pub(crate) const FIRST_SEARCH: Search = Search {
    evaluations: 45,
    size: 0.5,
};
pub(crate) const REFINEMENT: Search = Search {
    evaluations: 22,
    size: 0.25,
};
/// ρ and κ (s/m) from which the first search begins.
const START: (f64, f64) = (0.3, 0.8);
/// Greatest correlation: beyond it errors and a strike's nuisances cannot be distinguished.
const MOST_CORRELATED: f64 = 0.97;
/// Least and greatest κ in s/m: with 1 mm of camera noise, stamps that are off by 10 µs, and by 100 ms.
const JITTER: (f64, f64) = (0.01, 100.0);

/// The noise under which `log_likelihood` is greatest, from `start` where one is given.
pub(crate) fn estimate(
    start: Option<FrameNoise>,
    search: Search,
    mut log_likelihood: impl FnMut(FrameNoise) -> f64,
) -> FrameNoise {
    let start = start.map_or(START, |noise| (noise.correlation, noise.jitter));
    let at = [
        start.0.clamp(0.0, MOST_CORRELATED).atanh(),
        start.1.clamp(JITTER.0, JITTER.1).ln(),
    ];
    let noise = |at: [f64; 2]| FrameNoise {
        correlation: at[0].tanh().clamp(0.0, MOST_CORRELATED),
        jitter: at[1].exp().clamp(JITTER.0, JITTER.1),
    };
    let best = minimum(at, search, |at| {
        let value = -log_likelihood(noise(at));
        if value.is_finite() { value } else { f64::MAX }
    });
    noise(best)
}

/// Nelder and Mead's simplex in the plane.
fn minimum(start: [f64; 2], search: Search, mut f: impl FnMut([f64; 2]) -> f64) -> [f64; 2] {
    let mut evaluations = 0;
    let mut value = |at: [f64; 2]| {
        evaluations += 1;
        (f(at), evaluations)
    };
    let corners = [[0.0, 0.0], [search.size, 0.0], [0.0, search.size]];
    let mut simplex = corners
        .map(|[x, y]| [start[0] + x, start[1] + y])
        .map(|at| (at, value(at).0));
    let mut used = simplex.len();
    while used < search.evaluations {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let [best, middle, worst] = simplex;
        let centre = [0, 1].map(|i| 0.5 * (best.0[i] + middle.0[i]));
        let away = |factor: f64| [0, 1].map(|i| centre[i] + factor * (centre[i] - worst.0[i]));
        let mut tried = |factor: f64| {
            let at = away(factor);
            let (found, count) = value(at);
            used = count;
            (at, found)
        };
        let reflected = tried(1.0);
        simplex[2] = if reflected.1 < best.1 {
            let expanded = tried(2.0);
            if expanded.1 < reflected.1 {
                expanded
            } else {
                reflected
            }
        } else if reflected.1 < middle.1 {
            reflected
        } else {
            let contracted = tried(if reflected.1 < worst.1 { 0.5 } else { -0.5 });
            if contracted.1 < worst.1.min(reflected.1) {
                contracted
            } else {
                for corner in [1, 2] {
                    let at = [0, 1].map(|i| 0.5 * (simplex[corner].0[i] + best.0[i]));
                    let (found, count) = value(at);
                    used = count;
                    simplex[corner] = (at, found);
                }
                continue;
            }
        };
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    simplex[0].0
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::*;

    fn frames() -> Frames {
        Frames {
            heading: Point::polar(1.0, 0.4),
            gaps: vec![1.0, 1.0, 3.0, 1.0, 2.0],
            speeds: vec![0.9, 0.8, 0.5, 0.4, 0.1],
            kept: vec![true, true, true, false, true],
        }
    }

    #[test]
    fn products_of_whitened_columns_are_those_with_the_inverse_covariance() {
        let noise = FrameNoise {
            correlation: 0.7,
            jitter: 1.3,
        };
        let frames = frames();
        let whitening = Whitening::new(&frames, noise);
        let kept: Vec<usize> = (0..5).filter(|k| frames.kept[*k]).collect();
        let number = |k: usize| frames.gaps[..=k].iter().sum::<f64>();
        let covariance = |jitter: f64| {
            DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
                let (k, l) = (kept[i], kept[j]);
                let apart = (number(k) - number(l)).abs();
                let own = if i == j {
                    (jitter * frames.speeds[k]).powi(2)
                } else {
                    0.0
                };
                noise.correlation.powf(apart) + own
            })
        };
        let (along, across) = (covariance(noise.jitter), covariance(0.0));
        let log_determinant = along.determinant().ln() + across.determinant().ln();
        assert!((whitening.log_determinant - log_determinant).abs() < 1e-12);
        assert_eq!(whitening.rows, 8.0);

        let raw = DMatrix::from_fn(10, 2, |i, j| ((3 * i + 7 * j) as f64).sin());
        let turned = |j: usize, is_across: bool| {
            DVector::from_iterator(
                kept.len(),
                kept.iter().map(|k| {
                    let at = Point::new(raw[(*k, j)], raw[(5 + k, j)]).rotated(-0.4);
                    if is_across { at.y } else { at.x }
                }),
            )
        };
        let expected: f64 = [(along, false), (across, true)]
            .iter()
            .map(|(covariance, is_across)| {
                let inverse = covariance.clone().try_inverse().expect("regular");
                turned(0, *is_across).dot(&(inverse * turned(1, *is_across)))
            })
            .sum();
        let whitened = whitening.columns(&raw);
        let found = whitened.column(0).dot(&whitened.column(1));
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        let restored = whitening.restored(whitened.column(0));
        for k in kept {
            assert!((restored[k] - raw[(k, 0)]).abs() < 1e-12);
            assert!((restored[5 + k] - raw[(5 + k, 0)]).abs() < 1e-12);
        }
    }

    #[test]
    fn white_noise_leaves_columns_as_they_are_but_turned() {
        let mut frames = frames();
        frames.kept = vec![true; 5];
        let whitening = Whitening::new(&frames, FrameNoise::WHITE);
        let raw = DVector::from_fn(10, |i, _| (i as f64).cos());
        let whitened = whitening.column(&raw);
        assert!((whitened.norm() - raw.norm()).abs() < 1e-12);
        assert_eq!(whitening.log_determinant, 0.0);
    }

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

    #[test]
    fn the_peak_of_a_likelihood_is_found() {
        let found = estimate(None, FIRST_SEARCH, |noise| {
            let away = [
                noise.correlation.atanh() - 0.9f64.atanh(),
                noise.jitter.ln() - 3f64.ln(),
            ];
            -(4.0 * away[0].powi(2) + away[1].powi(2) + away[0] * away[1])
        });
        assert!((found.correlation - 0.9).abs() < 0.02, "{found:?}");
        assert!((found.jitter - 3.0).abs() < 0.3, "{found:?}");
    }

    #[test]
    fn an_estimate_stays_within_its_bounds() {
        let found = estimate(None, FIRST_SEARCH, |noise| {
            noise.correlation + noise.jitter.ln()
        });
        assert!(found.correlation <= MOST_CORRELATED && found.jitter <= JITTER.1);
        let none = estimate(None, FIRST_SEARCH, |_| f64::NAN);
        assert!(none.correlation.is_finite() && none.jitter.is_finite());
    }
}
