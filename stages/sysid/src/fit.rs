//! Gauss–Newton with step control over the freed parameters and the mean launch, the scatter re-estimated as it goes.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use stage::Progress;
use values::{Shape, Strike};
use world::{ParameterSpec, World, WorldError, parameter};

use crate::{
    SysidError,
    compare::{Batch, Launch, StrikeSimulator},
    huber::{objective, weights},
    notes::Note,
    scatter::{self, Evidence, FRICTION, Nuisances, SPEED, VarianceComponents},
    slopes::{DIFFERENCE, LAUNCH_STEP, nuisances, sensitivities},
};

const MOST_ITERATIONS: u32 = 15;
/// Least number of iterations: each strike's own launch, clock and friction are then simulated beyond their derivatives, and again about where that
/// led.
const LEAST_ITERATIONS: u32 = 3;
/// The fit ends when no parameter moves by more than this share of its standard error.
const SETTLED: f64 = 0.05;
/// Names of a ball's rolling friction, and of the share of it that acts while the ball slips.
pub(crate) const ROLLS: &str = "rolling_friction";
pub(crate) const IN_SLIP: &str = "rolling_in_slip";
/// Prior mean and variance of that share: anything from none to all. Where strikes hardly show it, the intervals of what it is traded for are as wide
/// as that.
const ANY_SHARE: (f64, f64) = (0.5, 1.0 / 12.0);
/// What is fitted besides the parameters: the mean turn of the launches, and the mean delay of their clocks.
pub(crate) const MEANS: usize = 2;
/// Standard errors from which a mean turn of the launches is reported.
const STEADY: f64 = 4.0;

/// A fit and all that its intervals need.
pub(crate) struct Fitted {
    pub(crate) world: World,
    pub(crate) free: Vec<String>,
    pub(crate) launch: Launch,
    pub(crate) components: VarianceComponents,
    /// Σ Jᵀ·Σ⁻¹·J over strikes, plus the priors' precision; the freed parameters, then the means.
    pub(crate) information: DMatrix<f64>,
    /// Jᵀ·Σ⁻¹·r of each strike.
    pub(crate) scores: Vec<DVector<f64>>,
    /// Jᵀ·Σ⁻¹·J of each strike.
    pub(crate) informations: Vec<DMatrix<f64>>,
    /// Measured minus simulated coordinates of each strike, in m, less what its own deviations do beyond their derivatives.
    pub(crate) residuals: Vec<DVector<f64>>,
    pub(crate) slopes: Slopes,
    /// Whether a box's own deviations are those of its way.
    pub(crate) is_by_way: bool,
    /// Huber weight of each strike.
    pub(crate) weights: Vec<f64>,
    /// Best guess of each strike's own deviations: launch, clock, resting place and friction.
    pub(crate) guesses: Vec<Nuisances>,
    pub(crate) iterations: u32,
    pub(crate) simulations: u64,
}

impl Fitted {
    /// This fit, with the number of simulations of earlier fits added to its own.
    pub(crate) fn after(mut self, simulations: u64) -> Self {
        self.simulations += simulations;
        self
    }

    /// Parameters that ended at a bound of their range.
    pub(crate) fn at_bounds(&self) -> Vec<Note> {
        self.free
            .iter()
            .filter_map(|name| {
                let spec = parameter(name).ok()?;
                let value = self.world.value(name).ok()?;
                let margin = 1e-3 * (spec.high - spec.low);
                // A table may have no friction, and a share is from none to all.
                let is_least = value < spec.low + margin && name != "friction";
                ((is_least || value > spec.high - margin) && name != IN_SLIP).then(|| {
                    Note::AtBound {
                        name: name.clone(),
                        value,
                    }
                })
            })
            .collect()
    }

    /// Launches that are all turned alike.
    pub(crate) fn bias(&self) -> Option<Note> {
        let place = self.free.len();
        let error = self.information.clone().try_inverse()?[(place, place)].sqrt();
        let (turn, half) = (self.launch.turn, 2.0 * error);
        (turn.abs() > STEADY * error).then_some(Note::Turned { turn, half })
    }
}

