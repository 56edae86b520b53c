//! A model fitted to strikes: Gauss–Newton about each strike's own best launch.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};
use world::WorldError;

use crate::{
    linearisation::{Linearisation, Linearised},
    mixed::{self, Estimated, Prior, Products, VarianceComponents},
    model::{FRICTION, Model, RESTITUTION, specification},
    strikes::{Nuisances, PreparedStrikes},
};

/// Iterations at the most.
const ITERATIONS: usize = 12;
/// The fit ends when no value moves by more than this share of its standard error.
const SETTLED: f64 = 0.05;
/// Standard errors within which 95 % lie.
pub(crate) const NINETY_FIVE: f64 = 1.96;
/// A step that loses more log-likelihood than this is taken back.
const LOSS: f64 = 0.05;
/// Log-likelihood that a step must promise for a fit to go on, where it is to be compared alone; how far below its rival a fit that promises no
/// more is given up; and share of the promise within which a step must gain it for derivatives to be kept.
const COMPARED: f64 = 0.02;
const HOPELESS: f64 = 5.0;
const REACH: f64 = 0.2;
/// Change of a strike's own speed or friction (logarithm) or angle (rad) over which its track is as good as linear.
const CLOSE: f64 = 0.01;
/// Damping (Marquardt 1963), relative to the strikes' information on each value: its factors after a step that was good and one that
/// was not, and where the fit gives up.
const DAMPING: (f64, f64, f64) = (0.1, 10.0, 1e4);
/// Longest step of friction (relative), of the launch speed (as a logarithm) and of a strike's own speed (logarithm), angle (rad)
/// and friction (logarithm): derivatives do not reach further.
const LONGEST: f64 = 0.15;

/// A fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) model: Model,
    pub(crate) estimated: Estimated,
    /// Each strike's nuisances, about which it was linearised.
    pub(crate) nuisances: Vec<Nuisances>,
    pub(crate) linearisation: Arc<Linearisation>,
}

impl Fitted {
    /// Log-likelihood of the strikes, plus the log-prior of what a box alone has: wrong sizes, tip friction and load shift.
    pub(crate) fn likelihood(&self) -> f64 {
        self.estimated.likelihood_here + self.model.log_prior()
    }

    /// Whether tracks differ from it by far more than the camera's stated noise.
    pub(crate) fn is_far_from(&self, prepared: &PreparedStrikes<'_>) -> bool {
        let noise = self.estimated.components.camera;
        noise > prepared.thresholds.astray * prepared.rig.camera.noise
    }

    /// Whether tracks of a round object differ from it by far more than the camera's stated noise. Never of a box, which may tip on its way as no
    /// model describes.
    pub(crate) fn is_far_from_round(&self, prepared: &PreparedStrikes<'_>) -> bool {
        prepared.rig.object.shape().is_round() && self.is_far_from(prepared)
    }

    /// Whether what strikes differ by is hardly scatter, where no repeats tell: tracks of a round object are far from it, or friction scatters by as much
    /// as is allowed for.
    pub(crate) fn is_unlike_scatter(&self, prepared: &PreparedStrikes<'_>) -> bool {
        let components = &self.estimated.components;
        self.is_far_from_round(prepared) || components.is_at_bound(mixed::FRICTION)
    }

    /// This fit restricted to some of the strikes, its estimates unchanged.
    pub(crate) fn only(&self, places: &[usize]) -> Self {
        Self {
            model: self.model.clone(),
            estimated: self.estimated.clone(),
            nuisances: places.iter().map(|i| self.nuisances[*i]).collect(),
            linearisation: Arc::new(self.linearisation.only(places)),
        }
    }

    /// Forgets the columns that it was fitted from, which take most of its memory: it is then to compare with, not to fit on from.
    pub(crate) fn drop_columns(&mut self) {
        self.linearisation = Arc::default();
    }

    /// What a strike's friction differs by from the mean over all, relative: by its own scatter, and by how it wandered.
    pub(crate) fn friction_scatter(&self) -> f64 {
        self.estimated.components.nuisance[mixed::FRICTION].hypot(self.estimated.wandered)
    }

