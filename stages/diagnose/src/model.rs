//! A world in few numbers: friction, restitution, clock, what wrong sizes of a box do, and the free parameters of the effects added.

use std::collections::BTreeMap;

use values::Rig;
use world::{
    AddedEffect, Base, Estimate, ParameterSpec, WorldError,
    effects::{self, Effect, EffectParameter, Parameters},
    parameter,
};

use crate::{
    Thresholds,
    load_shift::LoadShift,
    wrong_sizes::{self, TipFriction, WrongSizes},
};

/// One number that a fit may change.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FreeParameter {
    /// Which effect of the model, and its parameter; none for the numbers that are the world's own.
    pub(crate) of: Option<(usize, String)>,
    /// Whether this parameter is the strength of an effect.
    pub(crate) is_strength: bool,
    /// Step of the finite differences.
    pub(crate) step: f64,
    /// Least and greatest value.
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// Where a prior is centred, and its standard deviation: wide, but for what wrong sizes do.
    pub(crate) centre: f64,
    pub(crate) width: f64,
}

/// Places of the numbers that every model has.
pub(crate) const FRICTION: usize = 0;
pub(crate) const RESTITUTION: usize = 1;
pub(crate) const CLOCK: usize = 2;
/// Place of the share by which launch angles are off where sizes are wrong: every model of a box has it.
const SIZES: usize = 3;
/// Place of the logarithm of a factor on the tip's friction, which a box that is struck aslant shows where the tip slips.
const TIP_FRICTION: usize = 4;
/// Place of the part of a box's load that shifts to its front as it brakes.
pub(crate) const LOAD_SHIFT: usize = 5;

/// An effect in a model: some parameters free, the others fixed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub(crate) name: &'static str,
    /// All of its parameters that are not neutral, by name; those that are free here start here.
    pub(crate) parameters: BTreeMap<String, f64>,
    /// Names of the free parameters.
    pub(crate) free: Vec<String>,
    /// Names of the free parameters that say how strong the effect is.
    pub(crate) strengths: Vec<String>,
    /// Ranges narrower than the library's, where these strikes say nothing beyond.
    pub(crate) within: BTreeMap<String, (f64, f64)>,
    /// Standard deviation about neutral that its strengths are drawn towards, for an effect of many.
    pub(crate) shrinks_to: Option<f64>,
}

/// A world with effects, and what of it is free.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) parts: Vec<Part>,
    pub(crate) free: Vec<FreeParameter>,
    /// Friction, restitution, clock (s), for a box the share of its wrong sizes, the tip's friction and the part of its load that shifts, then the
    /// free parameters of the parts in order.
    pub(crate) values: Vec<f64>,
}

/// Factor by which friction may differ from where it was identified.
const FURTHEST: f64 = 5.0;
/// Least change of friction that its range allows: where friction is next to nothing, drag may have been taken for it.
const LEAST: f64 = 0.05;
/// Least friction from which the step of friction's finite difference is taken.
const LEAST_STEPPED: f64 = 0.01;
/// How many scales wide the prior of an effect's parameter is: wide enough to move no estimate that the data determine.
pub(crate) const PRIOR: f64 = 20.0;
/// Share of a range within which its end is reached.
const EDGE: f64 = 1e-3;
/// Steps of finite differences, as a share of a parameter's scale.
const STEP: f64 = 0.05;
/// Logarithm by which the tip's friction may differ from where it was identified, effects left out, and the standard deviation of its prior.
const TIP_FRICTIONS: (f64, f64) = (0.7, 0.3);
/// Step of the finite difference by the logarithm of the tip's friction: small, for a launch bends much where a tip begins to slip.
const STEP_OF_TIP_FRICTION: f64 = 0.001;
/// Greatest part of a box's load that may shift, to either side of none, and the standard deviation of its prior.
const LOAD_SHIFTS: (f64, f64) = (2.0, 1.0);
/// Step of the finite difference by the part of the load that shifts.
const STEP_OF_LOAD_SHIFT: f64 = 0.1;
/// Step of the finite difference by the share of wrong sizes.
const STEP_OF_SHARE: f64 = 0.005;

