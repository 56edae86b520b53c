//! Where an object is, and rays against solids.

/// An object's form, standing on the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// An upright cylinder.
    Cylinder {
        /// In m.
        radius: f64,
        /// In m.
        height: f64,
    },
    /// A box.
    Box {
        /// Half sizes in m.
        half: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// In m.
        radius: f64,
    },
}

/// Where a ray meets a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Share of the ray from its origin to its end.
    pub(crate) along: f64,
    /// Outwards, of length 1.
    pub(crate) normal: [f64; 3],
    /// Which of the solid's faces, by number.
    pub(crate) face: usize,
}

impl Form {
    /// Its height in m.
    pub(crate) fn height(&self) -> f64 {
        match self {
            Self::Cylinder { height, .. } => *height,
            Self::Box { half } => 2.0 * half[2],
            Self::Sphere { radius } => 2.0 * radius,
        }
    }

    /// Radius in m of the circle that holds its outline from above.
    pub(crate) fn reach(&self) -> f64 {
        match self {
            Self::Cylinder { radius, .. } | Self::Sphere { radius } => *radius,
            Self::Box { half } => half[0].hypot(half[1]),
        }
    }

    /// Radius in m of a circle about as large as its base.
    pub(crate) fn base(&self) -> f64 {
        match self {
            Self::Cylinder { radius, .. } => *radius,
            Self::Sphere { radius } => 0.6 * radius,
            Self::Box { half } => 0.5 * (half[0] + half[1]),
        }
    }

    /// The first point at which a ray from `origin` along `ray` meets it.
    pub(crate) fn hit(&self, at: Moment, origin: [f64; 3], ray: [f64; 3]) -> Option<Hit> {
        let from = [origin[0] - at.x, origin[1] - at.y, origin[2]];
        match *self {
            Self::Cylinder { radius, height } => cylinder(radius, height, from, ray),
            Self::Sphere { radius } => sphere(radius, from, ray),
            Self::Box { half } => {
                let (sin, cos) = at.yaw.sin_cos();
                let turned = |v: [f64; 3]| [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[2]];
                let mut hit = slab(half, turned(from), turned(ray))?;
                let [x, y, z] = hit.normal;
                hit.normal = [cos * x - sin * y, sin * x + cos * y, z];
                Some(hit)
            }
        }
    }
}

fn cylinder(radius: f64, height: f64, from: [f64; 3], ray: [f64; 3]) -> Option<Hit> {
    let top = (height - from[2]) / ray[2];
    let [x, y] = [0, 1].map(|i| from[i] + top * ray[i]);
    if top > 0.0 && x * x + y * y <= radius * radius {
        return Some(Hit {
            along: top,
            normal: [0.0, 0.0, 1.0],
            face: 0,
        });
    }
    let a = ray[0] * ray[0] + ray[1] * ray[1];
    let b = from[0] * ray[0] + from[1] * ray[1];
    let c = from[0] * from[0] + from[1] * from[1] - radius * radius;
    let root = b * b - a * c;
    if root < 0.0 || a == 0.0 {
        return None;
    }
    let along = (-b - root.sqrt()) / a;
    let z = from[2] + along * ray[2];
    (along > 0.0 && (0.0..=height).contains(&z)).then(|| Hit {
        along,
        normal: [
            (from[0] + along * ray[0]) / radius,
            (from[1] + along * ray[1]) / radius,
            0.0,
        ],
        face: 1,
    })
}

fn sphere(radius: f64, from: [f64; 3], ray: [f64; 3]) -> Option<Hit> {
    let from = [from[0], from[1], from[2] - radius];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (a, b, c) = (
        dot(ray, ray),
        dot(from, ray),
        dot(from, from) - radius * radius,
    );
    let root = b * b - a * c;
    if root < 0.0 {
        return None;
    }
    let along = (-b - root.sqrt()) / a;
    (along > 0.0).then(|| Hit {
        along,
        normal: [0, 1, 2].map(|i| (from[i] + along * ray[i]) / radius),
        face: 0,
    })
}

fn slab(half: [f64; 3], from: [f64; 3], ray: [f64; 3]) -> Option<Hit> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut normal, mut face) = ([0.0; 3], 0);
    for i in 0..3 {
        let middle = if i == 2 { half[2] } else { 0.0 };
        let (near, far) = (
            (middle - half[i] - from[i]) / ray[i],
            (middle + half[i] - from[i]) / ray[i],
        );
        if near.min(far) > enter {
            enter = near.min(far);
            normal = [0.0; 3];
            normal[i] = -ray[i].signum();
            face = 2 * i + usize::from(ray[i] < 0.0);
        }
        leave = leave.min(near.max(far));
    }
    (enter > 0.0 && enter <= leave).then_some(Hit {
        along: enter,
        normal,
        face,
    })
}

/// Where an object is: its centre on the table (m) and its yaw (rad).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Along x, in m.
    pub x: f64,
    /// Along y, in m.
    pub y: f64,
    /// Yaw in rad.
    pub yaw: f64,
}
