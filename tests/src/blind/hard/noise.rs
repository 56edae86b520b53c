//! Draws the noise of a hard set.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rig::{Noise, NoiseKind};

use super::super::form::{Range, one_of, uniform};

/// Ranges of each kind's parameters: what real tables show, up to the largest that are to be withstood.
const RANGES: &[(&str, &[Range])] = &[
    ("friction_scatter", &[("sd", 0.01, 0.04)]),
    ("friction_wander", &[("step", 0.002, 0.01)]),
    ("launch_tails", &[]),
    ("launch_scatter_by_speed", &[("factor", 2.0, 4.0)]),
    ("launch_scatter_by_angle", &[("factor", 2.0, 4.0)]),
    ("camera_correlation", &[("rho", 0.3, 0.9)]),
    ("camera_tails", &[]),
    ("camera_noise_by_strike", &[("spread", 0.3, 0.7)]),
    ("late_stamps", &[("mean", 0.001, 0.005)]),
    ("jittering_stamps", &[("sd", 0.001, 0.005)]),
    (
        "stray_frames",
        &[("share", 0.003, 0.02), ("distance", 0.03, 0.2)],
    ),
    (
        "mount_vibration",
        &[("amplitude", 0.0003, 0.001), ("frequency", 5.0, 9.0)],
    ),
    ("wrong_rig_file", &[]),
    ("quantised_places", &[("step", 0.0005, 0.003)]),
    ("quantised_stamps", &[("step", 0.001, 0.010)]),
    (
        "lost_bursts",
        &[("share", 0.1, 0.6), ("longest", 0.08, 0.35)],
    ),
    // Beyond 0.62 to 0.83 m nothing is seen: up to a third of the strikes end there.
    ("narrow_view", &[("narrowness", 1.2, 1.6)]),
];
/// What is drawn for odd sets alone.
const ODD: &[(&str, &[Range])] = &[
    ("two_objects", &[("change", 0.1, 0.3), ("share", 0.2, 0.5)]),
    (
        "rolling_shutter",
        &[("readout", 0.005, 0.03), ("bearing", -3.1, 3.1)],
    ),
];
/// Kinds of the rig that are not drawn: a box's yaw shows in poses alone, and these sets have centroids.
#[cfg(test)]
const NOT_DRAWN: &[&str] = &["yaw_scatter"];
/// Relative errors of a rig file: its sizes, and the camera's noise that it states.
const SIZE_ERROR: f64 = 0.1;
const NOISE_ERROR: (f64, f64) = (-0.4, 1.0);
/// Chances of no kind, one, two; three kinds otherwise.
const CHANCES: [f64; 3] = [0.10, 0.40, 0.30];

/// Zero to three kinds of noise, each as strong as drawn.
pub(super) fn draw(random: &mut ChaCha8Rng) -> Noise {
    let luck = random.random::<f64>();
    let mut passed = 0.0;
    let count = CHANCES
        .iter()
        .take_while(|chance| {
            passed += **chance;
            luck >= passed
        })
        .count();
    let mut noise = Noise::none();
    while noise.0.len() < count {
        let kind = one_kind(RANGES, random);
        if noise.0.iter().all(|known| known.name() != kind.name()) {
            noise.0.push(kind);
        }
    }
    noise
}

pub(super) fn odd(random: &mut ChaCha8Rng) -> NoiseKind {
    one_kind(ODD, random)
}

fn one_kind(listed: &[(&str, &[Range])], random: &mut ChaCha8Rng) -> NoiseKind {
    let (name, ranges) = one_of(random, listed);
    let mut kind = NoiseKind::named(name).expect("the rig has every kind that is listed (tested)");
    for (parameter, low, high) in *ranges {
        kind.set(parameter, uniform(random, *low, *high));
    }
    if *name == "wrong_rig_file" {
        let sign = |random: &mut ChaCha8Rng| {
            if random.random::<f64>() < 0.5 {
                -1.0
            } else {
                1.0
            }
        };
        kind.set("object", SIZE_ERROR * sign(random));
        kind.set("mass", SIZE_ERROR * sign(random));
        kind.set("tip", SIZE_ERROR * sign(random));
        kind.set("noise", uniform(random, NOISE_ERROR.0, NOISE_ERROR.1));
    }
    kind
}

pub(super) fn kinds() -> impl Iterator<Item = &'static str> {
    RANGES.iter().map(|(name, _)| *name)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn every_kind_of_the_rig_is_drawn_with_parameters_that_it_has() {
        for kind in NoiseKind::all() {
            let odd = ODD.iter().map(|(name, _)| *name);
            let mut known = kinds().chain(odd).chain(NOT_DRAWN.iter().copied());
            assert!(known.any(|name| name == kind.name()), "{}", kind.name());
        }
        for (name, ranges) in RANGES.iter().chain(ODD) {
            let kind = NoiseKind::named(name).expect("known");
            assert!(ranges.iter().all(|(p, ..)| kind.get(p).is_some()), "{name}");
        }
    }

    #[test]
    fn a_tenth_of_the_sets_has_ideal_noise() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let counts: Vec<usize> = (0..2000).map(|_| draw(&mut random).0.len()).collect();
        let share = |n| counts.iter().filter(|c| **c == n).count() as f64 / 2000.0;
        assert!((share(0) - 0.1).abs() < 0.02 && (share(1) - 0.4).abs() < 0.04);
        assert!((share(3) - 0.2).abs() < 0.04);
    }
}
