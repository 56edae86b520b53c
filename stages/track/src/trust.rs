//! Whether a fit is to be believed.

use serde::{Deserialize, Serialize};

use crate::Image;
use crate::colour::Range;
use crate::edges::Ray;
use crate::fit::{Fit, NoFit};
use crate::outline::Solid;
use crate::size::is_glare;

/// Why a frame's centre is not given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// Nothing of the object's colour and size is on the table.
    NoObject,
    /// The object's marker cannot be read, and nothing else is known of how it looks.
    NoMarker,
    /// More than one thing of the object's colour and size is.
    TwoObjects,
    /// The object is cut by the image's border.
    Border,
    /// Part of the object is hidden, by a hand or the arm.
    Occluded,
    /// Glare hides the object's colour.
    Saturated,
    /// The object is too dark to judge its colour.
    Shaded,
    /// What is seen has not the object's shape or size.
    Shape,
    /// The table is not where it was in the log's other images: the camera was pushed, or something large lies before it.
    Moved,
    /// The object is seen elsewhere than where it rests in the frames before and behind.
    Jumped,
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
            Self::NoMarker => "no_marker",
            Self::TwoObjects => "two_objects",
            Self::Border => "border",
            Self::Occluded => "occluded",
            Self::Saturated => "saturated",
            Self::Shaded => "shaded",
            Self::Shape => "shape",
            Self::Moved => "moved",
            Self::Jumped => "jumped",
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
/// Least share of the outline that must be seen: of less, an outline that lies elsewhere could agree as well. Of one image alone more.
const LEAST_OUTLINE: f64 = 0.50;
const LEAST_ALONE: f64 = 0.60;
/// Where this share of the outline is seen, all inside is the object's, print and labels too; where less, so much of what the outline
/// encloses beside the part that is seen must have its colour.
const WHOLE_OUTLINE: f64 = 0.80;
const LEAST_INSIDE: f64 = 0.75;
/// Most of the outline that may speak against it, inside of which bare table is seen. Something that hides a part and looks like the table
/// is let pass where the rest decides by itself.
const MOST_AGAINST: f64 = 0.08;
const MOST_ALIKE: f64 = 0.35;
/// The object is seen as large as it is to this share of its half width, or to this many px.
const SIZE_SHARE: f64 = 0.08;
const SIZE: f64 = 1.2;
/// Where a part is hidden, an outline that lies elsewhere is one of another size: by so many px, and so many deviations of what the log tells.
const SIZE_IN_PART: f64 = 0.4;
const SURE_SIZE: f64 = 2.0;
/// The inside's contrast lies within this range of its middle's: what is outside has another colour or is too dark.
const INSIDE: std::ops::Range<f32> = 0.62..1.52;
/// A pixel with less than this share of the object's light is dark.
const DARK: f32 = 0.25;

/// A coordinate that is not known to this (standard deviation, m) may be wrong: a centre that is off by 3 mm is. Where all of the outline is seen,
/// nothing pulls all of it to one side.
const MOST_DEVIATION: f64 = 0.0007;
const MOST_DEVIATION_WHOLE: f64 = 0.0013;
/// Where a hard shadow's edge runs by, which is an edge as well, and the log's other images do not show the table.
const MOST_DEVIATION_IN_SHADOW: f64 = 0.00065;

/// What makes an object larger or smaller than it is seen to be does so on all sides alike, or on one: where a part is hidden, its centre is
/// off by half of that.
const OF_SIZE: f64 = 0.5;

/// Most of what is seen just outside the outline that may have the object's colour, or glare: dust and noise.
const MOST_OUTSIDE: f64 = 0.05;

/// What is thought of a fit.
pub(crate) struct Judgement {
    /// Share of outline and inside that agree with the object, 0 to 1.
    pub(crate) quality: f64,
    /// Standard deviation of a coordinate of the centre, in m.
    pub(crate) deviation: f64,
    pub(crate) against: Option<Reason>,
}

