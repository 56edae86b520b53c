//! One image after another: blobs, the fit of the likeliest, and what is said of it.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_6};

use values::{Interval, Point, Rig};

use crate::aligned::Aligned;
use crate::background::{Background, Pilot};
use crate::change::{BandSums, PatternSums};
use crate::colour::{Range, codes_of_bytes, light_of_bytes};
use crate::detect::{Blob, blobs};
use crate::edges::{Ray, SideSums, rays};
use crate::fit::{Fit, NoFit, SPACING, Scene, fit, nearby};
use crate::height::{HeightOff, Profile, Profiles, STEP, WINDOW};
use crate::learned::Learned;
use crate::marker::{ByMarker, ObjectMarker};
use crate::outline::{Outline, Pose, Solid};
use crate::size::is_glare;
use crate::table::Table;
use crate::trust::{Judgement, judge};
use crate::{CameraModel, Image, Reason, SetupError};

/// What was found in one image.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The object's centre on the table in m, or why it is not given.
    pub centre: Result<Point, Reason>,
    /// Standard deviation of a coordinate of the centre, in m.
    pub deviation: f64,
    /// How far the table is seen from where it was in the log's other images, in px.
    pub shift: [f64; 2],
    /// Share of the outline and of the inside that agree with the object, 0 to 1.
    pub quality: f64,
    /// Yaw in rad: by its marker, where that is read; else for a box, of the face that is nearest to the table's axes.
    pub yaw: f64,
    /// The marker, where place and yaw are taken from it.
    pub marker: Option<SeenMarker>,
    /// Centroid of the outline or centre of the marker, in px; none where neither was fitted.
    pub pixel: Option<[f64; 2]>,
    /// Corners of the outline in px, also of one that is not believed.
    pub outline: Vec<[f64; 2]>,
}

/// The object's marker in one image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenMarker {
    /// Standard deviation of the object's yaw, in rad.
    pub yaw_deviation: f64,
    /// How large the marker is seen, of what the rig file says of it.
    pub scale: f64,
}

/// What was found in one image, and what it teaches of others.
#[derive(Clone, Debug)]
pub(crate) struct Looked {
    pub(crate) observation: Observation,
    /// How bright the object's side is seen.
    pub(crate) side: SideSums,
    pub(crate) band: BandSums,
    pub(crate) shear: PatternSums<2>,
    /// How much larger than it is the object is seen, in px.
    pub(crate) larger: f64,
    /// Standard deviation of a coordinate, in m, for what a log's images do not tell of the side's brightness.
    unsure_of_side: f64,
}

/// Finds the object in images, each by itself: the same image gives the same answer.
#[derive(Clone, Debug)]
pub struct Tracker {
    camera: CameraModel,
    solid: Solid,
    /// Its colour; none where its marker alone is known.
    range: Option<Range>,
    marker: Option<ObjectMarker>,
    table: [Interval; 2],
    light: [f32; 256],
    codes: [f32; 256],
    /// How fast the object leaves an impact at the most, in m/s, and how far it moves within an exposure at the most, in m.
    fastest: f64,
    blur: f64,
    /// By how many px edges are taken to be blurred at the least.
    least_blur: f64,
}

/// An object leaves an impact faster than the tip: twice as fast at the most (restitution 1, a heavy striker).
const FASTEST: f64 = 2.0;
/// Pixels of the coarse grid across the object.
const ACROSS: f64 = 8.0;
/// A colour's region that is so many times larger or smaller than the object is another thing.
const MOST_TIMES: f64 = 2.0;
/// A blob of less than this share of the object's picture is no object; of more than the other, not one object alone.
const LEAST_AREA: f64 = 0.2;
const MOST_AREA: f64 = 2.0;
/// A blob of this share may be the object, a part of it hidden; so may what is left of a larger one.
const LIKE_IT: f64 = 0.4;
/// The object's colour that fills so much of an outline and ends there may be the object.
const MAY_BE: f64 = 0.4;
/// Where more than this share of what is found has always had the object's colour, it is what has always lain there.
const MOST_ALWAYS: f64 = 0.85;
/// A part of the object fills this share of its outline at the least: a cable of its colour fills less wherever it is laid.
const LIKE_IT_FILLED: f64 = 0.25;
/// Yaws (rad) from which a box is fitted where one along the table's axes does not do.
const YAWS: [f64; 5] = [
    FRAC_PI_6 / 2.0,
    -FRAC_PI_6 / 2.0,
    FRAC_PI_6,
    -FRAC_PI_6,
    FRAC_PI_4,
];

