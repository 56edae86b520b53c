//! Rendered cases, and how far the centres found are from those rendered.

pub mod messages;

use std::fmt;

pub use render::case::{Case, places, rig, tall};
use render::{Moment, Optics, Renderer, Scene};
use track::{Decoder, Image, ImageMessage, Observation, Payload, Tracker};
use values::{Object, Point};

pub fn decoded(decoder: &mut Decoder, jpeg: Option<u8>, picture: &render::Picture) -> Image {
    let data = match jpeg {
        Some(quality) => picture.jpeg(quality).expect("encodes"),
        None => picture.png().expect("encodes"),
    };
    let payload = Payload::Compressed(&data);
    let message = ImageMessage { stamp: 0, payload };
    decoder.decode(&message).expect("decodes").clone()
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
            let rendered = renderer.render(&path, seed as u64);
            let image = decoded(&mut decoder, case.jpeg, &rendered.picture);
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
                    let (pixel, truth) = (pixel.expect("fitted"), rendered.centroid.expect("seen"));
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
