//! A run on one screen: strikes, the verdict as a list, the table of stop errors, and what to do next.

use std::fmt::Write;

use diagnose::{Diagnosis, Parameter, Verdict};
use store::Model;
use values::Split;

use super::diagnosis::{changes, gap_in_brief, numbers, probability, verdict};
use super::shared::{lines, stop_errors, strikes, unused_diagnosis, warnings, wrapped};
use crate::outputs::NEXT_STRIKES;
use crate::results::{Results, Worlds};

/// Lines on rejected strikes, and on logs, that are shown; `--verbose` prints all.
const MOST_LINES: usize = 6;

/// The overview of a run's results.
pub fn overview(results: &Results) -> String {
    let mut text = strikes(results, MOST_LINES);
    if let Some(worlds) = &results.worlds {
        let fit = &worlds.fit;
        let learn = results.strikes.iter();
        let learn = learn.filter(|strike| strike.split == Split::Train).count();
        let earliest = match fit.strikes < learn {
            true => "the earliest ",
            false => "",
        };
        let _ = writeln!(
            text,
            "sysid      tracks of {earliest}{} strikes: {:.1} mm rms before, {:.1} mm after",
            fit.strikes,
            fit.rms_before * 1e3,
            fit.rms_after * 1e3
        );
        if let Some(found) = worlds.found() {
            text += &diagnosis(&found.diagnosis);
        }
        text += &carried(results, worlds);
        text += &unused_diagnosis(worlds);
    }
    text += &warnings(results);
    text += &stop_errors(results);
    text += &table(results).unwrap_or_default();
    text
}

/// What serves predictions without a name for the gap; empty where nothing does.
fn carried(results: &Results, worlds: &Worlds) -> String {
    let carried = worlds.found().and_then(|found| found.carried.as_ref());
    let Some(world) = carried.filter(|_| worlds.effect.is_some()) else {
        return String::new();
    };
    let names: Vec<&str> = world.effects.iter().map(|e| e.name.as_str()).collect();
    let told = format!(
        "{} as `effect`, which claims no name: it predicts strikes that were left out of its fits better",
        names.join(" and ")
    );
    let version = results.version();
    let is_used = version.is_some_and(|version| {
        let model = &version.contents.provenance.default_model;
        [Model::Effect, Model::EffectResidual].contains(model)
    });
    wrapped(if is_used { "used" } else { "tried" }, &told)
}

/// How the table varies beside the default model: from strike to strike, along a session, between sessions.
fn table(results: &Results) -> Option<String> {
    let provenance = &results.version()?.contents.provenance;
    let varies = provenance.varies.get(&provenance.default_model)?;
    let three = |[friction, gain, heading]: [f64; 3]| {
        format!(
            "friction {:.1} %, launch {:.1} %, heading {:.2}°",
            100.0 * friction,
            100.0 * gain,
            heading.to_degrees()
        )
    };
    // A step, or a cycle, is no walk.
    let changes = results
        .found()
        .is_some_and(|found| found.diagnosis.gap.varies());
    let wander = match varies.wander {
        [0.0, 0.0, 0.0] if changes => "no walk from strike to strike".into(),
        [0.0, 0.0, 0.0] => "none beyond chance".into(),
        wander => format!("{} a strike", three(wander)),
    };
    let between = &varies.between;
    let of = match between.sessions {
        1 => "assumed".into(),
        sessions => format!("of {sessions}"),
    };
    Some(format!(
        "table      strikes scatter by {:.1} % of the path; wander: {wander}\n           sessions ({of}) differ by {}\n",
        100.0 * varies.stop_scatter(),
        three(between.deviations)
    ))
}