impl Tracker {
    /// A tracker for the object and camera of a rig file.
    ///
    /// # Errors
    /// Keys that images need are missing, or the camera does not look at the table.
    pub fn new(rig: &Rig) -> Result<Self, SetupError> {
        let (colour, marker) = (rig.object.colour.as_ref(), ObjectMarker::of(&rig.object)?);
        if colour.is_none() && marker.is_none() {
            return Err(SetupError::Missing {
                key: "object.colour",
                mend: "`carom camera tune IMAGE` proposes it; or state the marker on it, `object.marker`",
            });
        }
        let camera = CameraModel::of(rig)?;
        Ok(Self {
            solid: Solid::of(&rig.object),
            range: colour.map(Range::of),
            marker,
            table: [rig.table.x, rig.table.y],
            light: light_of_bytes(),
            codes: codes_of_bytes(),
            fastest: rig.robot.speed.high * FASTEST,
            blur: camera.exposure.unwrap_or(0.0) * rig.robot.speed.high * FASTEST,
            least_blur: 0.0,
            camera,
        })
    }

    /// The camera that it sees through.
    pub fn camera(&self) -> &CameraModel {
        &self.camera
    }

    /// This tracker with a camera whose last row is seen so much later than its first, in s.
    pub(crate) fn with_readout(mut self, readout: f64) -> Self {
        self.camera.readout = Some(readout);
        self
    }

    /// This tracker where edges are taken to be blurred by so many px to both sides at the least.
    pub(crate) fn with_least_blur(mut self, pixels: f64) -> Self {
        self.least_blur = pixels;
        self
    }

    /// Finds the object in an image, of which nothing else is known.
    pub fn observe(&self, image: &Image) -> Observation {
        self.look(image, &Learned::default()).observation
    }

    /// The table without the object, as these images show it.
    pub(crate) fn background(&self, pilots: &[Pilot]) -> Option<Background> {
        Background::of(pilots, self.range.as_ref())
    }

    /// The same where it is known that the camera does not move.
    pub(crate) fn background_at_rest(&self, pilots: &[Pilot]) -> Option<Background> {
        Background::at_rest(pilots, self.range.as_ref())
    }

    /// Finds the object in an image of a log that taught something: by its marker, where that is read, else by its outline.
    pub(crate) fn look(&self, image: &Image, learned: &Learned) -> Looked {
        self.look_by(image, learned, self.marker.as_ref())
    }

    /// Looks at an image for what it teaches: at the object's outline, where its colour is known.
    pub(crate) fn study(&self, image: &Image, learned: &Learned) -> Looked {
        let marker = self.marker.as_ref().filter(|_| self.range.is_none());
        self.look_by(image, learned, marker)
    }

    fn look_by(&self, image: &Image, learned: &Learned, marker: Option<&ObjectMarker>) -> Looked {
        let Some(aligned) = learned.align(image) else {
            return Looked::none(Reason::Moved);
        };
        let by_marker = marker.and_then(|marker| self.by_marker(image, marker, &aligned));
        let mut looked = match (by_marker, &self.range) {
            (Some(looked), _) => looked,
            (None, Some(range)) => self.likeliest(image, range, learned, &aligned),
            (None, None) => Looked::none(Reason::NoMarker),
        };
        let middle = [0.5 * image.width as f64, 0.5 * image.height as f64];
        let at = looked.observation.pixel.unwrap_or(middle);
        looked.observation.shift = aligned.moved.at(at);
        let [fx, fy, ..] = self.camera.lens.matrix;
        let metres = self.camera.position[2] / fx.min(fy);
        let is_by_outline = looked.observation.marker.is_none();
        let deviation = &mut looked.observation.deviation;
        if is_by_outline && *deviation > 0.0 {
            *deviation = learned.deviation(*deviation, looked.unsure_of_side);
        }
        *deviation = deviation.hypot(metres * aligned.deviation);
        if let (Some(height), Ok(at)) = (&learned.height, looked.observation.centre) {
            let off = self.put_off_by(height, at);
            *deviation = deviation.hypot(off * std::f64::consts::FRAC_1_SQRT_2);
        }
        looked
    }