    /// Whether no value would move by more than a small share of its standard error. The priors count in it: two values that the data hardly
    /// distinguish have no finite error otherwise.
    fn is_settled(&self) -> bool {
        let Some(covariance) = self.covariance() else {
            return false;
        };
        self.model.free.iter().enumerate().all(|(i, free)| {
            let from = self.model.values[i];
            let to = (from + self.estimated.beta[i]).clamp(free.low, free.high);
            (to - from).abs() < SETTLED * covariance[(i, i)].max(0.0).sqrt()
        })
    }

    /// Gain in log-likelihood that the next step promises, if tracks are linear over it.
    fn promise(&self) -> f64 {
        self.estimated.likelihood_there - self.estimated.likelihood_here
    }

    /// Whether a fit has reached its goal.
    fn is_at(&self, goal: Goal) -> bool {
        match goal {
            Goal::Settled => self.is_settled(),
            Goal::Compared { .. } => {
                let is_near = self.promise() < COMPARED && self.are_launches_near();
                is_near || self.is_hopeless(goal)
            }
        }
    }

    /// Whether the strikes' own launches and frictions are within reach of where they were linearised: what they still gain, no step of the
    /// model's values promises.
    fn are_launches_near(&self) -> bool {
        let mut each = self.estimated.nuisances.iter().zip(&self.nuisances);
        each.all(|(to, from)| {
            let mut places = mixed::ESTIMATED.into_iter();
            places.all(|place| (to[place] - from[place]).abs() < CLOSE)
        })
    }

    /// Whether the fit stays far below the likelihood that it is compared with, even with the gain that the next step promises.
    fn is_hopeless(&self, goal: Goal) -> bool {
        let there = self.likelihood() + self.promise() + HOPELESS;
        matches!(goal, Goal::Compared { with } if there < with)
    }

    /// Whether a step gained what it had promised.
    fn is_as_promised(&self, from: &Self) -> bool {
        let gained = self.likelihood() - from.likelihood();
        (gained - from.promise()).abs() < f64::max(LOSS, REACH * from.promise())
    }

    /// Covariance of the model's values with their priors, which keep what the data do not determine finite.
    pub(crate) fn covariance(&self) -> Option<DMatrix<f64>> {
        let mut information = self.estimated.information.clone();
        for (i, free) in self.model.free.iter().enumerate() {
            information[(i, i)] += free.width.powi(-2);
        }
        information.try_inverse()
    }

    /// Covariance of the model's values, each standard error at least that of the jackknife over strikes (Bell and McCaffrey 2002, "CR3"), which
    /// assumes neither the noise nor the form of an effect.
    pub(crate) fn robust_covariance(&self) -> Option<DMatrix<f64>> {
        let covariance = self.covariance()?;
        let p = self.model.free.len();
        let estimated = &self.estimated;
        let mut between = DMatrix::zeros(p, p);
        for products in &self.linearisation.products {
            let (own, score) =
                products.scores(&estimated.components, &estimated.beta, &estimated.wander);
            let kept = DMatrix::identity(p, p) - own * &covariance;
            let away = kept.lu().solve(&score).unwrap_or(score);
            between += &away * away.transpose();
        }
        let jackknife = &covariance * between * &covariance;
        let widened = DVector::from_fn(p, |i, _| {
            (jackknife[(i, i)] / covariance[(i, i)]).max(1.0).sqrt()
        });
        Some(DMatrix::from_fn(p, p, |i, j| {
            widened[i] * covariance[(i, j)] * widened[j]
        }))
    }

    /// The parameters of effects' forms that lie at an end of their ranges, or no farther from it than their own standard error:
    /// place of the value. The data then want a form that the library does not have, or do not exclude one.
    pub(crate) fn forms_at_end(&self) -> Vec<usize> {
        let covariance = self.robust_covariance();
        let error = |i: usize| {
            let variance = covariance.as_ref().map_or(0.0, |all| all[(i, i)]);
            variance.max(0.0).sqrt()
        };
        let forms = self.model.forms().map(|(i, _, _)| i);
        forms
            .filter(|i| self.model.is_at_end(*i, error(*i)))
            .collect()
    }