/// How much of a fit agrees, and whether it is believed.
pub(crate) fn judge(
    image: &Image,
    light: &[f32; 256],
    range: &Range,
    solid: &Solid,
    fit: &Fit<'_>,
) -> Judgement {
    let scale = fit
        .outline
        .vertices
        .first()
        .map_or(1.0, |vertex| vertex.moves[0][0].hypot(vertex.moves[0][1]));
    let half_width = scale * solid.half_width();
    let tolerance = AGREES.max(AGREES_SHARE * half_width);
    let agrees = |left: &Option<f64>| left.is_some_and(|left| left.abs() < tolerance);
    let rays = fit.rays.len().max(1) as f64;
    let count = fit.residuals.iter().filter(|left| agrees(left)).count();
    let outline = count as f64 / rays;
    // Beside what agrees, what is inside must not be table, nor what is outside object.
    let against = fit.rays.iter().zip(&fit.residuals).filter(|(ray, left)| {
        let at = |far: f64| [0, 1].map(|i| ray.at[i] + far * ray.normal[i]);
        let inset = (ray.band + fit.clear + 0.5).min(half_width);
        !agrees(left)
            && (fit.table.is_bare_at(at(-inset)) && fit.table.is_bare_at(at(-inset - 1.0)))
    });
    let against = against.count() as f64 / rays;

    let inside = Inside::count(image, light, fit, &|left| agrees(left));
    // A log's other images tell how large the object is seen; of one image alone nothing tells how much blur and sharpening make of it.
    let is_known = fit.table.background.is_some();
    let is_whole = outline >= WHOLE_OUTLINE;
    let of_size = if is_whole { 0.0 } else { OF_SIZE };
    let deviation = fit.deviation.hypot(of_size * fit.larger / scale);
    let judged = |against: Option<Reason>| Judgement {
        quality: outline * inside.share,
        deviation,
        against,
    };
    let is_sure = deviation
        < match (is_whole, is_known) {
            (true, true) => MOST_DEVIATION_WHOLE,
            _ if is_in_shadow(fit) => MOST_DEVIATION_IN_SHADOW,
            (true, false) => MOST_DEVIATION_WHOLE,
            (false, _) => MOST_DEVIATION,
        };
    let least_outline = if is_known { LEAST_OUTLINE } else { LEAST_ALONE };
    let least_inside = if is_whole { 0.0 } else { LEAST_INSIDE };
    let most_against = if is_known && is_sure && outline >= LEAST_ALONE {
        MOST_ALIKE
    } else {
        MOST_AGAINST
    };
    if outline < least_outline || inside.beside < least_inside || against > most_against {
        return judged(Some(inside.reason));
    }
    let outside = Outside::count(image, light, range, fit, &agrees);
    // Where much of it is seen, and nothing speaks against it, a doubtful centre is a wide one.
    let is_clear = is_known && outline >= LEAST_ALONE && against == 0.0;
    let is_wide = is_clear && deviation < MOST_DEVIATION_WHOLE;
    if outside.is_much() || !(is_sure || is_wide) {
        return judged(Some(outside.reason()));
    }
    let most_size = match (is_whole, is_known) {
        (true, true) => SIZE.max(SIZE_SHARE * half_width),
        (true, false) => 0.5 * SIZE.max(SIZE_SHARE * half_width),
        (false, true) => SIZE_IN_PART.max(SURE_SIZE * fit.size_known),
        (false, false) => SIZE_IN_PART,
    };
    if fit.larger.abs() > most_size {
        return judged(Some(if is_whole {
            Reason::Shape
        } else {
            Reason::Occluded
        }));
    }
    judged(None)
}

/// The pixel so far (px) outwards along a ray.
fn pixel(image: &Image, ray: &Ray, far: f64) -> Option<[u8; 3]> {
    let [x, y] = [0, 1].map(|i| (ray.at[i] + far * ray.normal[i]).round());
    let is_in = x >= 0.0 && y >= 0.0 && x < image.width as f64 && y < image.height as f64;
    is_in.then(|| image.pixel(x as usize, y as usize))
}

/// Whether the edge of a hard shadow runs over the table around.
fn is_in_shadow(fit: &Fit<'_>) -> bool {
    let parted = fit.rays.iter().filter(|ray| {
        let at = [0, 1].map(|i| ray.at[i] + (fit.clear + 1.5) * ray.normal[i]);
        fit.table.is_parted_at(at)
    });
    parted.count() as f64 > MOST_OUTSIDE * fit.rays.len() as f64
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
    fn count(
        image: &Image,
        light: &[f32; 256],
        range: &Range,
        fit: &Fit<'_>,
        agrees: &dyn Fn(&Option<f64>) -> bool,
    ) -> Self {
        let mut count = Self {
            glare: 0,
            dark: 0,
            object: 0,
            all: 0,
        };
        let total: f32 = fit.object.iter().sum();
        for (ray, left) in fit.rays.iter().zip(&fit.residuals) {
            for beyond in [0.5, 1.5, 2.5] {
                // No blur between object and table is as bright as glare: it is looked for at the outline itself.
                let at = |far: f64| [0, 1].map(|i| ray.at[i] + far * ray.normal[i]);
                // What was there without the object is no part of it.
                let is_known =
                    |far: f64| fit.table.background.is_some() && fit.table.is_bare_at(at(far));
                let near = pixel(image, ray, beyond);
                let is_glare = near.is_some_and(is_glare) && !fit.is_table_bright;
                if is_glare && !is_known(beyond) && !is_known(fit.clear + beyond) {
                    count.glare += 1;
                }
                let Some(rgb) = pixel(image, ray, fit.clear + beyond) else {
                    continue;
                };
                count.all += 1;
                if is_known(fit.clear + beyond) {
                    continue;
                }
                let seen: f32 = rgb.iter().map(|byte| light[usize::from(*byte)]).sum();
                if range.contains(rgb, image.grey) {
                    if seen < DARK * total {
                        count.dark += 1;
                    } else if agrees(left) {
                        // Where no edge is seen, something of its colour lies over it.
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
    /// The object's share beside the part of the outline that agrees, near to it.
    beside: f64,
    /// What most of the rest is.
    reason: Reason,
}

impl Inside {
    fn count(
        image: &Image,
        light: &[f32; 256],
        fit: &Fit<'_>,
        agrees: &dyn Fn(&Option<f64>) -> bool,
    ) -> Self {
        /// Rings between the middle and the outline.
        const RINGS: usize = 5;
        let centre = fit.outline.middle_of_top();
        let (mut object, mut glare, mut dark, mut other) = (0usize, 0usize, 0usize, 0usize);
        let (mut beside, mut of) = (0usize, 0usize);
        let total: f32 = fit.object.iter().sum();
        for (ray, left) in fit.rays.iter().zip(&fit.residuals) {
            // As far in as the side and the blurred edge leave: a side may have another colour.
            let face = crate::outline::distance(ray.at, centre) - ray.band;
            let inset = ray.band + fit.window.min(0.5 * face);
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
                let is_object = INSIDE.contains(&value);
                if ring + 1 == RINGS && agrees(left) {
                    of += 1;
                    beside += usize::from(is_object);
                }
                if is_object {
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
            beside: beside as f64 / of.max(1) as f64,
            reason,
        }
    }
}