    /// What a centre there is off (m) at the most where the object is of another height.
    pub(crate) fn put_off_by(&self, height: &HeightOff, at: Point) -> f64 {
        let [x, y, z] = self.camera.position;
        let above = z - self.solid.height().unwrap_or_default();
        height.puts_off((at.x - x).hypot(at.y - y), above)
    }

    /// How fast (m/s) the object leaves an impact at the most.
    pub(crate) fn fastest(&self) -> f64 {
        self.fastest
    }

    /// The height (m) that is stated of an object that has one beside its width.
    pub(crate) fn height(&self) -> Option<f64> {
        self.solid.height()
    }

    /// How much taller than stated the object is, as these images show it.
    pub(crate) fn height_off(&self, profiles: &[Profiles]) -> Option<HeightOff> {
        HeightOff::of(profiles, self.solid.height()?)
    }

    /// What an image shows along rays across the object's outline, where it is found by that.
    pub(crate) fn profiles(
        &self,
        image: &Image,
        observation: &Observation,
        learned: &Learned,
    ) -> Option<Profiles> {
        let (at, pixel) = (observation.centre.ok()?, observation.pixel?);
        let range = self
            .range
            .as_ref()
            .filter(|_| observation.marker.is_none())?;
        let camera = self.camera_near(&learned.align(image)?, pixel);
        let pose = Pose {
            x: at.x,
            y: at.y,
            yaw: observation.yaw,
        };
        let outline = Outline::seen(&camera, &self.solid, pose)?;
        let table = Table {
            image,
            light: &self.light,
            codes: &self.codes,
            median: [0.0; 3],
            background: None,
        };
        let along = |ray: Ray| {
            let steps = ((ray.band + 2.0 * WINDOW) / STEP).round() as usize;
            let sample = |k: usize| {
                let t = WINDOW - STEP * k as f64;
                let bytes = table.codes_at([0, 1].map(|i| ray.at[i] + t * ray.normal[i]))?;
                Some((t, bytes.map(f64::from)))
            };
            let bytes: Option<Vec<_>> = (0..=steps).rev().map(sample).collect();
            Some(Profile { ray, bytes: bytes? })
        };
        let rays: Vec<Profile> = rays(&outline, SPACING)
            .into_iter()
            .filter_map(along)
            .collect();
        let shares = [0.2, 0.4, 0.6, 0.8].iter();
        let inside = shares.flat_map(|share| rays.iter().map(move |one| (share, one.ray.at)));
        let inside = inside.filter_map(|(share, at)| {
            let [x, y] = [0, 1].map(|i| (pixel[i] + share * (at[i] - pixel[i])).round());
            let is_in = x < image.width as f64 && y < image.height as f64;
            let rgb = is_in.then(|| image.pixel(x as usize, y as usize))?;
            range
                .contains(rgb, image.grey)
                .then_some(rgb.map(|byte| f64::from(byte) / 255.0))
        });
        let outside = rays.iter().filter_map(|one| Some(one.bytes.last()?.1));
        Some(Profiles {
            object: mean(inside)?,
            table: mean(outside)?,
            rays,
        })
    }

    /// The camera as it sees what is near a pixel: where the table has moved in the image, the object's picture has moved with it.
    fn camera_near(&self, aligned: &Aligned, pixel: [f64; 2]) -> CameraModel {
        let mut camera = self.camera;
        let [x, y] = aligned.moved.at(pixel);
        camera.lens.matrix[2] += x;
        camera.lens.matrix[3] += y;
        camera
    }

    /// The object by its marker on the table; none where the marker is not read.
    fn by_marker(&self, image: &Image, marker: &ObjectMarker, aligned: &Aligned) -> Option<Looked> {
        let camera_near = |pixel| self.camera_near(aligned, pixel);
        let mut found = marker.find(image, &self.light, &camera_near);
        found.retain(|found| self.is_on_table(Point::new(found.pose.x, found.pose.y)));
        let first = found.first()?;
        if found.len() > 1 {
            return Some(Looked::none(Reason::TwoObjects));
        }
        let camera = camera_near(first.pixel);
        let outline = Outline::seen(&camera, &self.solid, first.pose).unwrap_or_default();
        Some(Looked::at(Observation::of_marker(first, &outline)))
    }

