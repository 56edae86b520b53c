//! What the arm makes of its commands, estimated from its logged state, apart from all that follows.
//!
//! Where the launch that was delivered is known, the rest is diagnosed from it: restitution, camera and table can no longer stand for
//! the arm. What the arm does is a regression of its own, of delivered on commanded speeds and angles, by the formulas of the library's
//! effects of the striker.

use values::{ArmScatter, Point, Split, Strike, arm_scatter, delivered_strikes};
use world::{
    Estimate,
    effects::{self, Origin, effect},
};

use crate::diagnosis::{Diagnosis, NamedEffect, Parameter, Verdict};
use crate::gap;
use crate::model::specification;
use crate::question::Variation;
use crate::{DiagnoseError, Diagnosed, Input};

use forms::Quantity;
use law::{CHANCE, Law, fit};
use unexplained::{Unexplained, unexplained};

mod descent;
mod forms;
mod law;
mod unexplained;

/// Whether an effect is the arm's own: it is estimated here, where the arm's state is known.
pub(crate) fn is_the_arms(name: &str) -> bool {
    effect(name).is_ok_and(|spec| spec.origin == Origin::Arm)
}

/// An arm whose state was logged.
pub(crate) struct Arm {
    laws: Vec<Law>,
    /// What its launches depend on beside them.
    unexplained: Vec<Unexplained>,
    /// The strikes from what was delivered.
    pub(crate) input: Input,
}

impl Arm {
    /// The arm of these strikes; `None` where its state is known of fewer than half.
    pub(crate) fn of(input: &Input) -> Result<Option<Self>, DiagnoseError> {
        let Some(strikes) = delivered_strikes(&input.strikes) else {
            return Ok(None);
        };
        let (judges, fitted): (Vec<&Strike>, Vec<&Strike>) = input
            .strikes
            .iter()
            .filter(|strike| !strike.is_pushed_again())
            .partition(|strike| strike.split == Split::Test);
        let laws = fit(&input.rig, &fitted, &judges)?;
        let unexplained = unexplained(&input.rig, &laws, &[fitted, judges].concat())?;
        let input = Input {
            strikes,
            ..input.clone()
        };
        Ok(Some(Self {
            laws,
            unexplained,
            input,
        }))
    }

    /// What was found from the delivered launches, with what the arm does to its commands.
    pub(crate) fn complete(
        self,
        mut found: Diagnosed,
        input: &Input,
    ) -> Result<Diagnosed, DiagnoseError> {
        let scatter = arm_scatter(&input.strikes);
        let repeatability = self.repeatability(scatter);
        // A world that was fitted here scatters by the impact alone; the identified one by the arm, too.
        let mut impact = found.world.as_ref().unwrap_or(&input.world).scatter;
        match &mut found.world {
            Some(world) => {
                world.scatter.speed = world.scatter.speed.hypot(scatter.speed);
                world.scatter.angle = world.scatter.angle.hypot(scatter.angle);
            }
            None => {
                impact.speed = without(impact.speed, scatter.speed);
                impact.angle = without(impact.angle, scatter.angle);
            }
        }
        let diagnosis = &mut found.diagnosis;
        diagnosis.notes.push(format!(
            "the arm's state is logged: launches were taken as delivered, and scatter by {:.1} % and {:.2}° in the arm, by {:.1} % and \
             {:.2}° at the impact",
            100.0 * repeatability.speed,
            repeatability.angle.to_degrees(),
            100.0 * impact.speed,
            impact.angle.to_degrees()
        ));
        // What was measured stands for nothing else.
        for named in &mut diagnosis.effects {
            named.equivalent.retain(|name| !is_the_arms(name));
            named.rivals.retain(|rival| !is_the_arms(&rival.name));
        }
        if !self.laws.is_empty() {
            self.name_laws(diagnosis)?;
            let world = found.world.get_or_insert_with(|| input.world.clone());
            let added = self.laws.iter().map(|law| law.added.clone());
            world.effects.splice(0..0, added);
        }
        self.tell_unexplained(diagnosis);
        // What a command gives: before, after and the floor hold what the arm makes of it.
        let strikes: Vec<&Strike> = input
            .strikes
            .iter()
            .filter(|strike| !strike.is_pushed_again())
            .collect();
        let before = gap::stop_residuals(&input.rig, &input.world, &strikes)?;
        let after = match &found.world {
            Some(world) => gap::stop_residuals(&input.rig, world, &strikes)?,
            None => before.clone(),
        };
        found.residuals = gap::residuals(&strikes, &before, &after);
        let judges = |residuals: &[_]| gap::of_part(&strikes, residuals, true);
        let by_arm = gap::rms(strikes.iter().map(|strike| {
            let length = strike.path().norm();
            // A stop lies as far as the square of the speed says.
            Point::new(
                2.0 * repeatability.speed * length,
                repeatability.angle * length,
            )
        }));
        let beside = &found.diagnosis.gap;
        let variation = Variation {
            repeats: beside.noise_floor.hypot(by_arm),
            repeats_at_most: beside.noise_floor.hypot(by_arm),
            wander: beside.wander,
            sessions: beside.sessions,
        };
        found.diagnosis.gap = gap::gap(&judges(&before), &judges(&after), variation);
        Ok(found)
    }

