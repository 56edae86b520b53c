//! What a diagnosis finds, each with the words that say it. Lengths are in m, angles in rad, shares of 1.

#![expect(missing_docs, reason = "the words beside each say what it is")]

use std::fmt::{self, Display, Formatter};

use derive_more::Display;
use serde::{Deserialize, Serialize};
use values::{Sentence, Strays};
use world::effects::AddedEffect;

use crate::{
    evidence::PValue,
    question::{Column, Finding, Form, What},
    score::{DRAWN, FLIPPED},
};

/// The verdict.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Summary {
    #[display(
        "no gap at rest: tracks differ from the world's beyond noise ({_0}), but nothing by command or place moves stops by more than they \
         scatter"
    )]
    ConsistentAtRest(PValue),
    #[display(
        "no gap beyond noise ({_0}: strikes differ from noise as it was drawn, not from their own scatter); see `detectable` for the least \
         that would have shown"
    )]
    ConsistentByFlips(PValue),
    #[display("no gap beyond noise ({_0}); see `detectable` for the least that would have shown")]
    Consistent(PValue),
    #[display("a real gap that no candidate explains{}", _0.as_ref().map_or(String::new(), |cause| format!(": {cause}")))]
    Unexplained(Option<Cause>),
    #[display("{}", list(_0, ", and "))]
    Named(Vec<Stated>),
    /// With what it leaves open.
    #[display("{_0}{}", _1.iter().map(|beside| format!("; {beside}")).collect::<String>())]
    Beside(Box<Sentence<Summary>>, Vec<Note>),
    /// The arm's laws, and what was named beside them.
    #[display("{}, and {_1}", list(_0, ", and "))]
    ArmAndNamed(Vec<AddedEffect>, Box<Sentence<Summary>>),
    #[display(
        "{}, by its logged state; beside that there is no gap",
        list(_0, ", and ")
    )]
    ArmAndConsistent(Vec<AddedEffect>),
    #[display(
        "{}, by its logged state; beside that there is {_1}",
        list(_0, ", and ")
    )]
    ArmAndUnexplained(Vec<AddedEffect>, Box<Sentence<Summary>>),
}

/// An effect, and all that may as well stand in its place.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
#[display("{effect}{}", if equivalent.is_empty() { String::new() } else {
    format!(" ({} is one name of several: {} would fit these strikes as well)", effect.name, equivalent.join(" or "))
})]
pub struct Stated {
    pub effect: AddedEffect,
    pub equivalent: Vec<String>,
}

const FACING: &str = "the box leaves along the command, as one does that is turned to face each strike, and not as one that lies square to the table, \
    which a box whose yaw is not logged is taken to do: log its yaw (`topics.pose`), or lay it square before each strike";

/// What stands behind a gap that no candidate explains, and what to do about it.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Cause {
    Dependence(Dependence),
    /// Effects that are stated and never named.
    #[display("{}", list(_0, "; "))]
    NeverNamed(Vec<AddedEffect>),
    Varies(Variation),
    #[display(
        "in most strikes the object is pushed on after the impact, or speeds up again after it slowed down, which nothing in the library does; \
         look whether the arm goes on behind the object (shorten the command beyond the impact), or the table moves (a vibration), and log again"
    )]
    PushedAgain,
    #[display(
        "what fits best, in the notes, moves stops by more than repeats scatter, but a fit to four fifths of the strikes does not show that it \
         predicts the others: log more strikes"
    )]
    Unpaid,
    /// A drift of launch speed and friction at once.
    #[display(
        "launch speed and friction change together with the order of strikes, in the proportion that a drift of the camera's scale (its \
         height, its zoom) or of its clock would show; a tip that wears on a table that changes may do so too: measure a known length at the \
         beginning and at the end, and the camera's rate"
    )]
    CameraDrifts,
    #[display(
        "the launch angle depends on what is commanded or on where strikes start, or else on the order of strikes, which are one in these logs: \
         an arm or a camera that turns slowly would do the same; strike the first commands again, or in another order"
    )]
    HeadingInOrder,
    #[display(
        "stops move by more than they scatter, and commands follow the order of strikes: what fits best, in the notes, or a wander of launch or friction \
         would do it; strike in another order"
    )]
    RunsWithOrder,
    #[display(
        "all strikes start at one place, from where what depends on the place, on the way gone and on the time since the impact is one: \
         something that changes along every slide (an object that sticks at first, or rides on air) would look like a patch there, or like several \
         effects; strike from other places"
    )]
    OnePlace,
    #[display("{FACING}")]
    Facing,
    /// An effect that acts in a part of the strikes alone.
    #[display("what looks like {name} acts {}: look what was changed between them (the camera, the table, the object, the tip), and diagnose each \
         part alone",
        if *is_by_session { "in some sessions and not in others" } else { "in some part of the strikes, by their order, and not in others" })]
    ActsInPart {
        name: String,
        is_by_session: bool,
    },
    #[display(
        "the identified world misses the strikes that were left out by more than twice what strikes scatter by, though one that is fitted to \
         the strikes alone does not: slides that no strike began, or a value that the rig file fixes, taught it something else; look at \
         slides.parquet and at what was identified"
    )]
    WorldOfOtherStrikes,
    #[display(
        "the identified world misses {missed} of {of} strikes that took no part by more than three times what strikes scatter by, and not the others: look \
         in the report at what these have in common (a speed, an angle, a place), which it predicts as they do not go"
    )]
    PartMissed {
        missed: usize,
        of: usize,
    },
    #[display("{_0}")]
    PartStrays(StrayStrikes),
}

