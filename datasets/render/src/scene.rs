//! What is before the camera.

use values::{Object, Solid};

use crate::{Form, Moment};

/// A capsule at a height over the table: a hand, an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// One end on the table's plane, in m.
    pub from: [f64; 2],
    /// The other end on the table's plane, in m.
    pub to: [f64; 2],
    /// Half of its width in m.
    pub radius: f64,
    /// Its height over the table in m.
    pub height: f64,
    /// Its colour, as light of 0 to 1.
    pub colour: [f64; 3],
}

/// A soft shadow that something beside the picture throws over table and object: dark on one side of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shade {
    /// A point of its edge on the table, in m.
    pub at: [f64; 2],
    /// Into the shadow, of length 1.
    pub into: [f64; 2],
    /// Width of its edge in m.
    pub soft: f64,
    /// Share of the light that it takes.
    pub strength: f64,
}

/// A reflection of a lamp on the object's upper face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glare {
    /// Its middle, from the object's, in m.
    pub at: [f64; 2],
    /// Its radius in m.
    pub radius: f64,
}

/// What is before the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The object.
    pub form: Form,
    /// Colour of the object, as light of 0 to 1.
    pub object: [f64; 3],
    /// Colour of the table, as light of 0 to 1.
    pub table: [f64; 3],
    /// Share by which the table's pattern is lighter and darker.
    pub grain: f64,
    /// By what share the light grows a metre along x and y, from the middle of the picture.
    pub gradient: [f64; 2],
    /// How bright the object's sides are, of its upper face, where they face the light and where they face away.
    pub sides: [f64; 2],
    /// Light comes from this side, in rad from +x.
    pub light_from: f64,
    /// The object's own shadow: its length in m, the width of its edge in m, and the share of light that it takes.
    pub shadow: [f64; 3],
    /// A shadow of something else than the object; none where there is none.
    pub shade: Option<Shade>,
    /// A reflection.
    pub glare: Option<Glare>,
    /// Other objects of the same form and colour.
    pub others: Vec<Moment>,
    /// What lies over the scene.
    pub covers: Vec<Cover>,
}

impl Scene {
    /// A red object on a grey table, evenly lit, without shadow or noise; nothing if a size of the object is missing.
    pub fn plain(object: &Object) -> Option<Self> {
        let form = match object.solid {
            Solid::Cylinder {
                radius,
                half_height,
            } => Form::Cylinder {
                radius,
                height: 2.0 * half_height,
            },
            Solid::Sphere { radius } => Form::Sphere { radius },
            Solid::Box { half_size } => Form::Box { half: half_size },
        };
        Some(Self {
            form,
            object: [0.50, 0.03, 0.04],
            table: [0.32, 0.31, 0.29],
            grain: 0.0,
            gradient: [0.0; 2],
            sides: [1.0; 2],
            light_from: 2.2,
            shadow: [0.0, 0.01, 0.0],
            shade: None,
            glare: None,
            others: Vec::new(),
            covers: Vec::new(),
        })
    }

    /// A laboratory: uneven light, a table with a grain, darker sides, and the object's own soft shadow.
    pub fn laboratory(object: &Object) -> Option<Self> {
        Some(Self {
            grain: 0.02,
            gradient: [0.15, -0.20],
            sides: [0.75, 0.45],
            shadow: [0.03, 0.02, 0.5],
            ..Self::plain(object)?
        })
    }
}
