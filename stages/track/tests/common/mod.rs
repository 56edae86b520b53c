//! Rendered cases: what varies, and how far the centres found are from those rendered.

#![allow(dead_code, reason = "each test uses a part")]

use std::fmt;

use render::{Moment, Optics, Renderer, Scene, Shade};
use track::{Decoder, Image, ImageMessage, Observation, Payload, Tracker};
use values::{Colour, ImageTopic, Object, Point, Rig, Shape, StampMark};

/// What is rendered.
#[derive(Clone, Copy)]
pub struct Case {
    pub pixels: [usize; 2],
    pub noise: f64,
    pub jpeg: Option<u8>,
    pub lens: bool,
    pub exposure: f64,
    pub readout: f64,
    pub speed: f64,
    pub tall: bool,
    pub scene: fn(&mut Scene),
}

impl Case {
    /// Evenly lit, noise of two levels, no lens, no compression.
    pub fn flat() -> Self {
        Self {
            pixels: [1280, 720],
            noise: 2.0,
            jpeg: None,
            lens: false,
            exposure: 0.0,
            readout: 0.0,
            speed: 0.0,
            tall: false,
            scene: |_| {},
        }
    }

    /// Light, shadow, blur, noise, JPEG and lens.
    pub fn all() -> Self {
        Self {
            jpeg: Some(90),
            lens: true,
            exposure: 0.005,
            speed: 1.0,
            tall: true,
            scene: |scene| {
                scene.gradient = [0.25, -0.25];
                scene.shadow = [0.03, 0.02, 0.5];
                scene.sides = [0.75, 0.45];
                scene.grain = 0.02;
                scene.shade = Some(Shade {
                    at: [0.6, 0.1],
                    into: [0.6, 0.8],
                    soft: 0.08,
                    strength: 0.4,
                });
            },
            ..Self::flat()
        }
    }
}

pub fn disc() -> Object {
    Object {
        half_height: Some(0.0005),
        ..tall(Shape::Cylinder)
    }
}

/// 40 mm tall.
pub fn tall(shape: Shape) -> Object {
    let mut object = Rig::demo(shape).object;
    object.colour = Some(Colour::demo());
    object
}

/// A camera 1.2 m over the table, 1.2 mm a pixel at 1280 × 720.
pub fn rig(object: &Object, case: &Case) -> Rig {
    let mut rig = Rig::demo(Shape::Cylinder);
    rig.object = object.clone();
    let [width, height] = case.pixels.map(|size| size as f64);
    let focal = 1000.0 * width / 1280.0;
    rig.camera.matrix = Some([focal, 1.003 * focal, 0.5 * width + 3.0, 0.5 * height - 4.0]);
    if case.lens {
        rig.camera.distortion = Some([-0.18, 0.06, 0.0007, -0.0005, 0.0]);
    }
    rig.camera.position = Some([0.52, 0.03, 1.2]);
    // Nearly straight down: a degree off.
    let tilt = (0.5f64.to_radians().sin(), 0.5f64.to_radians().cos());
    let h = std::f64::consts::FRAC_1_SQRT_2;
    rig.camera.orientation = Some([-h * tilt.1, h * tilt.1, h * tilt.0, h * tilt.0]);
    rig.camera.exposure = case.exposure;
    rig.camera.readout = case.readout;
    rig.camera.stamp = StampMark::Middle;
    rig.topics.image = Some(ImageTopic::new("/camera/image"));
    rig
}

/// A picture as `track` reads it.
pub fn decoded(decoder: &mut Decoder, jpeg: Option<u8>, picture: &render::Picture) -> Image {
    let data = match jpeg {
        Some(quality) => picture.jpeg(quality).expect("encodes"),
        None => picture.png().expect("encodes"),
    };
    let payload = Payload::Compressed(&data);
    let message = ImageMessage { stamp: 0, payload };
    decoder.decode(&message).expect("decodes").clone()
}

/// Even places over the table, the same in every run.
pub fn places(count: usize) -> Vec<(Moment, f64)> {
    (0..count)
        .map(|k| {
            let share = |step: f64| (0.37 + k as f64 * step).fract();
            let at = Moment {
                x: 0.25 + 0.55 * share(0.618_034),
                y: -0.30 + 0.66 * share(0.754_878),
                yaw: -0.7 + 1.4 * share(0.569_84),
            };
            (at, std::f64::consts::TAU * share(0.445_042))
        })
        .collect()
}

/// How far off the centres are.
#[derive(Clone, Debug, Default)]
pub struct Errors {
    pub rms_px: f64,
    pub rms_mm: f64,
    pub worst_mm: f64,
    pub lost: usize,
    pub reasons: Vec<String>,
}

impl Errors {
    pub fn of(case: &Case, object: &Object, count: usize) -> Self {
        let rig = rig(object, case);
        let mut scene = Scene::plain(&rig.object).expect("sizes");
        (case.scene)(&mut scene);
        let optics = Optics::of(&rig, case.pixels).expect("complete");
        let renderer = Renderer::new(optics, scene, case.noise, 6);
        let tracker = Tracker::new(&rig).expect("complete");
        let mut decoder = Decoder::default();
        let mut errors = Self::default();
        let mut found = 0.0;
        for (seed, (at, heading)) in places(count).into_iter().enumerate() {
            let (sin, cos) = heading.sin_cos();
            let path = |t: f64| Moment {
                x: at.x + case.speed * t * cos,
                y: at.y + case.speed * t * sin,
                yaw: at.yaw,
            };
            let shot = renderer.shoot(&path, seed as u64);
            let image = decoded(&mut decoder, case.jpeg, &shot.picture);
            let Observation {
                centre,
                pixel,
                quality,
                ..
            } = tracker.observe(&image);
            match centre {
                Err(reason) => {
                    errors.lost += 1;
                    errors
                        .reasons
                        .push(format!("{} at {at:?} ({quality:.2})", reason.name()));
                }
                Ok(centre) => {
                    let mm = 1e3 * centre.distance(Point::new(at.x, at.y));
                    let (pixel, truth) = (pixel.expect("fitted"), shot.centroid.expect("seen"));
                    let px = (pixel[0] - truth[0]).hypot(pixel[1] - truth[1]);
                    errors.rms_mm += mm * mm;
                    errors.rms_px += px * px;
                    errors.worst_mm = errors.worst_mm.max(mm);
                    found += 1.0;
                }
            }
        }
        // Of a coordinate, as an rms of both.
        errors.rms_px = (errors.rms_px / (2.0 * f64::max(found, 1.0))).sqrt();
        errors.rms_mm = (errors.rms_mm / f64::max(found, 1.0)).sqrt();
        errors
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.4} px rms, {:.3} mm rms, {:.3} mm at worst, {} lost {:?}",
            self.rms_px, self.rms_mm, self.worst_mm, self.lost, self.reasons
        )
    }
}