/// Strikes that stop far from where the others do; those scatter by `others` (m).
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
#[display("{count} of {of} strikes stop more than five times as far off as the others scatter ({:.1} mm), {} (`stray_strikes` in diagnosis.json lists them)",
    1e3 * others,
    gathered.as_ref().map_or_else(
        || "and have nothing in common that was logged: look whether the tip grazed or struck twice, a command was another's, or somebody touched the \
            object".into(),
        |gathered| format!("most of them {gathered}")))]
pub struct StrayStrikes {
    pub count: usize,
    pub of: usize,
    pub others: f64,
    pub gathered: Option<Gathered>,
}

/// Where most of the strays are, from and to.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Gathered {
    /// Numbers of strikes, from 0.
    #[display("among those of `order` {from} to {to}, {}",
        if *is_latest { "the latest: the object, the tip, the table or the camera is not what it was; log strikes of what it is now" }
        else { "and few before and after: look what was changed there" })]
    Order {
        from: usize,
        to: usize,
        is_latest: bool,
    },
    #[display("at commanded speeds from {_0:.2} to {_1:.2} m/s")]
    Speed(f64, f64),
    #[display("at commanded angles from {:.0}° to {:.0}°", _0.to_degrees(), _1.to_degrees())]
    Angle(f64, f64),
    #[display("at starts from x = {_0:.2} to {_1:.2} m")]
    X(f64, f64),
    #[display("at starts from y = {_0:.2} to {_1:.2} m")]
    Y(f64, f64),
}

impl Gathered {
    /// Whether they are the latest strikes.
    pub(crate) fn is_latest(&self) -> bool {
        matches!(
            self,
            Self::Order {
                is_latest: true,
                ..
            }
        )
    }
}

impl StrayStrikes {
    /// Whether they are no strays: they follow what was logged, or are a part of the strikes.
    pub(crate) fn are_a_gap(&self) -> bool {
        self.gathered.is_some() || Strays::is_a_part(self.count, self.of)
    }
}

/// What launches, friction or pushes depend on. `size`: by how much it moves stops.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
#[display("{what} {}, which moves stops by {:.1} mm", by(covariate, *form), 1e3 * size)]
pub struct Dependence {
    pub what: What,
    pub covariate: String,
    pub form: Option<Form>,
    pub size: f64,
}

impl From<&Finding> for Dependence {
    fn from(finding: &Finding) -> Self {
        Self {
            what: finding.what,
            covariate: finding.covariate.into(),
            form: finding.form,
            size: finding.size,
        }
    }
}

impl Display for What {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Column(Column::Launch) => "the launch speed",
            Self::Column(Column::Heading) => "the launch angle",
            Self::Column(Column::Friction) => "friction",
            Self::Column(Column::Stop) => "how far objects slide",
            Self::Column(Column::Fade) => "friction from the beginning of the way to its end",
            Self::Column(Column::Curve) | Self::Across => "a push across the way",
            Self::Along => "a push along the way",
        })
    }
}

