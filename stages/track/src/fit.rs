//! The pose at which the outline lies on the edges seen, step by step.

use crate::aligned::Alignment;
use nalgebra::{Vector2, Vector3};

use crate::change::{BandSums, Change, PatternSums, Prior};
use crate::colour::{Contrast, Map, Part, Range};
use crate::edges::{Edge, Ray, SideSums, WIDE_BAND, edges, rays};
use crate::learned::Learned;
use crate::outline::{Outline, Pose, Solid};
use crate::size::GLARE;
use crate::table::Table;
use crate::{CameraModel, Image};

/// What a fit is made with.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) image: &'a Image,
    pub(crate) camera: &'a CameraModel,
    pub(crate) solid: &'a Solid,
    pub(crate) range: &'a Range,
    pub(crate) light: &'a [f32; 256],
    /// What edges are sought in.
    pub(crate) codes: &'a [f32; 256],
    /// How far a point of the object moves within an exposure at the most, in m.
    pub(crate) blur: f64,
    /// By how many px edges are taken to be blurred to both sides at the least.
    pub(crate) least_blur: f64,
    /// What the log's other images show, and how their background lies in this one.
    pub(crate) learned: &'a Learned,
    pub(crate) alignment: Alignment,
    /// Whether an edge counts only where table is seen outside of it: what hides a part may have the table's hue.
    pub(crate) is_strict: bool,
}

/// The outline that lies best on the edges.
#[derive(Clone)]
pub(crate) struct Fit<'a> {
    pub(crate) pose: Pose,
    pub(crate) outline: Outline,
    pub(crate) rays: Vec<Ray>,
    /// What is left of each ray's edge, in px; none where there is no edge.
    pub(crate) residuals: Vec<Edge>,
    /// Standard deviation of a coordinate of the centre, in m.
    pub(crate) deviation: f64,
    /// The same for what a log's images do not tell of the side's brightness.
    pub(crate) unsure_of_side: f64,
    /// How bright this image shows the object's side.
    pub(crate) side: SideSums,
    pub(crate) band: BandSums,
    /// What they say of how it is sheared: by so much of its velocity (m/s) as each row of the image is seen later, in s for all rows.
    pub(crate) shear: PatternSums<2>,
    /// Mean distance, in px, by which most edges miss a step at the most.
    spread: f64,
    /// How much larger than the outline the object is seen, beyond what the log's other images let expect, in px.
    pub(crate) larger: f64,
    /// How much larger than the outline it is seen, what they let expect included, in px.
    pub(crate) seen_larger: f64,
    /// How well that is known before it is seen: standard deviation in px.
    pub(crate) size_known: f64,
    pub(crate) map: Map,
    /// Light of the object's middle.
    pub(crate) object: [f32; 3],
    pub(crate) table: Table<'a>,
    /// Whether the table around is so bright that glare cannot be distinguished from it.
    pub(crate) is_table_bright: bool,
    /// Half width of the search across the outline, in px.
    pub(crate) window: f64,
    /// How far from the outline its blurred edge has ended, in px.
    pub(crate) clear: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoFit {
    /// The outline leaves the image.
    Border,
    /// Object and table look alike.
    NoContrast,
    NoEdges,
}

/// Distance between rays, in px: about that over which JPEG's noise is alike.
pub(crate) const SPACING: f64 = 1.5;
/// Px of a ray at each end from which its levels are taken.
const LEVEL: f64 = 2.5;
/// Px between a level and the blurred edge.
const CLEAR: f64 = 1.5;
/// What a first guess may be off, in px.
const FIRST: f64 = 2.0;
/// Steps of Gauss–Newton at the most, and the move in px at which they end.
const STEPS: usize = 8;
const DONE: f64 = 0.004;
/// How bright a side is, of the upper face, one image does not tell by better than this: standard deviation.
const UNSEEN_SIDE: f64 = 0.23;
/// Nor do a log's images tell it of each direction by better than this: it is no sum of a cosine and a sine.
const LEARNT_SIDE: f64 = 0.06;
/// A table with more than this share of glare's light cannot be distinguished from it: compression rings.
const BRIGHT: f32 = 0.8;
/// Fewest pixels of the object, and of the table, for their colours.
const FEWEST_PIXELS: usize = 16;

/// Fits the outline from a first guess on: as if nothing moved, and where edges are wider than that, or none are found, as if it did.
pub(crate) fn fit<'a>(scene: &Scene<'a>, start: Pose) -> Result<Fit<'a>, NoFit> {
    let still = fit_blurred(scene, start, scene.least_blur);
    let blur = match &still {
        Ok(fit) if fit.spread > SPREAD => (2.0 * fit.spread - CLEAR).max(scene.least_blur),
        Err(NoFit::NoEdges) if scene.blur > 0.0 => {
            let [fx, fy, ..] = scene.camera.lens.matrix;
            0.5 * scene.blur * fx.max(fy) / scene.camera.position[2]
        }
        _ => return still,
    };
    let start = still.as_ref().map_or(start, |fit| fit.pose);
    fit_blurred(scene, start, blur).or(still)
}

