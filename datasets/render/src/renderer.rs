//! Rays from pixels, added up.

use crate::light::byte;
use crate::noise::{bells, noisy};
use crate::optics::Rays;
use crate::solid::Hit;
use crate::{Moment, Optics, Picture, Scene};

/// A camera before a scene.
#[derive(Clone, Debug)]
pub struct Renderer {
    optics: Optics,
    scene: Scene,
    /// Standard deviation of a byte.
    noise: f64,
    /// Rays across a pixel: their square is cast for each.
    across: usize,
    rays: Rays,
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
    /// Area of the object's picture in px².
    pub area: f64,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug)]
enum Met {
    Table,
    Cover(usize),
    Object {
        index: usize,
        object: Moment,
        hit: Hit,
    },
}

/// A surface, by number: thing and face.
type Surface = (usize, usize);
const TABLE: Surface = (0, 0);

impl Met {
    fn surface(&self) -> Surface {
        match self {
            Self::Table => TABLE,
            Self::Cover(cover) => (1, *cover),
            Self::Object { index, hit, .. } => (2 + index, hit.face),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        self.surface() == other.surface()
    }
}

/// Rays across a pixel where it and its neighbours show one surface of an object: its light changes slowly. One is enough for the table.
const ACROSS_SURFACE: usize = 2;
/// Positions of the object that are worked out for one picture.
const MOMENTS: usize = 64;
/// The golden section: its multiples fill an interval evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Renderer {
    /// A camera with this noise (standard deviation of a byte), which casts the square of `across` rays for each pixel.
    pub fn new(optics: Optics, scene: Scene, noise: f64, across: usize) -> Self {
        let [width, height] = [optics.width, optics.height].map(|size| size as f64);
        let middle = optics.on_table(optics.ray(0.5 * width, 0.5 * height));
        let mut renderer = Self {
            optics,
            scene,
            noise,
            across: across.max(1),
            rays: Rays::of(&optics),
            bare: Vec::new(),
            bells: bells(),
            middle,
        };
        renderer.lay_table();
        renderer
    }

    fn lay_table(&mut self) {
        let (width, height) = (self.optics.width, self.optics.height);
        let mut bare = Vec::with_capacity(3 * width * height);
        for row in 0..height {
            for column in 0..width {
                let ray = self.rays.through(column, row, 0.5, 0.5);
                let light = self
                    .scene
                    .table_light(self.optics.on_table(ray), self.middle);
                bare.extend(light.map(byte));
            }
        }
        self.bare = bare;
    }

    /// The camera.
    pub fn optics(&self) -> &Optics {
        &self.optics
    }

    /// Puts another scene before it.
    pub fn set_scene(&mut self, scene: Scene) {
        let is_same_table = self.scene.has_table_of(&scene);
        self.scene = scene;
        if !is_same_table {
            self.lay_table();
        }
    }

    /// Takes a picture; `path` gives where the object is so many seconds after the middle of the first row's exposure.
    pub fn render(&self, path: &dyn Fn(f64) -> Moment, seed: u64) -> Rendering {
        let (width, height) = (self.optics.width, self.optics.height);
        let begin = -0.5 * self.optics.exposure;
        let lasts = self.optics.exposure + self.optics.readout;
        let moments: Vec<Moment> = (0..=MOMENTS)
            .map(|k| path(begin + lasts * k as f64 / MOMENTS as f64))
            .collect();
        let mut bytes = self.bare.clone();
        let (mut seen, mut sum) = (0.0, [0.0; 2]);
        let regions = self.regions(&moments);
        for (index, &region) in regions.iter().enumerate() {
            let surfaces = self.surfaces(region, &moments);
            let [left, top, right, bottom] = region;
            let pixels =
                (top..bottom).flat_map(|row| (left..right).map(move |column| (column, row)));
            for ((column, row), surface) in pixels.zip(surfaces) {
                let across = match surface {
                    Some(TABLE) => 1,
                    Some(_) => self.across.min(ACROSS_SURFACE),
                    None => self.across,
                };
                let (light, object) = self.pixel(column, row, &moments, across);
                let at = 3 * (row * width + column);
                for (to, light) in bytes[at..at + 3].iter_mut().zip(light) {
                    *to = byte(light);
                }
                // Regions overlap: a pixel counts once.
                if regions[..index]
                    .iter()
                    .any(|region| holds(region, [column, row]))
                {
                    continue;
                }
                seen += object;
                sum[0] += object * column as f64;
                sum[1] += object * row as f64;
            }
        }
        let rgb = noisy(&bytes, self.noise, &self.bells, seed);
        Rendering {
            picture: Picture { width, height, rgb },
            centroid: (seen > 0.0).then(|| sum.map(|sum| sum / seen)),
            area: seen,
        }
    }