fn by(covariate: &str, form: Option<Form>) -> String {
    match (covariate, form) {
        ("order", Some(Form::Step(at) | Form::StepInSession(at))) => {
            format!("steps at the strike of `order` {at}")
        }
        ("order" | "session", Some(Form::Sessions)) => "differs between sessions".into(),
        ("order" | "session", Some(form)) => {
            format!("depends on the order of strikes ({})", form.name())
        }
        ("level", _) => "is off in all strikes".into(),
        ("phase", _) => "is there in all strikes".into(),
        ("start", _) => "depends on where strikes start".into(),
        ("position", _) => "depends on the place on the table".into(),
        ("command", _) => "depends on speed, angle and start together".into(),
        ("command and order", _) => {
            "depends on speed, angle or start otherwise as strikes go on".into()
        }
        ("command and session", _) => {
            "depends on speed, angle or start otherwise in one session than in another".into()
        }
        ("speed", _) => "depends on the commanded speed".into(),
        ("angle", _) => "depends on the commanded angle".into(),
        ("command before", _) => "depends on the command of the strike before".into(),
        ("start before", _) => "depends on where the object lay in the strike before".into(),
        ("commands before", _) => "depends on the commands of the strikes before".into(),
        ("group", _) => "falls into two groups of strikes, which nothing that was logged tells apart (two objects, a tip or a focus that rests in one \
             of two states)"
            .into(),
        ("pause", _) => "depends on the pause before a strike".into(),
        (covariate, _) => format!("depends on the {covariate}"),
    }
}

/// How stops vary, where that is by more than repeats scatter (`repeats`).
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
#[display(
    "stops {}, where repeats scatter by {:.1} mm: something changes slowly (warmth, air, the arm), which no prediction from commands knows",
    list(by, ", and "), 1e3 * repeats
)]
pub struct Variation {
    pub by: Vec<Change>,
    pub repeats: f64,
}

#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Change {
    /// With the ends of its 95 % interval.
    #[display("wander by {:.1} mm [{:.1}, {:.1}] over the order of strikes", 1e3 * _0, 1e3 * _1[0], 1e3 * _1[1])]
    Wander(f64, [f64; 2]),
    /// With the ends of its 95 % interval.
    #[display("differ by {:.1} mm [{:.1}, {:.1}] between sessions", 1e3 * _0, 1e3 * _1[0], 1e3 * _1[1])]
    Sessions(f64, [f64; 2]),
}

