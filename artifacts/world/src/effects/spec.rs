//! What is known of a kind of effect before it is fitted.

use std::collections::{BTreeMap, BTreeSet};

use values::{Point, Rig};

use super::{
    action::Effect,
    start::{Experiment, FitStart},
};

/// One kind of effect.
pub struct EffectSpec {
    /// Name in `world.toml`, `diagnosis.json` and on the command line.
    pub name: &'static str,
    /// Its parameters.
    pub parameters: Parameters,
    /// What it makes depend on what.
    pub family: Family,
    /// Effects that do the same to the centroid tracks of one round object and one striker, or so nearly that strikes
    /// within a robot's limits do not tell them apart: named with it, never instead of it.
    pub equivalent: &'static [&'static str],
    /// Simpler effects that it can take the form of: it is named in the place of one only where the data tell what it has
    /// beyond that one.
    pub contains: &'static [&'static str],
    /// Whether it is tried only where nothing simpler is enough.
    pub is_last_resort: bool,
    /// What it stands for, and where the formula comes from.
    pub source: &'static str,
    /// Where fits of it begin on these strikes; none where they cannot tell it.
    pub starts: fn(&Experiment<'_>) -> Vec<FitStart>,
    /// Makes it act.
    pub build: fn(&Values, &Rig) -> Box<dyn Effect>,
    /// One sentence that states fitted values to a person.
    pub statement: fn(&Values) -> String,
}

impl EffectSpec {
    /// The parameter of that name; where parameters are named by session, every name is one.
    pub fn parameter(&self, name: &str) -> Option<&EffectParameter> {
        match &self.parameters {
            Parameters::Listed(listed) => listed.iter().find(|p| p.name == name),
            Parameters::BySession { parameter, .. } => Some(parameter),
        }
    }
}

/// What an effect makes depend on what: a smooth dependence of that kind holds all that a wrong form of the effect leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Friction, by the number of strikes before or the session.
    FrictionByOrder,
    /// Friction, by place on the table.
    FrictionByPlace,
    /// Friction or drag, by sliding speed.
    FrictionBySpeed,
    /// Friction, by the direction of the slide.
    FrictionByHeading,
    /// Force, by place on the table.
    ForceByPlace,
    /// Launch speed, by commanded speed.
    LaunchSpeed,
    /// Launch speed, by the number of strikes before or the session.
    LaunchSpeedByOrder,
    /// Launch angle, by commanded angle.
    LaunchAngle,
    /// Launch angle, by commanded speed and angle.
    LaunchAngleByCommand,
    /// Launch angle, by the number of strikes before or the session.
    LaunchAngleByOrder,
    /// What is seen, by place on the table.
    SeenByPlace,
}

/// How the parameters of an effect are named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameters {
    /// These; one left out is neutral.
    Listed(&'static [EffectParameter]),
    /// One of this kind for each session, named as [`values::Conditions::session`]; sessions are draws ([`super::Population`]).
    BySession {
        /// What each is.
        parameter: EffectParameter,
        /// Whether they are relative changes from the sessions' mean, which the world itself holds.
        is_relative: bool,
    },
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectParameter {
    /// Its name.
    pub name: &'static str,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Value at which the effect does nothing, or where a fit starts.
    pub neutral: f64,
    /// Size that real tables show: the scale of a prior and of finite differences.
    pub scale: f64,
}

/// A coordinate of the point that a camera looks down on.
pub(super) const fn centre(name: &'static str, neutral: f64) -> EffectParameter {
    EffectParameter {
        name,
        unit: "m",
        low: -5.0,
        high: 5.0,
        neutral,
        scale: 0.2,
    }
}

/// Values of an effect's parameters, by name, in the parameters' units.
pub struct Values {
    /// Every one that is listed or given.
    pub(super) all: BTreeMap<String, f64>,
    /// Names of those that the world gives.
    pub(super) given: BTreeSet<String>,
}

impl Values {
    /// Value of a parameter that the effect's specification lists.
    pub fn get(&self, name: &str) -> f64 {
        self.all[name]
    }

    /// Names and values, in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.all.iter().map(|(name, value)| (name.as_str(), *value))
    }

    /// The point that the camera looks down on, in m: the effect's own, so that another rig file changes nothing; the rig's
    /// where the effect does not say.
    pub fn camera_centre(&self, rig: &Rig) -> Point {
        let own = |name: &str, rig: f64| match self.given.contains(name) {
            true => self.get(name),
            false => rig,
        };
        let centre = rig.camera.centre;
        Point::new(own("center_x", centre.x), own("center_y", centre.y))
    }
}
