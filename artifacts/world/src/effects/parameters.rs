//! The parameters of an effect: names, units and ranges, and the values that a world gives them.

use std::{
    collections::{BTreeMap, BTreeSet},
    f64::consts::PI,
};

use values::{Point, Rig};

/// How the parameters of an effect are named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameters {
    /// The listed parameters; one left out is neutral.
    Listed(&'static [EffectParameter]),
    /// One parameter of one kind for each session, named as [`values::Conditions::session`]; sessions are draws ([`super::Population`]).
    BySession {
        /// Unit, range and scale of each parameter.
        parameter: EffectParameter,
        /// Whether values are relative changes from the sessions' mean, which the world itself holds.
        is_relative: bool,
    },
}

impl Parameters {
    /// The parameter of that name; where parameters are named by session, every name is one.
    pub fn get(&self, name: &str) -> Option<&EffectParameter> {
        match self {
            Self::Listed(listed) => listed.iter().find(|p| p.name == name),
            Self::BySession { parameter, .. } => Some(parameter),
        }
    }
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
    /// Whether it is a detail of the form: no evidence for a name, and freed only once names are known, so that the intervals of the others hold it.
    /// Its scale is then the standard deviation of its prior about neutral.
    pub is_detail: bool,
}

impl EffectParameter {
    /// A parameter that does nothing at 0, from `low` to `high`.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        [low, high]: [f64; 2],
        scale: f64,
    ) -> Self {
        Self {
            name,
            unit,
            low,
            high,
            neutral: 0.0,
            scale,
            is_detail: false,
        }
    }

    /// This parameter with another neutral value: where the effect does nothing, or a fit starts.
    pub const fn neutral_at(self, neutral: f64) -> Self {
        Self { neutral, ..self }
    }

    /// This parameter as a detail of the form.
    pub const fn as_detail(self) -> Self {
        Self {
            is_detail: true,
            ..self
        }
    }
}

/// The direction of a line's normal, from +x.
pub(super) const fn direction() -> EffectParameter {
    EffectParameter::new("direction", "rad", [-PI, PI], 0.3)
}

/// A coordinate of the middle of something on the table.
pub(super) const fn middle(name: &'static str, neutral: f64) -> EffectParameter {
    EffectParameter::new(name, "m", [-5.0, 5.0], 0.1).neutral_at(neutral)
}

/// A coordinate of a point that is given and not fitted: where a camera looks down, or from where a line is measured.
pub(super) const fn centre(name: &'static str, neutral: f64) -> EffectParameter {
    EffectParameter::new(name, "m", [-5.0, 5.0], 0.2).neutral_at(neutral)
}

/// Values of an effect's parameters, by name, in the parameters' units.
pub struct Values {
    /// Values of all parameters listed or given, by name.
    pub(super) all: BTreeMap<String, f64>,
    /// Names of the parameters that the world gives.
    pub(super) given: BTreeSet<String>,
}

impl Values {
    /// Value of a parameter that the effect's specification lists.
    pub fn get(&self, name: &str) -> f64 {
        self.all[name]
    }

    /// Value of a parameter, where the world gives it.
    pub fn given(&self, name: &str) -> Option<f64> {
        self.given.contains(name).then(|| self.get(name))
    }

    /// Names and values, in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.all.iter().map(|(name, value)| (name.as_str(), *value))
    }

    /// The place (`center_x`, `center_y`) in m.
    pub fn centre(&self) -> Point {
        Point::new(self.get("center_x"), self.get("center_y"))
    }

    /// The point, in m, of a line that is nearest to the one from which its `offset` is measured along its `direction`.
    pub fn line_foot(&self) -> Point {
        self.centre() + Point::polar(self.get("offset"), self.get("direction"))
    }

    /// The point that the camera looks down on, in m: the effect's own, so that another rig file changes nothing; the rig's
    /// where the effect does not say.
    pub fn camera_centre(&self, rig: &Rig) -> Point {
        let centre = rig.camera.centre;
        Point::new(
            self.given("center_x").unwrap_or(centre.x),
            self.given("center_y").unwrap_or(centre.y),
        )
    }
}
