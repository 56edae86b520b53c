//! Lines, arrows, discs and texts, drawn twice: as a scene, and as points along them.

use std::f64::consts::TAU;

use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, CylinderPrimitive, LinePrimitive, PackedElementField,
    Point3, PointCloud, Pose, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, TextPrimitive,
    Vector3,
};

use values::{Point, Solid};

use super::messages::{Message, timestamp};
use crate::Error;

/// Distance between points along a line, in m.
const DOTS: f64 = 0.004;
/// Width of lines, in m.
const WIDTH: f64 = 0.002;
/// Angle in rad of the two strokes of an arrow's head to its shaft.
const BARB: f64 = 0.5;
const CIRCLE: u32 = 48;

/// A colour: its shares of red, green and blue, and how much it covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink(pub [f64; 4]);

impl Ink {
    /// This colour, covering this share.
    pub fn covering(self, share: f64) -> Self {
        let [r, g, b, _] = self.0;
        Self([r, g, b, share])
    }

    fn color(self) -> Option<Color> {
        let [r, g, b, a] = self.0;
        Some(Color { r, g, b, a })
    }
}

/// What is drawn in one frame, and replaced as a whole.
#[derive(Default)]
pub struct Drawing {
    scene: SceneEntity,
    /// x, y, z in m, and the colour.
    dots: Vec<([f64; 3], Ink)>,
}

impl Drawing {
    /// A point of a cloud alone.
    pub fn dot(&mut self, at: Point, z: f64, ink: Ink) {
        self.dots.push(([at.x, at.y, z], ink));
    }

    /// A line through points at height `z`.
    pub fn line(&mut self, points: &[Point], z: f64, ink: Ink) {
        for ends in points.windows(2) {
            self.dots_along(ends[0], ends[1], z, ink);
        }
        let point = |at: &Point| Point3 {
            x: at.x,
            y: at.y,
            z,
        };
        self.scene.lines.push(LinePrimitive {
            pose: pose([0.0; 3], 0.0),
            thickness: WIDTH,
            points: points.iter().map(point).collect(),
            color: ink.color(),
            ..LinePrimitive::default()
        });
    }

    /// A line that ends where it begins.
    pub fn outline(&mut self, points: &[Point], z: f64, ink: Ink) {
        let around: Vec<Point> = points.iter().chain(points.first()).copied().collect();
        self.line(&around, z, ink);
    }

    /// An arrow at height `z`; nothing where it has no length.
    pub fn arrow(&mut self, from: Point, to: Point, z: f64, ink: Ink) {
        let length = from.distance(to);
        if length < 1e-6 {
            return;
        }
        let head = (0.3 * length).min(0.02);
        self.dots_along(from, to, z, ink);
        for side in [-BARB, BARB] {
            let back = (from - to) * (head / length);
            self.dots_along(to, to + back.rotated(side), z, ink);
        }
        self.scene.arrows.push(ArrowPrimitive {
            pose: pose([from.x, from.y, z], (to - from).bearing()),
            shaft_length: length - head,
            shaft_diameter: 2.0 * WIDTH,
            head_length: head,
            head_diameter: 0.5 * head + 2.0 * WIDTH,
            color: ink.color(),
        });
    }

    /// A slab: its centre, its sizes in m.
    pub fn slab(&mut self, centre: [f64; 3], size: [f64; 3], ink: Ink) {
        self.scene.cubes.push(cube(centre, size, ink));
    }

    /// An upright disc or post: its centre, its radius and height in m.
    pub fn post(&mut self, centre: [f64; 3], radius: f64, height: f64, ink: Ink) {
        self.scene.cylinders.push(CylinderPrimitive {
            pose: pose(centre, 0.0),
            size: vector([2.0 * radius, 2.0 * radius, height]),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: ink.color(),
        });
    }

    /// An object that stands in its frame's origin.
    pub fn solid(&mut self, solid: Solid, ink: Ink) {
        let middle = solid.half_height();
        let centre = [0.0, 0.0, middle];
        match solid {
            Solid::Cylinder { radius, .. } => self.post(centre, radius, 2.0 * middle, ink),
            Solid::Box { half_size } => {
                self.slab(centre, half_size.map(|half| 2.0 * half), ink);
            }
            Solid::Sphere { radius } => self.scene.spheres.push(SpherePrimitive {
                pose: pose(centre, 0.0),
                size: vector([2.0 * radius; 3]),
                color: ink.color(),
            }),
        }
        for z in [0.0, 2.0 * middle] {
            let points = outline(solid, Point::default(), 0.0);
            for ends in points.windows(2) {
                self.dots_along(ends[0], ends[1], z, ink.covering(1.0));
            }
        }
    }

