//! What changed between two versions: inputs, worlds, effects, commands, stop errors.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;
use store::{Artifact, Model, ResidualModel, TrainedRegion};
use strike::Planner;
use values::{Interval, Point, StopErrors};
use world::{AddedEffect, Estimate, World};

use crate::Error;
use crate::error::to_json;
use crate::summary::diagnosis::to_two_figures_of;

/// Targets along each of distance and bearing whose commands are compared.
const ALONG: u32 = 5;

/// A value before and after; none where there was none.
#[derive(Debug, PartialEq, Serialize)]
pub struct Change<T> {
    /// What it is of, such as `table.x.high`.
    pub name: String,
    /// In the first version.
    pub before: Option<T>,
    pub after: Option<T>,
}

/// A parameter before and after.
#[derive(Debug, PartialEq, Serialize)]
pub struct Moved {
    #[serde(flatten)]
    pub change: Change<Estimate>,
    /// Whether each value lies outside the other's 95 % interval: more than what two fits of one table differ by, as a rule. None
    /// where one of them has no interval.
    pub is_beyond: Option<bool>,
}

/// What differs between two worlds.
#[derive(Debug, Default, PartialEq, Serialize)]
pub struct WorldDifference {
    /// Parameters whose values differ.
    pub parameters: Vec<Moved>,
    /// Names of effects that the second alone has.
    pub added: Vec<String>,
    /// Names of effects that the first alone has.
    pub removed: Vec<String>,
    /// Parameters of effects that both have, named `effect.parameter`.
    pub effects: Vec<Moved>,
    /// Scatter, shift, sessions.
    pub other: Vec<Change<Value>>,
}

/// How the commands of two versions differ, on targets that both were trained around.
#[derive(Debug, PartialEq, Serialize)]
pub struct Commands {
    pub targets: usize,
    /// Targets that the first refuses.
    pub refused_before: usize,
    /// Targets that the second refuses.
    pub refused_after: usize,
    /// Targets that both plan.
    pub both: usize,
    /// Mean and largest difference of speed among them, in m/s.
    pub speed: [f64; 2],
    /// Mean and largest difference of angle among them, in rad.
    pub angle: [f64; 2],
}

/// What `carom artifacts diff` finds.
#[derive(Debug, Serialize)]
pub struct Difference {
    /// First version.
    pub before: String,
    /// Second version.
    pub after: String,
    /// Programs, seeds, counts of strikes, rig, trained region, stages and their settings.
    pub made_by: Vec<Change<Value>>,
    /// Logs that the second alone was computed from.
    pub logs_added: Vec<String>,
    /// Logs that the first alone was computed from.
    pub logs_removed: Vec<String>,
    pub sysid: WorldDifference,
    /// The worlds with effects, or that world beside the plain one where one version alone has effects.
    pub effect: WorldDifference,
    /// Kinds of residual models that are not the same, by the model that uses them.
    pub residuals: Vec<Change<String>>,
    /// Commands of the default models; none where neither could plan.
    pub commands: Option<Commands>,
    /// Stop errors by model, and of `noise_floor`, in m. Each version's own held-out strikes judge it.
    pub errors: Vec<Change<StopErrors>>,
}

/// Compares two versions, which need not be of one run.
pub fn difference(before: &Artifact, after: &Artifact) -> Result<Difference, Error> {
    let logs = |version: &Artifact| -> BTreeMap<String, String> {
        let inputs = version.manifest.provenance.inputs.iter();
        inputs
            .map(|log| (log.sha256.clone(), log.name.clone()))
            .collect()
    };
    let (logs_before, logs_after) = (logs(before), logs(after));
    let only = |these: &BTreeMap<String, String>, others: &BTreeMap<String, String>| {
        let these = these.iter().filter(|(hash, _)| !others.contains_key(*hash));
        these.map(|(_, name)| name.clone()).collect()
    };
    let used = |version: &'_ Artifact| {
        let used = version.effect.as_ref().unwrap_or(&version.sysid);
        used.world.clone()
    };
    let has_effects = before.effect.is_some() || after.effect.is_some();
    Ok(Difference {
        before: before.version.clone(),
        after: after.version.clone(),
        made_by: changes(&made_by(before)?, &made_by(after)?),
        logs_added: only(&logs_after, &logs_before),
        logs_removed: only(&logs_before, &logs_after),
        sysid: worlds(&before.sysid.world, &after.sysid.world)?,
        effect: match has_effects {
            true => worlds(&used(before), &used(after))?,
            false => WorldDifference::default(),
        },
        residuals: residuals(before, after),
        commands: commands(before, after),
        errors: errors(before, after),
    })
}

