//! The marker that lies on the object: found by its dark square, known by its cells, and laid onto the image.

use values::{Object, Point, wrap_angle};

use crate::board::{Dictionary, Grey, Pattern, Quad, cell_lights, dark_quads};
use crate::marker_fit::{Lit, MarkerFit, Placed, fit_marker, is_on};
use crate::outline::Pose;
use crate::{CameraModel, Image, SetupError};

/// The marker of a rig's object.
#[derive(Clone, Debug)]
pub(crate) struct ObjectMarker {
    pattern: Pattern,
    /// Side of its black square in m.
    side: f64,
    /// Its centre, from the object's, in m where the object is not turned; its yaw then.
    offset: Point,
    yaw: f64,
    /// Height of the face on which it lies, in m.
    height: f64,
}

/// The object as its marker shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ByMarker {
    pub(crate) pose: Pose,
    /// Pixel of the marker's centre.
    pub(crate) pixel: [f64; 2],
    /// Standard deviations of a coordinate (m) and of the yaw (rad).
    pub(crate) deviation: [f64; 2],
    /// How large it is seen of what it is.
    pub(crate) scale: f64,
    pub(crate) quality: f64,
}

/// A dark square may be the marker if its sides are so long, of the marker's.
const LIKE_IT: std::ops::Range<f64> = 0.7..1.3;
/// Its cells' light is like the pattern's to this correlation at the least, where it is looked at first.
const LEAST_ALIKE: f64 = 0.5;
/// White about it that is looked at, in cells.
const MARGIN: f64 = 0.5;
const MOST_PIXELS: usize = 4000;
/// Most cells that may be seen otherwise: dirt, glare.
const MOST_WRONG: usize = 1;
/// Least share of the pixels' variance that the pattern explains, and least light of white beyond black.
const LEAST_EXPLAINED: f64 = 0.75;
const LEAST_CONTRAST: f64 = 0.01;
/// The marker is seen as large as it is to this share.
const MOST_LARGER: f64 = 0.08;
/// A coordinate that is not known to this (m) may be wrong.
const MOST_DEVIATION: f64 = 0.00075;
/// What the scatter of pixels does not show: they are not independent; and, in px and in m, what the light does.
const NOT_INDEPENDENT: f64 = 2.0;
const UNSEEN_PX: f64 = 0.012;
const UNSEEN: f64 = 0.00001;

impl ObjectMarker {
    /// The marker that a rig file states.
    ///
    /// # Errors
    /// Its dictionary is not known, or has no such number.
    pub(crate) fn of(object: &Object) -> Result<Option<Self>, SetupError> {
        let Some(marker) = &object.marker else {
            return Ok(None);
        };
        let dictionary = Dictionary::named(&marker.dictionary);
        let dictionary = dictionary.ok_or_else(|| SetupError::Dictionary {
            name: marker.dictionary.clone(),
        })?;
        let pattern = Pattern::of(&dictionary, marker.id).ok_or_else(|| SetupError::Marker {
            id: marker.id,
            name: marker.dictionary.clone(),
            last: dictionary.len().saturating_sub(1),
        })?;
        Ok(Some(Self {
            pattern,
            side: marker.size,
            offset: marker.offset,
            yaw: marker.yaw,
            height: 2.0 * object.solid.half_height(),
        }))
    }

    /// All places where it is seen; `camera_near` is the camera as it sees what is near a pixel.
    pub(crate) fn find(
        &self,
        image: &Image,
        light: &[f32; 256],
        camera_near: &dyn Fn([f64; 2]) -> CameraModel,
    ) -> Vec<ByMarker> {
        let grey = Grey::of(image);
        let mut found: Vec<ByMarker> = Vec::new();
        for quad in dark_quads(&grey) {
            let middle = [0, 1].map(|i| 0.25 * quad.iter().map(|at| at[i]).sum::<f64>());
            let camera = camera_near(middle);
            let start = self.start(&grey, &camera, &quad);
            // Most squares are found twice.
            let is_new = |start: &Placed| {
                let pose = self.pose(start);
                let near = |other: &ByMarker| is_near(&other.pose, &pose, 0.5 * self.side);
                !found.iter().any(near)
            };
            let start = start.filter(is_new);
            found.extend(start.and_then(|start| self.fitted(image, light, &camera, start)));
        }
        found
    }

