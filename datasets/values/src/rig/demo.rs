//! The rig of the demo.

use super::{
    Camera, Frames, Object, Rig, Robot, Shape, Solid, StampMark, Striker, Table, Tip, Topics,
};
use crate::Point;

impl Rig {
    /// A rig of the demo's kind: a 100 g cylinder before a small arm.
    pub fn demo(shape: Shape) -> Self {
        let (solid, mass) = match shape {
            Shape::Cylinder => (
                Solid::Cylinder {
                    radius: 0.030,
                    half_height: 0.020,
                },
                0.100,
            ),
            Shape::Box => (
                Solid::Box {
                    half_size: [0.030, 0.030, 0.020],
                },
                0.150,
            ),
            Shape::Sphere => (Solid::Sphere { radius: 0.025 }, 0.100),
        };
        let object = Object {
            solid,
            mass,
            colour: None,
            marker: None,
        };
        Self {
            object,
            striker: Striker {
                tip: Tip::Sphere,
                radius: 0.012,
            },
            table: Table {
                x: [0.10, 1.00].into(),
                y: [-0.60, 0.60].into(),
                fences: Vec::new(),
            },
            camera: Camera {
                rate: 60.0,
                noise: 0.0007,
                centre: Point::new(0.45, 0.0),
                matrix: None,
                size: None,
                distortion: None,
                position: None,
                orientation: None,
                exposure: None,
                readout: None,
                stamp: StampMark::Middle,
            },
            robot: Robot::limits([0.4, 1.0].into(), [-0.80, 0.80].into(), 5.0),
            topics: Topics::default(),
            frames: Frames::default(),
        }
    }
}