/// The verdict, one effect a line, the gap, and what to do next.
fn diagnosis(diagnosis: &Diagnosis) -> String {
    let are_left_out = diagnosis.strays.is_some() && diagnosis.verdict == Verdict::Consistent;
    let mut text = format!(
        "diagnosis  {} ({}p {})\n",
        verdict(diagnosis.verdict),
        if are_left_out { "but for strays: " } else { "" },
        probability(diagnosis.least_p_value(), diagnosis.replicates)
    );
    for effect in &diagnosis.effects {
        let values: Vec<String> = effect
            .parameters
            .iter()
            .map(|(name, parameter)| value(name, parameter))
            .collect();
        text += &effect_lines(&effect.name, &values);
        if !effect.equivalent.is_empty() {
            let others = effect.equivalent.join(", ");
            let _ = writeln!(text, "             cannot be distinguished from: {others}");
        }
    }
    if diagnosis.verdict == Verdict::Unexplained {
        let depends: Vec<&str> = diagnosis
            .r#where
            .iter()
            .map(|place| place.covariate.as_str())
            .collect();
        if !depends.is_empty() {
            let _ = writeln!(
                text,
                "           the gap depends on: {}",
                depends.join(", ")
            );
        }
    }
    if diagnosis.verdict == Verdict::Unexplained {
        for map in &diagnosis.maps {
            let (name, share) = (&map.name, 100.0 * map.share);
            let _ = writeln!(
                text,
                "           a smooth {name} map would take {share:.0} % of the squared stop error"
            );
        }
    }
    let _ = writeln!(text, "           {}", gap_in_brief(&diagnosis.gap));
    for line in changes(&diagnosis.gap).iter().flat_map(|told| told.lines()) {
        let _ = writeln!(text, "           {line}");
    }
    text += &next(diagnosis);
    text
}

/// Values of an effect that are shown: a map of a table has a hundred.
const MOST_VALUES: usize = 6;

/// An effect and its values, separated by commas.
fn effect_lines(name: &str, values: &[String]) -> String {
    let (shown, more) = values.split_at(values.len().min(MOST_VALUES));
    let mut separated = shown.join(",\n");
    if !more.is_empty() {
        separated += &format!(",\nand {} more, in diagnosis.json", more.len());
    }
    lines(format!("           {name}:"), 12, separated.lines())
}

/// A parameter in words, such as `tilt_x 0.0041 [0.0037, 0.0046] rad`; `center_x 0.45 m` where it was not fitted.
fn value(name: &str, parameter: &Parameter) -> String {
    let [value, low, high] = numbers(parameter);
    let text = match low == high {
        true => format!("{name} {value} {}", parameter.unit),
        false => format!("{name} {value} [{low}, {high}] {}", parameter.unit),
    };
    text.trim_end().to_owned()
}

fn next(diagnosis: &Diagnosis) -> String {
    let count = diagnosis.next_strikes.len();
    match (diagnosis.verdict, count) {
        (Verdict::Consistent, 0) => {
            "next       no effect shows that would move stops beyond scatter: none is added\n"
                .into()
        }
        (Verdict::Consistent, 1..) => format!(
            "next       no effect shows that would move stops beyond scatter: none is added. Few commands\n           \
             were repeated: the {count} strikes in {NEXT_STRIKES} would tell whether repeats scatter by as much\n"
        ),
        (Verdict::Named, 1..) if diagnosis.gap.after > diagnosis.gap.before => format!(
            "next       on held-out strikes the effects bring stops no nearer; the {count} strikes in\n           \
             {NEXT_STRIKES} would say more\n"
        ),
        (_, 1..) => {
            format!(
                "next       the {count} strikes in {NEXT_STRIKES} would be the most informative\n"
            )
        }
        (Verdict::Named, 0) => "next       check the effects on the rig: see the report\n".into(),
        (Verdict::Unexplained, 0) => "next       the report shows what the gap depends on\n".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::shared::WIDTH;
    use super::*;
    use crate::report::found_tilt;
    use crate::results::testing::diagnosed;

    #[test]
    fn an_overview_fits_a_screen_and_names_each_effect_with_its_interval() {
        let found = found_tilt();
        let text = overview(&diagnosed(Some(found.clone())));
        assert!(text.lines().count() < 24, "{text}");
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
        let parameter = &found.diagnosis.effects[0].parameters["tilt_x"];
        assert!(text.contains(&value("tilt_x", parameter)), "{text}");
        assert!(text.contains("diagnosis  named (p "), "{text}");
        assert!(text.contains("next       "), "{text}");

        let mut worse = found.diagnosis;
        worse.gap.after = 1.1 * worse.gap.before;
        worse.next_strikes = vec![worse.next_strikes.first().cloned().expect("planned")];
        assert!(next(&worse).contains("no nearer"), "{}", next(&worse));
    }

    #[test]
    fn many_values_take_more_lines() {
        let values: Vec<String> = (0..6)
            .map(|i| format!("parameter_{i} 0.501 [0.489, 0.513] m"))
            .collect();
        let text = effect_lines("friction_patch", &values);
        assert_eq!(text.lines().count(), 3, "{text}");
        assert!(values.iter().all(|value| text.contains(value)), "{text}");
    }
}
