//! What the arm makes of its commands, estimated from its logged state, apart from all that follows.
//!
//! Where the launch that was delivered is known, the rest is diagnosed from it: restitution, camera and table can no longer stand for
//! the arm. What the arm does is a regression of its own, of delivered on commanded speeds and angles, by the formulas of the library's
//! effects of the striker.

use std::collections::BTreeMap;

use values::{ArmScatter, Command, Point, Sentence, Split, Strike, arm_scatter, calibrated};
use world::{
    Estimate,
    effects::{self, Effect, Origin, effect},
};

use crate::diagnosis::{Diagnosis, NamedEffect, Parameter, Verdict};
use crate::gap;
use crate::model::{Model, Part, specification};
use crate::notes;
use crate::question::{self, Variation};
use crate::strikes::RESOLVED;
use crate::words::{Note, Summary, WhyNot};
use crate::{DiagnoseError, Diagnosed, Input};

use forms::{Pair, Quantity};
use law::{CHANCE, Law, fit};

mod descent;
mod forms;
mod law;

/// Whether an effect is the arm's own: it is estimated here, where the arm's state is known.
fn is_the_arms(name: &str) -> bool {
    effect(name).is_ok_and(|spec| spec.origin == Origin::Arm)
}

/// An arm whose state was logged.
pub(crate) struct Arm {
    laws: Vec<Law>,
    /// The input with each strike's command replaced by what the arm delivered.
    pub(crate) input: Input,
}

impl Arm {
    /// The arm of these strikes, which were delivered as `strikes` say.
    pub(crate) fn of(input: &Input, strikes: Vec<Strike>) -> Result<Self, DiagnoseError> {
        let fitted = fitted(input);
        let laws = fit(&input.rig, &fitted)?;
        let input = Input {
            strikes,
            ..input.clone()
        };
        Ok(Self { laws, input })
    }

    /// Whether an effect is one of the arm, or the name of a law found here.
    pub(crate) fn does(&self, name: &str) -> bool {
        is_the_arms(name) || self.laws.iter().any(|law| law.name == name)
    }

    pub(crate) fn has_no_law(&self) -> bool {
        self.laws.is_empty()
    }

    /// A model with the laws, as they are.
    pub(crate) fn with_laws(&self, model: Model) -> Model {
        self.laws.iter().fold(model, |model, law| {
            let parameters = law.added.parameters.iter();
            model.with(Part {
                name: law.name,
                parameters: parameters
                    .map(|(name, e)| (name.clone(), e.value))
                    .collect(),
                free: Vec::new(),
                strengths: Vec::new(),
                within: BTreeMap::new(),
                shrinks_to: None,
            })
        })
    }

    /// By how much the laws move the stops of these strikes, root mean square in m.
    pub(crate) fn moves(&self, input: &Input) -> Result<f64, DiagnoseError> {
        let effects = self.effects(input)?;
        let by_laws = |strike: &Strike| {
            let (command, from) = (strike.command, strike.initial);
            let by = effects::deliver(&effects, command, from, &strike.conditions);
            beside(command, by)
        };
        Ok(moved(&fitted(input), by_laws))
    }

    fn effects(&self, input: &Input) -> Result<Vec<Box<dyn Effect>>, DiagnoseError> {
        let laws = self.laws.iter();
        let built = laws.map(|law| effects::build(&law.added, &input.rig));
        Ok(built.collect::<Result<Vec<_>, _>>()?)
    }

    /// Completes a diagnosis made from delivered launches by what the arm does to its commands, about which stops vary so.
    pub(crate) fn complete(
        mut self,
        mut found: Diagnosed,
        input: &Input,
        variation: Variation,
    ) -> Result<Diagnosed, DiagnoseError> {
        let strikes: Vec<&Strike> = input
            .strikes
            .iter()
            .filter(|strike| !strike.is_pushed_again())
            .collect();
        let fitted = fitted(input);
        let beside = self.beside_laws(input)?;
        // A world that was fitted here scatters by the impact alone; the identified one by the arm, too.
        let mut impact = found.world.as_ref().unwrap_or(&input.world).scatter;
        match &mut found.world {
            Some(world) => {
                world.scatter.speed = world.scatter.speed.hypot(beside.speed);
                world.scatter.angle = world.scatter.angle.hypot(beside.angle);
            }
            None => {
                let scatter = arm_scatter(&input.strikes);
                impact.speed = without(impact.speed, scatter.speed);
                impact.angle = without(impact.angle, scatter.angle);
            }
        }
        let diagnosis = &mut found.diagnosis;
        let delivered = Note::Delivered {
            arm: [beside.speed, beside.angle],
            impact: [impact.speed, impact.angle],
        };
        diagnosis.notes.push(delivered.into());
        // What was measured stands for nothing else.
        for named in &mut diagnosis.effects {
            named.equivalent.retain(|name| !is_the_arms(name));
            named.rivals.retain(|rival| !is_the_arms(&rival.name));
        }
        let left_out = self.without_little(input, &fitted, variation.repeats.value)?;
        diagnosis.notes.extend(left_out.map(Sentence::from));
        if !self.laws.is_empty() {
            self.name_laws(diagnosis);
            let world = found.world.get_or_insert_with(|| input.world.clone());
            let added = self.laws.iter().map(|law| law.added.clone());
            world.effects.splice(0..0, added);
        }
        // What a command gives: before, after and the floor hold what the arm makes of it.
        let before = gap::stop_residuals(&input.rig, &input.world, &strikes)?;
        let after = match &found.world {
            Some(world) => gap::stop_residuals(&input.rig, world, &strikes)?,
            None => before.clone(),
        };
        found.residuals = gap::residuals(&strikes, &before, &after);
        let judges = |residuals: &[_]| gap::of_part(&strikes, residuals, true);
        found.diagnosis.gap = gap::gap(&judges(&before), &judges(&after), variation);
        Ok(found)
    }

