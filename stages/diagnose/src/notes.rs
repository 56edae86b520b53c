//! Sentences beside the verdict: the noise, what was left out, what was not named.

use values::{Rig, Strike};
use world::{Estimate, World};

use crate::{
    constancy::Changing,
    diagnosis::{Gap, Noise, Verdict},
    fit::Fitted,
    heldout::{self, Gains},
    mixed::{ANGLE, FRICTION, SPEED},
    usable::Usable,
    wrong_sizes,
};

/// Noise that is worth a sentence: friction (relative), correlation, jitter of stamps in s.
const REPORTED: (f64, f64, f64) = (0.005, 0.2, 0.001);

/// What repeats differ by, beside launches.
pub(crate) fn noise(noise: &Noise, fitted: &Fitted, verdict: Verdict) -> Vec<String> {
    let mut notes = Vec::new();
    let mut kinds = Vec::new();
    if noise.friction > REPORTED.0 {
        kinds.push(format!(
            "friction scatters by {:.1} % from strike to strike",
            100.0 * noise.friction
        ));
    }
    if noise.camera_correlation > REPORTED.1 {
        kinds.push(format!(
            "camera errors are correlated from frame to frame ({:.2})",
            noise.camera_correlation
        ));
    }
    if noise.stamp_jitter > REPORTED.2 {
        kinds.push(format!(
            "stamps jitter by {:.1} ms",
            1e3 * noise.stamp_jitter
        ));
    }
    if noise.frames_left_out > 0 {
        kinds.push(format!(
            "{} stray frames were left out",
            noise.frames_left_out
        ));
    }
    if !kinds.is_empty() {
        notes.push(format!("noise: {}", kinds.join("; ")));
    }
    let components = &fitted.estimated.components;
    for (place, what) in [
        (SPEED, "launch speed"),
        (ANGLE, "launch angle"),
        (FRICTION, "friction"),
    ] {
        if components.is_at_bound(place) && verdict != Verdict::Consistent {
            let bound = match place {
                ANGLE => format!("{:.0}°", crate::mixed::GREATEST.to_degrees()),
                _ => format!("{:.0} %", 100.0 * crate::mixed::GREATEST),
            };
            notes.push(format!(
                "{what} scatters from strike to strike by as much as is allowed for, {bound}: something is missing there that no candidate holds"
            ));
        }
    }
    notes
}

/// That stops wander with the order of strikes, or differ between sessions, by more than repeats scatter.
pub(crate) fn variation(gap: &Gap) -> Option<String> {
    let told = [
        (gap.wander, "wander", "over the order of strikes"),
        (gap.sessions, "differ", "between sessions"),
    ];
    let told = told
        .into_iter()
        .filter(|(by, ..)| gap.is_beyond_repeats(*by));
    let told: Vec<String> = told
        .map(|(by, how, over)| format!("{how} by {:.1} mm {over}", 1e3 * by))
        .collect();
    (!told.is_empty()).then(|| {
        format!(
            "stops {}, where repeats scatter by {:.1} mm: something changes slowly (warmth, air, the arm), which no prediction from commands knows",
            told.join(", and "),
            1e3 * gap.noise_floor
        )
    })
}

/// Stop error, in units of what repeats scatter by, from which effects that are named are not all, where as many strikes judge as make a figure.
const NOT_ALL: f64 = 1.6;

/// That strikes which judge still miss by more than repeats scatter, with all effects that are named.
pub(crate) fn not_all(gap: &Gap) -> Option<String> {
    let is_left = gap.heldout_strikes >= JUDGES && gap.after > NOT_ALL * gap.noise_floor;
    is_left.then(|| {
        format!(
            "that is not all: stops that took no part still miss by {:.1} mm, where repeats scatter by {:.1} mm",
            1e3 * gap.after,
            1e3 * gap.noise_floor
        )
    })
}

/// 95 % intervals by which a share must differ from none to be told: a right rig file is doubted once in a thousand.
const DOUBTED: f64 = 1.7;

/// A sentence that launch angles are off by a share, where the data determine it, and what that says of the sizes; where the arm's state is logged it
/// is not the arm's.
pub(crate) fn wrong_sizes(rig: &Rig, fitted: &Fitted, is_delivered: bool) -> Option<String> {
    let place = fitted.model.sizes()?;
    let share = fitted.model.values[place];
    let half = fitted.ninety_five() * fitted.robust_covariance()?[(place, place)].max(0.0).sqrt();
    let ratio = (share / wrong_sizes::sensitivity(rig)?).exp();
    let (least, more) = match fitted.model.is_at_end(place, 0.0) {
        true => (
            " or more",
            ", which is as far as rulers are believed to err",
        ),
        false => ("", ""),
    };
    let alike = match is_delivered {
        true => "",
        false => "; an arm that is off by as small a share looks alike and is not named",
    };
    (share.abs() > DOUBTED * half).then(|| {
        format!(
            "launch angles are off by {:+.1} %{least} (± {:.1} %), as where the tip's radius over half a side of the box is {:.2} times that \
             of the rig file{more}: measure both sizes{alike}",
            100.0 * share,
            100.0 * half,
            ratio
        )
    })
}

