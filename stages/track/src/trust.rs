//! Whether a fit is to be believed.

use serde::{Deserialize, Serialize};

use crate::Image;
use crate::fit::{Fit, NoFit};
use crate::outline::Solid;

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
    /// It is too dark to tell its colour.
    Shaded,
    /// What is seen has not the object's shape or size.
    Shape,
    /// The image was seen before, while the object moved.
    Repeated,
    /// The stamp is not after the one before.
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
/// All bytes of a pixel at or over this are glare.
const GLARE: u8 = 245;
/// A pixel with less than this share of the object's light is dark.
const DARK: f32 = 0.25;

/// How much of a fit agrees, 0 to 1, or why it is not believed.
pub(crate) fn judge(
    image: &Image,
    light: &[f32; 256],
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
    if fit.larger.abs() > SIZE.max(SIZE_SHARE * half_width) {
        return Err((Reason::Shape, quality));
    }
    Ok(quality)
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
                } else if rgb.iter().all(|byte| *byte >= GLARE) {
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