impl Model {
    /// A model without effects: friction and restitution as given, the clock late by half a frame, the sizes of the rig file.
    pub(crate) fn plain(
        friction: f64,
        restitution: f64,
        rig: &Rig,
        thresholds: &Thresholds,
    ) -> Self {
        let frame = 1.0 / rig.camera.rate;
        let base = |step, low, high, centre, width| FreeParameter {
            of: None,
            is_strength: false,
            step,
            low,
            high,
            centre,
            width,
        };
        let (frictions, restitutions) =
            (world_parameter("friction"), world_parameter("restitution"));
        let mut model = Self {
            parts: Vec::new(),
            free: vec![
                base(
                    0.01 * friction.max(LEAST_STEPPED),
                    (friction / FURTHEST)
                        .min(friction - LEAST)
                        .max(frictions.low),
                    (friction * FURTHEST).clamp(LEAST, frictions.high),
                    friction,
                    10.0,
                ),
                base(0.01, restitutions.low, restitutions.high, restitution, 10.0),
                base(0.05 * frame, -2.0 * frame, 3.0 * frame, 0.5 * frame, 10.0),
            ],
            values: vec![friction, restitution, 0.5 * frame],
        };
        if let Some(sensitivity) = wrong_sizes::sensitivity(rig) {
            let scatter = thresholds.wrong_sizes * sensitivity;
            let most = thresholds.believed_sizes * scatter;
            let share = base(STEP_OF_SHARE, -most, most, 0.0, scatter);
            model.free.push(share);
            model.values.push(0.0);
            let (most, width) = TIP_FRICTIONS;
            let friction = base(STEP_OF_TIP_FRICTION, -most, most, 0.0, width);
            model.free.push(friction);
            model.values.push(0.0);
            let (most, width) = LOAD_SHIFTS;
            let shift = base(STEP_OF_LOAD_SHIFT, -most, most, 0.0, width);
            model.free.push(shift);
            model.values.push(0.0);
        }
        model
    }

    /// How many of its numbers are the world's own, before those of effects.
    fn own(&self) -> usize {
        self.free
            .iter()
            .take_while(|free| free.of.is_none())
            .count()
    }

    /// Place of the share by which launch angles are off where sizes are wrong; none for a round object.
    pub(crate) fn sizes(&self) -> Option<usize> {
        (self.own() > SIZES).then_some(SIZES)
    }

    /// Place of the logarithm of the factor on the tip's friction; none for a round object, which is struck through its centre.
    pub(crate) fn tip_friction(&self) -> Option<usize> {
        self.sizes().map(|_| TIP_FRICTION)
    }

    /// Log-density of the priors of what a box alone has, less that at zero; other priors move no value that the data determine.
    pub(crate) fn log_prior(&self) -> f64 {
        let of_a_box = SIZES..self.own().max(SIZES);
        of_a_box
            .map(|place| -0.5 * (self.values[place] / self.free[place].width).powi(2))
            .sum()
    }

    /// This model with one more effect. With a law of restitution, restitution may not be negative: an object would leave slower than the tip that
    /// struck it, and the law would stand for what the arm delivers.
    pub(crate) fn with(&self, part: Part) -> Self {
        let mut model = self.clone();
        let place = model.parts.len();
        if effects::effect(part.name).is_ok_and(|spec| spec.family.is_of_restitution()) {
            model.free[RESTITUTION].low = 0.0;
            model.values[RESTITUTION] = model.values[RESTITUTION].max(0.0);
        }
        for name in &part.free {
            let spec = specification(part.name, name);
            let value = part.parameters.get(name).copied().unwrap_or(spec.neutral);
            let (low, high) = part
                .within
                .get(name)
                .copied()
                .unwrap_or((spec.low, spec.high));
            let is_strength = part.strengths.contains(name);
            let (centre, width) = match part.shrinks_to {
                Some(width) if is_strength => (spec.neutral, width),
                _ if spec.is_detail => (spec.neutral, spec.scale),
                _ => (value, PRIOR * spec.scale),
            };
            model.free.push(FreeParameter {
                of: Some((place, name.clone())),
                is_strength,
                step: STEP * spec.scale,
                low,
                high,
                centre,
                width,
            });
            model.values.push(value.clamp(low, high));
        }
        model.parts.push(part);
        model
    }