    /// The effect that is as strong as its range allows, within its error: something else stands behind it.
    pub(crate) fn at_its_strongest(&self) -> Option<&'static str> {
        /// Part of a range that counts as its end, at the most.
        const END: f64 = 0.05;
        let covariance = self.robust_covariance()?;
        let free = self.model.free.iter().enumerate();
        let mut strengths = free.filter(|(_, free)| free.is_strength && free.low < free.high);
        let (_, free) = strengths.find(|(i, free)| {
            let error = NINETY_FIVE * covariance[(*i, *i)].max(0.0).sqrt();
            self.model
                .is_at_end(*i, error.min(END * (free.high - free.low)))
        })?;
        let (part, _) = free.of.as_ref()?;
        Some(self.model.parts[*part].name)
    }

    /// Standard errors within which 95 % lie, where errors of as many values are estimated from as many strikes: Student's t.
    pub(crate) fn ninety_five(&self) -> f64 {
        let freedom = self.nuisances.len().saturating_sub(self.model.free.len());
        StudentsT::new(0.0, 1.0, freedom.max(1) as f64)
            .map_or(NINETY_FIVE, |t| t.inverse_cdf(0.975))
    }

    /// Place of an effect that may as well be absent: the 95 % interval of each of its strengths holds the neutral value, or is told as its whole range.
    pub(crate) fn unsure(&self) -> Option<usize> {
        let (covariance, robust) = (self.covariance()?, self.robust_covariance()?);
        let ninety_five = self.ninety_five();
        (0..self.model.parts.len()).find(|part| {
            let name = self.model.parts[*part].name;
            let free = self.model.free.iter().enumerate();
            free.filter_map(|(i, free)| {
                let (_, parameter) = free.of.as_ref().filter(|(of, _)| of == part)?;
                let spec = specification(name, parameter);
                // A cap is a strength, too: none is the end of its range.
                let is_strength =
                    free.is_strength || spec.neutral == spec.low || spec.neutral == spec.high;
                is_strength.then_some((i, free, spec.neutral))
            })
            .all(|(i, free, neutral)| {
                let error = |covariance: &DMatrix<f64>| covariance[(i, i)].max(0.0).sqrt();
                let value = self.model.values[i];
                let told = ninety_five * error(&robust);
                (value - neutral).abs() < NINETY_FIVE * error(&covariance)
                    || value - told <= free.low && value + told >= free.high
            })
        })
    }
}