/// What a version was made by and for, without what has a place of its own in a [`Difference`].
fn made_by(version: &Artifact) -> Result<Value, Error> {
    let manifest = &version.manifest;
    let stages = manifest.provenance.stages.iter();
    let stages: BTreeMap<&str, Value> = stages
        .map(|stage| Ok((stage.name.as_str(), to_json(stage)?)))
        .collect::<Result<_, Error>>()?;
    let provenance = &manifest.provenance;
    Ok(serde_json::json!({
        "carom": manifest.carom,
        "MuJoCo": manifest.mujoco,
        "default_model": provenance.default_model,
        "without_effects": provenance.without_effects,
        "moved": provenance.moved,
        "seeds": provenance.seeds,
        "strikes": provenance.strikes.map(|strikes| strikes.count),
        "trained_region": provenance.trained_region,
        "rig": version.rig,
        "stages": stages,
    }))
}

/// What differs between two maps, by name.
fn differing<T: Clone + PartialEq>(
    before: &BTreeMap<String, T>,
    after: &BTreeMap<String, T>,
) -> Vec<Change<T>> {
    let names: BTreeSet<&String> = before.keys().chain(after.keys()).collect();
    let change = |name: &String| Change {
        name: name.clone(),
        before: before.get(name).cloned(),
        after: after.get(name).cloned(),
    };
    let all = names.into_iter().map(change);
    all.filter(|change| change.before != change.after).collect()
}

/// Every leaf that differs, named by its way; a list is a leaf.
fn changes(before: &Value, after: &Value) -> Vec<Change<Value>> {
    let [before, after] = [before, after].map(|value| {
        let mut found = BTreeMap::new();
        leaves(value, String::new(), &mut found);
        found
    });
    differing(&before, &after)
}

fn leaves(value: &Value, name: String, found: &mut BTreeMap<String, Value>) {
    match value {
        Value::Null => {}
        Value::Object(map) => {
            for (key, value) in map {
                let dot = if name.is_empty() { "" } else { "." };
                leaves(value, format!("{name}{dot}{key}"), found);
            }
        }
        leaf => {
            found.insert(name, leaf.clone());
        }
    }
}

fn worlds(before: &World, after: &World) -> Result<WorldDifference, Error> {
    let effects = |world: &World| -> BTreeMap<String, AddedEffect> {
        let added = world.effects.iter().cloned();
        added.map(|effect| (effect.name.clone(), effect)).collect()
    };
    let (effects_before, effects_after) = (effects(before), effects(after));
    let only = |these: &BTreeMap<String, AddedEffect>, others: &BTreeMap<String, AddedEffect>| {
        let names = these.keys().filter(|name| !others.contains_key(*name));
        names.cloned().collect()
    };
    let both = effects_before
        .iter()
        .filter_map(|(name, effect)| Some((name, effect, effects_after.get(name)?)));
    let rest = |world: &World| {
        to_json(&World {
            parameters: BTreeMap::new(),
            effects: Vec::new(),
            ..world.clone()
        })
    };
    Ok(WorldDifference {
        parameters: moved("", &before.parameters, &after.parameters),
        added: only(&effects_after, &effects_before),
        removed: only(&effects_before, &effects_after),
        effects: both
            .flat_map(|(name, before, after)| {
                moved(&format!("{name}."), &before.parameters, &after.parameters)
            })
            .collect(),
        other: changes(&rest(before)?, &rest(after)?),
    })
}

