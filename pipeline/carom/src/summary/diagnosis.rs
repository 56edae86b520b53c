//! A diagnosis as the command line prints it.

use std::fmt::Write;

use diagnose::{Diagnosis, Gap, NamedEffect, Parameter, Verdict};

use crate::outputs::NEXT_STRIKES;

/// Candidates of the ranking that are printed.
const RANKED: usize = 3;

/// Verdict, effects, gap, rivals, next strikes and notes, a line each.
pub fn diagnosis(diagnosis: &Diagnosis) -> String {
    let mut text = format!("diagnosis  {}", verdict(diagnosis.verdict));
    if diagnosis.effects.is_empty() {
        let _ = write!(text, ": {}", diagnosis.summary.trim_end_matches('.'));
    }
    text.push('\n');
    for place in &diagnosis.r#where {
        let _ = writeln!(
            text,
            "           by {}: {}",
            place.covariate, place.description
        );
    }
    for effect in &diagnosis.effects {
        text += &named(effect);
    }
    let _ = writeln!(text, "           {}", gap(&diagnosis.gap));
    if !diagnosis.ranking.is_empty() && diagnosis.verdict != Verdict::Consistent {
        let best = diagnosis.ranking.iter().take(RANKED);
        let best: Vec<String> = best
            .map(|ranked| format!("{} {:.1}", ranked.name, ranked.evidence))
            .collect();
        let _ = writeln!(
            text,
            "           evidence of each candidate alone: {}",
            best.join(", ")
        );
    }
    if !diagnosis.next_strikes.is_empty() {
        let _ = writeln!(
            text,
            "           the {} most informative next strikes are in {NEXT_STRIKES}",
            diagnosis.next_strikes.len()
        );
    }
    for note in &diagnosis.notes {
        let _ = writeln!(text, "           {note}");
    }
    text
}

/// The verdict's name in files.
pub fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Named => "named",
        Verdict::Consistent => "consistent",
        Verdict::Unexplained => "unexplained",
    }
}

/// How far the gap shrinks, in a sentence.
pub fn gap(gap: &Gap) -> String {
    if gap.heldout_strikes == 0 {
        return "no strike was held out, so that the gap is not measured".into();
    }
    let millimetres = |length: f64| format!("{:.1} mm", length * 1e3);
    let floor = millimetres(gap.noise_floor);
    let before = millimetres(gap.before);
    if gap.after == gap.before {
        return format!(
            "{} on {} strikes that took no part: {before}, where the fit's own scatter leaves {floor}",
            gap.measure, gap.heldout_strikes
        );
    }
    let closed = if gap.after < gap.noise_floor {
        ", within the scatter that the fit allows for".into()
    } else {
        closed(gap).map_or(String::new(), |share| {
            format!(", {share:.0} % of the gap is closed")
        })
    };
    format!(
        "{} on {} strikes that took no part: {before} before, {} after ({}), where the fit's own scatter leaves {floor}{closed}",
        gap.measure,
        gap.heldout_strikes,
        millimetres(gap.after),
        gap.change_in_words()
    )
}

/// What is told where strikes change over their order, or from session to session, by more than this times what repeats scatter by.
const CHANGES: f64 = 2.0;

/// How far stops move by what changes while strikes are made, where that is more than scatter.
pub fn changes(gap: &Gap) -> Option<String> {
    let moves = gap.wander.hypot(gap.sessions);
    (moves > CHANGES * gap.noise_floor).then(|| {
        format!(
            "what changes over the strikes, or from session to session, moves stops by {:.1} mm:\nlook for its cause; `strike --adapt` follows it",
            moves * 1e3
        )
    })
}

/// How far the gap shrinks, on one line.
pub fn gap_in_brief(gap: &Gap) -> String {
    if gap.heldout_strikes == 0 {
        return "gap not measured: no strike was held out".into();
    }
    let mm = |length: f64| format!("{:.1}", length * 1e3);
    let (after, change) = match gap.after == gap.before {
        true => (String::new(), String::new()),
        false => (
            format!(" → {}", mm(gap.after)),
            format!(", {}", gap.change_in_words()),
        ),
    };
    format!(
        "gap {}{after} mm{change} ({}, {} held out; fitted scatter {} mm)",
        mm(gap.before),
        gap.measure,
        gap.heldout_strikes,
        mm(gap.noise_floor)
    )
}

/// (before − after)/(before − floor) in per cent; none where there was no gap above the floor, or it does not shrink.
fn closed(gap: &Gap) -> Option<f64> {
    let open = gap.before - gap.noise_floor;
    (open > 0.0 && gap.after < gap.before).then(|| 100.0 * (gap.before - gap.after) / open)
}

/// A probability as short as it can be said: replicates show none below one in their number.
pub fn probability(p: f64, replicates: usize) -> String {
    let least = 1.0 / (1.0 + replicates as f64);
    if replicates > 0 && p <= least {
        format!("< 1/{replicates}")
    } else if p < 1e-3 {
        format!("{p:.0e}")
    } else {
        format!("{p:.3}")
    }
}

