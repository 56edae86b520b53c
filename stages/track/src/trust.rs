//! Whether a fit is to be believed.

use serde::{Deserialize, Serialize};

use crate::Image;
use crate::colour::Range;
use crate::edges::Ray;
use crate::fit::{Fit, NoFit};
use crate::outline::Solid;
use crate::size::GLARE;

/// Why a frame's centre is not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Nothing of the object's colour and size is on the table.
    NoObject,
    /// More than one thing of the object's colour and size is.
    TwoObjects,
    /// The object is cut by the image's border.
    Border,
    /// Part of it is hidden, by a hand or the arm.
    Occluded,
    /// Glare hides its colour.
    Saturated,
    /// It is too dark to judge its colour.
    Shaded,
    /// What is seen has not the object's shape or size.
    Shape,
    /// The image was seen before, while the object moved.
    Repeated,
    /// The stamp is not after the one before, ahead of those behind, or before 1970.
    Stale,
    /// The image could not be decoded.
    Undecodable,
}

impl Reason {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoObject => "no_object",
            Self::TwoObjects => "two_objects",
            Self::Border => "border",
            Self::Occluded => "occluded",
            Self::Saturated => "saturated",
            Self::Shaded => "shaded",
            Self::Shape => "shape",
            Self::Repeated => "repeated",
            Self::Stale => "stale",
            Self::Undecodable => "undecodable",
        }
    }
}

impl From<NoFit> for Reason {
    fn from(no_fit: NoFit) -> Self {
        match no_fit {
            NoFit::Border => Self::Border,
            NoFit::NoContrast => Self::Shaded,
            NoFit::NoEdges => Self::Shape,
        }
    }
}

/// An edge that lies within this of the outline (px), or this share of the object's half width, agrees with it.
const AGREES: f64 = 0.8;
const AGREES_SHARE: f64 = 0.03;
/// Least share of the outline that must agree, and of the inside that must have the object's colour. A hand that hides more leaves an
/// outline that could lie elsewhere.
const LEAST_OUTLINE: f64 = 0.80;
const LEAST_INSIDE: f64 = 0.75;
/// The object is seen as large as it is to this share of its half width, or to this many px.
const SIZE_SHARE: f64 = 0.08;
const SIZE: f64 = 1.2;
/// The inside's contrast lies within this range of its middle's: what is outside has another colour or is too dark.
const INSIDE: std::ops::Range<f32> = 0.35..2.5;
/// A pixel with less than this share of the object's light is dark.
const DARK: f32 = 0.25;

/// A centre that is off by more than this (m) is wrong.
const WRONG: f64 = 0.003;
/// A third of the outline may move the centre by half of that: what misleads one third hardly misleads the others alike. Where a hard shadow
/// lies around, which may, each third may move it by its third.
const MOST_PULL: f64 = WRONG / 2.0;
const MOST_PULL_IN_SHADOW: f64 = WRONG / 3.0;

/// Most of what is seen just outside the outline that may have the object's colour, or glare: dust and noise.
const MOST_OUTSIDE: f64 = 0.05;

/// The table's light is that which this share of it stays below: without what is brighter than the table.
const BRIGHT_SHARE: f64 = 0.9;
/// Most of a face under a hard shadow's edge that may be lit otherwise than the rest: noise.
const MOST_ODD: f64 = 0.03;

/// How much of a fit agrees, 0 to 1, or why it is not believed.
pub(crate) fn judge(
    image: &Image,
    light: &[f32; 256],
    range: &Range,
    solid: &Solid,
    fit: &Fit,
) -> Result<f64, (Reason, f64)> {
    let scale = fit
        .outline
        .vertices
        .first()
        .map_or(1.0, |vertex| vertex.moves[0][0].hypot(vertex.moves[0][1]));
    let half_width = scale * solid.half_width();
    let tolerance = AGREES.max(AGREES_SHARE * half_width);
    let agrees = |left: &&Option<f64>| left.is_some_and(|left| left.abs() < tolerance);
    let count = fit.residuals.iter().filter(agrees).count();
    let outline = count as f64 / fit.residuals.len().max(1) as f64;

    let inside = Inside::count(image, light, fit);
    let quality = outline * inside.share;
    if inside.share < LEAST_INSIDE {
        return Err((inside.reason, quality));
    }
    if outline < LEAST_OUTLINE {
        return Err((Reason::Occluded, quality));
    }
    let is_half_dark = is_table_half_dark(image, light, fit);
    if is_half_dark && is_face_half_dark(fit) {
        return Err((Reason::Shaded, quality));
    }
    let outside = Outside::count(image, light, range, fit);
    let most_pull = if is_half_dark {
        MOST_PULL_IN_SHADOW
    } else {
        MOST_PULL
    };
    if outside.is_much() || fit.pull > most_pull {
        return Err((outside.reason(), quality));
    }
    if fit.larger.abs() > SIZE.max(SIZE_SHARE * half_width) {
        return Err((Reason::Shape, quality));
    }
    Ok(quality)
}

/// The pixel so far (px) outwards along a ray.
fn pixel(image: &Image, ray: &Ray, far: f64) -> Option<[u8; 3]> {
    let [x, y] = [0, 1].map(|i| (ray.at[i] + far * ray.normal[i]).round());
    let is_in = x >= 0.0 && y >= 0.0 && x < image.width as f64 && y < image.height as f64;
    is_in.then(|| image.pixel(x as usize, y as usize))
}