    /// What has the object's colour, but for what always had it. Where there is nothing, glare may hide its colour, or it stands on a mark
    /// of its colour: what is found there is the object if not nearly all of it has always been there.
    fn likeliest(
        &self,
        image: &Image,
        range: &Range,
        learned: &Learned,
        aligned: &Aligned,
    ) -> Looked {
        let background = learned.background.as_ref();
        let of = |background, may_glare| {
            let candidates = self.candidates(image, range, background, aligned, may_glare);
            self.likeliest_of(candidates, image, range, learned, aligned)
        };
        of(background, false)
            .or_else(|| of(background, true).filter(is_found))
            .or_else(|| {
                let known = background?;
                let on_mark = of(None, false).filter(is_found)?;
                (!self.was_there(&on_mark, known, aligned)).then_some(on_mark)
            })
            .unwrap_or_else(|| Looked::none(Reason::NoObject))
    }

    /// All that may be the object is fitted: it is what has its shape. Where nothing has, the reason is the largest's.
    fn likeliest_of(
        &self,
        candidates: Vec<(Blob, Pose)>,
        image: &Image,
        range: &Range,
        learned: &Learned,
        aligned: &Aligned,
    ) -> Option<Looked> {
        let mut best: Option<Looked> = None;
        // Blobs as large as the object that were not found to be it: one of them may be, and what was found another.
        let mut like_it = 0;
        for (blob, pose) in candidates {
            let area = self.area(pose);
            let scene = Scene {
                image,
                camera: &self.camera_near(aligned, blob.centre),
                solid: &self.solid,
                range,
                light: &self.light,
                codes: &self.codes,
                blur: self.blur,
                least_blur: self.least_blur,
                learned,
                alignment: aligned.near(blob.centre),
                is_strict: false,
            };
            let is_large = blob.area > (1.0 + LIKE_IT) * area;
            let reach = if is_large { blob.reach } else { [0.0; 2] };
            let mut found = self.fit(&scene, pose, reach);
            if is_large && is_found(&found) && self.is_another_beside(&scene, pose, reach, &found) {
                found.observation.centre = Err(Reason::TwoObjects);
                return Some(found);
            }
            let is_object = found.observation.centre.is_ok();
            let is_as_large = (LIKE_IT * area..MOST_AREA * area).contains(&blob.area);
            if !is_object
                && is_as_large
                && self.is_filled(&scene, pose, blob.reach, None, LIKE_IT_FILLED)
            {
                like_it += 1;
            }
            match &mut best {
                Some(best) if is_object && best.observation.centre.is_ok() => {
                    // Print may part one object's colour into two blobs.
                    if self.are_apart(&best.observation, &found.observation) {
                        best.observation.centre = Err(Reason::TwoObjects);
                        return Some(best.clone());
                    }
                }
                Some(best) if best.observation.centre.is_ok() => {}
                Some(best) if is_object => *best = found,
                Some(_) => {}
                None => best = Some(found),
            }
        }
        let mut best = best?;
        if best.observation.centre.is_ok() && like_it > 0 {
            best.observation.centre = Err(Reason::TwoObjects);
        }
        Some(best)
    }

    /// Whether nearly all of what was found has always had the object's colour.
    fn was_there(&self, found: &Looked, background: &Background, aligned: &Aligned) -> bool {
        let seen = &found.observation;
        let (Ok(at), Some(pixel)) = (seen.centre, seen.pixel) else {
            return false;
        };
        let (x, y, yaw) = (at.x, at.y, seen.yaw);
        let camera = self.camera_near(aligned, pixel);
        let Some(outline) = Outline::seen(&camera, &self.solid, Pose { x, y, yaw }) else {
            return false;
        };
        let [low, high] = outline
            .bounds()
            .map(|end| end.map(|at| at.max(0.0) as usize));
        let rows = (low[1]..=high[1]).flat_map(|y| (low[0]..=high[0]).map(move |x| (x, y)));
        let within = rows.filter(|(x, y)| outline.holds([*x as f64, *y as f64]));
        let (mut always, mut all) = (0, 0);
        for (x, y) in within {
            all += 1;
            always += usize::from(background.is_coloured(x, y));
        }
        always as f64 > MOST_ALWAYS * f64::from(all)
    }

    /// Whether something of the object's colour and shape lies beside what was found in one blob.
    fn is_another_beside(
        &self,
        scene: &Scene<'_>,
        start: Pose,
        reach: [f64; 2],
        found: &Looked,
    ) -> bool {
        let Observation {
            centre: Ok(at),
            yaw,
            ..
        } = found.observation
        else {
            return false;
        };
        let pose = Pose {
            x: at.x,
            y: at.y,
            yaw,
        };
        let Some(outline) = Outline::seen(scene.camera, scene.solid, pose) else {
            return false;
        };
        self.is_filled(scene, start, reach, Some(&outline), MAY_BE)
    }

