//! A world as plain data: `world.toml`.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use serde::{Deserialize, Serialize};

use crate::{
    Estimate, PARAMETERS, Shift, WorldError,
    effects::{self, AddedEffect, Parameters, Population, UNKNOWN},
    parameter,
    parameter::in_range,
};

/// The model of a set-up: parameters, launch scatter, and the effects added to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct World {
    /// Every parameter of [`PARAMETERS`] that differs from its nominal value or was identified.
    #[serde(default)]
    pub parameters: BTreeMap<String, Estimate>,
    /// How repeats of one command differ.
    #[serde(default)]
    pub scatter: Scatter,
    /// How friction, launch speed and heading changed for good since the parameters were identified.
    #[serde(default, skip_serializing_if = "Shift::is_none")]
    pub shift: Shift,
    /// For each effect by session, by its name, the population that sessions are drawn from: what is known of a session that was never seen.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sessions: BTreeMap<String, Population>,
    /// Effects, in the order added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<AddedEffect>,
}

/// How repeats of one command differ; standard deviations, but for the camera's correlation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scatter {
    /// Standard deviation of the delivered speed, relative to the commanded.
    pub speed: f64,
    /// Standard deviation of the delivered angle, in rad.
    pub angle: f64,
    /// Standard deviation of a centroid's coordinate, in m.
    pub camera: f64,
    /// Standard deviation of friction from strike to strike, relative to the world's; zero where a file does not say.
    #[serde(default)]
    pub friction: f64,
    /// Correlation of the centroid's error from one frame to the next, 0 to 1; none where a file does not say.
    #[serde(default)]
    pub camera_correlation: f64,
    /// Standard deviation of a frame's stamp, in s; zero where a file does not say.
    #[serde(default)]
    pub stamp_jitter: f64,
}

impl World {
    /// The world before anything is measured: every parameter nominal, no effect.
    pub fn nominal() -> Self {
        Self {
            parameters: BTreeMap::new(),
            scatter: Scatter::default(),
            shift: Shift::default(),
            sessions: BTreeMap::new(),
            effects: Vec::new(),
        }
    }

    /// Reads and checks a world file.
    pub fn load(path: &Path) -> Result<Self, WorldError> {
        let text = std::fs::read_to_string(path).map_err(|source| WorldError::Read {
            path: path.display().to_string(),
            source,
        })?;
        Self::parse(&text)
    }

    /// Parses and checks the text of a world file.
    pub fn parse(text: &str) -> Result<Self, WorldError> {
        let world: Self =
            toml::from_str(text).map_err(|error| WorldError::Parse(error.to_string()))?;
        world.check()?;
        Ok(world)
    }

