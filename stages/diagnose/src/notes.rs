//! What is told beside the verdict, and when: the noise, what was left out, what was not named.

use values::{Rig, Strike};
use world::{Estimate, World};

use crate::{
    diagnosis::{Gap, Noise, Verdict},
    fit::Fitted,
    heldout::{self, Gains},
    mixed::{ANGLE, FRICTION, GREATEST, SPEED},
    question::Column,
    usable::Usable,
    words::{Change, NoiseKind, Note, Variation, WhyNot},
    wrong_sizes,
};

/// Noise that is worth a sentence: friction (relative), correlation, jitter of stamps in s.
const REPORTED: (f64, f64, f64) = (0.005, 0.2, 0.001);

/// What repeats differ by, beside launches.
pub(crate) fn noise(noise: &Noise, fitted: &Fitted, verdict: Verdict) -> Vec<Note> {
    let (friction, correlation, jitter) =
        (noise.friction, noise.camera_correlation, noise.stamp_jitter);
    let left_out = noise.frames_left_out;
    let kinds = [
        (friction > REPORTED.0).then_some(NoiseKind::Friction(friction)),
        (correlation > REPORTED.1).then_some(NoiseKind::CameraCorrelation(correlation)),
        (jitter > REPORTED.2).then_some(NoiseKind::StampJitter(jitter)),
        (left_out > 0).then_some(NoiseKind::FramesLeftOut(left_out)),
    ];
    let kinds: Vec<NoiseKind> = kinds.into_iter().flatten().collect();
    let components = &fitted.estimated.components;
    let at_bound = [
        (SPEED, Column::Launch),
        (ANGLE, Column::Heading),
        (FRICTION, Column::Friction),
    ]
    .into_iter()
    .filter(|(place, _)| components.is_at_bound(*place) && verdict != Verdict::Consistent)
    .map(|(_, of)| Note::ScatterAtBound {
        of,
        bound: GREATEST,
    });
    let kinds = (!kinds.is_empty()).then_some(Note::Noise(kinds));
    kinds.into_iter().chain(at_bound).collect()
}

/// That stops wander with the order of strikes, or differ between sessions, by more than repeats scatter.
pub(crate) fn variation(gap: &Gap) -> Option<Variation> {
    let is_told = |by: f64| gap.is_beyond_repeats(by);
    let wander = is_told(gap.wander).then_some(Change::Wander(gap.wander, gap.wander_95));
    let sessions = is_told(gap.sessions).then_some(Change::Sessions(gap.sessions, gap.sessions_95));
    let by: Vec<Change> = wander.into_iter().chain(sessions).collect();
    (!by.is_empty()).then_some(Variation {
        by,
        repeats: gap.noise_floor,
    })
}

/// Stop error, in units of what repeats scatter by, from which effects that are named are not all, where as many strikes judge as make a figure; of
/// fewer, by the square root of what is missing of them more.
const NOT_ALL: f64 = 1.6;

/// That strikes which judge still miss by more than repeats scatter, with all effects that are named.
pub(crate) fn not_all(gap: &Gap) -> Option<Note> {
    let (missed, repeats) = (gap.after, gap.noise_floor);
    let few = JUDGES as f64 / gap.heldout_strikes.clamp(1, JUDGES) as f64;
    let is_left = missed > NOT_ALL * few.sqrt() * repeats;
    is_left.then_some(Note::NotAll { missed, repeats })
}

/// 95 % intervals by which a share must differ from none to be told: a right rig file is doubted once in a thousand.
const DOUBTED: f64 = 1.7;

/// That launch angles are off by a share, where the data determine it, and what that says of the sizes; where the arm's state is logged it is not
/// the arm's.
pub(crate) fn wrong_sizes(rig: &Rig, fitted: &Fitted, is_delivered: bool) -> Option<Note> {
    let place = fitted.model.sizes()?;
    let share = fitted.model.values[place];
    let half = fitted.ninety_five() * fitted.robust_covariance()?[(place, place)].max(0.0).sqrt();
    let ratio = (share / wrong_sizes::sensitivity(rig)?).exp();
    (share.abs() > DOUBTED * half).then(|| Note::WrongSizes {
        share,
        half,
        ratio,
        is_at_end: fitted.model.is_at_end(place, 0.0),
        is_delivered,
    })
}

/// Factor on the rig file's r/h up to which sizes are doubted in the arm's place: both off by a half, one up and one down.
const DOUBTED_RATIO: f64 = 3.0;

/// That wrong sizes of a box launch as the arm's error does that is named, where they need not be absurd.
pub(crate) fn arm_or_sizes(rig: &Rig, fitted: &Fitted) -> Option<Note> {
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
    is_credible.then_some(Note::ArmOrSizes { ratio })
}

/// Friction and restitution beside the effects that a world has: identification's are those without them.
pub(crate) fn beside_effects(world: &World) -> Option<Note> {
    let of = |name: &str| {
        let Estimate { value, low, high } = world.parameters.get(name)?;
        Some([*value, (*low)?, (*high)?])
    };
    let (friction, restitution) = (of("friction")?, of("restitution")?);
    Some(Note::BesideEffects {
        friction,
        restitution,
    })
}

/// Effects that fit the strikes and are not named.
pub(crate) fn not_named(names: &[&str], why: WhyNot) -> Note {
    Note::NotNamed {
        names: names.iter().map(ToString::to_string).collect(),
        why,
    }
}

/// Effects that the tracks show and that move stops by little.
pub(crate) fn little(names: &[&str]) -> Option<Note> {
    (!names.is_empty()).then(|| not_named(names, WhyNot::MovesLittle))
}

/// That effects do not pay on strikes that took no part in their fit.
pub(crate) fn does_not_pay(gains: &Gains) -> WhyNot {
    let (sum, error) = heldout::total(&gains.stop);
    let strikes = gains.stop.len();
    let each = 1.0 / strikes.max(1) as f64;
    WhyNot::StopsNoNearer {
        change: -each * sum,
        error: each * error,
        strikes,
    }
}

/// Strikes that were left out before anything was fitted.
pub(crate) fn left_out(usable: &Usable, pushed: usize) -> impl Iterator<Item = Note> {
    let count = usable.pushed_again;
    let again = (count > 0 && !usable.are_pushed_again).then_some(Note::PushedAgain { count });
    let stay = (pushed > 0).then_some(Note::StaysAtTip { count: pushed });
    again.into_iter().chain(stay)
}

/// That a box's yaw was tracked, and used; none where it was not, or counts for nothing.
pub(crate) fn turned(rig: &Rig, strikes: &[&Strike]) -> Option<Note> {
    let yaws: Vec<f64> = strikes.iter().filter_map(|s| s.conditions.yaw).collect();
    let is_told = !rig.object.shape().is_round() && !yaws.is_empty();
    is_told.then(|| Note::Turned {
        least: yaws.iter().copied().fold(f64::INFINITY, f64::min),
        most: yaws.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        untracked: strikes.len() - yaws.len(),
    })
}

/// Held-out strikes below which the gap's figures are coarse.
const JUDGES: usize = 10;

/// That few strikes judge the gap; none where enough do.
pub(crate) fn few_judges(count: usize) -> Option<Note> {
    (1..JUDGES)
        .contains(&count)
        .then_some(Note::FewJudges { count })
}
