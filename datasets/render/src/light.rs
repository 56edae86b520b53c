//! How much light comes from a point.

use crate::{Moment, Scene};

/// From 0 to 1 between two values, without corners.
fn smooth(low: f64, high: f64, at: f64) -> f64 {
    let share = ((at - low) / (high - low).max(1e-12)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

fn to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let ab = [b[0] - a[0], b[1] - a[1]];
    let ap = [p[0] - a[0], p[1] - a[1]];
    let square = ab[0] * ab[0] + ab[1] * ab[1];
    let share = if square > 0.0 {
        ((ap[0] * ab[0] + ap[1] * ab[1]) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (ap[0] - share * ab[0]).hypot(ap[1] - share * ab[1])
}

impl Scene {
    /// Light that falls on a point, of that at `middle`.
    fn lit(&self, [x, y]: [f64; 2], middle: [f64; 2]) -> f64 {
        let even = 1.0 + self.gradient[0] * (x - middle[0]) + self.gradient[1] * (y - middle[1]);
        let shade = self.shade.map_or(0.0, |shade| {
            let depth = (x - shade.at[0]) * shade.into[0] + (y - shade.at[1]) * shade.into[1];
            shade.strength * smooth(-0.5 * shade.soft, 0.5 * shade.soft, depth)
        });
        even.max(0.05) * (1.0 - shade)
    }

    pub(crate) fn table_light(&self, [x, y]: [f64; 2], middle: [f64; 2]) -> [f64; 3] {
        let pattern = (90.0 * x + 4.0 * (23.0 * y).sin()).sin() * (31.0 * x - 57.0 * y).cos();
        let lit = self.lit([x, y], middle) * (1.0 + self.grain * pattern);
        self.table.map(|part| part * lit)
    }

    /// Share of the light at a point of the table that an object there leaves.
    pub(crate) fn past(&self, object: Moment, at: [f64; 2]) -> f64 {
        let [length, soft, strength] = self.shadow;
        let (sin, cos) = self.light_from.sin_cos();
        let foot = [object.x, object.y];
        let end = [foot[0] - length * cos, foot[1] - length * sin];
        let inside = self.form.base() - to_segment(at, foot, end);
        1.0 - strength * smooth(-0.5 * soft, 0.5 * soft, inside)
    }

    /// Light from a point of an object with this normal.
    pub(crate) fn object_light(
        &self,
        object: Moment,
        at: [f64; 3],
        normal: [f64; 3],
        middle: [f64; 2],
    ) -> [f64; 3] {
        let lit = self.lit([at[0], at[1]], middle);
        let (sin, cos) = self.light_from.sin_cos();
        let facing = 0.5 + 0.5 * (normal[0] * cos + normal[1] * sin);
        let side = self.sides[1] + (self.sides[0] - self.sides[1]) * facing;
        let up = normal[2].clamp(0.0, 1.0);
        let light = lit * (up + (1.0 - up) * side);
        let colour = self.object.map(|part| part * light);
        match self.glare {
            Some(glare) if up > 0.9 => {
                let from = [
                    at[0] - object.x - glare.at[0],
                    at[1] - object.y - glare.at[1],
                ];
                let share = 1.0 - smooth(0.6 * glare.radius, glare.radius, from[0].hypot(from[1]));
                colour.map(|part| part + share * 1.2)
            }
            _ => colour,
        }
    }

    /// The number of the cover, if any, that hides what a ray from `origin` along `ray` meets.
    pub(crate) fn covered(&self, origin: [f64; 3], ray: [f64; 3]) -> Option<usize> {
        self.covers.iter().position(|cover| {
            let along = (cover.height - origin[2]) / ray[2];
            let at = [origin[0] + along * ray[0], origin[1] + along * ray[1]];
            along > 0.0 && to_segment(at, cover.from, cover.to) < cover.radius
        })
    }

    /// Whether the bare table looks alike in both.
    pub(crate) fn has_table_of(&self, other: &Self) -> bool {
        self.table == other.table
            && self.grain == other.grain
            && self.gradient == other.gradient
            && self.shade == other.shade
    }
}

/// sRGB's byte of light (IEC 61966-2-1), not rounded.
pub(crate) fn byte(light: f64) -> f32 {
    let light = light.clamp(0.0, 1.0);
    let value = if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (255.0 * value) as f32
}