    /// Of each pixel of a region, row by row: the surface that it and its neighbours show throughout the exposure, where it is one.
    fn surfaces(&self, region: [usize; 4], moments: &[Moment]) -> Vec<Option<Surface>> {
        let [left, top, right, bottom] = region;
        // With a rim of one pixel, which ends at the picture's border.
        let (first, last) = (left.saturating_sub(1), (right + 1).min(self.optics.width));
        let (above, below) = (top.saturating_sub(1), (bottom + 1).min(self.optics.height));
        let width = last - first;
        let mut met = Vec::with_capacity(width * (below - above));
        for row in above..below {
            for column in first..last {
                let ray = self.rays.through(column, row, 0.5, 0.5);
                let at = |share: f64| self.meet(ray, between(moments, self.exposed(row, share)));
                let begin = at(0.0);
                let is_still = self.optics.exposure == 0.0;
                let is_same = is_still || (at(0.5).is_like(&begin) && at(1.0).is_like(&begin));
                met.push(is_same.then_some(begin.surface()));
            }
        }
        let mut surfaces = Vec::with_capacity((right - left) * (bottom - top));
        for row in top..bottom {
            for column in left..right {
                let at = |row: usize, column: usize| met[(row - above) * width + column - first];
                let here = at(row, column);
                let rows = row.saturating_sub(1).max(above)..(row + 2).min(below);
                let is_one = rows.into_iter().all(|row| {
                    let columns = column.saturating_sub(1).max(first)..(column + 2).min(last);
                    columns.into_iter().all(|column| at(row, column) == here)
                });
                surfaces.push(here.filter(|_| is_one));
            }
        }
        surfaces
    }

    /// The share (0 to 1) of all rows' exposure at which a share of this row's is over.
    fn exposed(&self, row: usize, share: f64) -> f64 {
        let whole = self.optics.exposure + self.optics.readout;
        let rows = self.optics.height.max(2) - 1;
        let begin = self.optics.readout * row as f64 / rows as f64;
        if whole > 0.0 {
            (begin + self.optics.exposure * share) / whole
        } else {
            0.5
        }
    }

    /// Light of a pixel from so many rays across, and the share of it that is object.
    fn pixel(&self, column: usize, row: usize, moments: &[Moment], n: usize) -> ([f64; 3], f64) {
        let count = n * n;
        let first = (column as f64 * GOLDEN + row as f64 * GOLDEN * GOLDEN).fract();
        let (mut light, mut object) = ([0.0; 3], 0.0);
        for k in 0..count {
            let (i, j) = (k % n, k / n);
            let share = |i: usize| (i as f64 + 0.5) / n as f64;
            let ray = self.rays.through(column, row, share(i), share(j));
            // Every ray has its own time in the exposure; over the pixel they are even.
            let at = self.exposed(row, (first + k as f64 * GOLDEN).fract());
            let (part, is_object) = self.cast(ray, between(moments, at));
            light = [0, 1, 2].map(|i| light[i] + part[i] / count as f64);
            object += f64::from(u8::from(is_object)) / count as f64;
        }
        (light, object)
    }

    fn meet(&self, ray: [f64; 3], moment: Moment) -> Met {
        let origin = self.optics.position;
        if let Some(cover) = self.scene.covered(origin, ray) {
            return Met::Cover(cover);
        }
        let objects = std::iter::once(moment).chain(self.scene.others.iter().copied());
        for (index, object) in objects.enumerate() {
            if let Some(hit) = self.scene.form.hit(object, origin, ray) {
                return Met::Object { index, object, hit };
            }
        }
        Met::Table
    }

    /// The light along a ray, and whether it comes from the object.
    fn cast(&self, ray: [f64; 3], moment: Moment) -> ([f64; 3], bool) {
        let scene = &self.scene;
        match self.meet(ray, moment) {
            Met::Cover(cover) => (scene.covers[cover].colour, false),
            Met::Object { index, object, hit } => {
                let at = [0, 1, 2].map(|i| self.optics.position[i] + hit.along * ray[i]);
                let light = scene.object_light(object, at, hit.normal, self.middle);
                (light, index == 0)
            }
            Met::Table => {
                let at = self.optics.on_table(ray);
                let objects = std::iter::once(&moment).chain(&scene.others);
                let past: f64 = objects.map(|object| scene.past(*object, at)).product();
                let light = scene.table_light(at, self.middle);
                (light.map(|part| part * past), false)
            }
        }
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

fn holds([left, top, right, bottom]: &[usize; 4], [column, row]: [usize; 2]) -> bool {
    (*left..*right).contains(&column) && (*top..*bottom).contains(&row)
}

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
