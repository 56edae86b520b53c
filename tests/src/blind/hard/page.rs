//! The page of the hard benchmark.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::judged::{Judged, Proportion};
use super::cases::Drawn;
use super::design::Design;
use super::kind::HardKind;
use super::noise::kinds;
use super::outcome::HardOutcome;
use super::{answers, rows};

/// The key of this benchmark's runs in `tests/judged.json`.
pub const BENCHMARK: &str = "hard";

pub fn hard_page(outcomes: &[HardOutcome], judged: &mut Judged, command: &str) -> String {
    let made: Vec<&HardOutcome> = outcomes
        .iter()
        .filter(|o| o.answer.verdict != "impossible")
        .collect();
    let figures = rows::figures(&made);
    judged.note(BENCHMARK, command, &figures);
    let mut text = format!(
        "# The hard benchmark\n\nMade by `{command}`. {} sets, {} that the rig could not make. The seeds of a page are used once: \
         nothing was chosen or tuned on them. Intervals are those of Clopper and Pearson. The last column has every run whose page was \
         committed, with the program as it was then: {}.\n\n{ABOUT}\n\n\
         | measured | to reach | this run | all runs |\n|---|---|---|---|\n{}",
        outcomes.len(),
        outcomes.len() - made.len(),
        judged.commands(BENCHMARK),
        judged.rows(BENCHMARK, &figures)
    );
    for (what, goal, got) in rows::ratios(&made) {
        let _ = writeln!(text, "| {what} | {goal} | {got} | |");
    }
    by_set(&mut text, &made);
    alarms(&mut text, &made);
    by_phenomenon(&mut text, &made);
    intervals(&mut text, &made);
    wrong(&mut text, &made);
    grading(&mut text);
    text
}

const ABOUT: &str = "Each set is drawn from its seed: a design, an ideal table, or one to three kinds of noise; a phenomenon in any form that the rig \
has, or none; a rig file whose sizes may be 10 % wrong; in a tenth of the sets a camera whose scale is up to 5 % wrong; a cylinder, or in \
three of ten sets a box; one to four sessions; random friction and restitution. Eight of twenty sets hide nothing. Phenomena that have a name, or no candidate, are hidden in designs that vary everything: one angle, \
speed or start makes different ones the same. \
The floor is what repeats of a command scatter by at rest (launch, friction, camera). A phenomenon's magnitude is the root mean square shift \
of the stops of the set's own design that is left when friction and one factor of launch are fitted to it, in units of the floor. A set counts where \
its strikes' squared magnitudes sum to 43 and more: half of that tells one form from another in 99 of 100 sets. True repeats are the rig's own: 40 of the \
set's commands, each struck 12 times with all of the set's noise but a wander. What is hidden, how, and what is right to say of it was written from \
physics alone, without a look into the diagnosis or its effects. The reverse no longer holds for three forms: after sets of earlier pages had been \
looked at, `table_bowl` was given unequal curvatures (as `trough` has), `camera_lean` its foreshortening, and `anisotropic_friction` a flow rule that \
need not be the associated one (as `cosine_grain` has). Nor does it for forces across the way by speed, air that turns, and a picture shifted \
beyond a line: since seeds 92000000 the library states them (and names none) in the forms of `side_force`, `swirl` and `stitched_cameras`. The \
table that grades stands at the end.";

/// Rates by design, shape, number of strikes and of sessions.
fn by_set(text: &mut String, made: &[&HardOutcome]) {
    let _ = writeln!(
        text,
        "\n## By design, and by shape\n\nSets that are right; of those that hide nothing, false alarms. Of one to three phenomena, \"by name\" counts names alone, without the classes that are said with them.\n\n\
         | sets | nothing hidden: false alarms | one to three phenomena | by name | no candidate has it | place and order | odd |\n\
         |---|---|---|---|---|---|---|"
    );
    let mut row = |what: &str, keep: &dyn Fn(&HardOutcome, &Drawn) -> bool| {
        let cell = |kinds: &[HardKind], hit: &dyn Fn(&HardOutcome) -> bool| {
            let kept = made.iter().filter(|o| {
                let is_in = o.drawn.as_ref().is_some_and(|drawn| keep(o, drawn));
                is_in && kinds.contains(&o.case.kind) && o.is_detectable()
            });
            Proportion::of(kept, |o| hit(o))
        };
        let named = [HardKind::Single, HardKind::Weak, HardKind::Several];
        let right = HardOutcome::is_right;
        let cells = [
            cell(&[HardKind::Control], &|o| !o.is_right()),
            cell(&named, &right),
            cell(&named, &HardOutcome::is_right_by_name),
            cell(&[HardKind::Foreign], &right),
            cell(&[HardKind::Place, HardKind::Order], &right),
            cell(&[HardKind::Odd], &right),
        ];
        let cells = cells.map(|cell| cell.to_string());
        let _ = writeln!(text, "| {what} | {} |", cells.join(" | "));
    };
    for design in Design::ALL {
        row(design.name(), &|_, drawn| drawn.design == design);
    }
    row("a cylinder", &|o, _| !o.is_box());
    row("a box", &|o, _| o.is_box());
    row("up to 60 strikes", &|_, drawn| drawn.strikes() <= 60);
    row("more strikes", &|_, drawn| drawn.strikes() > 60);
    row("one session", &|_, drawn| drawn.sessions == 1);
    row("several sessions", &|_, drawn| drawn.sessions > 1);
    row("a camera's scale that is wrong", &|o, _| {
        o.has_wrong_scale()
    });
}

