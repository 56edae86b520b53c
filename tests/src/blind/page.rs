//! The page: what was measured, beside what was to be reached.

use std::collections::BTreeMap;
use std::fmt::Write;

mod beside;

use super::cases::{EFFECTS, FOREIGN, Kind, MAGNITUDES, STRIKES};
use super::chosen::{Pair, Struck};
use super::grade::{Tally, can_be_told, is_exact, is_right, tally};
use super::outcome::Outcome;
use super::peers::Peers;

fn percent(tally: Tally) -> String {
    let (low, high) = tally.interval();
    format!(
        "{:.1} % [{:.1}, {:.1}] ({} of {})",
        100.0 * tally.share(),
        100.0 * low,
        100.0 * high,
        tally.hits,
        tally.all
    )
}

/// The page in Markdown, and the command that made it.
pub fn page(
    outcomes: &[Outcome],
    peers: Option<&[Peers]>,
    struck: Option<&[Struck]>,
    command: &str,
) -> String {
    let made: Vec<&Outcome> = outcomes
        .iter()
        .filter(|o| o.verdict != "impossible")
        .collect();
    let of = |kind: Kind| {
        let mine = move |o: &&Outcome| o.case.kind == kind && !o.case.is_box();
        made.iter().copied().filter(mine)
    };
    let boxes = |kind: Kind| {
        let mine = move |o: &&Outcome| o.case.kind == kind && o.case.is_box();
        made.iter().copied().filter(mine)
    };
    let strong = |o: &&Outcome| o.case.magnitude >= 2.0;
    let mut text = format!(
        "# The hidden-effect benchmark\n\nMade by `{command}`. Each set is logged by the embedded rig, with its own physics and \
         random friction, restitution, and form of the effect; an effect's magnitude is the root mean square shift of the stops \
         that it makes, in units of the rig's noise floor. The object is a cylinder where no box is spoken of. {} sets, {} that the rig could not make.\n\n\
         | measured | to reach | got |\n|---|---|---|\n",
        outcomes.len(),
        outcomes.len() - made.len()
    );
    let mut row = |what: &str, goal: &str, got: String| {
        let _ = writeln!(text, "| {what} | {goal} | {got} |");
    };
    row(
        "false alarms with nothing hidden",
        "≤ 5 %, upper limit ≤ 8 %",
        percent(tally(of(Kind::Control), |o| !is_right(o))),
    );
    row(
        "right name or class at ≥ 2× the floor",
        "≥ 95 %",
        percent(tally(of(Kind::Single).filter(strong), is_right)),
    );
    row(
        "exact name at ≥ 2× where the data can tell",
        "≥ 90 %",
        percent(tally(
            of(Kind::Single).filter(strong).filter(|o| can_be_told(o)),
            is_exact,
        )),
    );
    row(
        "both of a pair",
        "≥ 75 %",
        percent(tally(of(Kind::Pair), is_right)),
    );
    row(
        "`unexplained` for what no candidate has, at ≥ 2×",
        "≥ 90 %",
        percent(tally(of(Kind::Foreign), is_right)),
    );
    row(
        "a box: false alarms with nothing hidden",
        "",
        percent(tally(boxes(Kind::Control), |o| !is_right(o))),
    );
    row(
        "a box: right name or class at 2× the floor, 120 strikes",
        "",
        percent(tally(boxes(Kind::Single), is_right)),
    );
    let covered = made.iter().flat_map(|o| &o.covered);
    let (inside, all) = covered.fold((0, 0), |(inside, all), c| {
        (
            inside + usize::from(c.low <= c.truth && c.truth <= c.high),
            all + 1,
        )
    });
    row(
        "95 % intervals that hold the truth",
        "90–97 %",
        percent(Tally { hits: inside, all }),
    );
    row(
        "gap closed on held-out strikes, single effects at ≥ 2×",
        "≥ 0.9",
        closed(of(Kind::Single).filter(strong).filter(|o| is_right(o))),
    );
    if let Some(struck) = struck {
        row(
            "strikes needed to separate a pair, chosen against random",
            "≥ 5 times fewer",
            fewer(struck),
        );
    }
    row(
        "one diagnosis, median and longest",
        "≤ 20 s",
        seconds(&made),
    );
    power(&mut text, &made);
    confusion(&mut text, &made);
    controls(&mut text, &made);
    if let Some(peers) = peers {
        beside::peers(&mut text, &made, peers);
    }
    if let Some(struck) = struck {
        beside::struck(&mut text, struck);
    }
    wrong(&mut text, &made);
    text
}

/// Median of random strikes for each chosen one, over the pairs that either told.
fn fewer(struck: &[Struck]) -> String {
    let pairs = || struck.iter().flat_map(|s| &s.pairs);
    let mut times: Vec<f64> = pairs().filter_map(Pair::times).collect();
    times.sort_by(f64::total_cmp);
    match times.get(times.len() / 2) {
        Some(median) => format!(
            "{median:.1} times (median of {} pairs; {} more were told by neither)",
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
        let (n, b, a, f) = outcome.gap;
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
        .map(|o| o.seconds)
        .collect();
    seconds.sort_by(f64::total_cmp);
    match (seconds.get(seconds.len() / 2), seconds.last()) {
        (Some(median), Some(longest)) => format!(
            "{median:.1} s, {longest:.1} s, identification included, each set on one thread beside others, on whatever else the machine did"
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
                let tally = tally(sets, is_right);
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
            *said.entry(says(outcome)).or_default() += 1;
        }
        let mut said: Vec<(String, usize)> = said.into_iter().collect();
        said.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let said: Vec<String> = said.iter().map(|(what, n)| format!("{what} {n}")).collect();
        let _ = writeln!(text, "| `{effect}` | {} |", said.join("; "));
    }
}

fn says(outcome: &Outcome) -> String {
    if outcome.named.is_empty() {
        return outcome.verdict.clone();
    }
    outcome
        .named
        .iter()
        .map(|(name, equivalent)| match equivalent.as_slice() {
            [] => name.clone(),
            others => format!("{name} [{}]", others.join(", ")),
        })
        .collect::<Vec<_>>()
        .join(" + ")
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
                percent(tally(sets, |o| !is_right(o)))
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
        let _ = writeln!(text, "| {} | {} |", outcome.case.id, says(outcome));
    }
}