fn moved(
    prefix: &str,
    before: &BTreeMap<String, Estimate>,
    after: &BTreeMap<String, Estimate>,
) -> Vec<Moved> {
    let moved = |change: Change<Estimate>| Moved {
        is_beyond: change
            .before
            .zip(change.after)
            .and_then(|(a, b)| is_beyond(&a, &b)),
        change: Change {
            name: format!("{prefix}{}", change.name),
            ..change
        },
    };
    differing(before, after).into_iter().map(moved).collect()
}

fn is_beyond(one: &Estimate, other: &Estimate) -> Option<bool> {
    let outside = |interval: &Estimate, value: f64| {
        let (low, high) = (interval.low?, interval.high?);
        Some(!Interval { low, high }.contains(value))
    };
    Some(outside(one, other.value)? && outside(other, one.value)?)
}

/// What kind of residual a version adds, by the model that adds it.
fn residuals(before: &Artifact, after: &Artifact) -> Vec<Change<String>> {
    let of = |version: &'_ Artifact, model: Model| version.model(model)?.1.cloned();
    let models = [Model::SysidResidual, Model::EffectResidual].into_iter();
    models
        .map(|model| (model, of(before, model), of(after, model)))
        .filter(|(_, before, after)| before != after)
        .map(|(model, before, after)| Change {
            name: model.name().into(),
            before: before.as_ref().map(kind),
            after: after.as_ref().map(kind),
        })
        .collect()
}

fn kind(residual: &ResidualModel) -> String {
    match residual {
        ResidualModel::Launch(_) => "launch map".into(),
        ResidualModel::Networks(_) => "networks".into(),
    }
}

/// Plans with both default models on a grid over what both were trained on.
fn commands(before: &Artifact, after: &Artifact) -> Option<Commands> {
    let planner =
        |version: &Artifact| Planner::new(version, version.manifest.provenance.default_model).ok();
    let (first, second) = (planner(before)?, planner(after)?);
    let paths = grid(
        &before.manifest.provenance.trained_region,
        &after.manifest.provenance.trained_region,
    );
    let plans: Vec<_> = paths
        .par_iter()
        .map(|(from, to)| [&first, &second].map(|planner| planner.plan(*from, *to).ok()))
        .collect();
    let differences: Vec<[f64; 2]> = plans
        .iter()
        .filter_map(|[before, after]| {
            let (before, after) = (before.as_ref()?, after.as_ref()?);
            Some([
                (after.speed - before.speed).abs(),
                values::wrap_angle(after.angle - before.angle).abs(),
            ])
        })
        .collect();
    let mean_and_most = |which: usize| {
        let values = || differences.iter().map(|both| both[which]);
        let mean = values().sum::<f64>() / differences.len().max(1) as f64;
        [mean, values().fold(0.0, f64::max)]
    };
    let refused = |which: usize| plans.iter().filter(|both| both[which].is_none()).count();
    Some(Commands {
        targets: plans.len(),
        refused_before: refused(0),
        refused_after: refused(1),
        both: differences.len(),
        speed: mean_and_most(0),
        angle: mean_and_most(1),
    })
}

/// Starts and targets in m: from the middle of the first region's starts, distances and bearings that both hold.
fn grid(one: &TrainedRegion, other: &TrainedRegion) -> Vec<(Point, Point)> {
    let middle = |interval: Option<Interval>| interval.map_or(0.0, |i| 0.5 * (i.low + i.high));
    let from = Point::new(middle(one.start_x), middle(one.start_y));
    let both = |a: Interval, b: Interval| (a.low.max(b.low), a.high.min(b.high));
    let (distance, bearing) = (
        both(one.distance, other.distance),
        both(one.bearing, other.bearing),
    );
    // The middles of equal parts: what lies at an edge is refused by whichever was trained on less.
    let at = |(low, high): (f64, f64), part: u32| {
        low + (high - low) * (f64::from(part) + 0.5) / f64::from(ALONG)
    };
    if distance.0 > distance.1 || bearing.0 > bearing.1 {
        return Vec::new();
    }
    (0..ALONG)
        .flat_map(|i| (0..ALONG).map(move |j| (i, j)))
        .map(|(i, j)| (from, from + Point::polar(at(distance, i), at(bearing, j))))
        .collect()
}

