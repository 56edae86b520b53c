//! From correlated errors to independent ones: a Kalman filter's innovations (Harvey 1989, section 3.4), in one pass over the
//! frames.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::{FrameNoise, Frames};

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
}