/// The values at which a fit stands.
#[derive(Clone)]
struct FitPoint {
    world: World,
    launch: Launch,
}

impl FitPoint {
    /// The point a step away, parameters kept in their ranges.
    fn moved(&self, specs: &[&ParameterSpec], step: &DVector<f64>) -> Result<Self, WorldError> {
        let mut world = self.world.clone();
        for (spec, step) in specs.iter().zip(step.iter()) {
            let value = world.value(spec.name)? + step;
            world = world.with(spec.name, value.clamp(spec.low, spec.high));
        }
        let launch = Launch {
            turn: self.launch.turn + step[specs.len()],
            delay: self.launch.delay + step[specs.len() + 1],
            ..self.launch
        };
        Ok(Self { world, launch })
    }

    fn simulate(&self, lab: &StrikeSimulator<'_>) -> Result<Batch, WorldError> {
        lab.simulate(&self.world, self.launch)
    }

    /// Whether a parameter lies at the bound of its range that this step would take it beyond.
    fn is_held(&self, spec: &ParameterSpec, step: f64) -> Result<bool, WorldError> {
        let value = self.world.value(spec.name)?;
        Ok(value <= spec.low && step < 0.0 || value >= spec.high && step > 0.0)
    }
}

/// Derivatives of every strike's track, and where they were taken.
pub(crate) struct Slopes {
    pub(crate) by_nuisance: Vec<DMatrix<f64>>,
    /// The freed parameters, then the means.
    pub(crate) by_fitted: Vec<DMatrix<f64>>,
    place: FitPoint,
}

impl Slopes {
    fn new(
        lab: &StrikeSimulator<'_>,
        place: &FitPoint,
        free: &[String],
    ) -> Result<Self, WorldError> {
        let (mut by_nuisance, by_turn) = nuisances(lab, &place.world, &place.simulate(lab)?)?;
        let by_free = sensitivities(lab, &place.world, place.launch, free)?;
        own_derivatives(
            lab.rig.object.shape(),
            &place.world,
            free,
            &by_free,
            &mut by_nuisance,
        )?;
        let by_fitted = by_free
            .into_iter()
            .zip(by_turn.iter().zip(&by_nuisance))
            .map(|(by_free, (by_turn, by_nuisance))| beside_means(by_free, by_turn, by_nuisance))
            .collect();
        Ok(Self {
            by_nuisance,
            by_fitted,
            place: place.clone(),
        })
    }

    /// Whether derivatives taken here still hold at a point: it lies no further off than the differences reached.
    fn hold_at(&self, place: &FitPoint, specs: &[&ParameterSpec]) -> Result<bool, WorldError> {
        for spec in specs {
            let moved = place.world.value(spec.name)? - self.place.world.value(spec.name)?;
            if moved.abs() > DIFFERENCE * (spec.high - spec.low) {
                return Ok(false);
            }
        }
        let turned = place.launch.turn - self.place.launch.turn;
        let delayed = place.launch.delay - self.place.launch.delay;
        let (_, turn, delay) = LAUNCH_STEP;
        Ok(turned.abs() <= turn && delayed.abs() <= delay)
    }

    /// The freed parameters that were fitted, and the means.
    fn fitted(&self) -> usize {
        self.by_fitted.first().map_or(0, DMatrix::ncols)
    }
}

/// Gives each strike a friction of its own, where friction is fitted: its derivative by the logarithm of friction. Where restitution is
/// fitted, the derivative by a round object's own launch speed is that by 1 + e, to the last digit: differences that step otherwise
/// would seem to distinguish the two.
pub(crate) fn own_derivatives(
    shape: Shape,
    world: &World,
    free: &[String],
    by_free: &[DMatrix<f64>],
    by_nuisance: &mut [DMatrix<f64>],
) -> Result<(), WorldError> {
    let is_round = shape.is_round();
    for (name, one, place, counts) in [
        ("friction", 0.0, FRICTION, true),
        ("restitution", 1.0, SPEED, is_round),
    ] {
        let column = free.iter().position(|free| free == name);
        let Some(column) = column.filter(|_| counts) else {
            continue;
        };
        let value = one + world.value(name)?;
        // What differs of a table holds back a ball that rolls as one that slides.
        let rolls = free
            .iter()
            .position(|free| free == ROLLS && place == FRICTION);
        let rolling = world.value(ROLLS)?;
        for (nuisances, parameters) in by_nuisance.iter_mut().zip(by_free) {
            let mut own = parameters.column(column) * value;
            if let Some(rolls) = rolls {
                own += parameters.column(rolls) * rolling;
            }
            nuisances.set_column(place, &own);
        }
    }
    Ok(())
}

