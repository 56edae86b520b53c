//! A night over several rigs: their recipes in one file, what came of each, and what they have in common.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use store::Artifact;
use values::{Object, Solid};
use world::Estimate;
use world::effects::{Origin, effect};

use super::night::Night;
use crate::Error;
use crate::dataset::Recipe;
use crate::error::Outcome;
use crate::summary::diagnosis::to_two_figures_of;

/// Chance that quantities which are the same on every rig are said to differ, over all of them.
const CHANCE: f64 = 0.05;
/// Standard deviations of half a 95 % interval.
const HALF: f64 = 1.96;
/// How parameters of a world begin that are of the contact with the tip; the others are of the object on its table.
const CONTACT: [&str; 4] = ["restitution", "contact_time", "tip_friction", "solimp_"];
/// Parameters of an effect that are shown: a map of a table has a hundred.
const MOST_SHOWN: usize = 6;

/// The recipes of a fleet by the names of its rigs: a table of the file each.
pub fn recipes(path: &Path) -> Result<BTreeMap<String, Recipe>, Error> {
    let said = |why: String| Error::input(format!("read the fleet {}: {why}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|error| Error::unreadable(path, &error))?;
    let recipes: BTreeMap<String, Recipe> = toml::from_str(&text).map_err(|error| {
        said(format!(
            "{}; it holds a table for each rig, `[NAME]`, with `logs`, `rig` and `seed`",
            error.to_string().trim_end()
        ))
    })?;
    if recipes.is_empty() {
        return Err(said(
            "it names no rig; add a table `[NAME]` with `logs` and `rig`".into(),
        ));
    }
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    for (name, recipe) in &recipes {
        if name.is_empty() || !name.chars().all(is_plain) {
            return Err(said(format!(
                "the rig [{name:?}] has a folder of its name: use letters, digits, - and _"
            )));
        }
        if recipe.filters != Default::default() {
            return Err(said(format!(
                "[{name}.filters] are of datasets: a night learns from every strike; take away the logs that it must not read"
            )));
        }
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let within = recipes.into_iter().map(|(name, recipe)| {
        let recipe = recipe.within(folder);
        (name, recipe)
    });
    Ok(within.collect())
}

/// What came of one rig's night.
#[derive(Debug, Serialize)]
pub struct RigNight {
    pub name: String,
    /// The exit code that its night alone would have had.
    pub exit: u8,
    /// What was decided; none where the work failed.
    pub night: Option<Night>,
    /// Why it failed.
    pub error: Option<String>,
    /// What came of telling an MLflow server, where one was to be told.
    pub mlflow: Option<String>,
    #[serde(skip)]
    pub outcome: Outcome,
}

impl RigNight {
    /// A rig's night, with what came of telling a server, or why there was none.
    pub fn of(name: &str, worked: Result<(Night, Option<String>), Error>) -> Self {
        let name = name.into();
        match worked {
            Ok((night, mlflow)) => Self {
                name,
                exit: night.outcome() as u8,
                outcome: night.outcome(),
                night: Some(night),
                error: None,
                mlflow,
            },
            Err(error) => Self {
                name,
                exit: error.outcome() as u8,
                outcome: error.outcome(),
                night: None,
                error: Some(format!("failed to {error}")),
                mlflow: None,
            },
        }
    }

    /// What there is to say beyond the headline.
    pub fn lines(&self) -> Vec<String> {
        let mlflow = self.mlflow.as_ref().map(|line| format!("mlflow: {line}"));
        let night = self.night.iter().flat_map(Night::lines);
        night.chain(mlflow).collect()
    }

    pub fn headline(&self) -> String {
        let error = || self.error.clone().unwrap_or_default();
        self.night.as_ref().map_or_else(error, Night::headline)
    }

    /// How much it matters beside the other rigs' outcomes.
    fn weight(&self) -> usize {
        const RISING: [Outcome; 6] = [
            Outcome::Done,
            Outcome::Rejected,
            Outcome::Busy,
            Outcome::Refused,
            Outcome::BadInput,
            Outcome::Failed,
        ];
        let place = RISING.iter().position(|one| *one == self.outcome);
        place.unwrap_or(RISING.len())
    }
}

/// A night over all rigs: `fleet.json`.
#[derive(Debug, Serialize)]
pub struct FleetNight {
    pub rigs: Vec<RigNight>,
    /// What is known of the rigs whose version in use could be read.
    pub known: Vec<Quantity>,
}

/// A parameter of the worlds in use, by rig.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// The world's parameter, or an effect's behind a full stop.
    pub name: String,
    /// What it is a property of.
    pub part: Part,
    /// The object that these rigs strike.
    pub object: String,
    pub rigs: BTreeMap<String, Estimate>,
    /// Whether the rigs share it.
    pub shared: Shared,
    /// Chance that intervals lie as far apart where the quantity is one; none where that is no question.
    pub p_value: Option<f64>,
    /// The one value, where it is common.
    pub common: Option<Estimate>,
    /// Two rigs that differ by less would be said to have it in common.
    pub resolves: Option<f64>,
}

/// What a parameter is a property of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The object on its table.
    Table,
    /// Tip and object where they meet; a constant gain of the arm's speed looks the same.
    Contact,
    Arm,
    Camera,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shared {
    /// The rigs' intervals agree.
    Common,
    /// The rigs' intervals do not agree.
    Differs,
    /// Each rig has its own: its arm's or its camera's, or one that was not measured on all that strike this object.
    Own,
}

impl FleetNight {
    /// What came of the rigs, and what their versions in use have in common.
    pub fn of(rigs: Vec<RigNight>, in_use: &BTreeMap<String, Artifact>) -> Self {
        Self {
            rigs,
            known: known(in_use),
        }
    }

    /// The worst of all rigs'.
    pub fn outcome(&self) -> Outcome {
        let worst = self.rigs.iter().max_by_key(|rig| rig.weight());
        worst.map_or(Outcome::Done, |rig| rig.outcome)
    }

    pub fn headline(&self) -> String {
        let count = |is: fn(&RigNight) -> bool| self.rigs.iter().filter(|rig| is(rig)).count();
        let well = count(|rig| matches!(rig.outcome, Outcome::Done | Outcome::Rejected));
        let rest = match self.rigs.len() - well {
            0 => "none needs anybody".into(),
            1 => "1 needs somebody".into(),
            many => format!("{many} need somebody"),
        };
        format!("{} rigs, {rest}", self.rigs.len())
    }

    /// What is known and shown, by what the rigs share, each under its title.
    pub fn shown(&self) -> [(&'static str, Vec<String>); 3] {
        [
            (Shared::Common, "common"),
            (Shared::Differs, "differs"),
            (Shared::Own, "own"),
        ]
        .map(|(shared, title)| {
            let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
            let of = self.known.iter().filter(|one| one.shared == shared);
            let of = of.filter(|one| match one.name.split_once('.') {
                None => true,
                Some((effect, _)) => {
                    let count = counts.entry(effect).or_default();
                    *count += 1;
                    *count <= MOST_SHOWN
                }
            });
            (title, of.map(Quantity::sentence).collect())
        })
    }

    pub fn text(&self) -> String {
        let mut text = format!("fleet      {}\n", self.headline());
        for rig in &self.rigs {
            text += &format!("{:<10} {}\n", rig.name, rig.headline());
            for line in rig.lines() {
                text += &format!("           {line}\n");
            }
        }
        for (title, sentences) in self.shown() {
            for (place, sentence) in sentences.iter().enumerate() {
                let title = if place == 0 { title } else { "" };
                text += &format!("{title:<10} {sentence}\n");
            }
        }
        text
    }
}

impl Quantity {
    /// The quantity as these rigs, which strike the same object, measured it.
    fn of(
        name: &str,
        part: Part,
        object: &str,
        of: usize,
        rigs: BTreeMap<String, Estimate>,
    ) -> Self {
        let measured: Option<Vec<(f64, f64)>> = rigs.values().map(measured).collect();
        let is_question = matches!(part, Part::Table | Part::Contact) && rigs.len() == of && of > 1;
        let (mut p_value, mut common, mut resolves) = (None, None, None);
        if let Some(measured) = measured.filter(|_| is_question) {
            // Cochran's Q about the mean by inverse variances.
            let weight = |sd: f64| sd.powi(-2);
            let weights: f64 = measured.iter().map(|(_, sd)| weight(*sd)).sum();
            let sum: f64 = measured.iter().map(|(x, sd)| x * weight(*sd)).sum();
            let mean = sum / weights;
            let q = measured
                .iter()
                .map(|(x, sd)| (x - mean).powi(2) * weight(*sd));
            let chance = ChiSquared::new((of - 1) as f64).map(|chi| chi.sf(q.sum()));
            p_value = chance.ok();
            let half = HALF / weights.sqrt();
            common = Some(Estimate {
                value: mean,
                low: Some(mean - half),
                high: Some(mean + half),
            });
            let mut sds: Vec<f64> = measured.iter().map(|(_, sd)| *sd).collect();
            sds.sort_by(|a, b| b.total_cmp(a));
            resolves = Some(HALF * sds[0].hypot(sds[1]));
        }
        Self {
            name: name.into(),
            part,
            object: object.into(),
            rigs,
            shared: Shared::Own,
            p_value,
            common,
            resolves,
        }
    }

    /// Says whether the rigs share it, at this level.
    fn decided(mut self, level: f64) -> Self {
        self.shared = match self.p_value {
            None => Shared::Own,
            Some(p) if p < level => Shared::Differs,
            Some(_) => Shared::Common,
        };
        self.common = self.common.filter(|_| self.shared == Shared::Common);
        self
    }

    pub fn sentence(&self) -> String {
        let each = self.rigs.iter();
        let each = each.map(|(rig, estimate)| format!("{rig} {}", told(estimate)));
        let each = each.collect::<Vec<_>>().join(", ");
        let Self { name, object, .. } = self;
        let p = self.p_value.unwrap_or(1.0);
        match (self.shared, &self.common, self.resolves) {
            (Shared::Common, Some(common), Some(resolves)) => format!(
                "{name} of the {object}: {} ({each}; less than {} between two would not show)",
                told(common),
                to_two_figures_of(resolves, resolves)
            ),
            (Shared::Differs, ..) => format!("{name} of the {object}: {each} (p = {p:.1e})"),
            _ => format!("{name}: {each}"),
        }
    }
}

/// All that the worlds in use say, by part and name.
fn known(in_use: &BTreeMap<String, Artifact>) -> Vec<Quantity> {
    let mut found: BTreeMap<(Part, String, String), BTreeMap<String, Estimate>> = BTreeMap::new();
    let mut striking: BTreeMap<String, usize> = BTreeMap::new();
    for (rig, artifact) in in_use {
        let object = named(&artifact.rig.object);
        *striking.entry(object.clone()).or_default() += 1;
        let world = &artifact.effect.as_ref().unwrap_or(&artifact.sysid).world;
        let of_world = world.parameters.iter().map(|(name, estimate)| {
            let part = match CONTACT.iter().any(|begins| name.starts_with(begins)) {
                true => Part::Contact,
                false => Part::Table,
            };
            (part, name.clone(), *estimate)
        });
        let of_effects = world.effects.iter().flat_map(|added| {
            let origin = effect(&added.name).map(|spec| spec.origin);
            let part = match origin {
                Ok(Origin::Table) => Part::Table,
                Ok(Origin::Contact) => Part::Contact,
                Ok(Origin::Camera) => Part::Camera,
                Ok(Origin::Arm) | Err(_) => Part::Arm,
            };
            let each = added.parameters.iter();
            each.map(move |(name, estimate)| (part, format!("{}.{name}", added.name), *estimate))
        });
        let stated = of_world.chain(of_effects);
        // What was not fitted says nothing of a rig.
        for (part, name, estimate) in stated.filter(|(.., estimate)| measured(estimate).is_some()) {
            let rigs = found.entry((part, name, object.clone())).or_default();
            rigs.insert(rig.clone(), estimate);
        }
    }
    let quantity = |((part, name, object), rigs): ((Part, String, String), _)| {
        Quantity::of(&name, part, &object, striking[&object], rigs)
    };
    let known: Vec<Quantity> = found.into_iter().map(quantity).collect();
    let asked = known.iter().filter(|one| one.p_value.is_some()).count();
    let level = CHANCE / asked.max(1) as f64;
    known.into_iter().map(|one| one.decided(level)).collect()
}

/// An object's shape, sizes and mass.
fn named(object: &Object) -> String {
    let mm = |metres: f64| format!("{}", (metres * 1e4).round() / 10.0);
    let sizes = match object.solid {
        Solid::Cylinder {
            radius,
            half_height,
        } => vec![2.0 * radius, 2.0 * half_height],
        Solid::Box { half_size } => half_size.map(|half| 2.0 * half).to_vec(),
        Solid::Sphere { radius } => vec![2.0 * radius],
    };
    let sizes: Vec<String> = sizes.into_iter().map(mm).collect();
    let grams = (object.mass * 1e4).round() / 10.0;
    format!(
        "{} of {} mm and {grams} g",
        object.shape().name(),
        sizes.join(" × ")
    )
}

/// Value and standard deviation; none where no interval says.
fn measured(estimate: &Estimate) -> Option<(f64, f64)> {
    let sd = (estimate.high? - estimate.low?) / (2.0 * HALF);
    (sd > 0.0 && sd.is_finite()).then_some((estimate.value, sd))
}

fn told(estimate: &Estimate) -> String {
    let end = |end: Option<f64>| end.unwrap_or(estimate.value);
    let (low, high) = (end(estimate.low), end(estimate.high));
    let [value, low, high] = [estimate.value, low, high].map(|x| to_two_figures_of(high - low, x));
    format!("{value} [{low}, {high}]")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity(part: Part, of: usize, values: &[(f64, f64)]) -> Quantity {
        let estimate = |(value, half): &(f64, f64)| Estimate {
            value: *value,
            low: Some(value - half),
            high: Some(value + half),
        };
        let named = values.iter().enumerate();
        let rigs = named.map(|(number, one)| (format!("rig_{number}"), estimate(one)));
        Quantity::of("friction", part, "cylinder", of, rigs.collect()).decided(CHANCE)
    }

    #[test]
    fn what_agrees_within_intervals_is_common_and_what_does_not_differs() {
        let alike = quantity(Part::Table, 3, &[(0.20, 0.01), (0.21, 0.01), (0.205, 0.02)]);
        assert_eq!(alike.shared, Shared::Common);
        let common = alike.common.expect("a value");
        assert!((common.value - 0.205).abs() < 1e-9);
        assert!(common.high.expect("an end") - common.value < 0.01);
        assert!((alike.resolves.expect("known") - 0.0224).abs() < 1e-3);
        let other = quantity(Part::Table, 2, &[(0.20, 0.01), (0.24, 0.01)]);
        assert_eq!((other.shared, other.common), (Shared::Differs, None));
    }

    #[test]
    fn an_arm_s_errors_and_what_one_rig_alone_shows_are_each_its_own() {
        let arm = quantity(Part::Arm, 2, &[(0.1, 0.1), (0.1, 0.1)]);
        let one_of_two = quantity(Part::Table, 2, &[(0.1, 0.1)]);
        let alone = quantity(Part::Table, 1, &[(0.1, 0.1)]);
        for own in [arm, one_of_two, alone] {
            assert_eq!((own.shared, own.common), (Shared::Own, None));
        }
    }

    #[test]
    fn a_file_that_is_no_fleet_s_is_refused_with_what_is_wrong() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("fleet.toml");
        for (text, why) in [
            ("", "names no rig"),
            ("[left]\nlogs = []", "missing field `rig`"),
            (
                "[left]\nlogs = []\nrig = 'a'\nlog = 1",
                "unknown field `log`",
            ),
            ("['../a']\nlogs = []\nrig = 'a'", "letters, digits"),
            (
                "[a]\nlogs = []\nrig = 'a'\n[a.filters]\nspeed = [0.5, 0.6]",
                "of datasets",
            ),
        ] {
            std::fs::write(&path, text).expect("written");
            let error = recipes(&path).expect_err(why);
            assert!(matches!(error, Error::Input(_)));
            assert!(error.to_string().contains(why), "{error}");
        }
    }
}
