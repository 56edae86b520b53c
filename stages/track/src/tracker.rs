//! One image after another: blobs, the fit of the likeliest, and what is said of it.

use std::f64::consts::{FRAC_PI_4, FRAC_PI_6};

use values::{Interval, Point, Rig};

use crate::colour::{Range, light_of_bytes};
use crate::detect::{Blob, blobs};
use crate::fit::{Fit, NoFit, Scene, fit};
use crate::outline::{Outline, Pose, Solid};
use crate::trust::judge;
use crate::{CameraModel, Image, Reason, SetupError};

/// What was found in one image.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// The object's centre on the table in m, or why it is not given.
    pub centre: Result<Point, Reason>,
    /// Share of the outline and of the inside that agree with the object, 0 to 1.
    pub quality: f64,
    /// Yaw in rad, for a box: of the face that is nearest to the table's axes.
    pub yaw: f64,
    /// Centroid of the outline, in px; none where no outline was fitted.
    pub pixel: Option<[f64; 2]>,
    /// Corners of the outline in px, also of one that is not believed.
    pub outline: Vec<[f64; 2]>,
}

/// Finds the object in images, each by itself: the same image gives the same answer.
#[derive(Clone, Debug)]
pub struct Tracker {
    camera: CameraModel,
    solid: Solid,
    range: Range,
    table: [Interval; 2],
    light: [f32; 256],
    /// How far the object moves within an exposure at the most, in m.
    blur: f64,
}

/// An object leaves an impact faster than the tip: twice as fast at the most (restitution 1, a heavy striker).
const FASTEST: f64 = 2.0;
/// Pixels of the coarse grid across the object.
const ACROSS: f64 = 8.0;
/// A blob of less than this share of the object's picture is no object; of more than the other, not the object alone.
const LEAST_AREA: f64 = 0.25;
const MOST_AREA: f64 = 2.0;
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
        let colour = rig.object.colour.as_ref().ok_or(SetupError::Missing {
            key: "object.colour",
            mend: "`carom camera tune IMAGE` proposes it",
        })?;
        let camera = CameraModel::of(rig)?;
        Ok(Self {
            solid: Solid::of(&rig.object),
            range: Range::of(colour),
            table: [rig.table.x, rig.table.y],
            light: light_of_bytes(),
            blur: camera.exposure * rig.robot.speed.high * FASTEST,
            camera,
        })
    }

    /// The camera that it sees through.
    pub fn camera(&self) -> &CameraModel {
        &self.camera
    }

    /// Finds the object in an image.
    pub fn observe(&self, image: &Image) -> Observation {
        let candidates = self.candidates(image);
        let Some((blob, pose)) = candidates.first().copied() else {
            return Observation::none(Reason::NoObject);
        };
        let mut found = self.fit(image, pose);
        if candidates.len() > 1 {
            found.centre = Err(Reason::TwoObjects);
        } else if blob.area > MOST_AREA * self.area(pose) && found.centre.is_ok() {
            found.centre = Err(Reason::Occluded);
        }
        found
    }

    /// Blobs that may be the object, on the table: the largest first. Where none is on the table, the largest beside it.
    fn candidates(&self, image: &Image) -> Vec<(Blob, Pose)> {
        let stride = self.stride();
        let (mut on, mut beside) = (Vec::new(), None);
        for blob in blobs(image, &self.range, stride) {
            let Some(at) = self.camera.point(blob.centre, self.solid.middle()) else {
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
            let reach = self.solid.reach();
            let is_on = [(at.x, self.table[0]), (at.y, self.table[1])]
                .into_iter()
                .all(|(at, side)| side.low - reach <= at && at <= side.high + reach);
            if is_on {
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

    fn fit(&self, image: &Image, start: Pose) -> Observation {
        let scene = Scene {
            image,
            camera: &self.camera,
            solid: &self.solid,
            range: &self.range,
            light: &self.light,
            blur: self.blur,
        };
        let mut best = self.judged(&scene, start);
        if self.solid.turns() && best.centre.is_err() {
            for turn in YAWS {
                let yaw = start.yaw + turn;
                let other = self.judged(&scene, Pose { yaw, ..start });
                let is_better =
                    (other.centre.is_ok(), other.quality) > (best.centre.is_ok(), best.quality);
                if is_better {
                    best = other;
                }
            }
        }
        best
    }

    fn judged(&self, scene: &Scene<'_>, start: Pose) -> Observation {
        match fit(scene, start) {
            Err(no_fit) => Observation::none(self.without_fit(scene, start, no_fit)),
            Ok(fit) => {
                let judged = judge(scene.image, &self.light, &self.range, &self.solid, &fit);
                Observation::of(&fit, judged)
            }
        }
    }

    /// A blob at the border may have its centroid well within.
    fn without_fit(&self, scene: &Scene<'_>, start: Pose, no_fit: NoFit) -> Reason {
        let pixel = self.camera.pixel([start.x, start.y, self.solid.middle()]);
        let Some([x, y]) = pixel else {
            return Reason::Border;
        };
        let [fx, fy, ..] = self.camera.lens.matrix;
        let around = 1.2 * self.solid.reach() * fx.max(fy) / self.camera.position[2];
        let is_within = |at: f64, size: usize| at > around && at < size as f64 - around;
        if is_within(x, scene.image.width) && is_within(y, scene.image.height) {
            no_fit.into()
        } else {
            Reason::Border
        }
    }
}

impl Observation {
    /// Nothing was found, or nothing looked at.
    pub fn none(reason: Reason) -> Self {
        Self {
            centre: Err(reason),
            quality: 0.0,
            yaw: 0.0,
            pixel: None,
            outline: Vec::new(),
        }
    }

    fn of(fit: &Fit, judged: Result<f64, (Reason, f64)>) -> Self {
        let (centre, quality) = match judged {
            Ok(quality) => (Ok(Point::new(fit.pose.x, fit.pose.y)), quality),
            Err((reason, quality)) => (Err(reason), quality),
        };
        Self {
            centre,
            quality,
            yaw: fit.pose.yaw,
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