impl PreparedStrikes<'_> {
    /// A model where it stands, with the step that a fit would take from there; `None` where a strike does not come to rest, or strikes do
    /// not determine it.
    fn stands(
        &self,
        model: Model,
        nuisances: Vec<Nuisances>,
        components: &VarianceComponents,
        damping: f64,
    ) -> Result<Option<Fitted>, WorldError> {
        let raw = Linearised::all(self, &model, &nuisances)?;
        Ok(raw.and_then(|raw| {
            let linearisation = Linearisation::new(self, raw.into());
            weighed(model, linearisation, nuisances, components, damping)
        }))
    }

    /// A model at moved values with the step that a fit would take from there, by the derivatives of `from`: one simulation for each strike.
    fn moves(
        &self,
        model: Model,
        nuisances: Vec<Nuisances>,
        from: &Fitted,
        damping: f64,
    ) -> Result<Option<Fitted>, WorldError> {
        let linearisation = from.linearisation.moved(self, &model, &nuisances)?;
        let components = &from.estimated.components;
        Ok(linearisation.and_then(|linearisation| {
            weighed(model, linearisation, nuisances, components, damping)
        }))
    }

    /// Fits a model again, from where it was left, under the noise and frames that these strikes have now.
    pub(crate) fn refit(
        &self,
        fitted: &Fitted,
        iterations: usize,
    ) -> Result<Option<Fitted>, WorldError> {
        let components = fitted.estimated.components.under(self.noise);
        let linearisation = Linearisation::new(self, Arc::clone(&fitted.linearisation.raw));
        let (model, nuisances) = (fitted.model.clone(), fitted.nuisances.clone());
        weighed(model, linearisation, nuisances, &components, 0.0)
            .map(|first| self.proceed(first, iterations, Goal::Settled))
            .transpose()
    }

    /// Fits a model from where it stands; `None` where it diverges.
    pub(crate) fn fit(
        &self,
        model: &Model,
        components: &VarianceComponents,
        nuisances: &[Nuisances],
        goal: Goal,
    ) -> Result<Option<Fitted>, WorldError> {
        self.stands(model.clone(), nuisances.to_vec(), components, 0.0)?
            .map(|first| self.proceed(first, ITERATIONS - 1, goal))
            .transpose()
    }

    /// Fits a model from where another one stands.
    pub(crate) fn fit_from(
        &self,
        from: &Fitted,
        model: &Model,
        goal: Goal,
    ) -> Result<Option<Fitted>, WorldError> {
        let components = &from.estimated.components;
        self.fit(model, components, &from.nuisances, goal)
    }

    /// A fitted model linearised again at its present values.
    fn anew(&self, fitted: &Fitted) -> Result<Option<Fitted>, WorldError> {
        let (model, nuisances) = (fitted.model.clone(), fitted.nuisances.clone());
        self.stands(model, nuisances, &fitted.estimated.components, 0.0)
    }

    /// Takes at most `iterations` accepted Gauss–Newton steps.
    fn proceed(
        &self,
        mut best: Fitted,
        iterations: usize,
        goal: Goal,
    ) -> Result<Fitted, WorldError> {
        let mut damping = 0.0;
        let mut accepted = 0;
        let mut is_fresh = true;
        while accepted < iterations {
            if best.is_at(goal) {
                if is_fresh || best.is_hopeless(goal) {
                    break;
                }
                let Some(anew) = self.anew(&best)? else {
                    break;
                };
                (best, is_fresh) = (anew, true);
                continue;
            }
            let mut model = best.model.clone();
            for (place, free) in best.model.free.iter().enumerate() {
                let moved = model.values[place] + step(&best, place);
                model.values[place] = moved.clamp(free.low, free.high);
            }
            let mut nuisances = best.estimated.nuisances.clone();
            shorten(&mut nuisances, &best.nuisances);
            centre(&mut model, &mut nuisances);
            let components = best.estimated.components;
            let is_better = |found: &Fitted| found.likelihood() > best.likelihood() - LOSS;
            // One slide a strike shows whether a step is good, and whether derivatives reach to where it leads.
            let near = match goal {
                Goal::Settled => None,
                Goal::Compared { .. } => self
                    .moves(model.clone(), nuisances.clone(), &best, damping)?
                    .filter(&is_better),
            };
            let is_kept = near.as_ref().is_some_and(|near| near.is_as_promised(&best));
            let found = match (near, goal) {
                (near, _) if is_kept => near,
                (None, Goal::Compared { .. }) => None,
                _ => self
                    .stands(model, nuisances, &components, damping)?
                    .filter(&is_better),
            };
            match found {
                Some(found) => {
                    is_fresh = !is_kept;
                    best = found;
                    damping *= DAMPING.0;
                    accepted += 1;
                }
                None if !is_fresh => {
                    let Some(anew) = self.anew(&best)? else {
                        break;
                    };
                    (best, is_fresh) = (anew, true);
                }
                // The columns mislead so far away: nearer, and the scatter with it.
                None => {
                    damping = f64::max(1.0, damping * DAMPING.1);
                    let products = &best.linearisation.products;
                    match held(&best.model, products, &components, damping) {
                        Some(nearer) if damping <= DAMPING.2 => best.estimated = nearer,
                        _ => break,
                    }
                }
            }
        }
        Ok(best)
    }
}

/// How far a fit goes.
#[derive(Clone, Copy)]
pub(crate) enum Goal {
    /// Until no value moves by more than a small share of its standard error.
    Settled,
    /// Until the likelihood is known well enough to be compared with `with`, or is plainly far below it. Derivatives are taken anew only where the
    /// gain of a step differs from what they promised.
    Compared { with: f64 },
}

impl Goal {
    /// The likelihood is wanted however low it is: no fit is given up.
    pub(crate) const LIKELIHOOD: Self = Self::Compared {
        with: f64::NEG_INFINITY,
    };
}

/// A fitted model from strikes linearised about it, with the next step; `None` where the strikes do not determine its values.
fn weighed(
    model: Model,
    linearisation: Linearisation,
    nuisances: Vec<Nuisances>,
    components: &VarianceComponents,
    damping: f64,
) -> Option<Fitted> {
    Some(Fitted {
        estimated: held(&model, &linearisation.products, components, damping)?,
        model,
        nuisances,
        linearisation: Arc::new(linearisation),
    })
}