    /// By how much repeats of a command differ in what the arm delivers: what launches depend on is no scatter.
    fn repeatability(&self, scatter: ArmScatter) -> ArmScatter {
        let rest = |quantity| {
            let of_it = self.unexplained.iter().filter(|u| u.quantity == quantity);
            let share = of_it.map(|u| u.dependence.share).fold(0.0, f64::max);
            (1.0 - share).sqrt()
        };
        ArmScatter {
            speed: scatter.speed * rest(Quantity::Speed),
            angle: scatter.angle * rest(Quantity::Angle),
        }
    }

    /// Names the laws before what was found beside them.
    fn name_laws(&self, diagnosis: &mut Diagnosis) -> Result<(), DiagnoseError> {
        let statements: Vec<String> = self
            .laws
            .iter()
            .map(|law| effects::statement(&law.added))
            .collect::<Result<_, _>>()?;
        let also = statements.join(", and ");
        diagnosis.summary = match diagnosis.verdict {
            Verdict::Named => format!("{also}, and {}", diagnosis.summary),
            Verdict::Consistent => {
                format!("{also}, by its logged state; beside that there is no gap")
            }
            Verdict::Unexplained => {
                diagnosis.notes.push(
                    "beside what the arm does there is a gap that no candidate explains".into(),
                );
                format!(
                    "{also}, by its logged state; beside that there is {}",
                    diagnosis.summary
                )
            }
        };
        diagnosis.verdict = Verdict::Named;
        for p_value in [&mut diagnosis.p_value, &mut diagnosis.p_value_signs] {
            *p_value = p_value.min(CHANCE);
        }
        let named = self.laws.iter().zip(statements);
        let named: Vec<NamedEffect> = named.map(|(law, text)| named_law(law, text)).collect();
        diagnosis.effects.splice(0..0, named);
        Ok(())
    }

    /// Tells what launches depend on beside the laws: by itself it is a gap that no candidate explains.
    fn tell_unexplained(&self, diagnosis: &mut Diagnosis) {
        let Some(Unexplained {
            dependence: first, ..
        }) = self.unexplained.first()
        else {
            return;
        };
        let all = || self.unexplained.iter().map(|u| u.dependence.clone());
        diagnosis.notes.push(format!(
            "what the arm makes of its commands depends on them as no law of the library does: {}",
            all().map(|d| d.description).collect::<Vec<_>>().join("; ")
        ));
        if diagnosis.verdict == Verdict::Consistent {
            diagnosis.verdict = Verdict::Unexplained;
            diagnosis.summary = format!(
                "the arm errs as no candidate does: {}; beside that there is no gap",
                first.description
            );
            diagnosis.cause = Some(diagnosis.summary.clone());
            (diagnosis.p_value, diagnosis.p_value_signs) = (first.p_value, first.p_value);
        }
        diagnosis.r#where.splice(0..0, all());
    }
}

/// A deviation without one that it was added to.
fn without(total: f64, part: f64) -> f64 {
    (total * total - part * part).max(0.0).sqrt()
}

fn named_law(law: &Law, statement: String) -> NamedEffect {
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
        statement,
        evidence: law.evidence,
        equivalent: Vec::new(),
        rivals: Vec::new(),
    }
}