fn errors(before: &Artifact, after: &Artifact) -> Vec<Change<StopErrors>> {
    let metrics = |version: &Artifact, model| {
        let metrics = &version.manifest.provenance.metrics;
        metrics.get(&model).copied()
    };
    let floor = |version: &Artifact| version.manifest.provenance.noise_floor;
    Model::ALL
        .into_iter()
        .map(|model| Change {
            name: model.name().into(),
            before: metrics(before, model),
            after: metrics(after, model),
        })
        .chain([Change {
            name: "noise_floor".into(),
            before: floor(before),
            after: floor(after),
        }])
        .filter(|change| change.before.is_some() || change.after.is_some())
        .collect()
}

impl Difference {
    /// For a person, a line a change.
    pub fn text(&self) -> String {
        let mut text = format!("{} → {}\n", self.before, self.after);
        for (what, logs) in [("new", &self.logs_added), ("gone", &self.logs_removed)] {
            if !logs.is_empty() {
                let _ = writeln!(text, "logs       {what}: {}", listed(logs));
            }
        }
        for change in &self.made_by {
            let _ = writeln!(text, "made by    {}", leaf(change));
        }
        text += &self.sysid.text("sysid");
        text += &self.effect.text("effects");
        for change in &self.residuals {
            let said = |kind: &Option<String>| kind.clone().unwrap_or("none".into());
            let (before, after) = (said(&change.before), said(&change.after));
            let anew = if before == after {
                ", trained anew"
            } else {
                ""
            };
            let _ = writeln!(text, "residual   {}: {before} → {after}{anew}", change.name);
        }
        text += &self.commands.as_ref().map_or_else(
            || "commands   not compared: one of the two plans nothing\n".into(),
            Commands::text,
        );
        for change in &self.errors {
            let said = |errors: &Option<StopErrors>| match errors {
                Some(errors) => format!(
                    "{:.2} ± {:.2} cm ({} strikes)",
                    errors.mean * 100.0,
                    errors.sd * 100.0,
                    errors.n
                ),
                None => "none".into(),
            };
            let (before, after) = (said(&change.before), said(&change.after));
            let said = match before == after {
                true => format!("{before}, as before"),
                false => format!("{before} → {after}"),
            };
            let _ = writeln!(text, "error      {:<15} {said}", change.name);
        }
        text
    }
}

/// Names of logs, the first few.
fn listed(names: &[String]) -> String {
    const MOST: usize = 4;
    let mut text = names[..names.len().min(MOST)].join(", ");
    if names.len() > MOST {
        let _ = write!(text, " and {} more", names.len() - MOST);
    }
    text
}

fn leaf(change: &Change<Value>) -> String {
    let said = |value: &Option<Value>| value.as_ref().map_or("none".into(), four_figures);
    format!(
        "{}: {} → {}",
        change.name,
        said(&change.before),
        said(&change.after)
    )
}

/// A value with its numbers to four figures; `--json` has them all.
fn four_figures(value: &Value) -> String {
    match value {
        Value::Number(number) if number.is_f64() => {
            let number = number.as_f64().unwrap_or(f64::NAN);
            to_two_figures_of(number / 100.0, number)
        }
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(four_figures).collect();
            format!("[{}]", values.join(", "))
        }
        other => other.to_string(),
    }
}

impl WorldDifference {
    fn text(&self, name: &str) -> String {
        let mut text = String::new();
        for (what, effects) in [("new", &self.added), ("gone", &self.removed)] {
            for effect in effects {
                let _ = writeln!(text, "{name:<10} {what}: {effect}");
            }
        }
        for moved in self.parameters.iter().chain(&self.effects) {
            let _ = writeln!(text, "{name:<10} {}", moved.text());
        }
        for change in &self.other {
            let _ = writeln!(text, "{name:<10} {}", leaf(change));
        }
        text
    }
}

