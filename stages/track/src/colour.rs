//! Colours: the range that the rig file gives, and how far a pixel is object and not table.

use values::Colour;

use crate::Image;

/// A range of hue, saturation and value, tested without division.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Range {
    /// Hue in degrees.
    hue: [f32; 2],
    /// Saturation in parts of 1024.
    saturation: [u32; 2],
    /// Value, 0 to 255.
    value: [u8; 2],
}

impl Range {
    pub(crate) fn of(colour: &Colour) -> Self {
        let share = |share: f64| (share * 1024.0).round() as u32;
        Self {
            hue: [colour.hue.low as f32, colour.hue.high as f32],
            saturation: [share(colour.saturation.low), share(colour.saturation.high)],
            value: [colour.value.low, colour.value.high].map(|share| (share * 255.0).round() as u8),
        }
    }

    /// Whether a pixel lies in the range; without colours its value alone counts.
    #[inline]
    pub(crate) fn contains(&self, [r, g, b]: [u8; 3], grey: bool) -> bool {
        let high = r.max(g).max(b);
        if high < self.value[0] || high > self.value[1] {
            return false;
        }
        if grey {
            return true;
        }
        let low = r.min(g).min(b);
        let chroma = u32::from(high - low);
        let whole = u32::from(high);
        if chroma * 1024 < self.saturation[0] * whole || chroma * 1024 > self.saturation[1] * whole
        {
            return false;
        }
        if chroma == 0 {
            return true;
        }
        let [r, g, b] = [r, g, b].map(f32::from);
        let chroma = chroma as f32;
        let high = f32::from(high);
        let sixth = if high == r {
            (g - b) / chroma
        } else if high == g {
            2.0 + (b - r) / chroma
        } else {
            4.0 + (r - g) / chroma
        };
        let hue = (60.0 * sixth).rem_euclid(360.0);
        let [from, to] = self.hue;
        if from <= to {
            (from..=to).contains(&hue)
        } else {
            hue >= from || hue <= to
        }
    }
}

/// A byte as a number, 0 to 1. Cameras and JPEG average the colour of neighbouring pixels as bytes (4:2:0): of these, the area under an edge is kept.
pub(crate) fn codes_of_bytes() -> [f32; 256] {
    std::array::from_fn(|byte| byte as f32 / 255.0)
}

/// sRGB's curve (IEC 61966-2-1) undone, for each byte: light, 0 to 1. Light adds up; bytes do not.
pub(crate) fn light_of_bytes() -> [f32; 256] {
    std::array::from_fn(|byte| light_of(byte as f64 / 255.0) as f32)
}

/// The light, 0 to 1, that a byte shows, given as a share of 255: sRGB's curve undone.
pub(crate) fn light_of(byte: f64) -> f64 {
    if byte <= 0.040_45 {
        byte / 12.92
    } else {
        ((byte + 0.055) / 1.055).powf(2.4)
    }
}

/// The byte that shows this light, as a share of 255, and its derivative by the light.
pub(crate) fn byte_of(light: f64) -> (f64, f64) {
    if light <= 0.003_130_8 {
        return (12.92 * light.max(0.0), 12.92);
    }
    let power = 1.055 * light.powf(1.0 / 2.4);
    (power - 0.055, power / (2.4 * light))
}

/// How far a pixel is object (1) and not table (0): a linear function of its light, or of its bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contrast {
    weights: [f32; 3],
    offset: f32,
}

/// The object's light must stand off the table's direction by this share of its own to be distinguished from its shadows.
const LEAST_CHROMA: f32 = 0.2;
/// Light of object and table that differ by less than this, of 1, cannot be distinguished.
const LEAST_DIFFERENCE: f32 = 0.03;

