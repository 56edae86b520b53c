//! The page's comparisons: peers on the same sets, and strikes chosen against strikes at random.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::cases::{CLASSES, EFFECTS, Kind, SLIDING};
use super::super::chosen::Separation;
use super::super::judged::Proportion;
use super::super::outcome::Outcome;
use super::super::peers::Peers;

/// A set that carom and all peers were tried on.
struct Both<'o> {
    outcome: &'o Outcome,
    peers: &'o Peers,
}

/// Whether a name is what is hidden, or is in one class with it by construction; none where nothing is hidden.
fn fits(hidden: &[String], named: Option<&str>) -> bool {
    match (hidden, named) {
        ([], None) => true,
        ([hidden], Some(named)) => {
            let is_alike =
                |class: &&[&str]| class.contains(&hidden.as_str()) && class.contains(&named);
            hidden == named || CLASSES.iter().any(is_alike)
        }
        _ => false,
    }
}

/// By the rule of the peers, who have one name to give: the name alone counts, not the class that is said with it.
fn by_carom(both: &Both<'_>) -> bool {
    let answer = &both.outcome.answer;
    match (answer.verdict.as_str(), answer.named.as_slice()) {
        ("consistent", []) => fits(&both.outcome.case.hidden, None),
        ("named", [(name, _)]) => fits(&both.outcome.case.hidden, Some(name)),
        _ => false,
    }
}

fn by_sweep(both: &Both<'_>) -> bool {
    fits(&both.outcome.case.hidden, both.peers.swept.as_deref())
}

fn by_regression(both: &Both<'_>) -> bool {
    let first = both.peers.regressed.iter().flatten().next();
    fits(&both.outcome.case.hidden, first.map(String::as_str))
}

fn is_control(both: &&Both<'_>) -> bool {
    both.outcome.case.kind == Kind::Control
}

type Judge = fn(&Both<'_>) -> bool;
const JUDGES: [Judge; 3] = [by_carom, by_sweep, by_regression];

fn count<'b>(
    all: impl Iterator<Item = &'b Both<'b>> + Clone,
    judge: impl Fn(&Both<'_>) -> bool,
) -> Proportion {
    Proportion {
        hits: all.clone().filter(|b| judge(b)).count(),
        all: all.count(),
    }
}

/// The regression's place among the judges.
const REGRESSION: usize = 2;
const PEERS: [&str; 2] = ["the sweep", "the regression"];

/// Carom beside its peers, on the sets that they were tried on.
pub(super) fn peers(text: &mut String, outcomes: &[&Outcome], peers: &[Peers]) {
    let known: BTreeMap<&str, &Peers> = peers.iter().map(|p| (p.id.as_str(), p)).collect();
    let both: Vec<Both<'_>> = outcomes
        .iter()
        .filter_map(|outcome| {
            let peers = known.get(outcome.case.id.as_str())?;
            Some(Both { outcome, peers })
        })
        .collect();
    let hidden = |strikes: usize, which: &'static [&'static str]| {
        both.iter().filter(move |b| {
            let hidden = &b.outcome.case.hidden;
            b.outcome.case.strikes == strikes
                && hidden.iter().any(|effect| which.contains(&effect.as_str()))
        })
    };
    let _ = write!(
        text,
        "\n## Beside peers\n\nOn the plain controls and the single effects at ≥ 2× the floor, the same sets, by one rule: nothing named where nothing \
         is hidden; else one name, which is what is hidden or stands in one class with it by construction. A class that carom says beside its name does not \
         count here. A sweep: each effect fitted with friction and restitution to the end points alone, the least BIC names (the paper's brute force, in \
         the planar world), where its gain is more than a parametric bootstrap of the fitted null makes in one of a hundred draws, as carom's alarm is \
         calibrated. A sparse regression: pysindy's thresholded least squares on accelerations along the tracks (`tests/peers/sindy.py`); its largest \
         term beside friction is its name. It is judged on the effects along the slide, for which it has terms.\n\n\
         | | carom | sweep over end points | sparse regression |\n|---|---|---|---|\n"
    );
    let mut row = |what: &str, cells: Vec<String>| {
        let _ = writeln!(text, "| {what} | {} |", cells.join(" | "));
    };
    let alarms = JUDGES.map(|judge| count(both.iter().filter(is_control), |b| !judge(b)));
    row(
        "false alarms with nothing hidden",
        alarms.iter().map(|tally| tally.to_string()).collect(),
    );
    let mut better = Vec::new();
    for (peer, tally) in PEERS.iter().zip(&alarms[1..]) {
        if tally.hits < alarms[0].hits {
            better.push(format!("{peer} with nothing hidden"));
        }
    }
    for strikes in super::STRIKES {
        let [carom, sweep, _] =
            JUDGES.map(|judge| count(hidden(strikes, &EFFECTS), judge).to_string());
        row(
            &format!("right at ≥ 2×, {strikes} strikes, all effects"),
            vec![carom, sweep, "–".into()],
        );
        row(
            &format!("right at ≥ 2×, {strikes} strikes, effects along the slide"),
            JUDGES
                .iter()
                .map(|judge| count(hidden(strikes, SLIDING), judge).to_string())
                .collect(),
        );
    }
    for effect in EFFECTS {
        let of = || {
            both.iter()
                .filter(move |b| b.outcome.case.hidden == [effect.to_string()])
        };
        let tallies = JUDGES.map(|judge| count(of(), judge));
        row(
            &format!("`{effect}`"),
            tallies
                .iter()
                .enumerate()
                .map(|(judge, t)| match judge {
                    REGRESSION if !SLIDING.contains(&effect) => "–".into(),
                    _ => format!("{}/{}", t.hits, t.all),
                })
                .collect(),
        );
        for (peer, tally) in PEERS.iter().zip(&tallies[1..]) {
            if tally.hits > tallies[0].hits {
                better.push(format!("{peer} with `{effect}`"));
            }
        }
    }
    let _ = writeln!(
        text,
        "\nWhere a peer did better than carom: {}.",
        match better.as_slice() {
            [] => "nowhere".into(),
            all => all.join(", "),
        }
    );
    freed(text, &both);
}