fn is_glare(rgb: [u8; 3]) -> bool {
    rgb.iter().all(|byte| *byte >= GLARE)
}

/// Whether a part of the table around the object has too little light, of the rest, for an edge to be seen there: a hard shadow, which may be
/// the object's own.
fn is_table_half_dark(image: &Image, light: &[f32; 256], fit: &Fit) -> bool {
    let light_of = |ray: &Ray, far: f64| {
        let rgb = pixel(image, ray, far)?;
        Some(rgb.iter().map(|byte| light[usize::from(*byte)]).sum())
    };
    let beyond = |ray| [0.5, 1.5, 2.5].map(|beyond| light_of(ray, fit.clear + beyond));
    let mut table: Vec<f32> = fit.rays.iter().flat_map(beyond).flatten().collect();
    let bright = (BRIGHT_SHARE * table.len() as f64) as usize;
    if bright >= table.len() {
        return false;
    }
    let (_, bright, _) = table.select_nth_unstable_by(bright, f32::total_cmp);
    let least = INSIDE.start * *bright;
    let dark = table.iter().filter(|seen| **seen < least).count();
    dark as f64 > MOST_OUTSIDE * table.len() as f64
}

/// Whether the edge of a hard shadow runs over the object's face: the object's own shadow, however deep, does not.
fn is_face_half_dark(fit: &Fit) -> bool {
    let inside = |ray: &Ray| {
        let inset = ray.band + fit.clear;
        [0.0, 1.0, 2.0].map(|further| {
            let at = [0, 1].map(|i| ray.at[i] - (inset + further) * ray.normal[i]);
            fit.map.at(at[0], at[1])
        })
    };
    let face: Vec<f32> = fit.rays.iter().flat_map(inside).flatten().collect();
    let odd = face.iter().filter(|value| !INSIDE.contains(value)).count();
    odd as f64 > MOST_ODD * face.len() as f64
}

/// Signs that the object goes on outside the outline: there, where the blurred edge has ended, is its colour, or glare that the table
/// has not. A hard shadow across the object, or a lamp's reflection, makes such an outline.
struct Outside {
    glare: usize,
    dark: usize,
    object: usize,
    all: usize,
}

impl Outside {
    fn count(image: &Image, light: &[f32; 256], range: &Range, fit: &Fit) -> Self {
        let mut count = Self {
            glare: 0,
            dark: 0,
            object: 0,
            all: 0,
        };
        let total: f32 = fit.object.iter().sum();
        for ray in &fit.rays {
            for beyond in [0.5, 1.5, 2.5] {
                // No blur between object and table is as bright as glare: it is looked for at the outline itself.
                let near = pixel(image, ray, beyond);
                if near.is_some_and(is_glare) && !fit.is_table_bright {
                    count.glare += 1;
                }
                let Some(rgb) = pixel(image, ray, fit.clear + beyond) else {
                    continue;
                };
                count.all += 1;
                let seen: f32 = rgb.iter().map(|byte| light[usize::from(*byte)]).sum();
                if range.contains(rgb, image.grey) {
                    if seen < DARK * total {
                        count.dark += 1;
                    } else {
                        count.object += 1;
                    }
                }
            }
        }
        count
    }

    fn is_much(&self) -> bool {
        let odd = self.glare + self.dark + self.object;
        odd as f64 > MOST_OUTSIDE * self.all as f64
    }

    fn reason(&self) -> Reason {
        if self.glare > self.dark.max(self.object) {
            Reason::Saturated
        } else if self.dark > self.object {
            Reason::Shaded
        } else {
            Reason::Occluded
        }
    }
}

/// What lies inside the outline.
struct Inside {
    /// Share that has the object's colour.
    share: f64,
    /// What most of the rest is.
    reason: Reason,
}

impl Inside {
    fn count(image: &Image, light: &[f32; 256], fit: &Fit) -> Self {
        /// Rings between the middle and the outline.
        const RINGS: usize = 5;
        let (_, centre) = fit.outline.moments();
        let (mut object, mut glare, mut dark, mut other) = (0usize, 0usize, 0usize, 0usize);
        let total: f32 = fit.object.iter().sum();
        for ray in &fit.rays {
            // As far in as the side and the blurred edge leave.
            let inset = (ray.band + fit.window).min(0.5 * crate::outline::distance(ray.at, centre));
            let rim = [0, 1].map(|i| ray.at[i] - inset * ray.normal[i]);
            for ring in 0..RINGS {
                // Of equal area each.
                let share = ((ring as f64 + 0.5) / RINGS as f64).sqrt();
                let at = [0, 1].map(|i| centre[i] + share * (rim[i] - centre[i]));
                let Some(value) = fit.map.at(at[0], at[1]) else {
                    continue;
                };
                let rgb = image.pixel(at[0].round() as usize, at[1].round() as usize);
                let seen: f32 = rgb.iter().map(|byte| light[usize::from(*byte)]).sum();
                if INSIDE.contains(&value) {
                    object += 1;
                } else if is_glare(rgb) {
                    glare += 1;
                } else if seen < DARK * total {
                    dark += 1;
                } else {
                    other += 1;
                }
            }
        }
        let all = (object + glare + dark + other).max(1);
        let reason = if glare > dark.max(other) {
            Reason::Saturated
        } else if dark > other {
            Reason::Shaded
        } else {
            Reason::Occluded
        };
        Self {
            share: object as f64 / all as f64,
            reason,
        }
    }
}
