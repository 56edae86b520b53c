//! The page: what was measured, beside what was to be reached.

use std::collections::BTreeMap;
use std::fmt::Write;

mod beside;

use super::cases::{EFFECTS, FOREIGN, Kind, MAGNITUDES, STRIKES};
use super::chosen::{Pair, Separation};
use super::coverage::{self, Covered};
use super::grade::{is_claimed_alone, is_exact, is_of_its_own, is_right};
use super::judged::{Figure, Judged, Proportion};
use super::outcome::Outcome;
use super::peers::Peers;

/// The key of this benchmark's runs in `tests/judged.json`.
const BENCHMARK: &str = "plain";

/// The page in Markdown, and the command that made it; notes the run in `judged`.
pub fn page(
    outcomes: &[Outcome],
    peers: Option<&[Peers]>,
    separations: Option<&[Separation]>,
    judged: &mut Judged,
    command: &str,
) -> String {
    let made: Vec<&Outcome> = outcomes
        .iter()
        .filter(|o| o.answer.verdict != "impossible")
        .collect();
    let figures = figures(&made);
    judged.note(BENCHMARK, command, &figures);
    let mut text = format!(
        "# The hidden-effect benchmark\n\nMade by `{command}`. Each set is logged by the embedded rig, with its own physics and \
         random friction and restitution. An effect's place, direction, sign and form are drawn at random (exponents, edges, time constants, how \
         sharp a bend is), in every second set of two seeds and more it has the library's own form instead; its magnitude is the root mean square \
         shift of the stops that it makes, in units of the rig's noise floor. The object is a cylinder where no box is spoken of. \
         Noise is ideal here: `tests/HARD.md` has the other. {} sets, {} that the rig could not make. The last column has every run \
         whose page was committed, with the program as it was then: {}.\n\n\
         | measured | to reach | this run | all runs |\n|---|---|---|---|\n{}",
        outcomes.len(),
        outcomes.len() - made.len(),
        judged.commands(BENCHMARK),
        judged.rows(BENCHMARK, &figures)
    );
    let mut row = |what: &str, goal: &str, got: String| {
        let _ = writeln!(text, "| {what} | {goal} | {got} | |");
    };
    row(
        "gap closed on held-out strikes, single effects at ≥ 2× that are right",
        "≥ 0.9",
        closed(made.iter().copied().filter(|o| {
            o.case.kind == Kind::Single
                && !o.case.is_box()
                && o.case.magnitude >= 2.0
                && is_right(o)
        })),
    );
    if let Some(separations) = separations {
        row(
            "strikes needed to separate a pair, chosen against random",
            "≥ 5 times fewer",
            fewer(separations),
        );
    }
    row(
        "one diagnosis, median and longest",
        "≤ 10 s",
        seconds(&made),
    );
    power(&mut text, &made);
    confusion(&mut text, &made);
    controls(&mut text, &made);
    if let Some(peers) = peers {
        beside::peers(&mut text, &made, peers);
    }
    if let Some(separations) = separations {
        beside::separations(&mut text, separations);
    }
    wrong(&mut text, &made);
    text
}

/// The figures that are pooled over all runs.
fn figures(made: &[&Outcome]) -> Vec<Figure> {
    let of = |kind: Kind, is_box: bool| {
        let mine = move |o: &&Outcome| o.case.kind == kind && o.case.is_box() == is_box;
        made.iter().copied().filter(mine)
    };
    let strong = || of(Kind::Single, false).filter(|o| o.case.magnitude >= 2.0);
    let covered: Vec<&Covered> = made.iter().flat_map(|o| &o.covered).collect();
    let mut figures = vec![
        Figure::new(
            "false alarms with nothing hidden",
            "≤ 5 %, upper limit ≤ 8 %",
            Proportion::of(of(Kind::Control, false), |o| !is_right(o)),
        ),
        Figure::new(
            "right name or class at ≥ 2× the floor",
            "≥ 95 %",
            Proportion::of(strong(), |o| is_right(o)),
        ),
        Figure::new(
            "exact name alone at ≥ 2×, of all sets whose effect is in no class by construction",
            "≥ 90 %",
            Proportion::of(strong().filter(|o| is_of_its_own(o)), |o| {
                is_exact(o) && is_claimed_alone(o)
            }),
        ),
        Figure::new(
            "exact name, of those sets for which the diagnosis claims a name alone",
            "≥ 90 %",
            Proportion::of(
                strong().filter(|o| is_of_its_own(o) && is_claimed_alone(o)),
                |o| is_exact(o),
            ),
        ),
        Figure::new(
            "both of a pair",
            "≥ 75 %",
            Proportion::of(of(Kind::Pair, false), |o| is_right(o)),
        ),
        Figure::new(
            "`unexplained` for what no candidate has, at ≥ 2×",
            "≥ 90 %",
            Proportion::of(of(Kind::Foreign, false), |o| is_right(o)),
        ),
        Figure::new(
            "a box: false alarms with nothing hidden",
            "",
            Proportion::of(of(Kind::Control, true), |o| !is_right(o)),
        ),
        Figure::new(
            "a box: right name or class at 2× the floor, 120 strikes",
            "",
            Proportion::of(of(Kind::Single, true), |o| is_right(o)),
        ),
    ];
    figures.extend(coverage::figures(&covered));
    figures
}