    /// By how much deliveries differ from what the laws make of their commands, root mean square.
    fn beside_laws(&self, input: &Input) -> Result<ArmScatter, DiagnoseError> {
        let laws = self.effects(input)?;
        let each = input.strikes.iter().zip(calibrated(&input.strikes));
        let fitted = each.filter(|(strike, _)| is_fitted(strike));
        let pairs: Vec<Pair<'_>> = fitted
            .filter_map(|(strike, delivered)| Pair::of(strike, delivered))
            .collect();
        let left = |quantity| {
            let squares = pairs.iter().map(|pair| {
                let predicted = pair.beside(&laws).command;
                pair.difference(quantity, predicted).powi(2)
            });
            (squares.sum::<f64>() / pairs.len().max(1) as f64).sqrt()
        };
        Ok(ArmScatter {
            speed: left(Quantity::Speed),
            angle: left(Quantity::Angle),
        })
    }

    /// Leaves out the laws that move stops by little beside the scatter of repeats (`repeats`, m), and those that change deliveries by less than a
    /// state is read to. Returns a note for each kind left out.
    fn without_little(
        &mut self,
        input: &Input,
        strikes: &[&Strike],
        repeats: f64,
    ) -> Result<impl Iterator<Item = Note> + use<>, DiagnoseError> {
        let (mut little, mut unread) = (Vec::new(), Vec::new());
        for law in std::mem::take(&mut self.laws) {
            let effect = effects::build(&law.added, &input.rig)?;
            let differs = |strike: &Strike| {
                let command = strike.command;
                beside(
                    command,
                    effect.deliver(command, strike.initial, &strike.conditions),
                )
            };
            let is_read = strikes.iter().any(|strike| {
                let by = differs(strike);
                by.speed.abs() > READ.speed || by.angle.abs() > READ.angle
            });
            if !is_read {
                unread.push(law.name);
            } else if moved(strikes, differs) < question::little(repeats, RESOLVED) {
                little.push(law.name);
            } else {
                self.laws.push(law);
            }
        }
        let unread = (!unread.is_empty()).then(|| {
            let ArmScatter { speed, angle } = READ;
            notes::not_named(&unread, WhyNot::Unread { speed, angle })
        });
        Ok(notes::little(&little).into_iter().chain(unread))
    }

    /// Names the laws before what was found beside them.
    fn name_laws(&self, diagnosis: &mut Diagnosis) {
        let named: Vec<NamedEffect> = self.laws.iter().map(named_law).collect();
        let also = self.laws.iter().map(|law| law.added.clone()).collect();
        let summary = diagnosis.summary.clone();
        let summary = match diagnosis.verdict {
            Verdict::Named => Summary::ArmAndNamed(also, summary.into()),
            Verdict::Consistent => Summary::ArmAndConsistent(also),
            Verdict::Unexplained => {
                diagnosis.notes.push(Note::UnexplainedBesideArm.into());
                Summary::ArmAndUnexplained(also, summary.into())
            }
        };
        diagnosis.summary = summary.into();
        diagnosis.verdict = Verdict::Named;
        for p_value in [&mut diagnosis.p_value, &mut diagnosis.p_value_signs] {
            *p_value = p_value.min(CHANCE);
        }
        diagnosis.effects.splice(0..0, named);
    }
}

/// The strikes that fit and choose.
fn fitted(input: &Input) -> Vec<&Strike> {
    let strikes = input.strikes.iter();
    strikes.filter(|strike| is_fitted(strike)).collect()
}

fn is_fitted(strike: &Strike) -> bool {
    strike.split != Split::Test && !strike.is_pushed_again()
}

/// Error of reading a delivery off the arm's logged states, which come every few milliseconds of a plateau that may last no longer.
const READ: ArmScatter = ArmScatter {
    speed: 0.005,
    angle: 0.002,
};

/// By how much a delivery differs from its command.
fn beside(command: Command, by: Command) -> ArmScatter {
    ArmScatter {
        speed: by.speed / command.speed.max(1e-9) - 1.0,
        angle: by.angle - command.angle,
    }
}

/// Root mean square motion of stops, in m, for launches that differ by `differs`: the distance goes as the square of the speed.
fn moved(strikes: &[&Strike], differs: impl Fn(&Strike) -> ArmScatter) -> f64 {
    gap::rms(strikes.iter().map(|strike| {
        let (length, by) = (strike.path().norm(), differs(strike));
        Point::new(2.0 * by.speed * length, by.angle * length)
    }))
}

/// A standard deviation less an independent part of it: √(total² − part²).
fn without(total: f64, part: f64) -> f64 {
    (total * total - part * part).max(0.0).sqrt()
}

fn named_law(law: &Law) -> NamedEffect {
    let parameter = |(name, estimate): (&String, &Estimate)| {
        let parameter = Parameter {
            value: estimate.value,
            low: estimate.low.unwrap_or(estimate.value),
            high: estimate.high.unwrap_or(estimate.value),
            unit: specification(law.name, name).unit.to_string(),
        };
        (name.clone(), parameter)
    };
    NamedEffect {
        name: law.added.name.clone(),
        parameters: law.added.parameters.iter().map(parameter).collect(),
        statement: law.added.clone().into(),
        evidence: law.evidence,
        equivalent: Vec::new(),
        rivals: Vec::new(),
    }
}