    /// Where the marker lies if a dark square is it.
    fn start(&self, grey: &Grey, camera: &CameraModel, quad: &Quad) -> Option<Placed> {
        let mut corners = [[0.0; 2]; 4];
        for (corner, pixel) in corners.iter_mut().zip(quad) {
            let at = camera.point(*pixel, self.height)?;
            *corner = [at.x, at.y];
        }
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let length = (a[0] - b[0]).hypot(a[1] - b[1]);
            if !LIKE_IT.contains(&(length / self.side)) {
                return None;
            }
        }
        let lights = cell_lights(grey, quad, self.pattern.across)?;
        let alike = |quarters: &usize| self.alike(&lights, *quarters);
        let quarters = (0..4).max_by(|a, b| alike(a).total_cmp(&alike(b)))?;
        if alike(&quarters) < LEAST_ALIKE {
            return None;
        }
        // The corners as printed, clockwise from the upper left; its right is the direction of its upper and lower side.
        let corner = |k: usize| corners[(k + 4 - quarters) % 4];
        let [upper_left, upper_right, lower_right, lower_left] = [0, 1, 2, 3].map(corner);
        let right = [0, 1].map(|i| upper_right[i] + lower_right[i] - upper_left[i] - lower_left[i]);
        Some(Placed {
            at: [0, 1].map(|i| 0.25 * corners.iter().map(|at| at[i]).sum::<f64>()),
            yaw: right[1].atan2(right[0]),
            scale: 1.0,
        })
    }

    /// Correlation of cells' light with the pattern, turned by so many quarters clockwise to be upright.
    fn alike(&self, lights: &[f64], quarters: usize) -> f64 {
        let across = self.pattern.across;
        let (mut sum, mut squares, mut white, mut both) = (0.0, 0.0, 0.0, 0.0);
        for (k, light) in lights.iter().enumerate() {
            let (mut row, mut column) = (k / across, k % across);
            for _ in 0..quarters {
                (row, column) = (column, across - 1 - row);
            }
            sum += light;
            squares += light * light;
            if !self.pattern.is_black(column, row) {
                white += 1.0;
                both += light;
            }
        }
        let count = lights.len() as f64;
        let covariance = both - white * sum / count;
        let variances = (squares - sum * sum / count) * (white - white * white / count);
        covariance / variances.max(f64::MIN_POSITIVE).sqrt()
    }

    /// The marker laid onto the image from a start on; none where it is not it.
    fn fitted(
        &self,
        image: &Image,
        light: &[f32; 256],
        camera: &CameraModel,
        start: Placed,
    ) -> Option<ByMarker> {
        let pixels = self.pixels(image, light, camera, &start)?;
        let fit = fit_marker(&self.pattern, self.side, &pixels, start)?;
        let MarkerFit {
            placed,
            deviation,
            explained,
            wrong,
            contrast,
        } = fit;
        let larger = placed.scale.ln().abs();
        let pixel = camera.pixel([placed.at[0], placed.at[1], self.height])?;
        let beside = camera.pixel([placed.at[0] + self.side, placed.at[1], self.height])?;
        let metre = self.side / (beside[0] - pixel[0]).hypot(beside[1] - pixel[1]);
        let unseen = UNSEEN.hypot(UNSEEN_PX * metre);
        let deviation = [
            (NOT_INDEPENDENT * deviation[0]).hypot(unseen),
            (NOT_INDEPENDENT * deviation[1]).hypot(unseen / (0.5 * self.side)),
        ];
        let is_it = wrong <= MOST_WRONG
            && explained >= LEAST_EXPLAINED
            && contrast >= LEAST_CONTRAST
            && larger <= MOST_LARGER
            && deviation[0] <= MOST_DEVIATION;
        is_it.then(|| ByMarker {
            pose: self.pose(&placed),
            pixel,
            deviation,
            scale: placed.scale,
            quality: explained,
        })
    }

    /// Where the object is under its marker.
    fn pose(&self, placed: &Placed) -> Pose {
        let yaw = placed.yaw - self.yaw;
        let (sin, cos) = yaw.sin_cos();
        Pose {
            x: placed.at[0] - cos * self.offset.x + sin * self.offset.y,
            y: placed.at[1] - sin * self.offset.x - cos * self.offset.y,
            yaw: wrap_angle(yaw),
        }
    }

    /// The pixels that show it, and a little of what is around; none where it is cut by the border.
    fn pixels(
        &self,
        image: &Image,
        light: &[f32; 256],
        camera: &CameraModel,
        placed: &Placed,
    ) -> Option<Vec<Lit>> {
        let margin = MARGIN / self.pattern.across as f64;
        let reach = (0.5 + margin) * self.side;
        let (sin, cos) = placed.yaw.sin_cos();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for [i, j] in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
            let [x, y] = [i * reach, j * reach];
            let at = [
                placed.at[0] + cos * x - sin * y,
                placed.at[1] + sin * x + cos * y,
            ];
            let pixel = camera.pixel([at[0], at[1], self.height])?;
            low = [0, 1].map(|k| low[k].min(pixel[k]));
            high = [0, 1].map(|k| high[k].max(pixel[k]));
        }
        let size = [image.width as f64, image.height as f64];
        if (0..2).any(|k| low[k] < 0.0 || high[k] > size[k] - 1.0) {
            return None;
        }
        let [left, top] = low.map(|at| at.floor() as usize);
        let [right, bottom] = high.map(|at| at.ceil() as usize);
        let all = (right - left + 1) * (bottom - top + 1);
        let step = ((all as f64 / MOST_PIXELS as f64).sqrt().ceil() as usize).max(1);
        let mut pixels = Vec::new();
        for row in (top..=bottom.min(image.height - 1)).step_by(step) {
            for column in (left..=right.min(image.width - 1)).step_by(step) {
                let Some(at) = camera.point([column as f64, row as f64], self.height) else {
                    continue;
                };
                let at = [at.x, at.y];
                if is_on(&self.pattern, self.side, at, placed, MARGIN) {
                    let [r, g, b] = image
                        .pixel(column, row)
                        .map(|byte| light[usize::from(byte)]);
                    // Weights of ITU-R BT.601.
                    let seen = 0.299 * r + 0.587 * g + 0.114 * b;
                    pixels.push((at, f64::from(seen)));
                }
            }
        }
        Some(pixels)
    }
}

fn is_near(a: &Pose, b: &Pose, far: f64) -> bool {
    (a.x - b.x).hypot(a.y - b.y) < far
}