    /// This model without the effect at `place`, the others at their present values.
    pub(crate) fn without(&self, place: usize) -> Self {
        let mut parts = self.fitted_parts(&self.values);
        parts.remove(place);
        self.of(parts)
    }

    /// This model with the details free of the effects at places that `has_form` holds for; `None` where these have none.
    pub(crate) fn with_details(&self, has_form: impl Fn(usize) -> bool) -> Option<Self> {
        let mut parts = self.fitted_parts(&self.values);
        for (_, part) in parts.iter_mut().enumerate().filter(|(i, _)| has_form(*i)) {
            let details: Vec<String> = details(part.name)
                .map(|detail| detail.name.to_string())
                .filter(|name| !part.free.contains(name))
                .collect();
            part.free.extend(details);
        }
        let model = self.of(parts);
        (model.free.len() > self.free.len()).then_some(model)
    }

    /// This world's own numbers with these effects.
    fn of(&self, parts: Vec<Part>) -> Self {
        let mut plain = Self {
            parts: Vec::new(),
            free: self.free[..self.own()].to_vec(),
            values: self.values[..self.own()].to_vec(),
        };
        plain.free[RESTITUTION].low = world_parameter("restitution").low;
        parts
            .into_iter()
            .fold(plain, |model, part| model.with(part))
    }

    /// The parts with the free parameters at these values.
    pub(crate) fn fitted_parts(&self, values: &[f64]) -> Vec<Part> {
        let mut parts = self.parts.clone();
        for (free, value) in self.free.iter().zip(values) {
            if let Some((place, name)) = &free.of {
                parts[*place].parameters.insert(name.clone(), *value);
            }
        }
        parts
    }

    /// Friction or restitution that lies at an end of its range: its name and value. The data then want what no world has.
    pub(crate) fn world_at_end(&self) -> Option<(&'static str, f64)> {
        [("friction", FRICTION), ("restitution", RESTITUTION)]
            .into_iter()
            .find(|(_, place)| self.is_at_end(*place, 0.0))
            .map(|(name, place)| (name, self.values[place]))
    }

    /// Whether no effect is as strong as its range allows: one that would be stronger still stands for something else.
    pub(crate) fn is_possible(&self) -> bool {
        (0..self.free.len()).all(|i| !self.free[i].is_strength || !self.is_at_end(i, 0.0))
    }

    /// The parameters of effects' forms (a place, a radius, a speed): the value's place, the effect's, and the name. One whose range
    /// ends at its neutral value is left out: no limit is met there, the form becomes a simpler one. So is a detail, which its prior holds.
    pub(crate) fn forms(&self) -> impl Iterator<Item = (usize, usize, &str)> {
        self.free.iter().enumerate().filter_map(|(i, free)| {
            let (part, name) = free.of.as_ref().filter(|_| !free.is_strength)?;
            let spec = specification(self.parts[*part].name, name);
            let is_limited =
                !spec.is_detail && spec.neutral != spec.low && spec.neutral != spec.high;
            is_limited.then_some((i, *part, name.as_str()))
        })
    }

    /// Whether a value lies at an end of its range, or no farther from it than `margin`.
    pub(crate) fn is_at_end(&self, i: usize, margin: f64) -> bool {
        let (free, value) = (&self.free[i], self.values[i]);
        let margin = margin.max(EDGE * (free.high - free.low));
        value < free.low + margin || value > free.high - margin
    }

    /// The effects at these values, and what a box alone has.
    pub(crate) fn effects(
        &self,
        rig: &Rig,
        values: &[f64],
    ) -> Result<Vec<Box<dyn Effect>>, WorldError> {
        let parts = self.fitted_parts(values);
        let effects = parts.iter().map(|part| effects::build(&added(part), rig));
        let mut effects = effects.collect::<Result<Vec<_>, WorldError>>()?;
        if self.sizes().is_some() {
            effects.push(Box::new(WrongSizes {
                share: values[SIZES],
            }));
            effects.push(Box::new(TipFriction {
                log: values[TIP_FRICTION],
            }));
            effects.push(Box::new(LoadShift {
                part: values[LOAD_SHIFT],
                height: rig.object.solid.half_height(),
                arm: Base::of(&rig.object).arm(),
            }));
        }
        Ok(effects)
    }
}

