//! Draws an effect's place, direction, sign and form, within what real tables show.
//!
//! Form is what the library fixes and a real table does not: exponents, edges, time constants, how sharp a bend is.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rig::Effect;

/// A number between two.
pub(super) fn uniform(random: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random::<f64>()
}

/// Draws one of the items; they must not be empty.
pub(super) fn one_of<'i, T>(random: &mut ChaCha8Rng, items: &'i [T]) -> &'i T {
    let at = (random.random::<f64>() * items.len() as f64) as usize;
    &items[at.min(items.len() - 1)]
}

/// Sets a parameter that the effect must have: a misspelt one would leave the default unnoticed.
fn set(effect: &mut Effect, parameter: &str, value: f64) {
    let name = effect.name();
    assert!(effect.set(parameter, value), "{name} has no {parameter}");
}

pub(super) type Range<'a> = (&'a str, f64, f64);

/// Ranges from which each effect's parameters of place and form are drawn, each by itself.
const RANGES: &str = "\
speed_weakening_friction: v_s 0.2 0.6, exponent 0.8 2.5
anisotropic_friction: direction -1.5 1.5
friction_patch: center_x 0.40 0.60, center_y -0.12 0.12, radius 0.06 0.12, stretch 0.6 1.8, edge 0.004 0.03
friction_drift: over 30.0 300.0
table_bowl: center_x 0.35 0.55, center_y -0.1 0.1
speed_dependent_restitution: reference 0.5 0.9
air_jet: center_x 0.42 0.58, center_y -0.08 0.08, bearing -3.1 3.1, radius 0.03 0.08
sticky_line: x 0.42 0.55, lean -0.5 0.5, width 0.004 0.012
vibration: frequency 2.0 5.0, bearing -3.1 3.1, decay 0.3 0.8
rectangular_patch: center_x 0.40 0.60, center_y -0.12 0.12, half_length 0.06 0.14, half_width 0.04 0.09, bearing -1.5 1.5, edge 0.002 0.02
friction_step: x 0.42 0.56, lean -0.6 0.6, bend -1.0 1.0, edge 0.002 0.02
friction_map: length 0.10 0.22, seed 0.0 1e4
rational_stribeck: v_s 0.15 0.5, exponent 1.0 3.0
logarithmic_stribeck: v_ref 0.4 0.9
power_drag: exponent 0.8 2.6
cosine_grain: direction -1.5 1.5
sine_bowl: center_x 0.35 0.55, center_y -0.1 0.1, radius 0.5 0.9
trough: center_x 0.35 0.55, center_y -0.1 0.1, bearing -1.5 1.5
rounded_speed: sharpness 2.0 8.0
angle_backlash: width 0.1 0.5
running_in: over 10.0 60.0
restitution_drift: over 30.0 300.0
friction_of_sessions: seed 0.0 1e4
striker_angle_by_session: seed 0.0 1e4
camera_angle_by_session: seed 0.0 1e4
camera_lean: bearing -3.1 3.1, height 0.8 1.6
magnet: center_x 0.42 0.58, center_y -0.10 0.10, depth 0.04 0.12
swirl: center_x 0.40 0.60, center_y -0.2 0.2
sloshing: frequency 2.5 6.0, decay 0.2 0.6
speed_ripple: period 0.12 0.25, phase 0.0 6.2
angle_ripple: period 0.2 0.4, phase 0.0 6.2
stitched_cameras: x 0.44 0.56
saddle: center_x 0.35 0.55, center_y -0.1 0.1, bearing -1.5 1.5
table_map: length 0.10 0.22, seed 0.0 1e4
off_centre_lens: off_x -0.2 0.2, off_y -0.2 0.2
striker_error_by_place: speed_x -0.4 0.4, speed_y -0.4 0.4, angle_x -0.3 0.3, angle_y -0.3 0.3
speed_by_reach: best 0.22 0.40
heading_by_bearing: period 0.7 1.6, phase 0.0 6.2
sanded_table: over 8.0 40.0
friction_cycle: phase 0.0 6.2";

/// Parameters of strength whose sign is drawn, by effect; of several, the mixture is drawn in [`draw`].
const SIGNED: &str = "\
friction_patch: change
friction_drift: change
table_bowl: kappa
striker_angle_bias: delta
off_centre_contact: offset
camera_rotation: angle
camera_distortion: k1
rectangular_patch: change
friction_step: change
sine_bowl: kappa
trough: kappa
angle_backlash: play
running_in: change
linear_wear: change
restitution_step: change
side_force: rate
swirl: rate
magnet: pull
saddle: kappa
off_centre_lens: k1
speed_by_reach: loss
friction_change: change
sanded_table: change
wiped_table: change
warming_arm: change
pushed_camera: turn";

/// The entries of a table's row.
fn row<'a>(table: &'a str, name: &str) -> impl Iterator<Item = &'a str> {
    let rows = table.lines().filter_map(|line| line.split_once(": "));
    let row = rows.filter(move |(of, _)| *of == name).map(|(_, row)| row);
    row.flat_map(|row| row.split(", "))
}

