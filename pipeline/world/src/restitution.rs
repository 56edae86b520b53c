//! MuJoCo has no restitution: a contact's spring and damper stand for it.
//!
//! With `solref = (-k, -b)`, b = 2ζ√k, a contact pushes as a damped oscillator of unit mass and lets go when its force
//! would pull; then e = exp(−ζ/√(1−ζ²)·atan2(2ζ√(1−ζ²), 2ζ²−1)), whatever the masses (MuJoCo docs, "Contact parameters").

use std::f64::consts::PI;

/// Coefficient of restitution of a contact with damping ratio ζ in [0, 1).
fn restitution_of(damping: f64) -> f64 {
    let root = (1.0 - damping * damping).sqrt();
    (-damping / root * (2.0 * damping * root).atan2(2.0 * damping * damping - 1.0)).exp()
}

/// Direct `solref` (−stiffness, −damping) of a contact that restores `restitution` (0.14–1) and whose undamped half
/// period is `contact_time` in seconds. Below 0.14 the damping ratio nears one; values under that are held at it.
pub fn contact_solref(contact_time: f64, restitution: f64) -> [f64; 2] {
    let (mut low, mut high) = (0.0, 0.9999);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if restitution_of(middle) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    let frequency = PI / contact_time;
    [-frequency * frequency, -(low + high) * frequency]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_is_inverted() {
        for restitution in [0.15, 0.3, 0.5, 0.8, 0.99] {
            let [stiffness, damping] = contact_solref(0.002, restitution);
            let ratio = -damping / (2.0 * (-stiffness).sqrt());
            assert!((restitution_of(ratio) - restitution).abs() < 1e-9);
        }
    }
}
