//! The table around the object in one image: as it was seen without the object where the log shows that, else as it is around.

use crate::Image;
use crate::aligned::Alignment;
use crate::background::Background;

#[derive(Clone, Copy)]
pub(crate) struct Table<'a> {
    pub(crate) image: &'a Image,
    pub(crate) light: &'a [f32; 256],
    pub(crate) codes: &'a [f32; 256],
    pub(crate) median: [f32; 3],
    /// The table without the object, and how it lies in this image.
    pub(crate) background: Option<(&'a Background, Alignment)>,
}

/// Light of the table in shadow, of its light without: from deep shadow to a lamp's gleam.
const SHADED: std::ops::Range<f32> = 0.2..1.25;
/// Light of a table that is bare and not shaded, of its light without.
const BARE: std::ops::Range<f32> = 0.85..1.18;
/// Light of a table on the other side of a hard shadow's edge, of its median light around: in the shadow, or beside it.
const DEEP: std::ops::Range<f32> = 0.02..0.35;
const BESIDE: std::ops::Range<f32> = 2.9..50.0;
/// Greatest difference of colour, as a share of the table's light; and the noise of the dark, of 1.
const OTHER: f32 = 0.14;
const NOISE: f32 = 0.012;

impl Table<'_> {
    /// Light between pixels, bilinear; none outside.
    pub(crate) fn light_at(&self, at: [f64; 2]) -> Option<[f32; 3]> {
        self.between(self.light, at)
    }

    /// Bytes between pixels, as edges are sought in; none outside.
    pub(crate) fn codes_at(&self, at: [f64; 2]) -> Option<[f32; 3]> {
        self.between(self.codes, at)
    }

    fn between(&self, values: &[f32; 256], [x, y]: [f64; 2]) -> Option<[f32; 3]> {
        let Image { width, height, .. } = *self.image;
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let (column, row) = (x as usize, y as usize);
        if column + 1 >= width || row + 1 >= height {
            return None;
        }
        let (a, b) = ((x - column as f64) as f32, (y - row as f64) as f32);
        let at = |dx, dy| self.image.pixel(column + dx, row + dy);
        let (p, q, r, s) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        Some([0, 1, 2].map(|i| {
            let value = |rgb: [u8; 3]| values[usize::from(rgb[i])];
            let upper = value(p) * (1.0 - a) + value(q) * a;
            let lower = value(r) * (1.0 - a) + value(s) * a;
            upper * (1.0 - b) + lower * b
        }))
    }

    /// Whether table is seen here, shaded or not; false outside the image.
    pub(crate) fn is_at(&self, at: [f64; 2]) -> bool {
        self.is_lit(at, SHADED)
    }

    /// Whether bare table is seen here, as bright as it is without the object.
    pub(crate) fn is_bare_at(&self, at: [f64; 2]) -> bool {
        self.is_lit(at, BARE)
    }

    /// Whether table is seen here that the edge of a hard shadow parts from most of that around.
    pub(crate) fn is_parted_at(&self, at: [f64; 2]) -> bool {
        self.is_lit(at, DEEP) || self.is_lit(at, BESIDE)
    }

    fn is_lit(&self, at: [f64; 2], lit: std::ops::Range<f32>) -> bool {
        let Some(seen) = self.light_at(at) else {
            return false;
        };
        let known = self.background.and_then(|(background, alignment)| {
            let [x, y] = [0, 1].map(|i| at[i] - alignment.shift[i]);
            let rgb = background.pixel(x, y)?;
            let light = rgb.map(|byte| self.light[usize::from(byte)] * alignment.light);
            Some(light)
        });
        let table = known.unwrap_or(self.median);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let share = dot(seen, table) / dot(table, table).max(1e-9);
        let off = [0, 1, 2].map(|i| seen[i] - share * table[i]);
        let most = OTHER * dot(seen, seen).sqrt() + NOISE;
        lit.contains(&share) && dot(off, off) < most * most
    }
}