/// The ranges of an effect's parameters.
fn ranges(name: &str) -> impl Iterator<Item = Range<'static>> {
    row(RANGES, name).map(|entry| {
        let mut words = entry.split(' ');
        let parameter = words.next().unwrap_or_default();
        let [low, high] = [(); 2].map(|()| {
            let word = words.next().and_then(|word| word.parse().ok());
            word.expect("a range is two numbers")
        });
        (parameter, low, high)
    })
}

/// Draws an effect's place, direction, sign and form for a set of this many strikes, and so many of them a session.
pub(super) fn draw(
    effect: &mut Effect,
    (strikes, a_session): (usize, usize),
    random: &mut ChaCha8Rng,
) {
    let name = effect.name();
    let positive = random.random::<f64>() >= 0.5;
    for (parameter, low, high) in ranges(name) {
        let value = uniform(random, low, high);
        set(effect, parameter, value);
    }
    for parameter in row(SIGNED, name).filter(|_| !positive) {
        let value = effect.get(parameter).unwrap_or_default();
        set(effect, parameter, -value);
    }
    let mut between = |low: f64, high: f64| uniform(random, low, high);
    match name {
        "table_tilt" | "warped_tilt" => {
            let bearing = between(-3.1, 3.1);
            set(effect, "t_x", 0.006 * bearing.cos());
            set(effect, "t_y", 0.006 * bearing.sin());
            if name == "warped_tilt" {
                set(effect, "warp", between(-0.008, 0.008));
            }
        }
        "friction_gradient" => {
            let bearing = between(-3.1, 3.1);
            set(effect, "g_x", 0.25 * bearing.cos());
            set(effect, "g_y", 0.25 * bearing.sin());
        }
        "striker_speed_error" => {
            set(effect, "b", 1.0);
            set(effect, "softness", between(0.0, 0.04));
            if positive {
                set(effect, "a", between(-0.08, -0.04));
                set(effect, "cap", 1.2);
            } else {
                set(effect, "a", 0.0);
                set(effect, "cap", between(0.75, 0.9));
            }
        }
        "striker_angle_error" => {
            // A gain, a slope, or both, with a constant and a bend beside them.
            let turn = between(0.0, std::f64::consts::TAU);
            set(effect, "gain", 0.15 * turn.cos());
            set(effect, "slope", 0.08 * turn.sin());
            set(effect, "bias", between(-0.02, 0.02));
            set(effect, "bend", between(-0.05, 0.05));
        }
        "restitution_step" => {
            let share = between(0.25, 0.75);
            set(effect, "from", (share * strikes as f64).round());
        }
        "friction_change" | "sanded_table" | "pushed_camera" => {
            // Within a session, that no change of session explains it.
            let from = (between(0.25, 0.75) * strikes as f64).round() as usize;
            let is_new_session = from.is_multiple_of(a_session);
            set(
                effect,
                "from",
                (from + 3 * usize::from(is_new_session)) as f64,
            );
        }
        "friction_cycle" => {
            let most = strikes as f64 / 1.5;
            set(effect, "period", 6.0 * (most / 6.0).powf(between(0.0, 1.0)));
        }
        "wiped_table" => {
            // Before each session, or now and then.
            let before_each = between(0.0, 1.0) < 0.5 && a_session < strikes;
            let every = match before_each {
                true => a_session as f64,
                false => between(8.0, 0.5 * strikes as f64).round(),
            };
            set(effect, "every", every);
        }
        "warming_arm" => {
            set(effect, "every", a_session as f64);
            set(effect, "over", between(0.15, 0.4) * a_session as f64);
        }
        "brown_lens" => {
            let k1 = if positive { 0.10 } else { -0.10 };
            set(effect, "k1", k1);
            set(effect, "k2", between(-0.2, 0.2));
            set(effect, "p1", between(-0.002, 0.002));
            set(effect, "p2", between(-0.002, 0.002));
        }
        "stitched_cameras" => {
            let bearing = between(-3.1, 3.1);
            set(effect, "shift_x", 0.008 * bearing.cos());
            set(effect, "shift_y", 0.008 * bearing.sin());
        }
        _ => {}
    }
}

/// Gives the effect the library's own form, where the rig has it.
pub(super) fn textbook(effect: &mut Effect) {
    for (parameter, value) in [
        ("exponent", 2.0),
        ("stretch", 1.0),
        ("edge", 0.001),
        ("softness", 0.0),
    ] {
        let is_form =
            effect.name() != "speed_dependent_restitution" && effect.get(parameter).is_some();
        if is_form {
            set(effect, parameter, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn every_effect_can_be_drawn_and_forms_differ_from_draw_to_draw() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for effect in Effect::all() {
            let (mut one, mut other) = (effect, effect);
            draw(&mut one, (100, 25), &mut random);
            draw(&mut other, (100, 25), &mut random);
        }
        let mut exponents: Vec<f64> = (0..20)
            .map(|_| {
                let mut effect = Effect::named("speed_weakening_friction").expect("known");
                draw(&mut effect, (100, 25), &mut random);
                effect.get("exponent").expect("it has one")
            })
            .collect();
        exponents.sort_by(f64::total_cmp);
        exponents.dedup();
        assert_eq!(exponents.len(), 20);
    }

    #[test]
    fn tables_name_effects_that_the_rig_has() {
        for line in RANGES.lines().chain(SIGNED.lines()) {
            let name = line.split(':').next().expect("a name");
            assert!(Effect::named(name).is_some(), "{name}");
        }
    }
}
