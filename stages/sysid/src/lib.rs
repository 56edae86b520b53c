//! System identification: the world's parameters from the tracks of strikes.
//!
//! Stop distance alone goes as (1+e)²/μ and cannot distinguish friction from restitution; tracks can. Each strike's launch scatters in speed and
//! angle, so the strike is the unit of evidence: residuals are weighed by Σ = σ²I + σ_v²·J_v·J_vᵀ + σ_θ²·J_θ·J_θᵀ + …, the scatter is estimated along
//! with the parameters (EM), and intervals come from how strikes differ. What turns or delays every strike alike is fitted beside the parameters and
//! reported in a note: it is no scatter, and it does not move the world. Gauss–Newton on large-step central differences starts from a line through
//! √(D − d(t)), which needs no simulation; NLopt's polish and the paper's Algorithm 2 are in [`algorithm2`].

pub mod algorithm2;
mod compare;
mod error;
mod fit;
mod huber;
mod identify;
mod interval;
mod notes;
mod pushes;
mod scatter;
mod sizes;
mod slip;
mod slopes;
mod start;
mod wander;
mod wanted;

pub use error::SysidError;
pub use notes::{Note, Scattering};

use std::{borrow::Cow, collections::BTreeSet};

use compare::{Launch, StrikeSimulator};
use identify::Identifiability;
use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Deliveries, Rig, Sentence, Shape, Solid, Split, Strays, Strike, arm_scatter};
use world::{Estimate, World, parameter};

/// How to identify.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sysid {
    /// Parameters to free; empty: friction, restitution and, for a box or a ball, one more if the data determine it, with notes
    /// on what they cannot determine.
    pub free: Vec<String>,
    /// The earliest strikes that learn, at most this many: later ones do not move the world under the solutions.
    pub most_strikes: usize,
}

impl Default for Sysid {
    fn default() -> Self {
        Self {
            free: Vec::new(),
            most_strikes: 100,
        }
    }
}

/// What to identify from.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Input {
    /// The rig.
    pub rig: Rig,
    /// The world to start from: its parameters that are not freed, and its effects, stay.
    pub world: World,
    /// Strikes in order of time; those of [`Split::Train`] are used.
    pub strikes: Vec<Strike>,
    /// Numbers, in the order, of further strikes of this table: where friction wanders, its interval is of their mean, too.
    pub later: Vec<f64>,
}

/// What was identified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fit {
    /// The world with its freed parameters, their 95 % intervals, and the scatter of launches and camera.
    pub world: World,
    /// The parameters that were freed.
    pub freed: Vec<String>,
    /// Strikes used.
    pub strikes: usize,
    /// Root of the mean squared track residual in m: before, in the nominal world.
    pub rms_before: f64,
    /// Root of the mean squared track residual in m: after, in the fitted world.
    pub rms_after: f64,
    /// Gauss–Newton iterations in MuJoCo; those in planar form, before, are not counted.
    pub iterations: u32,
    /// Strikes that MuJoCo simulated; those in planar form, and impacts alone, are not counted.
    pub simulations: u64,
    /// What to look at on the rig before this world is used: strikes that were left out, sizes that the strikes contradict, what
    /// went to a bound.
    pub warnings: Vec<Sentence<Note>>,
    /// What the data cannot determine, and what this world does not model.
    pub notes: Vec<Sentence<Note>>,
}

impl Stage for Sysid {
    const NAME: &'static str = "sysid";
    const VERSION: u32 = 31;
    type Input = Input;
    type Output = Fit;
    type Error = SysidError;