/// The gap with every parameter freed, beside the gap with the effects named.
fn freed(text: &mut String, both: &[Both<'_>]) {
    let (mut strikes, mut freed, mut before, mut after, mut floor) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut all = Proportion::default();
    for b in both.iter().filter(|b| !is_control(b)) {
        let (Some((_, rms)), (n, was, is, least)) = (b.peers.freed, b.outcome.answer.gap) else {
            continue;
        };
        let n = n as f64;
        strikes += n;
        freed += n * rms * rms;
        before += n * was * was;
        after += n * is * is;
        floor += n * least * least;
        all.all += 1;
        all.hits += usize::from(rms < is);
    }
    let mm = |sum: f64| 1e3 * (sum / f64::max(strikes, 1.0)).sqrt();
    let (freed, before, after, floor) = (mm(freed), mm(before), mm(after), mm(floor));
    let closed = |left: f64| (before - left) / (before - floor);
    let _ = writeln!(
        text,
        "\nEvery parameter freed that a round object's tracks depend on (friction, restitution, drag of the air, a turn of all launches) \
         names nothing. On held-out strikes it leaves {freed:.1} mm, and the effects that carom names leave {after:.1}, of {before:.1} mm \
         (friction and restitution alone) with a floor of {floor:.1}: {:.2} of the gap closed against {:.2}. It leaves less in {} of {} \
         sets.",
        closed(freed),
        closed(after),
        all.hits,
        all.all
    );
}

/// Strikes that separated pairs.
pub(super) fn separations(text: &mut String, separations: &[Separation]) {
    let _ = write!(
        text,
        "\n## Strikes chosen, and strikes at random\n\nSets of 20 strikes with a weak effect, whose diagnosis leaves another standing beside what \
         is hidden. More strikes of the embedded rig are added, those that `next_strikes` asks for (a dozen at a time) or random ones; after \
         1, 2, 4, 8, 12, 24 and 48 of either, and 96 and 192 random ones, a diagnosis looks, until one finds the odds for the hidden effect past 95 % (T > 10.8).\n\n\
         | set | against | chosen | random |\n|---|---|---|---|\n"
    );
    let needed = |strikes: Option<usize>| strikes.map_or("not enough".into(), |n| n.to_string());
    for set in separations {
        for pair in &set.pairs {
            let _ = writeln!(
                text,
                "| {} | `{}` | {} | {} |",
                set.id,
                pair.rival,
                needed(pair.chosen),
                needed(pair.random)
            );
        }
    }
    let nothing = separations
        .iter()
        .filter(|set| set.pairs.is_empty())
        .count();
    let _ = writeln!(
        text,
        "\n{nothing} of {} sets left nothing to separate, or not what is hidden.",
        separations.len()
    );
}
