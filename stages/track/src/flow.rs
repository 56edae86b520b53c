//! How far a plane before a camera that was turned or moved a little is seen from where it was.

/// A movement over an image: of its middle, then roll and zoom, shear, and what tilts add, to first order (the derivative of a homography).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flow {
    /// Each in px at half the image's width from its middle.
    parts: [f64; PARTS],
    middle: [f64; 2],
}

pub(crate) const PARTS: usize = 8;

impl Flow {
    /// No movement of an image of this size (px).
    pub(crate) fn still(size: [usize; 2]) -> Self {
        Self {
            parts: [0.0; PARTS],
            middle: size.map(|pixels| 0.5 * (pixels.max(2) - 1) as f64),
        }
    }

    /// This flow, all moved by so many px.
    pub(crate) fn moved(mut self, [x, y]: [f64; 2]) -> Self {
        self.parts[0] += x;
        self.parts[1] += y;
        self
    }

    /// What is added to another movement to be this one.
    pub(crate) fn since(mut self, other: &Self) -> Self {
        self.step(other.parts.into_iter().map(|part| -part));
        self
    }

    /// A pixel from the image's middle, in half its width.
    pub(crate) fn place(&self, pixel: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| (pixel[i] - self.middle[i]) / self.middle[0])
    }

    /// How far (px) each part moves a pixel where it is one.
    pub(crate) fn parts(&self, pixel: [f64; 2]) -> [[f64; 2]; PARTS] {
        let [x, y] = self.place(pixel);
        [
            [1.0, 0.0],
            [0.0, 1.0],
            [x, y],
            [-y, x],
            [x, -y],
            [y, x],
            [x * x, x * y],
            [x * y, y * y],
        ]
    }

    /// Whether nothing moves.
    pub(crate) fn is_still(&self) -> bool {
        self.parts == [0.0; PARTS]
    }

    /// How far a pixel is moved, in px.
    pub(crate) fn at(&self, pixel: [f64; 2]) -> [f64; 2] {
        let all = self.parts(pixel).into_iter().zip(self.parts);
        all.fold([0.0; 2], |sum, (way, part)| {
            [0, 1].map(|i| sum[i] + part * way[i])
        })
    }

    /// Adds to the first parts, and says how far the most of them moved.
    pub(crate) fn step(&mut self, parts: impl Iterator<Item = f64>) -> f64 {
        let mut most = 0.0f64;
        for (own, more) in self.parts.iter_mut().zip(parts) {
            *own += more;
            most = most.max(more.abs());
        }
        most
    }

    /// The middle of the image, and places half way to its corners: where a table is.
    fn places(&self) -> [[f64; 2]; 5] {
        let [x, y] = self.middle;
        let at = |across: f64, down: f64| [x + 0.6 * across * x, y + 0.6 * down * y];
        [
            at(0.0, 0.0),
            at(-1.0, -1.0),
            at(1.0, -1.0),
            at(-1.0, 1.0),
            at(1.0, 1.0),
        ]
    }

    /// The farthest that any of these is moved, in px.
    pub(crate) fn farthest(&self) -> f64 {
        let far = |place: [f64; 2]| {
            let [x, y] = self.at(place);
            x.hypot(y)
        };
        self.places().into_iter().map(far).fold(0.0, f64::max)
    }

    /// Standard deviation of the movement, in px, where of these it is known least, from the covariance of two parts.
    pub(crate) fn uncertainty(&self, covariance: impl Fn(usize, usize) -> f64) -> f64 {
        let variance = |place: [f64; 2], axis: usize| {
            let way = self.parts(place);
            let pairs = (0..PARTS).flat_map(|a| (0..PARTS).map(move |b| (a, b)));
            pairs
                .map(|(a, b)| way[a][axis] * way[b][axis] * covariance(a, b))
                .sum::<f64>()
        };
        let places = self.places().into_iter();
        let most = places.flat_map(|place| [0, 1].map(|axis| variance(place, axis)));
        most.fold(0.0, f64::max).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_that_rolls_moves_the_border_and_not_the_middle() {
        let mut flow = Flow::still([641, 481]);
        flow.step([0.0, 0.0, 0.0, 3.2].into_iter());
        assert_eq!(flow.at([320.0, 240.0]), [0.0, 0.0]);
        // A hundredth of a radian, a quarter turn on from where it is.
        let [x, y] = flow.at([620.0, 140.0]);
        assert!(
            (x - 1.0).abs() < 1e-12 && (y - 3.0).abs() < 1e-12,
            "{x} {y}"
        );
        let far = flow.moved([5.0, 0.0]).farthest();
        assert!((far - (5.0f64 + 1.44).hypot(1.92)).abs() < 1e-9, "{far}");
    }
}
