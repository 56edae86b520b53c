//! `tests/LIVING.md`, from outcomes alone.

use std::fmt::Write;

use super::{Case, Method, Outcome, RECENT};

/// The page.
pub fn page(outcomes: &[Outcome]) -> String {
    let rigs = {
        let mut numbers: Vec<u64> = outcomes.iter().map(|outcome| outcome.rig).collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    };
    let mut text = format!(
        "# A table that changes\n\n\
         `make living` strikes {} rigs of the embedded kind, drawn at random (numbers {} to {}): `carom run` on 100 strikes, then recent \
         strikes at random targets, then 16 targets. Misses are means over all targets, divided by the rig's repeat scatter (mean \
         distance of repeats from their mean). Every method plans with the same version and sees the same recent strikes.\n\n",
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
                let ratios: Vec<f64> = of.map(|outcome| outcome.miss / outcome.floor).collect();
                let shown = mean(&ratios).map_or("–".into(), |ratio| format!("{ratio:.2}"));
                let _ = write!(text, " {shown} |");
            }
            text.push('\n');
        }
        text.push('\n');
    }
    text += "## The promise\n\nMean of (miss / expected miss)², over all, and by thirds of the expected miss. Without recent strikes a plan says \
             \"if the table is as it was\".\n\n| | plans | all | least third | middle | greatest |\n|---|---|---|---|---|---|\n";
    for (name, chosen) in [
        (
            "steady, none seen",
            &(|o: &Outcome| o.case == Case::Steady && o.recent == 0) as &dyn Fn(&Outcome) -> bool,
        ),
        ("steady, after strikes", &|o: &Outcome| {
            o.case == Case::Steady && o.recent > 0
        }),
        ("noon, after one", &|o: &Outcome| {
            o.case == Case::Noon && o.recent == 1
        }),
        ("noon, after two and more", &|o: &Outcome| {
            o.case == Case::Noon && o.recent > 1
        }),
        ("wander, after strikes", &|o: &Outcome| {
            o.case == Case::Wander && o.recent > 0
        }),
    ] {
        let of = outcomes
            .iter()
            .filter(|o| o.method == Method::Filter && chosen(o));
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

fn mean(values: &[f64]) -> Option<f64> {
    let sum: f64 = values.iter().sum();
    (!values.is_empty()).then(|| sum / values.len() as f64)
}