/// What is told beside the verdict: what was dropped, or is short of data.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Note {
    #[display("noise: {}", list(_0, "; "))]
    Noise(Vec<NoiseKind>),
    #[display("{} scatters from strike to strike by as much as is allowed for, {}: something is missing there that no candidate holds",
        What::Column(*of).to_string().trim_start_matches("the "),
        if *of == Column::Heading { format!("{:.0}°", bound.to_degrees()) } else { format!("{:.0} %", 100.0 * bound) })]
    ScatterAtBound {
        of: Column,
        bound: f64,
    },
    Varies(Variation),
    /// Misses of strikes that took no part.
    #[display("that is not all: stops that took no part still miss by {:.1} mm, where repeats scatter by {:.1} mm", 1e3 * missed, 1e3 * repeats)]
    NotAll {
        missed: f64,
        repeats: f64,
    },
    #[display("that is not all: beside what is named {_0}")]
    StillDepends(Dependence),
    #[display("{FACING}")]
    Facing,
    /// A share that angles of launch are off by, half of its 95 % interval, and a factor on the ratio of radius to half side that does as much.
    #[display("launch angles are off by {:+.1} %{} (± {:.1} %), as where the tip's radius over half a side of the box is {ratio:.2} times that of \
         the rig file{}: measure both sizes{}",
        100.0 * share, if *is_at_end { " or more" } else { "" }, 100.0 * half,
        if *is_at_end { ", which is as far as rulers are believed to err" } else { "" },
        if *is_delivered { "" } else { "; an arm that is off by as small a share looks alike and is not named" })]
    WrongSizes {
        share: f64,
        half: f64,
        ratio: f64,
        is_at_end: bool,
        is_delivered: bool,
    },
    #[display(
        "at a box, sizes that are wrong launch as an arm does that errs by a share of its angle: a tip whose radius over half a side of the \
         box is {ratio:.2} times that of the rig file does all of it; measure both sizes before the arm is corrected"
    )]
    ArmOrSizes {
        ratio: f64,
    },
    /// Each with the ends of its 95 % interval.
    #[display("beside these effects, with 95 % intervals: friction {:.4} [{:.4}, {:.4}], restitution {:.4} [{:.4}, {:.4}]",
        friction[0], friction[1], friction[2], restitution[0], restitution[1], restitution[2])]
    BesideEffects {
        friction: [f64; 3],
        restitution: [f64; 3],
    },
    #[display("{_0}")]
    Strays(StrayStrikes),
    /// Tracks do not show how the object is braked on its way.
    #[display(
        "tracks of this box differ from any slide of this world by far more than the camera's noise, as where a box tips or turns: effects are \
         identified from launches and from the friction of whole strikes, and none that acts on the way or in the camera's picture"
    )]
    Astray,
    #[display(
        "what the world lacks is partly in its friction and restitution: the true ones may lie outside their intervals, which are of a world \
         that lacks nothing"
    )]
    ValuesHoldTheGap,
    #[display("would have been named, but is not: {} ({why})", names.join(" and "))]
    NotNamed {
        names: Vec<String>,
        why: WhyNot,
    },
    /// By how much the squared stop error of strikes that were left out of its fits falls, in m² a strike.
    #[display("not named, but fit to serve as `effect`, for together it predicts strikes that were left out of its fits better than the world without \
         effects (squared stop error {:+.1} mm² a strike, before anything is learnt on top): {}", -1e6 * nearer, list(effects, ", and "))]
    Carried {
        effects: Vec<AddedEffect>,
        nearer: f64,
    },
    #[display(
        "beside what is stated as the cause there stands, and is not named: {}",
        list(_0, ", and ")
    )]
    BesideNeverNamed(Vec<AddedEffect>),
    /// The data want a form that the library does not have.
    #[display(
        "{parameter} of {effect} was fitted at the end of its range, {value:.3} {unit}: the true value may lie beyond, so that its interval is \
         the whole range, and another effect may be the cause"
    )]
    AtEnd {
        effect: String,
        parameter: String,
        value: f64,
        unit: String,
    },
    /// Friction or restitution.
    #[display(
        "{name} stands at the end of its range, {value:.3}: these strikes want a value that no world has"
    )]
    WorldAtEnd {
        name: String,
        value: f64,
    },
    #[display(
        "strikes left out, for the arm pushes the object on after the impact, or it speeds up again as if it did: {count}"
    )]
    PushedAgain {
        count: usize,
    },
    #[display(
        "{count} strikes were left out: in the identified world their object does not leave the tip"
    )]
    StaysAtTip {
        count: usize,
    },
    #[display("poses show the box turned by {:.1}° to {:.1}° before strikes: each is simulated as it stood{}",
        least.to_degrees(), most.to_degrees(),
        if *untracked == 0 { String::new() } else { format!("; {untracked} strikes without poses are taken to stand straight") })]
    Turned {
        least: f64,
        most: f64,
        untracked: usize,
    },
    /// A camera whose lengths are all too long by a share shows the same slides under as much more friction, after launches that are as much faster.
    #[display("tracks do not show the camera's scale: were its lengths {:.0} % too long, friction would be {:.4} in place of {friction:.4}, and \
         restitution {:.3} in place of {restitution:.3}; measure a known length on the table",
        100.0 * SCALE, friction / (1.0 + SCALE), (1.0 + restitution) / (1.0 + SCALE) - 1.0)]
    CameraScale {
        friction: f64,
        restitution: f64,
    },
    #[display("only {} the gap: its figures are coarse", if *count == 1 { "one strike judges".into() } else { format!("{count} strikes judge") })]
    FewJudges {
        count: usize,
    },
    /// Scatter of speed (relative) and of angle.
    #[display("the arm's state is logged: launches were taken as delivered, and scatter by {:.1} % and {:.2}° in the arm, by {:.1} % and {:.2}° at \
         the impact", 100.0 * arm[0], arm[1].to_degrees(), 100.0 * impact[0], impact[1].to_degrees())]
    Delivered {
        arm: [f64; 2],
        impact: [f64; 2],
    },
    #[display("beside what the arm does there is a gap that no candidate explains")]
    UnexplainedBesideArm,
    #[display(
        "strikes depend on more than what the arm's logged state says of launches: the arm does more than that, or the state is wrong. They were \
         diagnosed as they were commanded: compare its speeds and angles with the commands"
    )]
    AsCommanded,
}

/// Share by which a camera's lengths may be too long, to say what that would do.
const SCALE: f64 = 0.01;

/// What repeats differ by, beside launches.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum NoiseKind {
    #[display("friction scatters by {:.1} % from strike to strike", 100.0 * _0)]
    Friction(f64),
    #[display("camera errors are correlated from frame to frame ({_0:.2})")]
    CameraCorrelation(f64),
    /// In s.
    #[display("stamps jitter by {:.1} ms", 1e3 * _0)]
    StampJitter(f64),
    #[display("{_0} stray frames were left out")]
    FramesLeftOut(usize),
}

