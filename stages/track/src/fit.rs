//! The pose at which the outline lies on the edges seen, step by step.

use crate::change::Change;
use crate::colour::{Contrast, Map, Part, Range};
use crate::edges::{Edge, Ray, edges, rays};
use crate::outline::{Outline, Pose, Solid};
use crate::size::GLARE;
use crate::{CameraModel, Image};

/// What a fit is made with.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) image: &'a Image,
    pub(crate) camera: &'a CameraModel,
    pub(crate) solid: &'a Solid,
    pub(crate) range: &'a Range,
    pub(crate) light: &'a [f32; 256],
    /// How far a point of the object moves within an exposure at the most, in m.
    pub(crate) blur: f64,
}

/// The outline that lies best on the edges.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub(crate) pose: Pose,
    pub(crate) outline: Outline,
    pub(crate) rays: Vec<Ray>,
    /// What is left of each ray's edge, in px; none where there is no edge.
    pub(crate) residuals: Vec<Edge>,
    /// How far a third of the outline moves the centre by itself, in m.
    pub(crate) pull: f64,
    /// How much larger than the outline the object is seen, in px.
    pub(crate) larger: f64,
    pub(crate) map: Map,
    /// Light of the object's middle.
    pub(crate) object: [f32; 3],
    /// Whether the table around is so bright that glare cannot be distinguished from it.
    pub(crate) is_table_bright: bool,
    /// Half width of the search across the outline, in px.
    pub(crate) window: f64,
    /// How far from the outline its blurred edge has ended, in px.
    pub(crate) clear: f64,
}

/// Why there is no fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoFit {
    /// The outline leaves the image.
    Border,
    /// Object and table look alike.
    NoContrast,
    /// Too few edges.
    NoEdges,
}

/// Distance between rays, in px: about that over which JPEG's noise is alike.
const SPACING: f64 = 1.5;
/// Px of a ray at each end from which its levels are taken.
const LEVEL: f64 = 2.5;
/// Px between a level and the blurred edge.
const CLEAR: f64 = 1.5;
/// What a first guess may be off, in px.
const FIRST: f64 = 2.0;
/// Steps of Gauss–Newton at the most, and the move in px at which they end.
const STEPS: usize = 8;
const DONE: f64 = 0.004;
/// A table with more than this share of glare's light cannot be distinguished from it: compression rings.
const BRIGHT: f32 = 0.8;
/// Fewest pixels of the object, and of the table, for their colours.
const FEWEST_PIXELS: usize = 16;

/// Fits the outline from a first guess on.
pub(crate) fn fit(scene: &Scene<'_>, start: Pose) -> Result<Fit, NoFit> {
    let mut pose = start;
    let mut colours: Option<Colours> = None;
    let mut mapped = start;
    for step in 0..STEPS {
        let outline = Outline::seen(scene.camera, scene.solid, pose).ok_or(NoFit::Border)?;
        let scale = outline
            .vertices
            .first()
            .map_or(1.0, |vertex| vertex.moves[0][0].hypot(vertex.moves[0][1]));
        let narrow = scale * scene.solid.half_width();
        let window = LEVEL + CLEAR + 0.5 * scale * scene.blur;
        let first = if step == 0 { FIRST } else { 0.0 };
        let window = (window + first).min(0.8 * narrow).max(2.0);
        let level = LEVEL.min(0.5 * window);
        if leaves(scene.image, &outline) {
            return Err(NoFit::Border);
        }
        let rays = rays(&outline, SPACING);
        let far = scale * (pose.x - mapped.x).hypot(pose.y - mapped.y);
        let seen = match colours.take() {
            Some(colours) if far < FIRST => colours,
            _ => {
                mapped = pose;
                colours_around(scene, &outline, &rays, window)?
            }
        };
        let found = edges(&seen.map, &rays, window, level);
        let turns = scene.solid.turns() && step > 0;
        let change = Change::least(&rays, &found, turns).ok_or(NoFit::NoEdges)?;
        let [x, y, yaw, larger] = change.parts;
        let moved = scale * (x.hypot(y) + scene.solid.reach() * yaw.abs());
        if !moved.is_finite() {
            return Err(NoFit::NoEdges);
        }
        pose.x += x;
        pose.y += y;
        pose.yaw += yaw;
        if (moved < DONE && step > 1) || step + 1 == STEPS {
            return Ok(Fit {
                pose,
                outline,
                residuals: change.residuals(&rays, &found),
                pull: change.pull(&rays, &found, turns).ok_or(NoFit::NoEdges)?,
                rays,
                larger,
                map: seen.map,
                object: seen.object,
                is_table_bright: seen.is_table_bright,
                window,
                clear: window - level,
            });
        }
        colours = Some(seen);
    }
    Err(NoFit::NoEdges)
}

