//! The effects that a world can hold beyond its parameters: each one file of the same shape.
//!
//! An effect has parameters (name, unit, range, prior scale), acts in one or more of four places (the command, the
//! model of the impact, friction and force during the slide, the measurement), and states a fitted value to a person.

mod anisotropic_friction;
mod camera_distortion;
mod camera_rotation;
mod friction_by_session;
mod friction_drift;
mod friction_patch;
mod off_centre_contact;
mod quadratic_drag;
mod speed_dependent_restitution;
mod speed_weakening_friction;
mod striker_angle_bias;
mod striker_speed_error;
mod table_bowl;
mod table_tilt;
#[cfg(test)]
mod tests;
mod viscous_drag;
mod wording;

use std::collections::BTreeMap;

use values::{Command, Conditions, Point, Rig};

use crate::{AddedEffect, WorldError, world::in_range};

const GRAVITY: f64 = 9.81;
/// In m, far below what any camera sees and well above the rounding of a position.
const UNOBSERVE_TOLERANCE: f64 = 1e-13;
/// Enough for the most distorted lens of the library, each step of which takes away a third of the error.
const UNOBSERVE_STEPS: u32 = 100;

/// One kind of effect.
pub struct EffectSpec {
    /// Name in `world.toml`, `diagnosis.json` and on the command line.
    pub name: &'static str,
    /// Its parameters.
    pub parameters: Parameters,
    /// Effects that do the same to the centroid tracks of one round object and one striker, or so nearly that strikes
    /// within a robot's limits do not tell them apart: named with it, never instead of it.
    pub equivalent: &'static [&'static str],
    /// What it stands for, and where the formula comes from.
    pub source: &'static str,
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
            Parameters::BySession(parameter) => Some(parameter),
        }
    }
}

/// How the parameters of an effect are named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameters {
    /// These; one left out is neutral.
    Listed(&'static [EffectParameter]),
    /// One of this kind for each session, named as [`Conditions::session`]; a session left out is neutral.
    BySession(EffectParameter),
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

/// Values of an effect's parameters, by name, in the parameters' units.
pub struct Values(BTreeMap<String, f64>);

impl Values {
    /// Value of a parameter that the effect's specification lists.
    pub fn get(&self, name: &str) -> f64 {
        self.0[name]
    }

    /// Names and values, in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(name, value)| (name.as_str(), *value))
    }
}

/// The object while it slides.
#[derive(Clone, Copy, Debug)]
pub struct Slide<'a> {
    /// Centre in m.
    pub position: Point,
    /// Velocity in m/s.
    pub velocity: Point,
    /// Deceleration by dry friction alone, in m/s²: μ·g of the world without effects for [`Effect::friction_factor`], and
    /// that times the factors of all effects for [`Effect::acceleration`].
    pub dry: f64,
    /// When and in which session.
    pub conditions: &'a Conditions,
}

/// Where an effect acts, so that a simulation need ask it nowhere else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// On the command or the impact.
    Launch,
    /// On friction or force, by a strike's conditions alone: the same all through one slide.
    Strike,
    /// On friction or force, by where the object is and how fast.
    Slide,
    /// On the measurement.
    Camera,
}

/// What an effect does; each place does nothing unless the effect says otherwise.
pub trait Effect: Send + Sync {
    /// Where it acts; everywhere else it does nothing.
    fn acts(&self) -> Acts;

    /// The command that the arm delivers in place of the one it was given.
    fn deliver(&self, command: Command) -> Command {
        command
    }

    /// Lateral offset of the tip's line, in m to the left of the direction of approach.
    fn tip_offset(&self) -> f64 {
        0.0
    }

    /// Factor on restitution at an impact speed in m/s.
    fn restitution_factor(&self, _impact_speed: f64) -> f64 {
        1.0
    }

    /// Factor on the friction between object and table.
    fn friction_factor(&self, _slide: &Slide<'_>) -> f64 {
        1.0
    }