/// Why effects that fit the strikes are not named.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum WhyNot {
    #[display("friction or restitution would have to be what no world has")]
    NoSuchWorld,
    #[display("{name} would be as strong as can be, and stands for something else")]
    AtItsStrongest { name: String },
    #[display(
        "commands follow the order of these strikes, so that a wander does the same, and nothing tells them apart: strike in another order"
    )]
    RunsWithOrder,
    #[display("what changes with the order of strikes does so in another form")]
    OtherForm,
    #[display("a camera that drifts would do the same")]
    CameraDrifts,
    #[display("a heading that drifts would do the same")]
    HeadingDrifts,
    #[display("a box that is turned to face each strike would launch alike")]
    Facing,
    #[display("all strikes start at one place")]
    OnePlace,
    #[display("it does not act alike in all strikes")]
    ActsInPart,
    #[display("tracks still leave the world's by far more than the camera's stated noise")]
    TracksStillDiffer,
    #[display("objects are pushed by where they are, which none of it does")]
    PushedByPlace,
    #[display("objects are pushed on their way, which no launch does")]
    PushedOnTheWay,
    #[display("beside it stops are off by as much again as repeats scatter by")]
    MuchIsLeft,
    /// Gain in log-likelihood, with its standard error.
    #[display(
        "fitted to four fifths of the strikes, it predicts the others no better beyond chance: {gain:+.1} ± {error:.1} of log-likelihood"
    )]
    PredictsNoBetter { gain: f64, error: f64 },
    /// Change of the squared stop error, in m².
    #[display("its stops are no nearer on strikes that took no part: squared stop error {:+.1} ± {:.1} mm² a strike on {strikes} left out of its \
         fits in turn", 1e6 * change, 1e6 * error)]
    StopsNoNearer {
        change: f64,
        error: f64,
        strikes: usize,
    },
    #[display("it moves stops by less than a third of what repeats scatter by")]
    MovesLittle,
    #[display("it changes what the arm delivers by no more than a state is read to, {:.1} % and {:.1}°", 100.0 * speed, angle.to_degrees())]
    Unread { speed: f64, angle: f64 },
}

/// What a strike worth making would separate, or measure.
#[derive(Clone, Debug, Display, Serialize, Deserialize)]
pub enum Purpose {
    #[display("{}", _0.join(" or "))]
    Separate(Vec<String>),
    #[display("scatter of repeats, or what no question finds")]
    Repeats,
}

/// Both probabilities, as far as the replicates can show them.
impl Display for PValue {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let one = |p: f64, replicates: usize| {
            let least = 1.0 / (1 + replicates) as f64;
            match p {
                p if p <= least => format!("p < 1/{replicates}"),
                p if p < 0.01 => format!("p = {p:.3}"),
                p => format!("p = {p:.2}"),
            }
        };
        let (drawn, flipped) = (one(self.drawn, DRAWN), one(self.flipped, FLIPPED));
        write!(f, "{drawn} by drawn noise, {flipped} by flipped signs")
    }
}

fn list(items: &[impl Display], between: &str) -> String {
    let items: Vec<String> = items.iter().map(ToString::to_string).collect();
    items.join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_stated_with_all_that_fit_as_well() {
        let alone = Stated {
            effect: AddedEffect::fixed("table_tilt", &[("tilt_x", 0.01)]),
            equivalent: Vec::new(),
        };
        let several = Stated {
            equivalent: vec!["anisotropic_friction".into(), "a draught".into()],
            ..alone.clone()
        };
        assert_eq!(alone.to_string(), alone.effect.to_string());
        let several = several.to_string();
        assert!(several.contains("table_tilt is one name of several"));
        assert!(several.contains("anisotropic_friction or a draught"));
    }

    #[test]
    fn a_probability_is_stated_no_smaller_than_its_replicates_show() {
        let least = PValue {
            drawn: 1.0 / (1 + DRAWN) as f64,
            flipped: 1.0 / (1 + FLIPPED) as f64,
        };
        let text = least.to_string();
        let bounds: Vec<f64> = text
            .split("1/")
            .skip(1)
            .map(|rest| {
                let number = rest.split_whitespace().next().expect("a number");
                1.0 / number.parse::<f64>().expect("replicates")
            })
            .collect();
        assert!(
            least.drawn < bounds[0] && least.flipped < bounds[1],
            "{text}"
        );
    }

    #[test]
    fn a_wrong_scale_is_read_as_friction_and_as_launch_speed() {
        let note = Note::CameraScale {
            friction: 0.303,
            restitution: 0.515,
        };
        let note = note.to_string();
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
