//! Rotations: vectors, axes and quaternions.

use crate::camera::dot;

/// A vector turned by a rotation vector (Rodrigues).
pub(crate) fn turned(v: [f64; 3], turn: [f64; 3]) -> [f64; 3] {
    let angle = length(turn);
    let Some(axis) = unit(turn) else { return v };
    let (sin, cos) = angle.sin_cos();
    let (across, along) = (cross(axis, v), dot(axis, v));
    [0, 1, 2].map(|i| cos * v[i] + sin * across[i] + (1.0 - cos) * along * axis[i])
}

/// The quaternion `[x, y, z, w]` of the rotation whose columns are these axes.
pub(crate) fn quaternion(axes: [[f64; 3]; 3]) -> [f64; 4] {
    let at = |row: usize, column: usize| axes[column][row];
    // The largest of the four parts is divided by; so none is lost (Shepperd 1978).
    let trace = at(0, 0) + at(1, 1) + at(2, 2);
    let parts = [at(0, 0), at(1, 1), at(2, 2), trace];
    let largest = (0..4).max_by(|a, b| parts[*a].total_cmp(&parts[*b]));
    let [x, y, z, w] = match largest.unwrap_or(3) {
        0 => [
            1.0 + at(0, 0) - at(1, 1) - at(2, 2),
            at(0, 1) + at(1, 0),
            at(0, 2) + at(2, 0),
            at(2, 1) - at(1, 2),
        ],
        1 => [
            at(0, 1) + at(1, 0),
            1.0 - at(0, 0) + at(1, 1) - at(2, 2),
            at(1, 2) + at(2, 1),
            at(0, 2) - at(2, 0),
        ],
        2 => [
            at(0, 2) + at(2, 0),
            at(1, 2) + at(2, 1),
            1.0 - at(0, 0) - at(1, 1) + at(2, 2),
            at(1, 0) - at(0, 1),
        ],
        _ => [
            at(2, 1) - at(1, 2),
            at(0, 2) - at(2, 0),
            at(1, 0) - at(0, 1),
            1.0 + trace,
        ],
    };
    let length = (x * x + y * y + z * z + w * w).sqrt();
    [x, y, z, w].map(|part| part / length)
}

pub(crate) fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

/// The direction with length 1; none of nothing.
pub(crate) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = length(v);
    (length > 0.0).then(|| v.map(|part| part / length))
}

/// The vector across both.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