    fn run(&self, input: &Input, progress: &Progress) -> Result<Fit, SysidError> {
        let mut found = self.identify(input, progress)?;
        let (mut input, mut left_out) = (Cow::Borrowed(input), 0);
        // A world is of the many: what a few do for no reason that was logged would move it.
        for _ in 0..ROUNDS {
            let Identified { strays, used, .. } = &found;
            let count = left_out + strays.count();
            let is_a_part = Strays::is_a_part(count, left_out + used.len());
            let order: Vec<f64> = used.iter().map(|used| used.number).collect();
            if !strays.are_beyond_tails() || is_a_part || strays.gathered(&order).is_some() {
                break;
            }
            let astray = used.iter().zip(&strays.which);
            let astray = astray.filter(|(_, is_stray)| **is_stray);
            let astray: BTreeSet<&String> = astray.map(|(used, _)| &used.id).collect();
            let is_other = |strike: &Strike| !astray.contains(&strike.id);
            input.to_mut().strikes.retain(is_other);
            match self.identify(&input, progress) {
                Ok(again) => found = again,
                Err(SysidError::TooFewStrikes { .. }) => break,
                Err(error) => return Err(error),
            }
            left_out = count;
        }
        let Identified { mut fit, used, .. } = found;
        if left_out > 0 {
            let note = Note::Strays {
                count: left_out,
                of: left_out + used.len(),
            };
            fit.warnings.push(note.into());
        }
        Ok(fit)
    }
}

/// Rounds in which strays are left out: without the first the others scatter by less, which shows the next.
const ROUNDS: usize = 3;

/// A strike that was used.
struct Used {
    id: String,
    /// Its number in the order of strikes.
    number: f64,
}

/// A world, and what its strikes say of themselves.
struct Identified {
    fit: Fit,
    used: Vec<Used>,
    /// Those whose tracks end far from where the others' do.
    strays: Strays,
}

