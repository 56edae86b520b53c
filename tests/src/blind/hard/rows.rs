//! What the hard benchmark measures, each figure with what it counts.

use super::super::coverage::{self, Covered};
use super::super::judged::{Figure, Proportion};
use super::design::Design;
use super::kind::HardKind;
use super::outcome::HardOutcome;

fn hides(outcome: &HardOutcome) -> bool {
    !outcome.hidden().is_empty()
}

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
    let count = |keep: &dyn Fn(&HardOutcome) -> bool, hit: &dyn Fn(&HardOutcome) -> bool| {
        Proportion::of(made.iter().filter(|o| keep(o)), |o| hit(o))
    };
    let figure = Figure::new;
    let is = |kind: HardKind| move |o: &HardOutcome| o.case.kind == kind && o.is_detectable();
    let is_control = is(HardKind::Control);
    let as_demo = |o: &HardOutcome| o.drawn.as_ref().is_some_and(|d| d.design == Design::Random);
    let right = HardOutcome::is_right;
    let by_name = HardOutcome::is_right_by_name;
    let wrong = |o: &HardOutcome| !o.is_right();
    let named = |o: &HardOutcome| o.case.kind.listed() == HardKind::Single;
    let many = |o: &HardOutcome| o.drawn.as_ref().is_some_and(|drawn| drawn.strikes() > 60);
    let is_near = |ratio: f64| (0.8..=1.2).contains(&ratio);
    let stated = |o: &HardOutcome| Some(is_near(o.over_repeats()?.0));
    let known_mean = |o: &HardOutcome| Some(is_near(o.few_repeats? / o.repeats?));
    let covered: Vec<&Covered> = made.iter().flat_map(|o| &o.covered).collect();
    let mut figures = vec![
        figure(
            "nothing hidden, all designs and noises: false alarms (anything but `consistent`)",
            "≤ 3 %",
            count(&is_control, &wrong),
        ),
        figure(
            "of these, strikes at random as the demo's",
            "≤ 6 %",
            count(&|o| is_control(o) && as_demo(o), &wrong),
        ),
        figure(
            "of these, every other design",
            "each ≤ 6 %",
            count(&|o| is_control(o) && !as_demo(o), &wrong),
        ),
        figure(
            "all designs, a wandering friction called drift, session or unexplained not counted",
            "",
            count(&is_control, &|o| wrong(o) && !describes_a_wander(o)),
        ),
        figure(
            "one phenomenon at 2–4 × the floor: right name or class and nothing else",
            "≥ 90 %",
            count(&is(HardKind::Single), &right),
        ),
        figure(
            "the same by name alone",
            "",
            count(&is(HardKind::Single), &by_name),
        ),
        figure(
            "one phenomenon at 0.5–2 × the floor that can be detected: right name or class",
            "",
            count(&is(HardKind::Weak), &right),
        ),
        figure(
            "the same by name alone, below twice the floor",
            "",
            count(&is(HardKind::Weak), &by_name),
        ),
        figure(
            "two or three hidden: all named or in a class, nothing else",
            "≥ 80 %",
            count(&is(HardKind::Several), &right),
        ),
        figure(
            "all of two or three by name alone",
            "",
            count(&is(HardKind::Several), &by_name),
        ),
        figure(
            "sets of one to three phenomena with a name more than is hidden",
            "≤ 5 %",
            count(&named, &HardOutcome::has_a_name_too_many),
        ),
        figure(
            "sets of one to three phenomena with a name that is not hidden",
            "",
            count(&named, &HardOutcome::has_a_wrong_name),
        ),
        figure(
            "what no candidate has, at 2–4 × the floor: `unexplained`",
            "≥ 85 %",
            count(&is(HardKind::Foreign), &right),
        ),
        figure(
            "arms that err by place, at 2–4 × the floor: named rightly, or `unexplained`",
            "≥ 90 %",
            count(&is(HardKind::Place), &right),
        ),
        figure(
            "what changes with the order, at 2–4 × the floor: named rightly, or `unexplained`",
            "≥ 90 %",
            count(&is(HardKind::Order), &right),
        ),
        figure(
            "two objects mixed up, a rolling shutter: nothing is named",
            "≥ 90 %",
            count(&is(HardKind::Odd), &right),
        ),
        figure(
            "noise floor within ± 20 % of true repeats, where something is hidden",
            "≥ 90 %",
            count(&|o| hides(o) && stated(o).is_some(), &|o| {
                stated(o) == Some(true)
            }),
        ),
        figure(
            "of these, sets of more than 60 strikes",
            "",
            count(&|o| hides(o) && many(o) && stated(o).is_some(), &|o| {
                stated(o) == Some(true)
            }),
        ),
        figure(
            "the floor of as many strikes by whoever knows what each command does in the mean",
            "",
            count(&|o| hides(o) && known_mean(o).is_some(), &|o| {
                known_mean(o) == Some(true)
            }),
        ),
    ];
    figures.extend(coverage::figures(&covered));
    figures
}

/// Median and quantiles of 10 and 90 % of numbers.
fn spread(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize);
    match (at(0.5), at(0.1), at(0.9)) {
        (Some(median), Some(low), Some(high)) => {
            format!("{median:.2} × [{low:.2}, {high:.2}] ({})", values.len())
        }
        _ => "–".into(),
    }
}

/// Rows of figures that are no shares: what, goal, and what came out.
pub(super) fn ratios(made: &[&HardOutcome]) -> Vec<(&'static str, &'static str, String)> {
    let over = |keep: &dyn Fn(&HardOutcome) -> bool, pick: fn((f64, f64)) -> f64| {
        let kept = made.iter().filter(|o| keep(o));
        spread(kept.filter_map(|o| o.over_repeats()).map(pick).collect())
    };
    let mut rows = vec![
        (
            "noise floor over true repeats, nothing hidden: median [10 %, 90 %]",
            "1.0 × [0.8, 1.2]",
            over(&|o| !hides(o), |(floor, _)| floor),
        ),
        (
            "noise floor over true repeats, something hidden",
            "1.0 × [0.8, 1.2]",
            over(&hides, |(floor, _)| floor),
        ),
        (
            "stop error of the diagnosed world over true repeats, where it is right",
            "≤ 1.2 ×",
            over(&|o| hides(o) && o.is_right(), |(_, after)| after),
        ),
    ];
    if let Some((median, longest)) = seconds(made) {
        rows.push((
            "one diagnosis of 120 strikes and more, median and longest, two at a time",
            "≤ 10 s",
            format!("{median:.1} s, {longest:.1} s"),
        ));
    }
    rows
}

/// Median and longest time of a diagnosis of 120 strikes and more, in s.
fn seconds(made: &[&HardOutcome]) -> Option<(f64, f64)> {
    let mut seconds: Vec<f64> = made
        .iter()
        .filter(|o| o.drawn.as_ref().is_some_and(|drawn| drawn.strikes() >= 120))
        .map(|o| o.answer.diagnosis_seconds)
        .collect();
    seconds.sort_by(f64::total_cmp);
    Some((*seconds.get(seconds.len() / 2)?, *seconds.last()?))
}
