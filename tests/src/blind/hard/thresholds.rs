//! What half and twice each number set by hand does: hard sets, diagnosed once by each variation.

use std::collections::BTreeMap;
use std::fmt::Write;

use diagnose::Thresholds;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::super::proportion::Proportion;
use super::super::set::{self, Answer};
use super::cases::{HardCase, HardKind, draw};
use super::outcome::HardOutcome;

/// A set, and what was said of it by each variation; none where the rig could not make it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct VariedSet {
    /// The set as it is, with the answer at the default values.
    pub default: HardOutcome,
    /// Answers that another value changed: by the variation's name.
    pub changed: BTreeMap<String, Answer>,
}

/// One threshold at another value.
struct Variation {
    threshold: String,
    /// `half` or `twice`.
    by: &'static str,
    value: f64,
}

impl Variation {
    fn name(&self) -> String {
        format!("{} {}", self.by, self.threshold)
    }

    fn thresholds(&self) -> Thresholds {
        let mut all = defaults();
        all.insert(self.threshold.clone(), self.value.into());
        serde_json::from_value(Value::Object(all)).expect("only a number differs")
    }
}

fn defaults() -> Map<String, Value> {
    match serde_json::to_value(Thresholds::default()) {
        Ok(Value::Object(map)) => map,
        _ => unreachable!("thresholds are an object of numbers"),
    }
}

/// Thresholds below one that are no share.
const EVIDENCE: &[&str] = &["better"];

/// Thresholds of the world without effects, which decide whether there is an alarm.
const BEFORE_ALARM: &[&str] = &["small_wander", "wrong_sizes", "believed_sizes"];

/// A threshold at a factor: of a share of one half and more, what is left to one is varied.
fn scaled(name: &str, value: f64, factor: f64) -> f64 {
    if (0.5..1.0).contains(&value) && !EVIDENCE.contains(&name) {
        1.0 - factor * (1.0 - value)
    } else {
        factor * value
    }
}

fn variations() -> Vec<Variation> {
    defaults()
        .into_iter()
        .flat_map(|(threshold, value)| {
            let value = value.as_f64().unwrap_or_default();
            [("half", 0.5), ("twice", 2.0)].map(|(by, factor)| Variation {
                threshold: threshold.clone(),
                by,
                value: scaled(&threshold, value, factor),
            })
        })
        .collect()
}

/// Diagnoses a set by every variation.
pub fn run_varied(case: &HardCase) -> VariedSet {
    let mut default = HardOutcome {
        case: case.clone(),
        drawn: draw(case),
        answer: Answer::none("impossible".into()),
        covered: Vec::new(),
    };
    let mut changed = BTreeMap::new();
    let drawn = default.drawn.as_ref();
    let identified = drawn.and_then(|drawn| set::identified_set(drawn.make(), None));
    match identified {
        None => {}
        Some(Err(error)) => default.answer = Answer::none(format!("error: {error}")),
        Some(Ok(set)) => {
            let answer = |thresholds| match set::diagnosis(&set.input, thresholds) {
                Ok((found, seconds)) => Answer::of(&found, (set.seconds, seconds)),
                Err(error) => Answer::none(format!("error: {error}")),
            };
            default.answer = answer(Thresholds::default());
            let is_alarm = default.answer.verdict != "consistent";
            for variation in variations() {
                // Without an alarm nothing is asked of effects.
                if !is_alarm && !BEFORE_ALARM.contains(&variation.threshold.as_str()) {
                    continue;
                }
                let other = answer(variation.thresholds());
                if other.text() != default.answer.text() {
                    changed.insert(variation.name(), other);
                }
            }
        }
    }
    VariedSet { default, changed }
}

impl VariedSet {
    fn at(&self, variation: &str) -> HardOutcome {
        let mut outcome = self.default.clone();
        if let Some(answer) = self.changed.get(variation) {
            outcome.answer = answer.clone();
        }
        outcome
    }
}

/// The page in Markdown.
pub fn thresholds_page(sets: &[VariedSet], command: &str) -> String {
    let made: Vec<&VariedSet> = sets
        .iter()
        .filter(|set| set.default.answer.verdict != "impossible")
        .collect();
    let default: Vec<HardOutcome> = made.iter().map(|set| set.default.clone()).collect();
    let mut text = format!(
        "# Thresholds of the diagnosis\n\nMade by `{command}`: {} sets of the [hard benchmark](HARD.md), each diagnosed anew with one \
         number at half and at twice its value. {ABOUT}\n\n| threshold | value | varied to | answers changed | {HEADS} |\n\
         |---|---|---|---|---|---|---|---|\n| all as they are | | | | {} |\n",
        made.len(),
        row(&default)
    );
    let defaults = defaults();
    for variation in variations() {
        let name = variation.name();
        let varied: Vec<HardOutcome> = made.iter().map(|set| set.at(&name)).collect();
        let changed = made.iter().filter(|set| set.changed.contains_key(&name));
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} |",
            variation.threshold,
            defaults[&variation.threshold],
            (1e6 * variation.value).round() / 1e6,
            changed.count(),
            row(&varied)
        );
    }
    text
}

const HEADS: &str = "false alarms | one to three hidden: right | a name too many | `unexplained` where no candidate has it";

const ABOUT: &str = "What each number means stands at its field in `stages/diagnose/src/thresholds.rs`. Of a share of one half and more, what is \
left to one is halved and doubled. An answer is changed where its verdict, a name or a class differs. Levels of significance, which \
statistics gives, and numbers that bound the work of a fit are not varied.";

fn row(outcomes: &[HardOutcome]) -> String {
    let of = |kinds: &'static [HardKind]| {
        let of_kinds = move |o: &&HardOutcome| kinds.contains(&o.case.kind);
        outcomes.iter().filter(of_kinds)
    };
    let count = |p: Proportion| format!("{} of {}", p.hits, p.all);
    const HIDDEN: &[HardKind] = &[HardKind::Single, HardKind::Weak, HardKind::Several];
    [
        Proportion::of(of(&[HardKind::Control]), |o| !o.is_right()),
        Proportion::of(of(HIDDEN), |o| o.is_right()),
        Proportion::of(of(HIDDEN), |o| o.has_a_name_too_many()),
        Proportion::of(of(&[HardKind::Foreign]), |o| o.is_right()),
    ]
    .map(count)
    .join(" | ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_threshold_is_varied_alone() {
        let all = variations();
        assert_eq!(all.len(), 2 * defaults().len());
        for variation in &all {
            let varied = serde_json::to_value(variation.thresholds()).expect("numbers");
            let differ = defaults()
                .into_iter()
                .filter(|(name, value)| varied[name] != *value);
            let names: Vec<String> = differ.map(|(name, _)| name).collect();
            assert_eq!(names, std::slice::from_ref(&variation.threshold));
        }
    }

    #[test]
    fn of_a_large_share_the_rest_is_varied() {
        assert!((scaled("explained", 0.95, 2.0) - 0.9).abs() < 1e-12);
        assert!((scaled("explained", 0.95, 0.5) - 0.975).abs() < 1e-12);
        assert_eq!(scaled("form", 0.02, 2.0), 0.04);
        assert_eq!(scaled("beyond_wander", 3.0, 0.5), 1.5);
        assert_eq!(scaled("better", 0.5, 2.0), 1.0);
    }
}