    /// A text whose middle is at `at`, `height` m high; it faces who looks. Clouds have no texts.
    pub fn text(&mut self, at: Point, height: f64, ink: Ink, text: impl Into<String>) {
        self.scene.texts.push(TextPrimitive {
            pose: pose([at.x, at.y, 0.01], 0.0),
            billboard: true,
            font_size: height,
            scale_invariant: false,
            color: ink.color(),
            text: text.into(),
        });
    }

    /// The scene on `topic` and its points on `topic/points`, in a frame.
    pub fn messages(mut self, topic: &str, frame: &str, stamp: u64) -> Result<[Message; 2], Error> {
        self.scene.id = topic.into();
        self.scene.frame_id = frame.into();
        self.scene.frame_locked = true;
        self.scene.timestamp = timestamp(stamp);
        let scene = SceneUpdate {
            deletions: Vec::new(),
            entities: vec![self.scene],
        };
        Ok([
            Message::new(topic, stamp, &scene)?,
            Message::new(
                format!("{topic}/points"),
                stamp,
                &cloud(&self.dots, frame, stamp),
            )?,
        ])
    }

    fn dots_along(&mut self, from: Point, to: Point, z: f64, ink: Ink) {
        let parts = (from.distance(to) / DOTS).ceil().max(1.0);
        for part in 0..=parts as u32 {
            self.dot(from + (to - from) * (f64::from(part) / parts), z, ink);
        }
    }
}

/// The object's outline, seen from above, at a place and turned by `yaw` (rad).
pub fn outline(solid: Solid, at: Point, yaw: f64) -> Vec<Point> {
    match solid.half_sides() {
        Some([x, y]) => [(x, y), (-x, y), (-x, -y), (x, -y), (x, y)]
            .map(|(x, y)| at + Point::new(x, y).rotated(yaw))
            .to_vec(),
        None => circle(at, solid.reach()),
    }
}

pub fn circle(centre: Point, radius: f64) -> Vec<Point> {
    let bearing = |part| TAU * f64::from(part) / f64::from(CIRCLE);
    (0..=CIRCLE)
        .map(|part| centre + Point::polar(radius, bearing(part)))
        .collect()
}

/// A pose upright at a place, turned by `yaw` (rad).
pub fn pose(at: [f64; 3], yaw: f64) -> Option<Pose> {
    Some(Pose {
        position: vector(at),
        orientation: turned(yaw),
    })
}

/// A vector in m.
pub fn vector([x, y, z]: [f64; 3]) -> Option<Vector3> {
    Some(Vector3 { x, y, z })
}

/// A turn about the vertical by `yaw` (rad).
pub fn turned(yaw: f64) -> Option<Quaternion> {
    let (z, w) = (0.5 * yaw).sin_cos();
    Some(Quaternion {
        x: 0.0,
        y: 0.0,
        z,
        w,
    })
}

fn cube(centre: [f64; 3], size: [f64; 3], ink: Ink) -> CubePrimitive {
    CubePrimitive {
        pose: pose(centre, 0.0),
        size: vector(size),
        color: ink.color(),
    }
}

fn cloud(dots: &[([f64; 3], Ink)], frame: &str, stamp: u64) -> PointCloud {
    const STRIDE: u32 = 16;
    let mut data = Vec::with_capacity(dots.len() * STRIDE as usize);
    for (at, Ink(ink)) in dots {
        for coordinate in at {
            data.extend((*coordinate as f32).to_le_bytes());
        }
        data.extend(ink.map(|share| (255.0 * share).round() as u8));
    }
    let field = |name: &str, offset, kind: NumericType| PackedElementField {
        name: name.into(),
        offset,
        r#type: kind.into(),
    };
    let places = ["x", "y", "z"].into_iter().zip((0..).step_by(4));
    let places = places.map(|(name, offset)| field(name, offset, NumericType::Float32));
    let colours = ["red", "green", "blue", "alpha"].into_iter().zip(12..);
    let colours = colours.map(|(name, offset)| field(name, offset, NumericType::Uint8));
    PointCloud {
        timestamp: timestamp(stamp),
        frame_id: frame.into(),
        pose: pose([0.0; 3], 0.0),
        point_stride: STRIDE,
        fields: places.chain(colours).collect(),
        data: data.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_cloud_lie_along_its_lines_and_have_their_colour() {
        let mut drawing = Drawing::default();
        let ink = Ink([1.0, 0.5, 0.0, 0.25]);
        drawing.line(&[Point::new(0.1, 0.0), Point::new(0.1, 0.2)], 0.5, ink);
        let cloud = cloud(&drawing.dots, "table", 1);
        assert_eq!(cloud.data.len(), 51 * 16);
        let number = |at: usize| f32::from_le_bytes(cloud.data[at..at + 4].try_into().expect("4"));
        let last = 50 * 16;
        assert_eq!(
            [number(last), number(last + 4), number(last + 8)],
            [0.1, 0.2, 0.5]
        );
        assert_eq!(cloud.data[last + 12..last + 16], [255, 128, 0, 64]);
        assert_eq!(cloud.fields[6].offset, 15);
    }
}