    /// Whether the object's colour fills so much of an outline within `reach` px and ends there: what lies within another outline does not.
    fn is_filled(
        &self,
        scene: &Scene<'_>,
        start: Pose,
        reach: [f64; 2],
        other: Option<&Outline>,
        least: f64,
    ) -> bool {
        self.turns().chain([0.0]).any(|yaw| {
            let near = nearby(scene, Pose { yaw, ..start }, reach, other);
            near.is_some_and(|(_, share)| share > least)
        })
    }

    /// Whether two that were found can stand beside each other.
    fn are_apart(&self, a: &Observation, b: &Observation) -> bool {
        let (Ok(a), Ok(b)) = (a.centre, b.centre) else {
            return false;
        };
        a.distance(b) > self.solid.half_width()
    }

    /// Yaws by which an object is turned that is not found as it lies.
    fn turns(&self) -> impl Iterator<Item = f64> + use<> {
        let turns: &[f64] = if self.solid.turns() { &YAWS } else { &[] };
        turns.iter().copied()
    }

    /// Blobs that may be the object, on the table: the largest first. Where none is on the table, the largest beside it. Where glare may
    /// hide the colour, what glares is the object's too.
    fn candidates(
        &self,
        image: &Image,
        range: &Range,
        background: Option<&Background>,
        aligned: &Aligned,
        may_glare: bool,
    ) -> Vec<(Blob, Pose)> {
        let stride = self.stride();
        let (mut on, mut beside) = (Vec::new(), None);
        let is_object = |rgb| range.contains(rgb, image.grey) || (may_glare && is_glare(rgb));
        for blob in blobs(image, is_object, stride, background) {
            let camera = self.camera_near(aligned, blob.centre);
            let Some(at) = camera.point(blob.centre, self.solid.middle()) else {
                continue;
            };
            let pose = Pose {
                x: at.x,
                y: at.y,
                yaw: 0.0,
            };
            if blob.area < LEAST_AREA * self.area(pose) {
                continue;
            }
            if self.is_on_table(at) {
                on.push((blob, pose));
            } else {
                beside.get_or_insert((blob, pose));
            }
        }
        if on.is_empty() {
            on.extend(beside);
        }
        on
    }

    /// Whether what is seen about a pixel, in px², may be the object by its place and size.
    pub fn is_of_size(&self, pixel: [f64; 2], area: f64) -> bool {
        let at = self.camera.point(pixel, self.solid.middle());
        at.filter(|at| self.is_on_table(*at))
            .is_some_and(|Point { x, y }| {
                let share = area / self.area(Pose { x, y, yaw: 0.0 });
                (1.0 / MOST_TIMES..=MOST_TIMES).contains(&share)
            })
    }

    fn is_on_table(&self, at: Point) -> bool {
        let reach = self.solid.reach();
        [(at.x, self.table[0]), (at.y, self.table[1])]
            .into_iter()
            .all(|(at, side)| side.low - reach <= at && at <= side.high + reach)
    }

    /// Area of the object's picture in px²; infinite where it cannot be seen.
    fn area(&self, pose: Pose) -> f64 {
        let outline = Outline::seen(&self.camera, &self.solid, pose);
        outline.map_or(f64::INFINITY, |outline| outline.moments().0)
    }

    /// Every how many pixels are looked at first.
    fn stride(&self) -> usize {
        let [fx, fy, ..] = self.camera.lens.matrix;
        let scale = fx.min(fy) / self.camera.position[2];
        let across = 2.0 * self.solid.half_width() * scale;
        (across / ACROSS).clamp(1.0, 6.0) as usize
    }

    /// The fit from a first guess on that is believed and known best; what has the object's colour reaches so many px from there.
    fn fit(&self, scene: &Scene<'_>, start: Pose, reach: [f64; 2]) -> Looked {
        let mut best = self.judged(scene, start);
        if is_found(&best) {
            return best;
        }
        let mut take = |other: Looked| {
            let key = |looked: &Looked| match looked.observation.centre {
                Ok(_) => (true, -looked.observation.deviation),
                Err(_) => (false, looked.observation.quality),
            };
            if key(&other) > key(&best) {
                best = other;
            }
        };
        for yaw in self.turns() {
            take(self.judged(scene, Pose { yaw, ..start }));
        }
        let strict = Scene {
            is_strict: true,
            ..*scene
        };
        take(self.judged(&strict, start));
        for yaw in self.turns().chain([0.0]) {
            if let Some((near, _)) = nearby(scene, Pose { yaw, ..start }, reach, None) {
                take(self.judged(scene, near));
                take(self.judged(&strict, near));
            }
        }
        best
    }

