//! What the hard benchmark measures, each figure with what it counts.

use super::super::coverage::{self, Covered};
use super::super::judged::Figure;
use super::super::proportion::Proportion;
use super::cases::HardKind;
use super::outcome::HardOutcome;

/// Verdicts that describe a random walk of friction: it is noise, and a drift as well.
fn describes_a_wander(outcome: &HardOutcome) -> bool {
    let answer = &outcome.answer;
    let is_slow = |name: &str| name == "friction_drift" || name == "friction_by_session";
    outcome.has_noise("friction_wander")
        && (answer.verdict == "unexplained"
            || (answer.named.len() == 1 && is_slow(&answer.named[0].0)))
}

/// The figures of all sets that the rig could make.
pub(super) fn figures(made: &[&HardOutcome]) -> Vec<Figure> {
    let of = |kind: HardKind| made.iter().copied().filter(move |o| o.case.kind == kind);
    let hidden = || {
        made.iter().copied().filter(|o| {
            matches!(
                o.case.kind,
                HardKind::Single | HardKind::Weak | HardKind::Several
            )
        })
    };
    let covered: Vec<&Covered> = made.iter().flat_map(|o| &o.covered).collect();
    let mut figures = vec![
        Figure {
            what: "hard controls, nothing hidden: false alarms (anything but `consistent`)",
            goal: "≤ 5 %, upper limit ≤ 8 %",
            got: Proportion::of(of(HardKind::Control), |o| !o.is_right()),
        },
        Figure {
            what: "the same, a wandering friction called drift, session or unexplained not counted",
            goal: "",
            got: Proportion::of(of(HardKind::Control), |o| {
                !o.is_right() && !describes_a_wander(o)
            }),
        },
        Figure {
            what: "hard singles at 2–4 × the floor: right name or class and nothing else",
            goal: "≥ 90 %",
            got: Proportion::of(of(HardKind::Single), |o| o.is_right()),
        },
        Figure {
            what: "hard singles at 0.5–2 × the floor: the same",
            goal: "",
            got: Proportion::of(of(HardKind::Weak), |o| o.is_right()),
        },
        Figure {
            what: "sets of one to three phenomena with a name more than is hidden",
            goal: "≤ 5 %",
            got: Proportion::of(hidden(), |o| o.has_a_name_too_many()),
        },
        Figure {
            what: "sets of one to three phenomena with a name that is not hidden",
            goal: "",
            got: Proportion::of(hidden(), |o| o.has_a_wrong_name()),
        },
        Figure {
            what: "two or three hidden: all named, nothing else",
            goal: "≥ 80 %",
            got: Proportion::of(of(HardKind::Several), |o| o.is_right()),
        },
        Figure {
            what: "what no candidate has, at 2–4 × the floor: `unexplained`",
            goal: "≥ 85 %",
            got: Proportion::of(of(HardKind::Foreign), |o| o.is_right()),
        },
    ];
    figures.extend(coverage::figures(&covered));
    figures
}

/// Median and longest time of a diagnosis of 120 strikes and more, in s.
pub(super) fn seconds(made: &[&HardOutcome]) -> Option<(f64, f64)> {
    let mut seconds: Vec<f64> = made
        .iter()
        .filter(|o| o.drawn.as_ref().is_some_and(|drawn| drawn.strikes >= 120))
        .map(|o| o.answer.diagnosis_seconds)
        .collect();
    seconds.sort_by(f64::total_cmp);
    Some((*seconds.get(seconds.len() / 2)?, *seconds.last()?))
}
