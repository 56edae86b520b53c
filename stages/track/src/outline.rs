//! The outline of the known shape as the camera sees it, and how it moves with the object.
//!
//! The outline is the convex hull of the shape's rims (cylinder, box) or of its contour circle (sphere), taken in directions,
//! where straight lines are straight, and then seen through the lens. When the object moves a little, a point of the outline
//! moves across it as the point of the object that is seen there: what the contour slides along the surface is along the outline.

use values::Object;

use crate::CameraModel;

/// Where the object is: its centre on the table (m) and its yaw (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pose {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) yaw: f64,
}

/// The object's solid shape, standing on the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Solid {
    Cylinder { radius: f64, height: f64 },
    Box { half: [f64; 2], height: f64 },
    Sphere { radius: f64 },
}

impl Solid {
    /// The solid of a rig's object.
    pub(crate) fn of(object: &Object) -> Self {
        let height = 2.0 * object.solid.half_height();
        match object.solid {
            values::Solid::Cylinder { radius, .. } => Self::Cylinder { radius, height },
            values::Solid::Sphere { radius } => Self::Sphere { radius },
            values::Solid::Box {
                half_size: [x, y, _],
            } => Self::Box {
                half: [x, y],
                height,
            },
        }
    }

    /// Whether its picture depends on its yaw.
    pub(crate) fn turns(&self) -> bool {
        matches!(self, Self::Box { .. })
    }

    /// Height in m of the middle of what is seen from above.
    pub(crate) fn middle(&self) -> f64 {
        match self {
            Self::Cylinder { height, .. } | Self::Box { height, .. } => 0.5 * height,
            Self::Sphere { radius } => *radius,
        }
    }

    /// Its height in m, where its outline shows more of it than its width.
    pub(crate) fn height(&self) -> Option<f64> {
        match self {
            Self::Cylinder { height, .. } | Self::Box { height, .. } => Some(*height),
            Self::Sphere { .. } => None,
        }
    }

    /// Largest half width in m.
    pub(crate) fn reach(&self) -> f64 {
        match self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => *radius,
            Self::Box { half, .. } => half[0].hypot(half[1]),
        }
    }

    /// Smallest half width in m.
    pub(crate) fn half_width(&self) -> f64 {
        match self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => *radius,
            Self::Box { half, .. } => half[0].min(half[1]),
        }
    }
}

/// A corner of the outline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    pub(crate) at: [f64; 2],
    /// How it moves with x, y (px/m), yaw (px/rad) and the object's height (px/m).
    pub(crate) moves: [[f64; 2]; 4],
}

/// What is seen of a solid.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outline {
    pub(crate) vertices: Vec<Vertex>,
    /// The corners of its upper face; none for a sphere.
    pub(crate) top: Vec<[f64; 2]>,
}

const POINTS: usize = 64;

struct Corner {
    direction: [f64; 2],
    vertex: Vertex,
    is_top: bool,
}