    fn judged(&self, scene: &Scene<'_>, start: Pose) -> Looked {
        match fit(scene, start) {
            Err(no_fit) => Looked::none(self.without_fit(scene, start, no_fit)),
            Ok(fit) => {
                let mut judged = judge(scene.image, &self.light, scene.range, &self.solid, &fit);
                if judged.against == Some(Reason::Occluded) && self.is_at_border(scene, fit.pose) {
                    judged.against = Some(Reason::Border);
                }
                Looked {
                    side: fit.side,
                    band: fit.band,
                    shear: fit.shear,
                    larger: fit.seen_larger,
                    unsure_of_side: fit.unsure_of_side,
                    observation: Observation::of(&fit, &judged),
                }
            }
        }
    }

    /// A blob at the border may have its centroid well within.
    fn without_fit(&self, scene: &Scene<'_>, start: Pose, no_fit: NoFit) -> Reason {
        match self.is_at_border(scene, start) {
            true => Reason::Border,
            false => no_fit.into(),
        }
    }

    /// Whether an object that lies so is near the picture's end.
    fn is_at_border(&self, scene: &Scene<'_>, pose: Pose) -> bool {
        let Some([x, y]) = scene.camera.pixel([pose.x, pose.y, self.solid.middle()]) else {
            return true;
        };
        let [fx, fy, ..] = self.camera.lens.matrix;
        let around = 1.2 * self.solid.reach() * fx.max(fy) / self.camera.position[2];
        let is_within = |at: f64, size: usize| at > around && at < size as f64 - around;
        !(is_within(x, scene.image.width) && is_within(y, scene.image.height))
    }
}

/// The mean of some colours; none where there is none.
fn mean(colours: impl Iterator<Item = [f64; 3]>) -> Option<[f64; 3]> {
    let (count, sum) = colours.fold((0.0, [0.0; 3]), |(count, sum), colour| {
        (count + 1.0, [0, 1, 2].map(|i| sum[i] + colour[i]))
    });
    (count > 0.0).then(|| sum.map(|part| part / count))
}

fn is_found(looked: &Looked) -> bool {
    looked.observation.centre.is_ok()
}

impl Looked {
    fn none(reason: Reason) -> Self {
        Self::at(Observation::none(reason))
    }

    /// An observation that tells of nothing else.
    fn at(observation: Observation) -> Self {
        Self {
            observation,
            side: SideSums::default(),
            band: BandSums::default(),
            shear: PatternSums::default(),
            larger: 0.0,
            unsure_of_side: 0.0,
        }
    }
}

impl Observation {
    /// Nothing was found, or nothing looked at.
    pub fn none(reason: Reason) -> Self {
        Self {
            centre: Err(reason),
            deviation: 0.0,
            shift: [0.0; 2],
            quality: 0.0,
            yaw: 0.0,
            marker: None,
            pixel: None,
            outline: Vec::new(),
        }
    }

    fn of_marker(seen: &ByMarker, outline: &Outline) -> Self {
        let [deviation, yaw_deviation] = seen.deviation;
        Self {
            centre: Ok(Point::new(seen.pose.x, seen.pose.y)),
            deviation,
            shift: [0.0; 2],
            quality: seen.quality,
            yaw: seen.pose.yaw,
            marker: Some(SeenMarker {
                yaw_deviation,
                scale: seen.scale,
            }),
            pixel: Some(seen.pixel),
            outline: outline.vertices.iter().map(|vertex| vertex.at).collect(),
        }
    }

    fn of(fit: &Fit<'_>, judged: &Judgement) -> Self {
        let centre = Point::new(fit.pose.x, fit.pose.y);
        Self {
            centre: judged.against.map_or(Ok(centre), Err),
            deviation: judged.deviation,
            shift: [0.0; 2],
            quality: judged.quality,
            yaw: fit.pose.yaw,
            marker: None,
            pixel: Some(fit.outline.moments().1),
            outline: fit
                .outline
                .vertices
                .iter()
                .map(|vertex| vertex.at)
                .collect(),
        }
    }
}
