//! The effects that a world can hold beyond its parameters: each one file of the same shape.
//!
//! An effect has parameters (name, unit, range, prior scale), acts in one or more of four places (the command, the
//! model of the impact, friction and force during the slide, the measurement), and states a fitted value to a person.

mod table_tilt;
mod viscous_drag;

use std::collections::BTreeMap;

use values::{Command, Conditions, Point, Rig};

use crate::{AddedEffect, WorldError, world::in_range};

/// One kind of effect.
pub struct EffectSpec {
    /// Name in `world.toml`, `diagnosis.json` and on the command line.
    pub name: &'static str,
    /// Its parameters.
    pub parameters: &'static [EffectParameter],
    /// What it stands for, and where the formula comes from.
    pub source: &'static str,
    /// Makes it act.
    pub build: fn(&Values, &Rig) -> Box<dyn Effect>,
    /// One sentence that states fitted values to a person.
    pub statement: fn(&Values) -> String,
}

impl EffectSpec {
    /// Its parameter of that name.
    pub fn parameter(&self, name: &str) -> Option<EffectParameter> {
        self.parameters.iter().copied().find(|p| p.name == name)
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
}

/// Values of an effect's parameters, by name, in the parameters' units.
pub struct Values(BTreeMap<String, f64>);

impl Values {
    /// Value of a parameter that the effect's specification lists.
    pub fn get(&self, name: &str) -> f64 {
        self.0[name]
    }
}

/// The object while it slides.
#[derive(Clone, Copy, Debug)]
pub struct Slide<'a> {
    /// Centre in m.
    pub position: Point,
    /// Velocity in m/s.
    pub velocity: Point,
    /// Deceleration by dry friction alone, μ·g of the world without effects, in m/s².
    pub dry: f64,
    /// When and in which session.
    pub conditions: &'a Conditions,
}

/// What an effect does; each place does nothing unless the effect says otherwise.
pub trait Effect: Send + Sync {
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
pub const EFFECTS: &[&EffectSpec] = &[&viscous_drag::SPEC, &table_tilt::SPEC];

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

/// Values of an added effect, each parameter known and in range; parameters left out are neutral.
pub fn values(added: &AddedEffect) -> Result<Values, WorldError> {
    let spec = effect(&added.name)?;
    if let Some(name) = added
        .parameters
        .keys()
        .find(|name| spec.parameters.iter().all(|p| p.name != *name))
    {
        return Err(WorldError::UnknownParameter {
            name: format!("{}.{name}", added.name),
            hint: String::new(),
            known: spec
                .parameters
                .iter()
                .map(|p| p.name)
                .collect::<Vec<_>>()
                .join(", "),
        });
    }
    let mut values = BTreeMap::new();
    for p in spec.parameters {
        let value = added
            .parameters
            .get(p.name)
            .map_or(p.neutral, |estimate| estimate.value);
        in_range(
            &format!("{}.{}", added.name, p.name),
            value,
            p.low,
            p.high,
            p.unit,
        )?;
        values.insert(p.name.to_string(), value);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Estimate, Simulated, Simulator, World};
    use values::Shape;

    const FRICTION: f64 = 0.25;

    /// A strike of the demo's cylinder along +x·angle in a world with one effect, or none.
    fn strike(effect: Option<(&str, &[(&str, f64)])>, speed: f64, angle: f64) -> Simulated {
        let rig = Rig::demo(Shape::Cylinder);
        let mut world = World::nominal(&rig)
            .with("friction", FRICTION)
            .with("fluid_blunt_drag", 0.0);
        world = world.with("fluid_slender_drag", 0.0);
        world.effects.extend(effect.map(|(name, parameters)| {
            AddedEffect {
                name: name.into(),
                parameters: parameters
                    .iter()
                    .map(|(name, value)| (name.to_string(), Estimate::fixed(*value)))
                    .collect(),
            }
        }));
        let simulator = Simulator::new(&rig, &world).expect("a valid world");
        let command = Command { speed, angle };
        simulator
            .worker()
            .strike(Point::new(0.25, 0.05), command, &Conditions::default())
            .expect("rests")
    }

    /// The effect moves the track by more than a millimetre.
    pub(super) fn assert_changes_track(name: &str, parameters: &[(&str, f64)]) {
        let (without, with) = (
            strike(None, 0.9, 0.2),
            strike(Some((name, parameters)), 0.9, 0.2),
        );
        let moved = without.stop.distance(with.stop);
        assert!(moved > 1e-3, "{name} moves the stop by {moved} m");
    }

    /// Distance (m) slid after the tip let go, dry deceleration (m/s²) and speed of release (m/s) with an effect.
    pub(super) fn slide_distance(
        name: &str,
        parameters: &[(&str, f64)],
        speed: f64,
        angle: f64,
    ) -> (f64, f64, f64) {
        let simulated = strike(Some((name, parameters)), speed, angle);
        let (from, dry) = (0.02, FRICTION * 9.81);
        // The speed a little after release, from two neighbouring samples; slid from their middle.
        let (before, after) = (simulated.at(from - 0.001), simulated.at(from + 0.001));
        let release = before.distance(after) / 0.002;
        (simulated.stop.distance(simulated.at(from)), dry, release)
    }

    #[test]
    fn every_effect_is_known_by_its_name_and_neutral_does_nothing() {
        let without = strike(None, 0.8, 0.1);
        for spec in EFFECTS {
            assert_eq!(effect(spec.name).expect("listed").name, spec.name);
            let neutral = strike(Some((spec.name, &[])), 0.8, 0.1);
            assert!(without.stop.distance(neutral.stop) < 1e-6, "{}", spec.name);
        }
    }
}