impl Sysid {
    /// The world of these strikes.
    fn identify(&self, input: &Input, progress: &Progress) -> Result<Identified, SysidError> {
        let (pushes, struck): (Vec<Strike>, Vec<Strike>) = input
            .strikes
            .iter()
            .cloned()
            .partition(|strike| strike.conditions.is_unstruck);
        // Where the arm's state is logged, launches are taken as delivered.
        let deliveries = Deliveries::of(&struck);
        let (strikes, are_delivered) = match &deliveries {
            Deliveries::Known(delivered) => (delivered, true),
            Deliveries::Unknown | Deliveries::NotFollowed => (&struck, false),
        };
        let learning = |strikes: &[Strike]| -> Vec<Strike> {
            strikes
                .iter()
                .filter(|strike| strike.split == Split::Train)
                .map(|strike| strike.after_impact(1.0 / input.rig.camera.rate))
                .filter(|strike| strike.track.len() >= 4)
                .take(self.most_strikes)
                .collect()
        };
        let (sliding, pushes) = (learning(strikes), learning(&pushes));
        let mut strikes: Vec<&Strike> = sliding.iter().collect();
        for name in &self.free {
            parameter(name)?;
        }
        let default = self.free.is_empty();
        let free: Vec<String> = if default && strikes.is_empty() && !pushes.is_empty() {
            // What no strike began says nothing of an impact.
            vec!["friction".into()]
        } else if default {
            let all = ["friction", "restitution", fit::ROLLS, fit::IN_SLIP];
            let of_a_ball = input.rig.object.shape() == Shape::Sphere;
            let count = if of_a_ball { 4 } else { 2 };
            all[..count].iter().map(ToString::to_string).collect()
        } else {
            self.free.clone()
        };
        let needed = 2 * free.len() + 1;
        let count = match strikes.is_empty() {
            true => pushes.len(),
            false => strikes.len(),
        };
        if count < needed {
            return Err(SysidError::TooFewStrikes {
                strikes: count,
                parameters: free.len(),
                needed,
            });
        }
        // What is pushed twice is no slide, and says nothing of one.
        let is_free = values::free_slides(&strikes);
        let free_slides: Vec<&Strike> = strikes
            .iter()
            .zip(is_free)
            .filter_map(|(strike, is_free)| is_free.then_some(*strike))
            .collect();
        let again = strikes.len() - free_slides.len();
        // Where most are, what is left is no fair sample of them.
        if free_slides.len() >= needed && 2 * again <= strikes.len() {
            strikes = free_slides;
        }
        let pushes::Teaching {
            slides: mut pushes,
            warning: not_taught,
        } = pushes::teaching(&strikes, pushes);
        let first = match strikes.is_empty() {
            true => pushes.iter().collect(),
            false => strikes.clone(),
        };
        let begun = start::start(&input.rig, &input.world, &first, &free);
        let stuck = start::hold(&input.rig, begun, &strikes, &free);
        let begun = match default {
            true => slip::start(&input.rig, stuck.clone(), &strikes)?,
            false => stuck.clone(),
        };
        let launched = strikes.clone();
        // An impact of this world stands for what began a slide: of its launch no more is known than what the slide itself shows.
        let gain = 1.0 + begun.value("restitution")?;
        for push in &mut pushes {
            push.command.speed /= gain;
        }
        strikes.extend(&pushes);
        let mujoco = StrikeSimulator::mujoco(&input.rig, &strikes);
        let by_way = StrikeSimulator::mujoco(&input.rig, &strikes).by_way(true);
        let fit_in = |mujoco: &StrikeSimulator<'_>, world: &World, launch, free: Vec<String>| {
            let planar = |world: &World| -> Result<_, SysidError> {
                let planar = StrikeSimulator::planar(&input.rig, world, &strikes, &free)?;
                Ok(planar.map(|planar| planar.by_way(mujoco.is_by_way)))
            };
            let Some(first) = planar(world)? else {
                return fit::fit(mujoco, mujoco, world, launch, free, progress);
            };
            // Where the planar form goes astray the fit goes on in MuJoCo from where it began.
            let near = fit::fit(&first, &first, world, launch, free.clone(), progress);
            let (world, launch) = near
                .as_ref()
                .map_or((world, launch), |near| (&near.world, near.launch));
            let beside = planar(world)?;
            let beside = beside.as_ref().unwrap_or(mujoco);
            fit::fit(mujoco, beside, world, launch, free.clone(), progress)
        };
        // Launches that scatter by as much as is allowed for do so for something that the world lacks: that is no scatter of a box's way.
        let fit = |world: &World, launch, free: Vec<String>| {
            if !by_way.is_by_way {
                return fit_in(&mujoco, world, launch, free);
            }
            match fit_in(&by_way, world, launch, free.clone()) {
                Ok(fitted) if !fitted.components.are_launches_at_bound() => Ok(fitted),
                other => {
                    let simulations = other.map_or(0, |other| other.simulations);
                    Ok(fit_in(&mujoco, world, launch, free)?.after(simulations))
                }
            }
        };
        // The planar form's launches are smooth; those of a tip that slips in some strikes are not, and its friction is fitted in MuJoCo.
        let with_tip = |free: &[String]| [free, &[start::HOLDS.into()]].concat();
        let of_a_tip_that_slips = match begun != stuck {
            true => fit(&begun, Launch::EXACT, with_tip(&free)).ok(),
            false => None,
        };
        let slips = of_a_tip_that_slips.is_some();
        let mut fitted = match (of_a_tip_that_slips, input.rig.object.solid) {
            (Some(fitted), _) => fitted,
            (None, Solid::Sphere { radius }) if default => {
                let from = |in_slip| {
                    let begun = start::ball(radius, &input.world, &strikes, in_slip);
                    fit(&begun, Launch::EXACT, free.clone())
                };
                // What is left within strikes is the camera's.
                match (from(0.0), from(1.0)) {
                    (Ok(none), Ok(all)) if all.components.camera < none.components.camera => {
                        all.after(none.simulations)
                    }
                    (Ok(none), Ok(all)) => none.after(all.simulations),
                    (none, all) => none.or(all)?,
                }
            }
            _ => fit(&stuck, Launch::EXACT, free)?,
        };
        let rms = |fitted: &fit::Fitted| identify::rms(&input.rig, fitted, &strikes);
        let mut identifiability = Identifiability::default();
        if default {
            let other = match slips {
                true => None,
                false => slip::explained(&input.rig, &fitted, &strikes)?,
            };
            let other = other.map(|other| fit(&other, fitted.launch, with_tip(&fitted.free)));
            if let Some(Ok(other)) = other {
                let simulations = fitted.simulations + other.simulations;
                // Where the world lacks what bends all tracks, launches tell nothing of the tip.
                if rms(&other)? <= rms(&fitted)? {
                    fitted = other;
                }
                fitted.simulations = simulations;
            }
            identifiability = identify::identifiability(&input.rig, &fitted, &strikes)?;
        }
        if let Some(more) = identifiability.worth_freeing.take() {
            let free = fitted.free.iter().cloned().chain([more]).collect();
            let freed = fit(&fitted.world, fitted.launch, free)?.after(fitted.simulations);
            if start::holds(&input.rig, &strikes, freed.world.value(start::HOLDS)?) {
                fitted = freed;
                let simulations = identifiability.simulations;
                identifiability = identify::identifiability(&input.rig, &fitted, &strikes)?;
                identifiability.simulations += simulations;
            } else {
                fitted.simulations = freed.simulations;
            }
        }
        let sizes = sizes::contradicted(&input.rig, &fitted, &strikes, are_delivered)?;
        // What no strike began is told apart.
        let told = if launched.is_empty() {
            &strikes
        } else {
            &launched
        };
        let mujoco = StrikeSimulator::mujoco(&input.rig, told);
        let simulated = |world| mujoco.simulate(world, Launch::EXACT);
        let used: Vec<(f64, f64)> = launched
            .iter()
            .zip(&fitted.guesses)
            .map(|(strike, guess)| (strike.conditions.order, guess[scatter::FRICTION]))
            .collect();
        let all = struck.iter().map(|strike| strike.conditions.order);
        let all: Vec<f64> = all.chain(input.later.iter().copied()).collect();
        let shared = match input.rig.object.shape() {
            Shape::Sphere => interval::shared(&fitted, &strikes),
            Shape::Cylinder | Shape::Box => None,
        };
        let scatter = fitted.components.nuisance[scatter::FRICTION];
        let unseen = wander::unseen(&used, scatter, &all);
        let mut world = interval::with_intervals(&fitted, unseen, shared.as_ref(), &strikes)?;
        if are_delivered {
            // Its scatter is the impact's; the arm's comes on top.
            let arm = arm_scatter(&struck);
            world.scatter.speed = world.scatter.speed.hypot(arm.speed);
            world.scatter.angle = world.scatter.angle.hypot(arm.angle);
        }
        let mut warnings = Vec::new();
        if deliveries == Deliveries::NotFollowed {
            warnings.push(Note::StateNotFollowed);
        }
        if let Some(&Estimate {
            value,
            low: Some(low),
            high: Some(high),
        }) = world.parameters.get("restitution")
            && high < 0.0
        {
            warnings.push(Note::NegativeRestitution { value, low, high });
        }
        if again > 0 {
            warnings.push(Note::PushedAgain {
                count: again,
                of: sliding.len(),
                are_left_out: launched.len() < sliding.len(),
            });
        }
        warnings.extend(not_taught);
        warnings.extend(sizes.note);
        warnings.extend(fitted.at_bounds());
        warnings.extend(fitted.components.at_bounds());
        let mut notes = identifiability.notes;
        notes.extend(fitted.bias());
        notes.extend(start::held(&input.world, &fitted));
        if strikes.len() > launched.len() {
            notes.push(Note::SlidesTeach {
                slides: strikes.len() - launched.len(),
                strikes: launched.len(),
            });
        }
        let (before, after) = (simulated(&input.world)?, simulated(&world)?);
        let used = launched.iter().map(|strike| Used {
            id: strike.id.clone(),
            number: strike.conditions.order,
        });
        let fit = Fit {
            rms_before: before.rms(told),
            rms_after: after.rms(told),
            freed: fitted.free.clone(),
            strikes: launched.len(),
            iterations: fitted.iterations,
            simulations: fitted.simulations
                + identifiability.simulations
                + sizes.simulations
                + 2 * strikes.len() as u64,
            world,
            warnings: warnings.into_iter().map(Sentence::from).collect(),
            notes: notes.into_iter().map(Sentence::from).collect(),
        };
        Ok(Identified {
            fit,
            used: used.collect(),
            strays: after.strays(&launched, input.rig.camera.noise),
        })
    }
}