/// Derivatives by parameters with those by the mean turn and the mean delay after them.
pub(crate) fn beside_means(
    by_parameters: DMatrix<f64>,
    by_turn: &DVector<f64>,
    by_nuisance: &DMatrix<f64>,
) -> DMatrix<f64> {
    let count = by_parameters.ncols();
    let mut all = by_parameters.resize_horizontally(count + MEANS, 0.0);
    all.set_column(count, by_turn);
    all.set_column(count + 1, &by_nuisance.column(2));
    all
}

/// `beyond`: how far each strike's own launch, clock and friction move it beyond their derivatives.
fn evidence<'a>(
    strikes: &[&Strike],
    batch: &Batch,
    slopes: &'a Slopes,
    beyond: Option<&[DVector<f64>]>,
    components: &VarianceComponents,
) -> Vec<Evidence<'a>> {
    strikes
        .par_iter()
        .enumerate()
        .map(|(i, strike)| {
            let mut residual = batch.residual(i, strike);
            if let Some(beyond) = beyond {
                residual -= &beyond[i];
            }
            Evidence::new(
                strike.conditions.is_unstruck,
                residual,
                &slopes.by_nuisance[i],
                components,
            )
        })
        .collect()
}

/// A Gauss–Newton step, and standard errors.
struct Step {
    by: DVector<f64>,
    errors: DVector<f64>,
}

/// The next step; what is held at a bound does not move. None where the data do not determine what is fitted.
fn newton(
    information: &DMatrix<f64>,
    score: &DVector<f64>,
    is_held: impl Fn(usize, f64) -> Result<bool, WorldError>,
) -> Result<Option<Step>, WorldError> {
    let mut moving: Vec<usize> = (0..score.len()).collect();
    loop {
        let part = information.select_rows(&moving).select_columns(&moving);
        let Some(factor) = part.cholesky() else {
            return Ok(None);
        };
        let (steps, variances) = (factor.solve(&score.select_rows(&moving)), factor.inverse());
        let mut held = None;
        for (place, &index) in moving.iter().enumerate() {
            if is_held(index, steps[place])? {
                held = Some(place);
            }
        }
        if let Some(held) = held {
            moving.remove(held);
            continue;
        }
        let mut step = DVector::zeros(score.len());
        let mut errors = DVector::repeat(score.len(), f64::INFINITY);
        for (place, &index) in moving.iter().enumerate() {
            step[index] = steps[place];
            errors[index] = variances[(place, place)].sqrt();
        }
        return Ok(Some(Step { by: step, errors }));
    }
}

