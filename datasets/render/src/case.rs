//! Cases on which trackers are measured: what varies, and the camera and object that all have.

use values::{Colour, ImageTopic, Object, Rig, Shape, Solid, StampMark};

use crate::{Moment, Scene, Shade};

/// What is rendered.
#[derive(Clone, Copy)]
pub struct Case {
    /// Width and height in px.
    pub pixels: [usize; 2],
    /// Standard deviation of a byte.
    pub noise: f64,
    /// JPEG's quality; none is PNG.
    pub jpeg: Option<u8>,
    /// Whether the lens bends.
    pub lens: bool,
    /// Exposure in s.
    pub exposure: f64,
    /// Read-out in s.
    pub readout: f64,
    /// How fast the object moves, in m/s.
    pub speed: f64,
    /// What is changed in a plain scene.
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

/// A flat disc of 60 mm.
pub fn disc() -> Object {
    Object {
        solid: Solid::Cylinder {
            radius: 0.030,
            half_height: 0.0005,
        },
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
    rig.camera.exposure = Some(case.exposure);
    rig.camera.readout = Some(case.readout);
    rig.camera.stamp = StampMark::Middle;
    rig.topics.image = Some(ImageTopic::new("/camera/image"));
    rig
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

/// Uneven light.
pub fn gradient(scene: &mut Scene) {
    scene.gradient = [0.3, -0.25];
}

/// A soft shadow of half the light, and the object's own.
pub fn shadow(scene: &mut Scene) {
    scene.shade = Some(Shade {
        at: [0.5, 0.0],
        into: [0.6, 0.8],
        soft: 0.06,
        strength: 0.5,
    });
    scene.shadow = [0.03, 0.02, 0.5];
}