impl Contrast {
    /// The function that is 1 for the object and 0 for the table, and for the table in any shade where the two differ in colour;
    /// none where they look alike.
    pub(crate) fn between(object: [f32; 3], table: [f32; 3], grey: bool) -> Option<Self> {
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let along = dot(object, table) / dot(table, table).max(1e-9);
        let off = [0, 1, 2].map(|i| object[i] - along * table[i]);
        let off_share = (dot(off, off) / dot(object, object).max(1e-9)).sqrt();
        if !grey && off_share > LEAST_CHROMA {
            let scale = dot(off, object);
            return Some(Self {
                weights: off.map(|part| part / scale),
                offset: 0.0,
            });
        }
        let difference = [0, 1, 2].map(|i| object[i] - table[i]);
        let square = dot(difference, difference);
        (square.sqrt() > LEAST_DIFFERENCE).then(|| {
            let weights = difference.map(|part| part / square);
            Self {
                weights,
                offset: -dot(weights, table),
            }
        })
    }

    pub(crate) fn of(&self, light: [f32; 3]) -> f32 {
        self.offset + (0..3).map(|i| self.weights[i] * light[i]).sum::<f32>()
    }

    /// Its values over a part of an image.
    pub(crate) fn map(&self, image: &Image, light: &[f32; 256], part: Part) -> Map {
        let tables: [[f32; 256]; 3] = [0, 1, 2].map(|i| light.map(|light| light * self.weights[i]));
        let mut values = Vec::with_capacity(part.width * part.height);
        for row in part.top..part.top + part.height {
            let from = 3 * (row * image.width + part.left);
            let pixels = image.rgb[from..from + 3 * part.width].chunks_exact(3);
            values.extend(pixels.map(|rgb| {
                self.offset
                    + tables[0][usize::from(rgb[0])]
                    + tables[1][usize::from(rgb[1])]
                    + tables[2][usize::from(rgb[2])]
            }));
        }
        Map { part, values }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Part {
    /// The pixels within bounds `[[x, y], [x, y]]` that an image has.
    pub(crate) fn of(image: &Image, [low, high]: [[f64; 2]; 2]) -> Self {
        let from = |low: f64, size: usize| (low.max(0.0).floor() as usize).min(size);
        let (left, top) = (from(low[0], image.width), from(low[1], image.height));
        let to = |high: f64, size: usize| ((high + 1.0).max(0.0).ceil() as usize).min(size);
        Self {
            left,
            top,
            width: to(high[0], image.width).saturating_sub(left),
            height: to(high[1], image.height).saturating_sub(top),
        }
    }
}

/// Values over a part of an image.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) part: Part,
    pub(crate) values: Vec<f32>,
}

impl Map {
    /// The value between pixels, bilinear; none outside.
    #[inline]
    pub(crate) fn at(&self, x: f64, y: f64) -> Option<f32> {
        let (x, y) = (x - self.part.left as f64, y - self.part.top as f64);
        if x < 0.0 || y < 0.0 {
            return None;
        }
        let (column, row, width) = (x as usize, y as usize, self.part.width);
        let (a, b) = ((x - column as f64) as f32, (y - row as f64) as f32);
        if column + 1 >= width || row + 1 >= self.part.height {
            return None;
        }
        let at = row * width + column;
        let between = |at: usize| {
            let pair = &self.values[at..at + 2];
            pair[0] * (1.0 - a) + pair[1] * a
        };
        Some(between(at) * (1.0 - b) + between(at + width) * b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hue_may_wrap_around() {
        let range = Range::of(&Colour::demo());
        assert!(range.contains([200, 40, 60], false));
        assert!(range.contains([200, 60, 40], false));
        assert!(!range.contains([60, 200, 40], false));
        assert!(!range.contains([200, 190, 190], false), "too pale");
        assert!(!range.contains([20, 2, 2], false), "too dark");
    }

    #[test]
    fn a_shadow_of_the_table_is_table() {
        let (object, table) = ([0.6, 0.05, 0.05], [0.4, 0.4, 0.38]);
        let contrast = Contrast::between(object, table, false).expect("they differ");
        let value = |light: [f32; 3]| contrast.of(light);
        assert!((value(object) - 1.0).abs() < 1e-5);
        assert!(value(table).abs() < 1e-5);
        assert!(value(table.map(|part| part * 0.4)).abs() < 1e-5);
        assert!(Contrast::between(table, table, false).is_none());
        assert!(Contrast::between([0.5; 3], [0.1; 3], true).is_some());
    }
}
