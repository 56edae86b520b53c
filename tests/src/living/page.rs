//! `tests/LIVING.md`, from outcomes alone.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::{Case, Method, Outcome, RECENT};

pub fn page(outcomes: &[Outcome]) -> String {
    let rigs = {
        let mut numbers: Vec<u64> = outcomes.iter().map(|outcome| outcome.rig).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    let mut text = format!(
        "# A table that changes\n\n\
         `make living` strikes {} rigs of the embedded kind, drawn at random (numbers {} to {}): `carom run` on 100 strikes, then one \
         strike after the other at targets; each of the latest 24 is planned after so many strikes just before it. Misses are means over \
         all targets, divided by the rig's repeat scatter (mean distance of repeats from their mean, at the same targets, on the table as it \
         then is; what wanders is none of it); where the table does not wander each plan is struck eight times. ± is the standard error over rigs. Every method plans with the same version and sees the \
         same recent strikes.\n\n",
        rigs.len(),
        rigs.first().unwrap_or(&0),
        rigs.last().unwrap_or(&0)
    );
    for (case, title) in [
        (Case::Steady, "Steady"),
        (
            Case::Noon,
            "Friction ±12 %, launch −5 %, heading ±1.5° at noon",
        ),
        (Case::NoonBad, "The same, the second strike bad"),
        (Case::SteadyBad, "Steady, the first strike bad"),
        (Case::Wander, "Friction walks by 0.6 % a strike"),
    ] {
        let _ = write!(text, "## {title}\n\n| recent strikes |");
        for recent in RECENT {
            let _ = write!(text, " {recent} |");
        }
        let _ = writeln!(text, "\n|---|{}", "---|".repeat(RECENT.len()));
        for (method, name) in [
            (Method::Filter, "`strike --recent`"),
            (Method::None, "no adaptation"),
            (Method::LastError, "last error off the target"),
            (Method::NewtonLast, "Newton, last"),
            (Method::NewtonMean, "Newton, averaged"),
        ] {
            let _ = write!(text, "| {name} |");
            for recent in RECENT {
                let of = outcomes.iter().filter(|outcome| {
                    (outcome.case, outcome.method, outcome.recent) == (case, method, recent)
                });
                let ratios: Vec<(u64, f64)> = of.map(|o| (o.rig, o.miss / o.floor)).collect();
                let _ = write!(text, " {} |", over_rigs(&ratios, method == Method::Filter));
            }
            text.push('\n');
        }
        let said = outcomes
            .iter()
            .filter(|o| o.case == case && o.says_changed)
            .count();
        let _ = writeln!(
            text,
            "\nBefore {said} of {} of these strikes `strike --recent` says that the table has changed and asks for `carom collect`.\n",
            outcomes
                .iter()
                .filter(|o| o.case == case && o.method == Method::Filter && o.recent > 0)
                .count()
        );
    }
    text += "## The promise\n\nMean of (miss / expected miss)², over all, and by thirds of the expected miss. Without recent strikes a plan says \
             \"if the table is as it was\".\n\n| | plans | all | least third | middle | greatest |\n|---|---|---|---|---|---|\n";
    const MANY: usize = usize::MAX;
    for (name, case, recent) in [
        ("steady, none seen", Case::Steady, 0..=0),
        ("steady, after strikes", Case::Steady, 1..=MANY),
        ("noon, after one", Case::Noon, 1..=1),
        ("noon, after two and more", Case::Noon, 2..=MANY),
        (
            "noon, the second bad, after two and more",
            Case::NoonBad,
            2..=MANY,
        ),
        ("steady, the first bad, after one", Case::SteadyBad, 1..=1),
        ("wander, after strikes", Case::Wander, 1..=MANY),
    ] {
        let is_chosen = |o: &&Outcome| o.case == case && recent.contains(&o.recent);
        let of = outcomes.iter().filter(|o| o.method == Method::Filter);
        let of = of.filter(is_chosen);
        let mut pairs: Vec<(f64, f64)> = of
            .filter_map(|outcome| Some((outcome.promise?, outcome.miss)))
            .collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ratio = |pairs: &[(f64, f64)]| {
            let ratios: Vec<f64> = pairs.iter().map(|(p, m)| (m / p).powi(2)).collect();
            mean(&ratios).map_or("–".into(), |ratio| format!("{ratio:.2}"))
        };
        let third = pairs.len() / 3;
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} |",
            pairs.len(),
            ratio(&pairs),
            ratio(&pairs[..third]),
            ratio(&pairs[third..2 * third]),
            ratio(&pairs[2 * third..])
        );
    }
    text
}

/// The mean over the rigs' means, and its standard error if asked for.
fn over_rigs(ratios: &[(u64, f64)], is_precise: bool) -> String {
    let mut of_rigs: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for (rig, ratio) in ratios {
        of_rigs.entry(*rig).or_default().push(*ratio);
    }
    let means: Vec<f64> = of_rigs.values().filter_map(|of_rig| mean(of_rig)).collect();
    let Some(all) = mean(&means) else {
        return "–".into();
    };
    let squares: f64 = means.iter().map(|mean| (mean - all).powi(2)).sum();
    let rigs = means.len() as f64;
    if is_precise && rigs > 1.0 {
        let error = (squares / (rigs - 1.0) / rigs).sqrt();
        format!("{all:.2} ± {error:.2}")
    } else {
        format!("{all:.2}")
    }
}

fn mean(values: &[f64]) -> Option<f64> {
    let sum: f64 = values.iter().sum();
    (!values.is_empty()).then(|| sum / values.len() as f64)
}
