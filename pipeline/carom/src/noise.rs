//! How repeats of one command scatter, for the noise floor.
//!
//! Identification explains the tracks by parameters, a mean turn and launch scatter: what these cannot absorb (a gain of
//! the speed, a slope of the table) counts as scatter there, though it repeats. The residual model takes that away, so that what it
//! leaves (on strikes that it did not learn from, where there are enough) is the better estimate.

use evaluate::Noise;
use residual::Residual;
use values::{Rig, Split};
use world::World;

use crate::results::Learnt;

/// Seconds of rest over which ingestion averages a position, about.
const REST: f64 = 0.3;
/// Standard deviation over median absolute deviation of a normal distribution: a patch of the table that a few strikes
/// cross is no scatter.
const NORMAL: f64 = 1.4826;
/// Fewer strikes tell no scatter.
const LEAST_ROWS: usize = 10;

/// From what the residual model leaves, where there is one and enough strikes to judge by; else as identified.
pub fn noise(rig: &Rig, learnt: &Learnt) -> Noise {
    let identified = identified(rig, &learnt.world);
    let Some(trained) = &learnt.trained else {
        return identified;
    };
    let rows = &learnt.residuals.rows;
    let judges = |row: &&Residual| row.split == Split::Validation;
    let few = rows.iter().filter(judges).count() < LEAST_ROWS;
    // A network that learnt from a few rows leaves much of them: the rows it saw tell no less than their scatter.
    let used = rows
        .iter()
        .filter(|row| judges(row) || few && row.split == Split::Train);
    let left = used.map(|row| {
        let inputs = [row.path.x, row.path.y, row.speed_sim, row.angle_sim];
        let [d_speed, d_angle] = trained.network.predict(inputs);
        let speed = row.speed_sim + row.d_speed;
        [(row.d_speed - d_speed) / speed, row.d_angle - d_angle]
    });
    let (speeds, angles): (Vec<f64>, Vec<f64>) = left.map(|[speed, angle]| (speed, angle)).unzip();
    if speeds.len() < LEAST_ROWS {
        return identified;
    }
    Noise {
        speed: deviation(speeds).min(identified.speed),
        angle: deviation(angles).min(identified.angle),
        // The error of a measured position is in the two above: each path is measured.
        position: 0.0,
    }
}

/// From the identified scatter.
pub fn identified(rig: &Rig, world: &World) -> Noise {
    Noise::of(&world.scatter, rig.camera.rate * REST)
}

fn deviation(values: Vec<f64>) -> f64 {
    let middle = median(values.clone());
    NORMAL * median(values.iter().map(|value| (value - middle).abs()).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    if values.len().is_multiple_of(2) {
        0.5 * (values[half - 1] + values[half])
    } else {
        values[half]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_is_not_moved_by_a_few_far_values() {
        let mut values: Vec<f64> = (-50..=50).map(|i| f64::from(i) / 50.0).collect();
        let clean = deviation(values.clone());
        assert!((clean - NORMAL * 0.5).abs() < 0.02);
        values.extend([9.0, 10.0]);
        assert!((deviation(values) - clean).abs() < 0.05);
    }
}