/// Median of random strikes for each chosen one, over the pairs that either separated.
fn fewer(separations: &[Separation]) -> String {
    let pairs = || separations.iter().flat_map(|s| &s.pairs);
    let mut times: Vec<f64> = pairs().filter_map(Pair::times).collect();
    times.sort_by(f64::total_cmp);
    match times.get(times.len() / 2) {
        Some(median) => format!(
            "{median:.1} times (median of {} pairs; {} more were separated by neither)",
            times.len(),
            pairs().count() - times.len()
        ),
        None => "–".into(),
    }
}

/// (before − after)/(before − floor), of root mean squares over all strikes of all sets.
fn closed<'o>(outcomes: impl Iterator<Item = &'o Outcome>) -> String {
    let (mut before, mut after, mut floor, mut strikes) = (0.0, 0.0, 0.0, 0.0);
    for outcome in outcomes {
        let (n, b, a, f) = outcome.answer.gap;
        let n = n as f64;
        before += n * b * b;
        after += n * a * a;
        floor += n * f * f;
        strikes += n;
    }
    let root = |sum: f64| (sum / f64::max(strikes, 1.0)).sqrt();
    let (before, after, floor) = (root(before), root(after), root(floor));
    format!(
        "{:.2} ({:.1} mm before, {:.1} after, floor {:.1}; {strikes} strikes)",
        (before - after) / (before - floor),
        1e3 * before,
        1e3 * after,
        1e3 * floor
    )
}

fn seconds(outcomes: &[&Outcome]) -> String {
    let mut seconds: Vec<f64> = outcomes
        .iter()
        .filter(|o| o.case.strikes == 120)
        .map(|o| o.answer.diagnosis_seconds)
        .collect();
    seconds.sort_by(f64::total_cmp);
    match (seconds.get(seconds.len() / 2), seconds.last()) {
        (Some(median), Some(longest)) => format!(
            "{median:.1} s, {longest:.1} s, each set on one thread beside others, on whatever else the machine did"
        ),
        _ => "–".into(),
    }
}

/// Right names against magnitude.
fn power(text: &mut String, outcomes: &[&Outcome]) {
    let _ = writeln!(text, "\n## Right names against magnitude\n");
    let _ = write!(text, "| effect |");
    for strikes in STRIKES {
        for magnitude in MAGNITUDES {
            let _ = write!(text, " {magnitude}×, {strikes} |");
        }
    }
    let _ = writeln!(
        text,
        "\n|---|{}",
        "---|".repeat(STRIKES.len() * MAGNITUDES.len())
    );
    for effect in EFFECTS.iter().chain(&FOREIGN) {
        let _ = write!(text, "| `{effect}` |");
        for strikes in STRIKES {
            for magnitude in MAGNITUDES {
                let sets = outcomes.iter().copied().filter(|o| {
                    o.case.kind != Kind::Pair
                        && !o.case.is_box()
                        && o.case.hidden == [effect.to_string()]
                        && o.case.strikes == strikes
                        && o.case.magnitude == magnitude
                });
                let tally = Proportion::of(sets, |o| is_right(o));
                let _ = match tally.all {
                    0 => write!(text, " – |"),
                    _ => write!(text, " {}/{} |", tally.hits, tally.all),
                };
            }
        }
        let _ = writeln!(text);
    }
}

/// What was named for what, single effects at twice the floor and more.
fn confusion(text: &mut String, outcomes: &[&Outcome]) {
    let _ = writeln!(
        text,
        "\n## What was said at ≥ 2× the floor\n\n| hidden | said (class in brackets) |\n|---|---|"
    );
    for effect in EFFECTS.iter().chain(&FOREIGN) {
        let mut said: BTreeMap<String, usize> = BTreeMap::new();
        for outcome in outcomes.iter().filter(|o| {
            o.case.kind != Kind::Pair
                && !o.case.is_box()
                && o.case.magnitude >= 2.0
                && o.case.hidden == [effect.to_string()]
        }) {
            *said.entry(outcome.answer.text()).or_default() += 1;
        }
        let mut said: Vec<(String, usize)> = said.into_iter().collect();
        said.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let said: Vec<String> = said.iter().map(|(what, n)| format!("{what} {n}")).collect();
        let _ = writeln!(text, "| `{effect}` | {} |", said.join("; "));
    }
}

fn controls(text: &mut String, outcomes: &[&Outcome]) {
    let _ = writeln!(
        text,
        "\n## Nothing hidden\n\n| variant | strikes | false alarms |\n|---|---|---|"
    );
    for variant in ["plain", "noise", "dropped", "start"] {
        for strikes in STRIKES {
            let sets = outcomes.iter().copied().filter(|o| {
                o.case.kind == Kind::Control
                    && o.case.variant == variant
                    && o.case.strikes == strikes
            });
            let _ = writeln!(
                text,
                "| {variant} | {strikes} | {} |",
                Proportion::of(sets, |o| !is_right(o))
            );
        }
    }
}

fn wrong(text: &mut String, outcomes: &[&Outcome]) {
    let _ = writeln!(
        text,
        "\n## Every set at ≥ 2× the floor, and every control, that is wrong\n\n| set | said |\n|---|---|"
    );
    for outcome in outcomes
        .iter()
        .filter(|o| !is_right(o) && (o.case.magnitude >= 2.0 || o.case.kind == Kind::Control))
    {
        let _ = writeln!(text, "| {} | {} |", outcome.case.id, outcome.answer.text());
    }
}