impl Moved {
    fn text(&self) -> String {
        let estimates = [&self.change.before, &self.change.after];
        let widths = estimates
            .into_iter()
            .flatten()
            .filter_map(|estimate| Some(estimate.high? - estimate.low?));
        let width = widths.fold(f64::INFINITY, f64::min);
        let said = |estimate: &Option<Estimate>| match *estimate {
            None => "none".to_owned(),
            Some(Estimate { value, low, high }) => {
                let number = |value: f64| match width.is_finite() {
                    true => to_two_figures_of(width, value),
                    false => format!("{value:.4}"),
                };
                match low.zip(high) {
                    Some((low, high)) => {
                        format!("{} [{}, {}]", number(value), number(low), number(high))
                    }
                    None => number(value),
                }
            }
        };
        let mark = match self.is_beyond {
            Some(true) => ", beyond both intervals",
            Some(false) | None => "",
        };
        format!(
            "{}: {} → {}{mark}",
            self.change.name,
            said(&self.change.before),
            said(&self.change.after)
        )
    }
}

impl Commands {
    fn text(&self) -> String {
        if self.targets == 0 {
            return "commands   not compared: the two were trained on different paths\n".into();
        }
        let mut text = format!(
            "commands   {} of {} targets are planned by both",
            self.both, self.targets
        );
        if self.both > 0 {
            let _ = write!(
                text,
                ": speed differs by {:.4} m/s on average, {:.4} at most; angle by {:.4} rad, {:.4} at most",
                self.speed[0], self.speed[1], self.angle[0], self.angle[1]
            );
        }
        if self.refused_before + self.refused_after > 0 {
            let _ = write!(
                text,
                "; refused: {} before, {} after",
                self.refused_before, self.refused_after
            );
        }
        text + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(value: f64, half: f64) -> Estimate {
        Estimate::with_interval(value, value - half, value + half)
    }

    fn world(friction: Estimate, effects: &[(&str, Estimate)]) -> World {
        let added = |(name, value): &(&str, Estimate)| AddedEffect {
            name: (*name).into(),
            parameters: [("tilt_x".to_string(), *value)].into(),
        };
        World {
            parameters: [("friction".to_string(), friction)].into(),
            effects: effects.iter().map(added).collect(),
            scatter: Default::default(),
            shift: Default::default(),
            sessions: BTreeMap::new(),
        }
    }

    #[test]
    fn worlds_differ_by_parameters_and_effects_and_say_what_lies_beyond_both_intervals() {
        let tilt = estimate(0.004, 0.0002);
        let before = world(estimate(0.30, 0.01), &[("table_tilt", tilt)]);
        assert_eq!(
            worlds(&before, &before).expect("compared"),
            WorldDifference::default()
        );

        let after = world(
            estimate(0.33, 0.01),
            &[
                ("table_tilt", estimate(0.0041, 0.0002)),
                ("viscous_drag", tilt),
            ],
        );
        let found = worlds(&before, &after).expect("compared");
        assert_eq!(found.added, ["viscous_drag"]);
        assert!(found.removed.is_empty() && found.other.is_empty());
        let text = found.text("world");
        assert!(
            text.contains("friction: 0.300 [0.290, 0.310] → 0.330 [0.320, 0.340], beyond both"),
            "{text}"
        );
        // A tenth of a milliradian lies within what the fit is sure of.
        assert_eq!(found.effects[0].is_beyond, Some(false));
        assert_eq!(found.effects[0].change.name, "table_tilt.tilt_x");
    }

    #[test]
    fn leaves_that_differ_are_named_by_their_way_and_missing_ones_are_none() {
        let before =
            serde_json::json!({ "rig": { "table": { "high": 1.0, "low": 0.0 } }, "seed": 1 });
        let after = serde_json::json!({ "rig": { "table": { "high": 1.2, "low": 0.0 } } });
        let found = changes(&before, &after);
        let said: Vec<String> = found.iter().map(leaf).collect();
        assert_eq!(said, ["rig.table.high: 1.000 → 1.200", "seed: 1 → none"]);
    }
}