/// A parameter's value and the ends of its interval, to two figures of the interval's width; of a value that was not fitted, to four.
pub fn numbers(parameter: &Parameter) -> [String; 3] {
    let Parameter {
        value, low, high, ..
    } = *parameter;
    if low == high {
        return [value, low, high].map(four_figures);
    }
    [value, low, high].map(|number| to_two_figures_of(high - low, number))
}

/// A number with as many decimals as `scale` needs for two figures.
pub fn to_two_figures_of(scale: f64, number: f64) -> String {
    let decimals = (1.0 - scale.abs().log10().floor()).clamp(0.0, 8.0);
    let decimals = if decimals.is_finite() {
        decimals as usize
    } else {
        4
    };
    format!("{number:.decimals$}")
}

fn named(effect: &NamedEffect) -> String {
    let mut text = format!("           {}: {}\n", effect.name, effect.statement);
    for (name, parameter) in &effect.parameters {
        let [value, low, high] = numbers(parameter);
        let interval = match low == high {
            true => String::new(),
            false => format!(" [{low}, {high}]"),
        };
        let line = format!(
            "             {name:<14} {value} {interval} {}",
            parameter.unit
        );
        let _ = writeln!(text, "{}", line.trim_end());
    }
    if !effect.equivalent.is_empty() {
        let _ = writeln!(
            text,
            "             these strikes cannot distinguish it from {}",
            effect.equivalent.join(", ")
        );
    }
    text
}

/// A number that has no interval, to four figures at the most.
fn four_figures(number: f64) -> String {
    if number == 0.0 {
        return "0".into();
    }
    let decimals = (3.0 - number.abs().log10().floor()).max(0.0) as usize;
    let text = format!("{number:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').into(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_the_figures_that_its_interval_bears() {
        let parameter = |value, low, high| Parameter {
            value,
            low,
            high,
            unit: String::new(),
        };
        for (parameter, text) in [
            (parameter(0.48123, 0.46, 0.5), ["0.481", "0.460", "0.500"]),
            (
                parameter(0.00123, 0.0011, 0.0014),
                ["0.00123", "0.00110", "0.00140"],
            ),
            (parameter(42.0, 10.0, 90.0), ["42", "10", "90"]),
            (parameter(0.45, 0.45, 0.45), ["0.45"; 3]),
            (parameter(1.0, 0.0, f64::INFINITY), ["1", "0", "inf"]),
        ] {
            assert_eq!(numbers(&parameter), text);
        }
    }

    #[test]
    fn a_probability_is_printed_no_smaller_than_its_replicates_show() {
        assert_eq!(probability(0.005, 199), "< 1/199");
        assert_eq!(probability(1e-9, 199), "< 1/199");
        assert_eq!(probability(0.01, 199), "0.010");
        assert_eq!(probability(2e-7, 0), "2e-7");
    }

    #[test]
    fn the_gap_is_printed_with_the_share_that_is_closed() {
        let mut measured = Gap {
            heldout_strikes: 40,
            before: 0.021,
            after: 0.003,
            change: 0.003 / 0.021 - 1.0,
            change_half_95: Some(0.032),
            noise_floor: 0.001,
            noise_floor_95: [0.0008, 0.0013],
            wander: 0.0,
            wander_95: [0.0, 0.001],
            sessions: 0.0,
            sessions_95: [0.0; 2],
            unit: "m".into(),
            measure: "rms stop error".into(),
        };
        assert_eq!(
            gap(&measured),
            "rms stop error on 40 strikes that took no part: 21.0 mm before, 3.0 mm after (-85.7 ± 3.2 %), where \
             the fit's own scatter leaves 1.0 mm, 90 % of the gap is closed"
        );
        // What five strikes show of a growth by 1.5 % says nothing, and is printed so.
        let grown = Gap {
            heldout_strikes: 5,
            before: 0.01023,
            after: 0.01038,
            change: 0.015,
            change_half_95: Some(0.08),
            noise_floor: 0.005,
            wander: 0.0,
            sessions: 0.0,
            ..measured.clone()
        };
        assert_eq!(
            gap_in_brief(&grown),
            "gap 10.2 → 10.4 mm, +1.5 ± 8.0 % (rms stop error, 5 held out; fitted scatter 5.0 mm)"
        );
        measured.noise_floor = 0.004;
        assert!(
            gap(&measured).ends_with("leaves 4.0 mm, within the scatter that the fit allows for")
        );
        assert_eq!(changes(&measured), None);
        (measured.wander, measured.sessions) = (0.008, 0.006);
        let told = changes(&measured).expect("more than scatter");
        assert!(told.contains("moves stops by 10.0 mm"), "{told}");
        measured.after = measured.before;
        assert!(!gap(&measured).contains("closed"));
        measured.heldout_strikes = 0;
        assert!(gap(&measured).contains("not measured"));
    }

    #[test]
    fn a_value_without_an_interval_is_said_to_four_figures() {
        let said = [0.926814859763348, -0.0, 0.45, 250.0, 12345.6].map(four_figures);
        assert_eq!(said, ["0.9268", "0", "0.45", "250", "12346"]);
    }
}