/// False alarms by kind of noise.
fn alarms(text: &mut String, made: &[&HardOutcome]) {
    let controls: Vec<&HardOutcome> = made
        .iter()
        .copied()
        .filter(|o| o.case.kind == HardKind::Control)
        .collect();
    let count = |keep: &dyn Fn(&HardOutcome) -> bool| {
        Proportion::of(controls.iter().filter(|o| keep(o)), |o| !o.is_right())
    };
    let _ = writeln!(
        text,
        "\n## False alarms\n\n| noise | alone | with others |\n|---|---|---|\n| none | {} | |",
        count(&|o| o.noise().is_empty())
    );
    for kind in kinds() {
        let _ = writeln!(
            text,
            "| `{kind}` | {} | {} |",
            count(&|o| o.noise() == [kind]),
            count(&|o| o.noise().len() > 1 && o.has_noise(kind))
        );
    }
}

/// What was said of each phenomenon.
fn by_phenomenon(text: &mut String, made: &[&HardOutcome]) {
    for (title, kind) in [
        ("One phenomenon at 2–4 × the floor", HardKind::Single),
        ("One phenomenon at 0.5–2 × the floor", HardKind::Weak),
        (
            "What no candidate has, at 2–4 × the floor",
            HardKind::Foreign,
        ),
        (
            "Arms that err by place, at 2–4 × the floor",
            HardKind::Place,
        ),
        (
            "What changes with the order, at 2–4 × the floor",
            HardKind::Order,
        ),
        ("What is neither noise nor an effect", HardKind::Odd),
    ] {
        let _ = writeln!(
            text,
            "\n## {title}\n\n| hidden | right | said (class in brackets) |\n|---|---|---|"
        );
        let mut by: BTreeMap<&str, Vec<&HardOutcome>> = BTreeMap::new();
        for outcome in made.iter().filter(|o| o.case.kind == kind) {
            for hidden in outcome.hidden() {
                by.entry(hidden).or_default().push(outcome);
            }
        }
        for (hidden, outcomes) in by {
            let right = outcomes.iter().filter(|o| o.is_right()).count();
            let said: Vec<String> = outcomes.iter().map(|o| o.answer.text()).collect();
            let _ = writeln!(
                text,
                "| `{hidden}` | {right}/{} | {} |",
                outcomes.len(),
                said.join("; ")
            );
        }
    }
}

/// Intervals that hold the truth, by parameter.
fn intervals(text: &mut String, made: &[&HardOutcome]) {
    let mut by: BTreeMap<&str, Proportion> = BTreeMap::new();
    for covered in made.iter().flat_map(|o| &o.covered) {
        let one = Proportion {
            hits: usize::from(covered.holds()),
            all: 1,
        };
        let sum = by.entry(&covered.parameter).or_default();
        *sum = sum.plus(one);
    }
    let _ = writeln!(
        text,
        "\n## Intervals that hold the truth\n\nFriction and restitution count where nothing is hidden, whatever was said, and where just what is \
         hidden was named and their meaning stays the same; an effect's parameters where the rig's formula gives them the library's meaning. \
         Where the camera's scale is wrong, the truth is what such a camera sees; where friction wanders, its mean over the strikes.\n\n\
         | parameter | held |\n|---|---|"
    );
    for (parameter, held) in by {
        let _ = writeln!(text, "| `{parameter}` | {held} |");
    }
}

fn wrong(text: &mut String, made: &[&HardOutcome]) {
    let _ = writeln!(
        text,
        "\n## Every wrong set\n\n| set | hidden (× the floor) | noise | made | said |\n|---|---|---|---|---|"
    );
    for outcome in made.iter().filter(|o| !o.is_right()) {
        let Some(drawn) = &outcome.drawn else {
            continue;
        };
        let hidden: Vec<String> = drawn
            .hidden
            .iter()
            .zip(&drawn.magnitudes)
            .map(|(hidden, magnitude)| format!("{hidden} {magnitude:.1}"))
            .collect();
        let mut noise = outcome.noise();
        if outcome.has_wrong_scale() {
            noise.push("camera_scale");
        }
        let object = if outcome.is_box() { ", box" } else { "" };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {}, {} strikes, {} sessions{object} | {} |",
            outcome.case.id,
            hidden.join(", "),
            noise.join(", "),
            drawn.design.name(),
            drawn.strikes(),
            drawn.sessions,
            outcome.answer.text()
        );
    }
}

fn grading(text: &mut String) {
    let _ = writeln!(
        text,
        "\n## What is right\n\nA `{}` is right where it is `consistent`. A set that hides phenomena is right where it has as many names as \
         are hidden and each phenomenon has one of its own: a name of this table, or one whose class (`equivalent`) holds such a name. A name that is \
         nearly the same (linear and quadratic drag) counts only where the class says so. Phenomena that are nearly the same are not hidden together.\n\n\
         | hidden (`carom demo --hide`) | right |\n|---|---|",
        HardKind::Control.name()
    );
    for (hidden, right) in answers::table() {
        let names: Vec<String> = right.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(text, "| `{hidden}` | {} |", names.join(" or "));
    }
}