/// Whether an outline comes nearer than this to the image's border (px): its edge cannot be seen then.
fn leaves(image: &Image, outline: &Outline) -> bool {
    const MARGIN: f64 = 2.0;
    let [low, high] = outline.bounds();
    let is_within =
        |i: usize, size: usize| low[i] >= MARGIN && high[i] <= size as f64 - 1.0 - MARGIN;
    !(is_within(0, image.width) && is_within(1, image.height))
}

/// What is known of the colours around an outline.
struct Colours {
    map: Map,
    object: [f32; 3],
    is_table_bright: bool,
}

/// The colours of object and table around an outline, and how far each pixel there is object.
fn colours_around(
    scene: &Scene<'_>,
    outline: &Outline,
    rays: &[Ray],
    window: f64,
) -> Result<Colours, NoFit> {
    let image = scene.image;
    let (_, centre) = outline.moments();
    let pixel = |at: [f64; 2]| {
        let [x, y] = at.map(f64::round);
        let is_in = x >= 0.0 && y >= 0.0 && x < image.width as f64 && y < image.height as f64;
        is_in.then(|| image.pixel(x as usize, y as usize))
    };
    let (mut object, mut table) = (Vec::new(), Vec::new());
    for ray in rays {
        for share in [0.2, 0.4, 0.6] {
            let at = [0, 1].map(|i| centre[i] + share * (ray.at[i] - centre[i]));
            object.extend(pixel(at).filter(|rgb| scene.range.contains(*rgb, image.grey)));
        }
        for beyond in [0.5, 2.0, 4.0] {
            let at = [0, 1].map(|i| ray.at[i] + (window + beyond) * ray.normal[i]);
            table.extend(pixel(at).filter(|rgb| !scene.range.contains(*rgb, image.grey)));
        }
    }
    if object.len().min(table.len()) < FEWEST_PIXELS {
        return Err(NoFit::NoContrast);
    }
    let object = median(scene.light, &mut object);
    let table = median(scene.light, &mut table);
    let contrast = Contrast::between(object, table, image.grey).ok_or(NoFit::NoContrast)?;
    let [low, high] = outline.bounds();
    let around = window + FIRST + 2.0;
    let bounds = [low.map(|low| low - around), high.map(|high| high + around)];
    let part = Part::of(image, bounds);
    if part.width < 2 || part.height < 2 {
        return Err(NoFit::Border);
    }
    let bright = BRIGHT * scene.light[usize::from(GLARE)];
    Ok(Colours {
        map: contrast.map(image, scene.light, part),
        object,
        is_table_bright: table.iter().all(|light| *light >= bright),
    })
}

/// The median light of each channel.
fn median(light: &[f32; 256], pixels: &mut [[u8; 3]]) -> [f32; 3] {
    let middle = pixels.len() / 2;
    [0, 1, 2].map(|channel| {
        let (_, median, _) = pixels.select_nth_unstable_by_key(middle, |rgb| rgb[channel]);
        light[usize::from(median[channel])]
    })
}