    /// Distance in m within which what it does on the table is smooth, from an object's centre at `position`.
    fn stretch(&self, _position: Point) -> f64 {
        f64::INFINITY
    }

    /// Force on the object per unit mass, in m/s².
    fn acceleration(&self, _slide: &Slide<'_>) -> Point {
        Point::default()
    }

    /// Where the camera sees an object that is at `point`, in m.
    fn observe(&self, point: Point) -> Point {
        point
    }
}

/// The library.
pub const EFFECTS: &[&EffectSpec] = &[
    &viscous_drag::SPEC,
    &quadratic_drag::SPEC,
    &speed_weakening_friction::SPEC,
    &anisotropic_friction::SPEC,
    &friction_patch::SPEC,
    &friction_drift::SPEC,
    &friction_by_session::SPEC,
    &table_tilt::SPEC,
    &table_bowl::SPEC,
    &striker_speed_error::SPEC,
    &striker_angle_bias::SPEC,
    &speed_dependent_restitution::SPEC,
    &off_centre_contact::SPEC,
    &camera_rotation::SPEC,
    &camera_distortion::SPEC,
];

/// The effect of that name; the error lists the valid ones.
pub fn effect(name: &str) -> Result<&'static EffectSpec, WorldError> {
    EFFECTS
        .iter()
        .copied()
        .find(|spec| spec.name == name)
        .ok_or_else(|| WorldError::UnknownEffect {
            name: name.into(),
            known: EFFECTS
                .iter()
                .map(|spec| spec.name)
                .collect::<Vec<_>>()
                .join(", "),
        })
}

/// Values of an added effect, each parameter known and in range; listed parameters left out are neutral.
pub fn values(added: &AddedEffect) -> Result<Values, WorldError> {
    let spec = effect(&added.name)?;
    let listed = match spec.parameters {
        Parameters::Listed(listed) => listed,
        Parameters::BySession(_) => &[],
    };
    let mut values: BTreeMap<String, f64> = listed
        .iter()
        .map(|p| (p.name.to_string(), p.neutral))
        .collect();
    for (name, estimate) in &added.parameters {
        let full = format!("{}.{name}", added.name);
        let Some(p) = spec.parameter(name) else {
            let known: Vec<_> = listed.iter().map(|p| p.name).collect();
            return Err(WorldError::UnknownParameter {
                name: full,
                hint: String::new(),
                known: known.join(", "),
            });
        };
        in_range(&full, estimate.value, p.low, p.high, p.unit)?;
        values.insert(name.clone(), estimate.value);
    }
    Ok(Values(values))
}

/// Whether an added effect is known and its values lie in their ranges.
pub fn check(added: &AddedEffect) -> Result<(), WorldError> {
    values(added).map(|_| ())
}

/// Makes an added effect act.
pub fn build(added: &AddedEffect, rig: &Rig) -> Result<Box<dyn Effect>, WorldError> {
    Ok((effect(&added.name)?.build)(&values(added)?, rig))
}

/// Makes it a sentence.
pub fn statement(added: &AddedEffect) -> Result<String, WorldError> {
    Ok((effect(&added.name)?.statement)(&values(added)?))
}

/// What the arm makes of a command with these effects.
pub fn deliver(effects: &[Box<dyn Effect>], command: Command) -> Command {
    effects
        .iter()
        .fold(command, |command, effect| effect.deliver(command))
}

/// Where the camera sees an object that is at `point` (m), with these effects.
pub fn observe(effects: &[Box<dyn Effect>], point: Point) -> Point {
    effects
        .iter()
        .fold(point, |seen, effect| effect.observe(seen))
}

/// Where an object is that the camera sees at `seen` (m): a fixed point, for the measurement changes little.
pub fn unobserve(effects: &[Box<dyn Effect>], seen: Point) -> Point {
    let mut point = seen;
    for _ in 0..UNOBSERVE_STEPS {
        let error = seen - observe(effects, point);
        point = point + error;
        if error.norm() < UNOBSERVE_TOLERANCE {
            break;
        }
    }
    point
}
