//! MuJoCo has no restitution: a contact's spring and damper represent it.
//!
//! With `solref = (-k, -b)`, b = 2ζ√k, a contact pushes as a damped oscillator of unit mass and lets go when its force
//! would pull (MuJoCo docs, "Contact parameters"). In the limit of short steps
//! e = exp(−ζ/√(1−ζ²)·atan2(2ζ√(1−ζ²), 2ζ²−1)), whatever the masses; at the steps taken here, first order in time, that is
//! off by one to three per cent. So ζ is chosen for the steps themselves: the same recursion, one dimension of it.

use std::f64::consts::PI;

/// Speed of release over speed of approach of MuJoCo's semi-implicit steps through a contact of stiffness and damping
/// given per unit mass (1/s², 1/s), from a start half a step deep.
fn stepped_restitution(stiffness: f64, damping: f64, timestep: f64) -> f64 {
    let (mut depth, mut speed) = (0.5 * timestep, 1.0);
    while depth > 0.0 {
        speed -= timestep * (stiffness * depth + damping * speed).max(0.0);
        depth += timestep * speed;
    }
    -speed
}

/// Direct `solref` (−stiffness, −damping) of a contact that restores `restitution` (0.14–0.99) when it is taken through
/// in steps of `timestep` seconds, and whose undamped half period is `contact_time` in seconds.
pub fn contact_solref(contact_time: f64, restitution: f64, timestep: f64) -> [f64; 2] {
    let frequency = PI / contact_time;
    let stiffness = frequency * frequency;
    let (mut low, mut high) = (0.0, 2.0 * frequency);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if stepped_restitution(stiffness, middle, timestep) > restitution {
            low = middle;
        } else {
            high = middle;
        }
    }
    [-stiffness, -0.5 * (low + high)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The limit of short steps.
    fn formula(damping_ratio: f64) -> f64 {
        let root = (1.0 - damping_ratio * damping_ratio).sqrt();
        (-damping_ratio / root
            * (2.0 * damping_ratio * root).atan2(2.0 * damping_ratio * damping_ratio - 1.0))
        .exp()
    }

    #[test]
    fn short_steps_approach_the_formula() {
        for restitution in [0.2, 0.3, 0.5, 0.8, 0.95] {
            let [stiffness, damping] = contact_solref(0.002, restitution, 1e-8);
            let ratio = -damping / (2.0 * (-stiffness).sqrt());
            assert!((formula(ratio) - restitution).abs() < 1e-4, "{restitution}");
        }
    }
}