/// Factor on the rig file's r/h up to which sizes are doubted in the arm's place: both off by a half, one up and one down.
const DOUBTED_RATIO: f64 = 3.0;

/// A sentence that wrong sizes of a box launch as the arm's error does that is named, where they need not be absurd.
pub(crate) fn arm_or_sizes(rig: &Rig, fitted: &Fitted) -> Option<String> {
    let model = &fitted.model;
    let share = model.values[model.sizes()?];
    let parts = model.fitted_parts(&model.values);
    let arm = parts
        .iter()
        .find(|part| part.name == "striker_angle_error")?;
    let gain = arm.parameters.get("gain")?;
    // Far off, angles follow the ratio of the sizes itself, not its logarithm.
    let off = (1.0 + share) * (1.0 + gain) - 1.0;
    let ratio = 1.0 + off / wrong_sizes::sensitivity(rig)?;
    let is_credible = (1.0 / DOUBTED_RATIO..DOUBTED_RATIO).contains(&ratio);
    is_credible.then(|| format!(
        "at a box, sizes that are wrong launch as an arm does that errs by a share of its angle: a tip whose radius over half a side of the box is \
         {ratio:.2} times that of the rig file does all of it; measure both sizes before the arm is corrected"
    ))
}

/// Friction and restitution beside the effects that a world has: identification's are those without them.
pub(crate) fn friction_and_restitution(world: &World) -> Option<String> {
    let of = |name: &str| {
        let Estimate { value, low, high } = world.parameters.get(name)?;
        Some(format!(
            "{name} {value:.4} [{:.4}, {:.4}]",
            (*low)?,
            (*high)?
        ))
    };
    Some(format!(
        "beside these effects, with 95 % intervals: {}, {}",
        of("friction")?,
        of("restitution")?
    ))
}

/// A sentence that tracks do not show how the object is braked on its way.
pub(crate) fn astray() -> String {
    "tracks of this box differ from any slide of this world by far more than the camera's noise, as where a box tips or turns: effects \
     are identified from launches and from the friction of whole strikes, and none that acts on the way or in the camera's picture"
        .into()
}

/// What an unexplained gap does to what was identified.
pub(crate) const VALUES_HOLD_THE_GAP: &str = "what the world lacks is partly in its friction and restitution: the true ones may lie outside \
     their intervals, which are of a world that lacks nothing";

/// Why effects that move stops have no name.
pub(crate) const UNPAID: &str = "what fits best, in the notes, moves stops by more than repeats scatter, but a fit to four fifths of the strikes does \
     not show that it predicts the others: log more strikes";

/// What stands behind a drift of launch speed and friction at once.
pub(crate) const CAMERA_DRIFTS: &str = "launch speed and friction change together with the order of strikes, in the proportion that a drift of the camera's \
     scale (its height, its zoom) or of its clock would show; a tip that wears on a table that changes may do so too: measure a known length at \
     the beginning and at the end, and the camera's rate";

/// An effect that acts in a part of the strikes alone.
pub(crate) fn changes(changing: &Changing) -> String {
    let how = match changing.is_by_session {
        true => "in some sessions and not in others",
        false => "in some part of the strikes, by their order, and not in others",
    };
    format!(
        "what looks like {} acts {how}: look what was changed between them (the camera, the table, the object, the tip), and diagnose each part \
         alone",
        changing.name
    )
}

/// Effects that fit the strikes and are not named.
pub(crate) fn not_named(names: &[&str], why: &str) -> String {
    format!(
        "would have been named, but is not: {} ({why})",
        names.join(" and ")
    )
}

/// Why several effects from one place are not named.
pub(crate) const FROM_ONE_PLACE: &str = "all strikes start at one place, from where what depends on the place, on the way gone and on the time since the impact \
     is one: something that changes along every slide (an object that sticks at first, or rides on air) would look like a patch there, or like several effects; strike from \
     other places";

/// Why an arm's error by angle is not named.
pub(crate) const ANGLES_IN_ORDER: &str = "the launch angle depends on the commanded angle or on the order of strikes, which are one in these logs: an arm \
     or a camera that turns slowly would do the same; strike the first commands again, or in another order";

/// Effects that the tracks show and that move stops by little.
pub(crate) fn little(names: &[&str]) -> Option<String> {
    (!names.is_empty()).then(|| {
        not_named(
            names,
            "it moves stops by less than a third of what repeats scatter by",
        )
    })
}