impl Outline {
    /// What the camera sees of a solid; none where a part of it lies behind.
    pub(crate) fn seen(camera: &CameraModel, solid: &Solid, pose: Pose) -> Option<Self> {
        let mut corners = Vec::with_capacity(2 * POINTS);
        // A polygon of the circle's area, so that it is as large as the circle.
        let step = std::f64::consts::TAU / POINTS as f64;
        let even = (step / step.sin()).sqrt();
        let circle = |k: usize| {
            let (sin, cos) = (k as f64 * step).sin_cos();
            [even * cos, even * sin]
        };
        match *solid {
            Solid::Cylinder { radius, height } => {
                for (z, is_top) in [(height, true), (0.0, false)] {
                    for k in 0..POINTS {
                        let arm = circle(k).map(|part| part * radius);
                        corners.push(corner(camera, pose, arm, z, is_top)?);
                    }
                }
            }
            Solid::Box { half, height } => {
                let (sin, cos) = pose.yaw.sin_cos();
                for (z, is_top) in [(height, true), (0.0, false)] {
                    for [i, j] in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]] {
                        let [a, b] = [i * half[0], j * half[1]];
                        let arm = [cos * a - sin * b, sin * a + cos * b];
                        corners.push(corner(camera, pose, arm, z, is_top)?);
                    }
                }
            }
            Solid::Sphere { radius } => {
                let to = [
                    camera.position[0] - pose.x,
                    camera.position[1] - pose.y,
                    camera.position[2] - radius,
                ];
                let distance = crate::camera::dot(to, to).sqrt();
                let share = radius / distance;
                if share >= 1.0 {
                    return None;
                }
                let axis = to.map(|part| part / distance);
                let [across, along] = across(axis);
                let rim = radius * (1.0 - share * share).sqrt();
                for k in 0..POINTS {
                    let [a, b] = circle(k).map(|part| part * rim);
                    let arm =
                        [0, 1, 2].map(|i| radius * share * axis[i] + a * across[i] + b * along[i]);
                    let z = radius + arm[2];
                    corners.push(corner(camera, pose, [arm[0], arm[1]], z, false)?);
                }
            }
        }
        let top = corners.iter().filter(|corner| corner.is_top);
        let top = top.map(|corner| corner.vertex.at).collect();
        Some(Self {
            vertices: hull(corners),
            top,
        })
    }

    /// Area in px² and centroid in px.
    pub(crate) fn moments(&self) -> (f64, [f64; 2]) {
        let Some(first) = self.vertices.first() else {
            return (0.0, [0.0; 2]);
        };
        let (mut area, mut sum) = (0.0, [0.0; 2]);
        let from = |vertex: &Vertex| [0, 1].map(|i| vertex.at[i] - first.at[i]);
        for pair in self.vertices.windows(2) {
            let (a, b) = (from(&pair[0]), from(&pair[1]));
            let cross = 0.5 * (a[0] * b[1] - a[1] * b[0]);
            area += cross;
            sum = [0, 1].map(|i| sum[i] + cross * (a[i] + b[i]) / 3.0);
        }
        if area == 0.0 {
            return (0.0, first.at);
        }
        (area.abs(), [0, 1].map(|i| first.at[i] + sum[i] / area))
    }

    /// The middle of its upper face in px; of a sphere, of all of it.
    pub(crate) fn middle_of_top(&self) -> [f64; 2] {
        if self.top.is_empty() {
            return self.moments().1;
        }
        let count = self.top.len() as f64;
        [0, 1].map(|i| self.top.iter().map(|at| at[i]).sum::<f64>() / count)
    }

    /// Length around, in px.
    pub(crate) fn length(&self) -> f64 {
        self.edges().map(|(a, b)| distance(a.at, b.at)).sum()
    }

    /// Its edges, each from a corner to the next.
    pub(crate) fn edges(&self) -> impl Iterator<Item = (&Vertex, &Vertex)> {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next)
    }

    /// Whether a pixel lies within.
    pub(crate) fn holds(&self, [x, y]: [f64; 2]) -> bool {
        self.edges().all(|(a, b)| {
            let along = [0, 1].map(|i| b.at[i] - a.at[i]);
            along[0] * (y - a.at[1]) >= along[1] * (x - a.at[0])
        })
    }

    /// The least and greatest coordinates in px: `[[x, y], [x, y]]`.
    pub(crate) fn bounds(&self) -> [[f64; 2]; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for vertex in &self.vertices {
            low = [0, 1].map(|i| low[i].min(vertex.at[i]));
            high = [0, 1].map(|i| high[i].max(vertex.at[i]));
        }
        [low, high]
    }
}

pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Two directions across an axis of length 1, and across each other.
fn across(axis: [f64; 3]) -> [[f64; 3]; 2] {
    let [x, y, z] = axis;
    let other = if z.abs() < 0.9 {
        [0.0, 0.0, 1.0]
    } else {
        [1.0, 0.0, 0.0]
    };
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let first = cross([x, y, z], other);
    let length = crate::camera::dot(first, first).sqrt();
    let first = first.map(|part| part / length);
    [first, cross(axis, first)]
}

/// The picture of a point of the object at `arm` (m) from its centre and at this height (m).
fn corner(camera: &CameraModel, pose: Pose, arm: [f64; 2], z: f64, is_top: bool) -> Option<Corner> {
    let point = [pose.x + arm[0], pose.y + arm[1], z];
    let direction = camera.direction(point)?;
    let [u, v] = direction;
    let depth = camera.optical(point)[2];
    let slope = camera.lens.slope(direction);
    // A step e of the point changes u = X/Z by (e·right − u·e·forward)/Z.
    let [right, down, forward] = camera.axes;
    let step = |e: [f64; 3]| {
        let along = |axis: [f64; 3]| crate::camera::dot(axis, e);
        let du = (along(right) - u * along(forward)) / depth;
        let dv = (along(down) - v * along(forward)) / depth;
        slope.map(|row| row[0] * du + row[1] * dv)
    };
    let vertex = Vertex {
        at: camera.lens.pixel(direction),
        moves: [
            step([1.0, 0.0, 0.0]),
            step([0.0, 1.0, 0.0]),
            step([-arm[1], arm[0], 0.0]),
            step([0.0, 0.0, f64::from(u8::from(is_top))]),
        ],
    };
    Some(Corner {
        direction,
        vertex,
        is_top,
    })
}

/// The convex hull (Andrew's monotone chain), in order around.
fn hull(mut corners: Vec<Corner>) -> Vec<Vertex> {
    corners.sort_by(|a, b| {
        let [a, b] = [a.direction, b.direction];
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let chain = |corners: &mut dyn Iterator<Item = &Corner>| {
        let mut kept: Vec<(usize, [f64; 2], Vertex)> = Vec::new();
        for (index, corner) in corners.enumerate() {
            while let [.., (_, a, _), (_, b, _)] = kept[..] {
                let c = corner.direction;
                let turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                if turn > 0.0 {
                    break;
                }
                kept.pop();
            }
            kept.push((index, corner.direction, corner.vertex));
        }
        kept.pop();
        kept.into_iter().map(|(_, _, vertex)| vertex)
    };
    let lower = chain(&mut corners.iter());
    let upper = chain(&mut corners.iter().rev());
    lower.chain(upper).collect()
}
