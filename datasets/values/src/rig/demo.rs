//! The rig of the demo.

use super::{Camera, Frames, Object, Rig, Robot, Shape, StampMark, Striker, Table, Tip, Topics};
use crate::Point;

impl Rig {
    /// A rig of the demo's kind: a 100 g cylinder before a small arm.
    pub fn demo(shape: Shape) -> Self {
        let object = match shape {
            Shape::Cylinder => Object {
                shape,
                radius: Some(0.030),
                half_height: Some(0.020),
                half_size: None,
                mass: 0.100,
                colour: None,
            },
            Shape::Box => Object {
                shape,
                radius: None,
                half_height: None,
                half_size: Some([0.030, 0.030, 0.020]),
                mass: 0.150,
                colour: None,
            },
            Shape::Sphere => Object {
                shape,
                radius: Some(0.025),
                half_height: None,
                half_size: None,
                mass: 0.100,
                colour: None,
            },
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
                exposure: 0.0,
                readout: 0.0,
                stamp: StampMark::Middle,
            },
            robot: Robot::limits([0.4, 1.0].into(), [-0.80, 0.80].into(), 5.0),
            topics: Topics::default(),
            frames: Frames::default(),
        }
    }
}