/// A Gaussian prior about where each value began, too wide to move a value that the data determine.
pub(crate) fn prior(model: &Model) -> Prior {
    let p = model.free.len();
    Prior {
        precision: DVector::from_fn(p, |i, _| model.free[i].width.powi(-2)),
        away: DVector::from_fn(p, |i, _| model.free[i].centre - model.values[i]),
    }
}

/// Mean of the strikes' own speeds and frictions, as logarithms, that restitution and friction take over: Gauss–Newton creeps along the line on which
/// both do the same.
const COMMON: f64 = 0.05;

fn centre(model: &mut Model, nuisances: &mut [Nuisances]) {
    let mean =
        |place: usize| nuisances.iter().map(|b| b[place]).sum::<f64>() / nuisances.len() as f64;
    let (speed, friction) = (mean(mixed::SPEED), mean(mixed::FRICTION));
    let mut shift = |value: usize, place: usize, from: f64, by: f64| {
        // Restitution acts as 1 + e, friction as itself.
        let free = &model.free[value];
        let was = from + model.values[value];
        let is = (was * by.exp() - from).clamp(free.low, free.high);
        model.values[value] = is;
        let taken_over = ((from + is) / was).ln();
        nuisances.iter_mut().for_each(|b| b[place] -= taken_over);
    };
    if speed.abs() > COMMON {
        shift(RESTITUTION, mixed::SPEED, 1.0, speed);
    }
    if friction.abs() > COMMON {
        shift(FRICTION, mixed::FRICTION, 0.0, friction);
    }
}

/// Friction below which a table hardly brakes.
const HARDLY_ANY: f64 = 0.01;

/// The step of one of the model's values, no longer than derivatives reach.
fn step(from: &Fitted, place: usize) -> f64 {
    let (value, step) = (from.model.values[place], from.estimated.beta[place]);
    let longest = match place {
        // From next to nothing, too, it gets away.
        FRICTION => LONGEST * value.max(HARDLY_ANY),
        RESTITUTION => LONGEST * (1.0 + value),
        _ => f64::INFINITY,
    };
    step.clamp(-longest, longest)
}

/// Limits the change of each strike's own speed, angle and friction to [`LONGEST`].
fn shorten(nuisances: &mut [Nuisances], from: &[Nuisances]) {
    for (to, from) in nuisances.iter_mut().zip(from) {
        for place in mixed::ESTIMATED {
            to[place] = to[place].clamp(from[place] - LONGEST, from[place] + LONGEST);
        }
    }
}

/// Prior precision that holds a value where it is.
pub(crate) const HELD: f64 = 1e15;

/// Estimates of β and the variance components, damped, with each value that stands at a bound and would leave its range held there.
fn held(
    model: &Model,
    products: &[Products],
    components: &VarianceComponents,
    damping: f64,
) -> Option<Estimated> {
    let mut prior = prior(model);
    if damping > 0.0 {
        let free = mixed::estimate(products, &prior, components)?;
        for i in 0..model.free.len() {
            prior.precision[i] += damping * free.information[(i, i)];
            prior.away[i] *= prior.precision[i].recip() * model.free[i].width.powi(-2);
        }
    }
    loop {
        let estimated = mixed::estimate(products, &prior, components)?;
        if !hold_at_bounds(model, &estimated, &mut prior) {
            return Some(estimated);
        }
    }
}

/// Holds each value of a model that stands at a bound and that a step would take beyond it; whether there is one that was not held.
pub(crate) fn hold_at_bounds(model: &Model, stepped: &Estimated, prior: &mut Prior) -> bool {
    let mut is_new = false;
    for (i, free) in model.free.iter().enumerate() {
        let (value, by) = (model.values[i], stepped.beta[i]);
        let is_beyond = (value <= free.low && by < 0.0) || (value >= free.high && by > 0.0);
        if is_beyond && prior.precision[i] < HELD {
            (prior.precision[i], prior.away[i]) = (HELD, 0.0);
            is_new = true;
        }
    }
    is_new
}
