//! Rays from pixels, added up.

use crate::noise::{Random, bells};
use crate::{Moment, Optics, Picture, Scene};

/// A camera before a scene whose table does not change.
#[derive(Clone, Debug)]
pub struct Renderer {
    optics: Optics,
    scene: Scene,
    /// Standard deviation of a byte.
    noise: f64,
    /// Rays across a pixel: their square is cast for each.
    across: usize,
    /// Rays through the corners of the pixels, in the frame `table`.
    corners: Vec<[f64; 3]>,
    /// The bare table: bytes before they are rounded.
    bare: Vec<f32>,
    bells: Vec<f32>,
    /// The table's point in the middle of the picture, in m.
    middle: [f64; 2],
}

/// A picture and what is known of it.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// What the camera gives.
    pub picture: Picture,
    /// Centroid of the object's picture in px, each pixel weighed by the share that is object; none where it is not seen.
    pub centroid: Option<[f64; 2]>,
}

/// Positions of the object that are worked out for one picture.
const MOMENTS: usize = 64;
/// The golden section: its multiples fill an interval evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Renderer {
    /// A camera with this noise (standard deviation of a byte), which casts the square of `across` rays for each pixel.
    pub fn new(optics: Optics, scene: Scene, noise: f64, across: usize) -> Self {
        let (width, height) = (optics.width, optics.height);
        let mut corners = Vec::with_capacity((width + 1) * (height + 1));
        for row in 0..=height {
            for column in 0..=width {
                corners.push(optics.ray(column as f64 - 0.5, row as f64 - 0.5));
            }
        }
        let ray = optics.ray(0.5 * width as f64, 0.5 * height as f64);
        let along = -optics.position[2] / ray[2];
        let middle = [0, 1].map(|i| optics.position[i] + along * ray[i]);
        let mut renderer = Self {
            optics,
            scene,
            noise,
            across: across.max(1),
            corners,
            bare: Vec::new(),
            bells: bells(),
            middle,
        };
        let mut bare = Vec::with_capacity(3 * width * height);
        for row in 0..height {
            for column in 0..width {
                let ray = renderer.ray(column, row, 0.5, 0.5);
                let light = renderer.scene.table_light(renderer.on_table(ray), middle);
                bare.extend(light.map(byte));
            }
        }
        renderer.bare = bare;
        renderer
    }

    /// The camera.
    pub fn optics(&self) -> &Optics {
        &self.optics
    }

    /// What is before it; others, covers and glare may be changed between pictures.
    pub fn scene_mut(&mut self) -> &mut Scene {
        &mut self.scene
    }

    /// Takes a picture; `path` tells where the object is so many seconds after the middle of the first row's exposure.
    pub fn render(&self, path: &dyn Fn(f64) -> Moment, seed: u64) -> Rendering {
        let (width, height) = (self.optics.width, self.optics.height);
        let begin = -0.5 * self.optics.exposure;
        let lasts = self.optics.exposure + self.optics.readout;
        let moments: Vec<Moment> = (0..=MOMENTS)
            .map(|k| path(begin + lasts * k as f64 / MOMENTS as f64))
            .collect();
        let mut bytes = self.bare.clone();
        let (mut seen, mut sum) = (0.0, [0.0; 2]);
        for [left, top, right, bottom] in self.regions(&moments) {
            for row in top..bottom {
                for column in left..right {
                    let (light, object) = self.pixel(column, row, &moments);
                    let at = 3 * (row * width + column);
                    for (to, light) in bytes[at..at + 3].iter_mut().zip(light) {
                        *to = byte(light);
                    }
                    seen += object;
                    sum[0] += object * column as f64;
                    sum[1] += object * row as f64;
                }
            }
        }
        let mut random = Random(seed);
        let mut rgb = Vec::with_capacity(3 * width * height);
        for four in bytes.chunks(4) {
            let draw = if self.noise > 0.0 { random.next() } else { 0 };
            rgb.extend(four.iter().enumerate().map(|(k, byte)| {
                let noise = if self.noise > 0.0 {
                    self.noise as f32 * self.bells[(draw >> (16 * k)) as usize & 0xffff]
                } else {
                    0.0
                };
                (byte + noise + 0.5).clamp(0.0, 255.0) as u8
            }));
        }
        Rendering {
            picture: Picture { width, height, rgb },
            centroid: (seen > 0.0).then(|| sum.map(|sum| sum / seen)),
        }
    }

    /// Light of a pixel, and the share of it that is object.
    fn pixel(&self, column: usize, row: usize, moments: &[Moment]) -> ([f64; 3], f64) {
        let n = self.across;
        let count = n * n;
        let whole = self.optics.exposure + self.optics.readout;
        let begin = if self.optics.height > 1 {
            self.optics.readout * row as f64 / (self.optics.height - 1) as f64
        } else {
            0.0
        };
        let first = (column as f64 * GOLDEN + row as f64 * GOLDEN * GOLDEN).fract();
        let (mut light, mut object) = ([0.0; 3], 0.0);
        for k in 0..count {
            let (i, j) = (k % n, k / n);
            let share = |i: usize| (i as f64 + 0.5) / n as f64;
            let ray = self.ray(column, row, share(i), share(j));
            // Every ray has its own time in the exposure; over the pixel they are even.
            let time = begin + self.optics.exposure * (first + k as f64 * GOLDEN).fract();
            let at = if whole > 0.0 { time / whole } else { 0.5 };
            let (part, is_object) = self.cast(ray, between(moments, at));
            light = [0, 1, 2].map(|i| light[i] + part[i] / count as f64);
            object += f64::from(u8::from(is_object)) / count as f64;
        }
        (light, object)
    }

    fn cast(&self, ray: [f64; 3], moment: Moment) -> ([f64; 3], bool) {
        let origin = self.optics.position;
        if let Some(colour) = self.scene.covered(origin, ray) {
            return (colour, false);
        }
        let objects = std::iter::once(&moment).chain(&self.scene.others);
        for (index, object) in objects.clone().enumerate() {
            if let Some(hit) = self.scene.form.hit(*object, origin, ray) {
                let at = [0, 1, 2].map(|i| origin[i] + hit.along * ray[i]);
                let scene = &self.scene;
                let light = scene.object_light(*object, at, hit.normal, self.middle);
                return (light, index == 0);
            }
        }
        let at = self.on_table(ray);
        let past: f64 = objects.map(|object| self.scene.past(*object, at)).product();
        let light = self.scene.table_light(at, self.middle);
        (light.map(|part| part * past), false)
    }

    /// The ray through a part (0 to 1 from the left and the top) of a pixel.
    fn ray(&self, column: usize, row: usize, x: f64, y: f64) -> [f64; 3] {
        let at = row * (self.optics.width + 1) + column;
        let below = at + self.optics.width + 1;
        let corner = |at: usize, i: usize| self.corners[at][i];
        [0, 1, 2].map(|i| {
            let upper = corner(at, i) * (1.0 - x) + corner(at + 1, i) * x;
            let lower = corner(below, i) * (1.0 - x) + corner(below + 1, i) * x;
            upper * (1.0 - y) + lower * y
        })
    }

    fn on_table(&self, ray: [f64; 3]) -> [f64; 2] {
        let along = -self.optics.position[2] / ray[2];
        [0, 1].map(|i| self.optics.position[i] + along * ray[i])
    }

    /// Rectangles of pixels (left, top, right, bottom) outside of which nothing but the bare table is seen.
    fn regions(&self, moments: &[Moment]) -> Vec<[usize; 4]> {
        let form = &self.scene.form;
        let [length, soft, _] = self.scene.shadow;
        let around = form.reach() + length + soft;
        let mut regions =
            vec![self.region(moments.iter().map(|at| [at.x, at.y]), around, form.height())];
        for other in &self.scene.others {
            regions.push(self.region([[other.x, other.y]].into_iter(), around, form.height()));
        }
        for cover in &self.scene.covers {
            let ends = [cover.from, cover.to].into_iter();
            regions.push(self.region(ends, cover.radius + 0.01, cover.height));
        }
        regions
    }

    fn region(
        &self,
        places: impl Iterator<Item = [f64; 2]>,
        around: f64,
        height: f64,
    ) -> [usize; 4] {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for [x, y] in places {
            for (dx, dy) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                for z in [0.0, height] {
                    let at = self.optics.seen([x + dx * around, y + dy * around, z]);
                    low = [0, 1].map(|i| low[i].min(at[i]));
                    high = [0, 1].map(|i| high[i].max(at[i]));
                }
            }
        }
        let clamp = |at: f64, size: usize| at.clamp(0.0, size as f64) as usize;
        let (width, height) = (self.optics.width, self.optics.height);
        [
            clamp(low[0] - 1.0, width),
            clamp(low[1] - 1.0, height),
            clamp(high[0] + 2.0, width),
            clamp(high[1] + 2.0, height),
        ]
    }
}

/// The place at a share of the way.
fn between(moments: &[Moment], share: f64) -> Moment {
    let at = share.clamp(0.0, 1.0) * (moments.len() - 1) as f64;
    let index = (at as usize).min(moments.len() - 2);
    let (a, b, s) = (moments[index], moments[index + 1], at - index as f64);
    Moment {
        x: a.x + s * (b.x - a.x),
        y: a.y + s * (b.y - a.y),
        yaw: a.yaw + s * (b.yaw - a.yaw),
    }
}

/// sRGB's byte of light (IEC 61966-2-1), not rounded.
fn byte(light: f64) -> f32 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * value) as f32
}