    /// The text of a world file that reads back as this value.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a world is plain data")
    }

    /// Whether every name is known, every value lies in its range and every interval is one of numbers.
    pub fn check(&self) -> Result<(), WorldError> {
        for (name, estimate) in &self.parameters {
            let spec = parameter(name)?;
            in_range(name, estimate.value, spec.low, spec.high, spec.unit)?;
        }
        for (name, value) in [
            ("scatter.speed", self.scatter.speed),
            ("scatter.angle", self.scatter.angle),
            ("scatter.camera", self.scatter.camera),
            ("scatter.friction", self.scatter.friction),
            ("scatter.stamp_jitter", self.scatter.stamp_jitter),
        ] {
            in_range(name, value, 0.0, 10.0, "")?;
        }
        let correlation = self.scatter.camera_correlation;
        in_range("scatter.camera_correlation", correlation, 0.0, 1.0, "")?;
        for (name, value) in Shift::NAMES.iter().zip(self.shift.values()) {
            in_range(&format!("shift.{name}"), value, -1.0, 1.0, "")?;
        }
        for effect in &self.effects {
            effects::check(effect)?;
        }
        for (name, population) in &self.sessions {
            let parameter = effects::effect(name)?.parameter(UNKNOWN);
            let known = self.effects.iter().any(|effect| effect.name == *name);
            let Some(parameter) = parameter.filter(|_| known) else {
                let why = format!("sessions.{name}: the world has no such effect by session");
                return Err(WorldError::Parse(why));
            };
            let widest = parameter.high - parameter.low;
            let (mean, scatter) = (population.mean, population.scatter);
            in_range(
                &format!("sessions.{name}.mean"),
                mean,
                parameter.low,
                parameter.high,
                parameter.unit,
            )?;
            in_range(
                &format!("sessions.{name}.scatter"),
                scatter,
                0.0,
                widest,
                parameter.unit,
            )?;
        }
        let added = self.effects.iter().flat_map(|effect| &effect.parameters);
        for (name, estimate) in self.parameters.iter().chain(added) {
            let mut ends = [estimate.low, estimate.high].into_iter().flatten();
            if !ends.all(f64::is_finite) {
                let why = format!("the interval of {name} is not finite");
                return Err(WorldError::Parse(why));
            }
        }
        Ok(())
    }

    /// The value of a parameter: as set, or nominal.
    pub fn value(&self, name: &str) -> Result<f64, WorldError> {
        let spec = parameter(name)?;
        Ok(self
            .parameters
            .get(name)
            .map_or(spec.nominal, |estimate| estimate.value))
    }

    /// The sessions that its effects know, in their order; none where nothing differs by session.
    pub fn known_sessions(&self) -> BTreeSet<&str> {
        let by_session = self.effects.iter().filter(|added| {
            let spec = effects::effect(&added.name);
            spec.is_ok_and(|spec| matches!(spec.parameters, Parameters::BySession { .. }))
        });
        by_session
            .flat_map(|added| added.parameters.keys())
            .map(String::as_str)
            .filter(|name| *name != UNKNOWN)
            .collect()
    }

    /// This world as if it had never seen a session: effects by session take their mean over the other sessions there. Only for predictions in that
    /// session: relative changes in the others are then from another mean.
    pub fn without_session(mut self, session: &str) -> Self {
        for added in &mut self.effects {
            let spec = effects::effect(&added.name).map(|spec| &spec.parameters);
            let Ok(Parameters::BySession { is_relative, .. }) = spec else {
                continue;
            };
            let known = added.parameters.iter().filter(|(name, _)| *name != UNKNOWN);
            let known: BTreeMap<String, f64> = known
                .map(|(name, estimate)| (name.clone(), estimate.value))
                .collect();
            let mut others = if *is_relative {
                effects::centred(&known)
            } else {
                known
            };
            if others.remove(session).is_some() {
                let mean = others.values().sum::<f64>() / others.len().max(1) as f64;
                added.parameters.remove(session);
                let mean = Estimate::fixed(mean);
                added.parameters.insert(UNKNOWN.into(), mean);
            }
        }
        self
    }

    /// This world with [`World::sessions`] computed from its effects by session.
    pub fn with_populations(mut self) -> Self {
        self.sessions.clear();
        for added in &self.effects {
            let spec = effects::effect(&added.name);
            if spec.is_ok_and(|spec| matches!(spec.parameters, Parameters::BySession { .. })) {
                let population = Population::of(&added.parameters);
                self.sessions.insert(added.name.clone(), population);
            }
        }
        self
    }

    /// This world with one parameter set to a value, without an interval.
    pub fn with(mut self, name: &str, value: f64) -> Self {
        self.parameters.insert(name.into(), Estimate::fixed(value));
        self
    }

    /// The names and values of all parameters.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, f64)> {
        PARAMETERS.iter().map(|spec| {
            (
                spec.name,
                self.parameters
                    .get(spec.name)
                    .map_or(spec.nominal, |e| e.value),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_reads_back_as_it_was_written() {
        let mut world = World::nominal().with("friction", 0.21);
        world.parameters.insert(
            "restitution".into(),
            Estimate::with_interval(0.4, 0.39, 0.41),
        );
        world
            .effects
            .push(AddedEffect::fixed("viscous_drag", &[("rate", 0.2)]));
        assert_eq!(World::parse(&world.to_toml()).expect("valid"), world);
    }

    #[test]
    fn a_session_that_is_left_out_has_the_mean_of_the_others() {
        let effect = |name: &str| AddedEffect::fixed(name, &[("a", 0.3), ("b", 0.1), ("c", -0.1)]);
        let mut world = World::nominal();
        world.effects = vec![
            effect("friction_by_session"),
            effect("striker_angle_by_session"),
        ];
        let unseen = world.clone().without_session("a");
        let mean = |place: usize| {
            assert!(!unseen.effects[place].parameters.contains_key("a"));
            unseen.effects[place].parameters[UNKNOWN].value
        };
        // Relative to the mean of all, 1.1, the others are 1.1 and 0.9.
        assert!((mean(0) - (1.0 / 1.1 - 1.0)).abs() < 1e-12);
        assert!(mean(1).abs() < 1e-12);
        assert_eq!(world.clone().without_session("d"), world);
    }

    #[test]
    fn a_world_file_without_the_newer_scatter_has_none_of_it() {
        let text = "[scatter]\nspeed = 0.02\nangle = 0.01\ncamera = 0.001\n";
        let scatter = World::parse(text).expect("an older file").scatter;
        assert_eq!(
            (
                scatter.friction,
                scatter.camera_correlation,
                scatter.stamp_jitter
            ),
            (0.0, 0.0, 0.0)
        );
        let error = World::parse(&format!("{text}camera_correlation = 1.5\n"))
            .expect_err("no correlation")
            .to_string();
        assert!(error.contains("scatter.camera_correlation"), "{error}");
    }

    #[test]
    fn unknown_names_and_impossible_values_are_reported() {
        let error = World::parse("[parameters.fricton]\nvalue = 0.2")
            .expect_err("unknown")
            .to_string();
        assert!(error.contains("did you mean `friction`?"), "{error}");
        for value in ["nan", "-1.0", "inf"] {
            let error = World::parse(&format!("[parameters.friction]\nvalue = {value}"))
                .expect_err(value)
                .to_string();
            assert!(error.contains("must lie in [0, 1.5]"), "{error}");
        }
    }
}