/// Range of a parameter of every world.
fn world_parameter(name: &str) -> &'static ParameterSpec {
    parameter(name).expect("every world has friction and restitution")
}

/// A part as an effect of `world.toml`, without intervals.
pub(crate) fn added(part: &Part) -> AddedEffect {
    AddedEffect {
        name: part.name.into(),
        parameters: part
            .parameters
            .iter()
            .map(|(name, value)| (name.clone(), Estimate::fixed(*value)))
            .collect(),
    }
}

/// Whether an effect's form has details.
pub(crate) fn has_details(effect: &str) -> bool {
    details(effect).next().is_some()
}

/// The details of an effect's form.
fn details(effect: &str) -> impl Iterator<Item = &'static EffectParameter> {
    let listed = match effects::effect(effect).map(|spec| spec.parameters) {
        Ok(Parameters::Listed(listed)) => listed,
        _ => &[],
    };
    listed.iter().filter(|parameter| parameter.is_detail)
}

/// Specification of an effect's parameter.
pub(crate) fn specification(effect: &str, parameter: &str) -> EffectParameter {
    effects::effect(effect)
        .ok()
        .and_then(|spec| spec.parameter(parameter).copied())
        .expect("a candidate names an effect and a parameter of the library")
}

#[cfg(test)]
mod tests {
    use values::Shape;

    use super::*;

    /// An effect as it begins, nothing of it free.
    fn part(name: &'static str) -> Part {
        Part {
            name,
            parameters: BTreeMap::new(),
            free: Vec::new(),
            strengths: Vec::new(),
            within: BTreeMap::new(),
            shrinks_to: None,
        }
    }

    #[test]
    fn no_fit_leaves_what_a_world_may_have() {
        for friction in [0.03, 0.3, 0.9] {
            let rig = Rig::demo(Shape::Cylinder);
            let mut model = Model::plain(friction, 0.5, &rig, &Thresholds::default());
            let free = model.free[FRICTION].clone();
            let range = world_parameter("friction");
            assert!(range.low <= free.low && free.high <= range.high, "{free:?}");
            assert_eq!(model.world_at_end(), None);
            model.values[FRICTION] = free.high;
            assert_eq!(model.world_at_end(), Some(("friction", free.high)));
        }
        // What drag does on a table without friction was taken for friction.
        let rig = Rig::demo(Shape::Cylinder);
        let air = Model::plain(0.026, 0.8, &rig, &Thresholds::default());
        assert_eq!(air.free[FRICTION].low, 0.0);
    }

    #[test]
    fn details_are_freed_once_and_where_they_are_asked_for() {
        let rig = Rig::demo(Shape::Cylinder);
        let plain = Model::plain(0.2, 0.5, &rig, &Thresholds::default());
        assert!(
            plain
                .with(part("table_tilt"))
                .with_details(|_| true)
                .is_none()
        );
        let held = plain.with(part("friction_patch"));
        let (all, none) = (held.with_details(|_| true), held.with_details(|_| false));
        let all = all.expect("a patch has details");
        assert_eq!(all.free.len(), held.free.len() + 4);
        assert!(none.is_none() && all.with_details(|_| true).is_none());
    }

    #[test]
    fn a_law_of_restitution_needs_a_restitution() {
        let rig = Rig::demo(Shape::Cylinder);
        let plain = Model::plain(0.2, -0.1, &rig, &Thresholds::default());
        let below = |model: &Model| model.free[RESTITUTION].low < 0.0;
        for name in ["speed_dependent_restitution", "restitution_drift"] {
            let with = plain.with(part(name));
            assert_eq!(with.values[RESTITUTION], 0.0, "{name}");
            assert!(!below(&with) && below(&with.without(0)), "{name}");
        }
        // An arm that delivers less than it is told moves objects as a restitution below nothing would.
        let arm = plain.with(part("striker_speed_error"));
        assert!(below(&arm) && arm.values[RESTITUTION] < 0.0);
    }
}