/// Fits the named parameters and the mean launch from `world` and `launch`. Residuals are simulated in `lab`, derivatives in `beside`.
pub(crate) fn fit(
    lab: &StrikeSimulator<'_>,
    beside: &StrikeSimulator<'_>,
    world: &World,
    launch: Launch,
    free: Vec<String>,
    progress: &Progress,
) -> Result<Fitted, SysidError> {
    let specs: Vec<_> = free
        .iter()
        .map(|name| parameter(name))
        .collect::<Result<_, _>>()?;
    let (rig, strikes, count) = (lab.rig, lab.strikes, lab.simulations());
    let a_slope = beside.simulations() * (3 + 2 * free.len() as u64);
    let mut place = FitPoint {
        world: world.clone(),
        launch,
    };
    let mut batch = place.simulate(lab)?;
    let mut slopes = Slopes::new(beside, &place, &free)?;
    let mut components = VarianceComponents::initial(rig.camera.noise, 1.0 / rig.camera.rate);
    let mut weights_now = vec![1.0; strikes.len()];
    let mut simulations = count + a_slope;
    let mut iterations = 0;
    let mut beyond: Option<Vec<DVector<f64>>> = None;
    loop {
        iterations += 1;
        let mut all = evidence(strikes, &batch, &slopes, beyond.as_deref(), &components);
        components =
            scatter::estimate_components(&components, &mut all, &weights_now, slopes.fitted());
        weights_now = weights(&all);
        let mut information = DMatrix::zeros(slopes.fitted(), slopes.fitted());
        let mut scores = Vec::with_capacity(strikes.len());
        let mut informations = Vec::with_capacity(strikes.len());
        for ((evidence, slope), weight) in all.iter().zip(&slopes.by_fitted).zip(&weights_now) {
            let weighed = evidence.weigh(slope);
            let own = slope.tr_mul(&weighed) * *weight;
            information += &own;
            informations.push(own);
            scores.push(weighed.tr_mul(&evidence.residual) * *weight);
        }
        let mut score: DVector<f64> = scores
            .iter()
            .fold(DVector::zeros(slopes.fitted()), |sum, s| sum + s);
        let any = free.iter().position(|name| name == IN_SLIP);
        if let Some(any) = any {
            information[(any, any)] += 1.0 / ANY_SHARE.1;
            score[any] += (ANY_SHARE.0 - place.world.value(IN_SLIP)?) / ANY_SHARE.1;
        }
        let known = |place: &FitPoint| match any {
            Some(_) => Ok((place.world.value(IN_SLIP)? - ANY_SHARE.0).powi(2) / ANY_SHARE.1),
            None => Ok::<_, WorldError>(0.0),
        };
        let is_held = |i: usize, step| {
            specs
                .get(i)
                .map_or(Ok(false), |spec| place.is_held(spec, step))
        };
        let Some(Step { by: step, errors }) = newton(&information, &score, is_held)? else {
            return Err(SysidError::Singular {
                names: free.join(", "),
            });
        };
        progress.set_message(format!(
            "iteration {iterations}, residual {:.2} mm",
            1e3 * batch.rms(strikes)
        ));
        let is_settled = step
            .iter()
            .zip(errors.iter())
            .all(|(s, e)| s.abs() < SETTLED * e);
        let guesses: Vec<Nuisances> = all.iter().map(Evidence::nuisance).collect();
        // A box's far strikes would move what is common to all, before what they do beyond their derivatives is known.
        let is_beyond_unknown = beside.is_by_way && beyond.is_none();
        let mut moved = None;
        if !(is_settled || is_beyond_unknown) && iterations < MOST_ITERATIONS {
            let now = objective(&all, &weights_now) + known(&place)?;
            // Shorten the step until the objective falls.
            let mut share = 1.0;
            while moved.is_none() && share > 0.01 {
                let trial = place.moved(&specs, &(&step * share))?;
                simulations += count;
                if let Ok(tried) = trial.simulate(lab) {
                    let then = evidence(strikes, &tried, &slopes, beyond.as_deref(), &components);
                    if objective(&then, &weights_now) + known(&trial)? <= now * (1.0 + 1e-9) {
                        moved = Some((trial, tried));
                    }
                }
                share *= 0.4;
            }
        }
        let goes_on = moved.is_some() || beside.goes_beyond() && iterations < LEAST_ITERATIONS;
        if goes_on {
            let (world, launch) = (&place.world, place.launch);
            beyond =
                beside.beyond_slopes(world, launch, &guesses, &components, &slopes.by_nuisance)?;
        }
        let Some(next) = moved else {
            if goes_on {
                continue;
            }
            let mut world = place.world;
            world.scatter = components.scatter();
            return Ok(Fitted {
                world,
                free,
                launch: place.launch,
                components,
                information,
                scores,
                informations,
                residuals: all.into_iter().map(|evidence| evidence.residual).collect(),
                slopes,
                is_by_way: beside.is_by_way,
                weights: weights_now,
                guesses,
                iterations,
                simulations,
            });
        };
        (place, batch) = next;
        if !slopes.hold_at(&place, &specs)? {
            slopes = Slopes::new(beside, &place, &free)?;
            simulations += a_slope;
        }
    }
}