/// Edges that miss a step by more px than that are blurred by movement: by a box four times as wide.
const SPREAD: f64 = 1.25;

/// The fit with edges that movement blurs by so many px to both sides.
fn fit_blurred<'a>(scene: &Scene<'a>, start: Pose, blur: f64) -> Result<Fit<'a>, NoFit> {
    let mut pose = start;
    let mut colours: Option<Colours<'_>> = None;
    let mut prior = Prior {
        turns: false,
        larger: scene.learned.larger,
    };
    let mut mapped = start;
    for step in 0..STEPS {
        let outline = Outline::seen(scene.camera, scene.solid, pose).ok_or(NoFit::Border)?;
        let scale = outline
            .vertices
            .first()
            .map_or(1.0, |vertex| vertex.moves[0][0].hypot(vertex.moves[0][1]));
        let narrow = scale * scene.solid.half_width();
        let window = LEVEL + CLEAR + blur;
        let first = if step == 0 { FIRST } else { 0.0 };
        let window = (window + first).min(0.8 * narrow).max(2.0);
        let level = LEVEL.min(0.5 * window);
        let rays = rays(&outline, SPACING);
        if leaves(scene, &rays) {
            return Err(NoFit::Border);
        }
        let far = scale * (pose.x - mapped.x).hypot(pose.y - mapped.y);
        let seen = match colours.take() {
            Some(colours) if far < FIRST => colours,
            _ => {
                mapped = pose;
                colours_around(scene, &outline, &rays, window)?
            }
        };
        let ends = [window, level];
        let known = scene.learned.side.as_ref();
        let edges = edges(
            &seen.map,
            &seen.table,
            &rays,
            ends,
            (known, scene.is_strict),
        );
        prior.turns = scene.solid.turns() && step > 0;
        let found = &edges.found;
        let change = Change::least(&rays, found, &prior).ok_or(NoFit::NoEdges)?;
        let [x, y, yaw, larger] = change.parts;
        let moved = scale * (x.hypot(y) + scene.solid.reach() * yaw.abs());
        if !moved.is_finite() {
            return Err(NoFit::NoEdges);
        }
        pose.x += x;
        pose.y += y;
        pose.yaw += yaw;
        if (moved < DONE && step > 1) || step + 1 == STEPS {
            let deviation = change.deviation(&rays, found, &prior);
            let deviation = deviation.ok_or(NoFit::NoEdges)?;
            // A wide side shows how bright it is.
            let narrow = rays.iter().map(|ray| ray.band.min(WIDE_BAND));
            let narrow = narrow.sum::<f64>() / rays.len() as f64 / scale;
            let of_side = match known {
                Some(_) => 0.0,
                None => UNSEEN_SIDE * narrow,
            };
            return Ok(Fit {
                pose,
                residuals: change.residuals(&rays, found),
                deviation: deviation.hypot(of_side),
                band: change.pattern(&rays, found, &prior, |ray| {
                    ray.band * Vector3::new(1.0, ray.normal[0], ray.normal[1])
                }),
                shear: {
                    let (_, [_, middle]) = outline.moments();
                    let rows = scene.image.height as f64;
                    change.pattern(&rays, found, &prior, |ray| {
                        (ray.at[1] - middle) / rows * Vector2::new(ray.moves[0], ray.moves[1])
                    })
                },
                unsure_of_side: LEARNT_SIDE * narrow,
                side: edges.side,
                spread: edges.spread(&rays, window),
                rays,
                outline,
                larger: larger - scene.learned.larger[0],
                seen_larger: larger,
                size_known: scene.learned.larger[1],
                map: seen.map,
                object: seen.object,
                table: seen.table,
                is_table_bright: seen.is_table_bright,
                window,
                clear: window - level,
            });
        }
        colours = Some(seen);
    }
    Err(NoFit::NoEdges)
}