/// What stands beside effects that are stated as the cause and never named.
pub(crate) fn beside_never_named(others: &[String]) -> Option<String> {
    (!others.is_empty()).then(|| {
        format!(
            "beside what is stated as the cause there stands, and is not named: {}",
            others.join(", and ")
        )
    })
}

/// A sentence that effects do not pay on strikes that took no part in their fit.
pub(crate) fn does_not_pay(gains: &Gains) -> String {
    let (sum, error) = heldout::total(&gains.stop);
    let each = 1e6 / gains.stop.len().max(1) as f64;
    format!(
        "its stops are no nearer on strikes that took no part: squared stop error {:+.1} ± {:.1} mm² a strike on {} left out of its fits in turn",
        -each * sum,
        each * error,
        gains.stop.len()
    )
}

/// A form at the end of its range: the data want one that the library does not have.
pub(crate) fn at_end(effect: &str, parameter: &str, value: f64, unit: &str) -> String {
    format!(
        "{parameter} of {effect} was fitted at the end of its range, {value:.3} {unit}: the true value may lie beyond, so that its \
         interval is the whole range, and another effect may be the cause"
    )
}

/// Friction or restitution at the end of its range.
pub(crate) fn world_at_end(name: &str, value: f64) -> String {
    format!(
        "{name} stands at the end of its range, {value:.3}: these strikes want a value that no world has"
    )
}

/// Why a world may miss strikes that show no gap of their own.
pub(crate) const WORLD_OF_OTHER_STRIKES: &str = "the identified world misses the strikes that were left out by more than twice what strikes scatter \
     by, though one that is fitted to the strikes alone does not: slides that no strike began, or a value that the rig file fixes, taught it something \
     else; look at slides.parquet and at what was identified";

/// What most objects do where the arm goes on behind them, or the table moves; and what to do about it.
pub(crate) const PUSHED_AGAIN: &str = "in most strikes the object speeds up again after it slowed down, which nothing in the library does; \
     look whether the arm goes on behind the object, or the table moves (a vibration), and log again";

/// Strikes that were left out before anything was fitted.
pub(crate) fn left_out(usable: &Usable, pushed: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if usable.pushed_again > 0 && !usable.are_pushed_again {
        notes.push(format!(
            "strikes left out, for the object speeds up again after it slowed down, as if the arm went on behind it: {}",
            usable.pushed_again
        ));
    }
    if pushed > 0 {
        notes.push(format!(
            "{pushed} strikes were left out: in the identified world their object does not leave the tip"
        ));
    }
    notes
}

/// A sentence that a box's yaw was tracked, and used; none where it was not, or counts for nothing.
pub(crate) fn turned(rig: &Rig, strikes: &[&Strike]) -> Option<String> {
    let yaws: Vec<f64> = strikes.iter().filter_map(|s| s.conditions.yaw).collect();
    if rig.object.shape().is_round() || yaws.is_empty() {
        return None;
    }
    let least = yaws.iter().copied().fold(f64::INFINITY, f64::min);
    let most = yaws.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut note = format!(
        "poses show the box turned by {:.1}° to {:.1}° before strikes: each is simulated as it stood",
        least.to_degrees(),
        most.to_degrees()
    );
    if yaws.len() < strikes.len() {
        let untracked = strikes.len() - yaws.len();
        note += &format!("; {untracked} strikes without poses are taken to stand straight");
    }
    Some(note)
}

/// Share by which a camera's lengths may be too long, to say what that would do.
const SCALE: f64 = 0.01;

/// A sentence on what tracks do not show: a camera whose lengths are all too long by a share shows the same slides under as much more friction, after
/// launches that are as much faster.
pub(crate) fn camera_scale(friction: f64, restitution: f64) -> String {
    format!(
        "tracks do not show the camera's scale: were its lengths {:.0} % too long, friction would be {:.4} in place of {friction:.4}, and \
         restitution {:.3} in place of {restitution:.3}; measure a known length on the table",
        100.0 * SCALE,
        friction / (1.0 + SCALE),
        (1.0 + restitution) / (1.0 + SCALE) - 1.0
    )
}

/// Held-out strikes below which the gap's figures are coarse.
const JUDGES: usize = 10;

/// A sentence that few strikes judge the gap; none where enough do.
pub(crate) fn few_judges(count: usize) -> Option<String> {
    let judges = match count {
        1 => "only one strike judges".into(),
        count => format!("only {count} strikes judge"),
    };
    (1..JUDGES)
        .contains(&count)
        .then(|| format!("{judges} the gap: its figures are coarse"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_scale_is_read_as_friction_and_as_launch_speed() {
        let note = camera_scale(0.303, 0.515);
        assert!(
            note.contains("friction would be 0.3000 in place of 0.3030"),
            "{note}"
        );
        assert!(
            note.contains("restitution 0.500 in place of 0.515"),
            "{note}"
        );
    }
}