/// A pose within `reach` px of a first guess at which the object's colour fills the outline and ends there, and the share of the outline that
/// does: where a part of the object is hidden or of another colour, or something of its colour lies beside it, the middle of what has its
/// colour is not its middle. What lies within another outline tells nothing.
pub(crate) fn nearby(
    scene: &Scene<'_>,
    start: Pose,
    reach: [f64; 2],
    other: Option<&Outline>,
) -> Option<(Pose, f64)> {
    let outline = Outline::seen(scene.camera, scene.solid, start)?;
    let rays = rays(&outline, SEARCH_SPACING);
    let scale = outline.vertices.first()?.moves;
    let across = scale[0][0].hypot(scale[0][1]) * scene.solid.half_width();
    let is_object = |ray: &Ray, far: f64, off: [f64; 2]| {
        let [x, y] = [0, 1].map(|i| (ray.at[i] + off[i] + far * ray.normal[i]).round());
        let (width, height) = (scene.image.width as f64, scene.image.height as f64);
        let is_in = x >= 0.0 && y >= 0.0 && x < width && y < height;
        is_in && !other.is_some_and(|other| other.holds([x, y])) && {
            let pixel = scene.image.pixel(x as usize, y as usize);
            scene.range.contains(pixel, scene.image.grey)
        }
    };
    let score = |off: [f64; 2]| -> i32 {
        let one = |ray: &Ray| {
            let (inside, outside) = (
                is_object(ray, -SEARCH_EDGE, off),
                is_object(ray, SEARCH_EDGE, off),
            );
            i32::from(inside) - 2 * i32::from(outside)
        };
        rays.iter().map(one).sum()
    };
    let step = (SEARCH_STEP * across).max(1.0);
    let [right, down] = reach.map(|reach| {
        let reach = reach.clamp(across, MOST_REACH * across);
        (reach / step).ceil() as i32
    });
    let offs = (-right..=right).flat_map(|i| (-down..=down).map(move |j| [i, j]));
    // Of several alike the nearest.
    let scored = offs.map(|[i, j]| {
        let off = [f64::from(i) * step, f64::from(j) * step];
        ((score(off), -(i * i + j * j)), [i, j])
    });
    let ((score, _), [i, j]) = scored.max()?;
    let off = [f64::from(i) * step, f64::from(j) * step];
    let middle = [start.x, start.y, scene.solid.middle()];
    let pixel = scene.camera.pixel(middle)?;
    let at = [pixel[0] + off[0], pixel[1] + off[1]];
    let at = scene.camera.point(at, scene.solid.middle())?;
    let pose = Pose {
        x: at.x,
        y: at.y,
        yaw: start.yaw,
    };
    Some((pose, f64::from(score) / rays.len() as f64))
}

/// The farthest a search goes, in half widths of the object. Distance of the rays of a search (px); how far to both sides of the outline it looks
/// (px); its steps, of the object's half width.
const MOST_REACH: f64 = 10.0;
const SEARCH_SPACING: f64 = 2.5;
const SEARCH_EDGE: f64 = 2.0;
const SEARCH_STEP: f64 = 0.12;

/// Whether much of an outline comes nearer than this to the image's border (px): its edge cannot be seen there. What is left of a circle
/// tells where it is, what is left of a box may be one that lies farther in.
fn leaves(scene: &Scene<'_>, rays: &[Ray]) -> bool {
    const MARGIN: f64 = 2.0;
    const MOST: f64 = 0.4;
    let (image, turns) = (scene.image, scene.solid.turns());
    let most = if turns { 0.0 } else { MOST };
    let is_within = |at: f64, size: usize| at >= MARGIN && at <= size as f64 - 1.0 - MARGIN;
    let is_out =
        |ray: &&Ray| !(is_within(ray.at[0], image.width) && is_within(ray.at[1], image.height));
    let out = rays.iter().filter(is_out).count();
    out as f64 > most * rays.len() as f64
}

/// What is known of the colours around an outline.
struct Colours<'a> {
    map: Map,
    table: Table<'a>,
    object: [f32; 3],
    is_table_bright: bool,
}

/// The colours of object and table around an outline, and how far each pixel there is object.
fn colours_around<'a>(
    scene: &Scene<'a>,
    outline: &Outline,
    rays: &[Ray],
    window: f64,
) -> Result<Colours<'a>, NoFit> {
    let image = scene.image;
    let (_, centre) = outline.moments();
    let pixel = |at: [f64; 2]| {
        let [x, y] = at.map(f64::round);
        let is_in = x >= 0.0 && y >= 0.0 && x < image.width as f64 && y < image.height as f64;
        is_in.then(|| image.pixel(x as usize, y as usize))
    };
    let (mut object, mut table) = (Vec::new(), Vec::new());
    for ray in rays {
        for share in [0.2, 0.4, 0.6, 0.8] {
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
    let [object, table] = [median(&mut object), median(&mut table)];
    let of = |scale: &[f32; 256], rgb: [u8; 3]| rgb.map(|code| scale[usize::from(code)]);
    let contrast = Contrast::between(of(scene.codes, object), of(scene.codes, table), image.grey);
    let [object, table] = [object, table].map(|rgb| of(scene.light, rgb));
    let contrast = contrast.ok_or(NoFit::NoContrast)?;
    let [low, high] = outline.bounds();
    let around = window + FIRST + 2.0;
    let bounds = [low.map(|low| low - around), high.map(|high| high + around)];
    let part = Part::of(image, bounds);
    if part.width < 2 || part.height < 2 {
        return Err(NoFit::Border);
    }
    let background = scene.learned.background.as_ref();
    let bright = BRIGHT * scene.light[usize::from(GLARE)];
    let mut map = contrast.map(image, scene.codes, part);
    if let Some(background) = background {
        background.take_from(&mut map, &contrast, scene.codes, &scene.alignment);
    }
    Ok(Colours {
        map,
        table: Table {
            image,
            light: scene.light,
            codes: scene.codes,
            median: table,
            background: background.map(|known| (known, scene.alignment)),
        },
        object,
        is_table_bright: table.iter().all(|light| *light >= bright),
    })
}

/// The median of each channel.
fn median(pixels: &mut [[u8; 3]]) -> [u8; 3] {
    let middle = pixels.len() / 2;
    [0, 1, 2].map(|channel| {
        let (_, median, _) = pixels.select_nth_unstable_by_key(middle, |rgb| rgb[channel]);
        median[channel]
    })
}
