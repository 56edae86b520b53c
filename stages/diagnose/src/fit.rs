//! A model fitted to strikes: Gauss–Newton about each strike's own best launch.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, SVector};
use rayon::prelude::*;
use values::{Point, Rig, Strike};
use world::{
    Base, Blow, World, WorldError,
    effects::Effect,
    launch::{Launch, launches_about},
    planar::{self, Frames, Job, Kick, Planar},
};

use crate::{
    mixed::{self, Estimated, NUISANCES, Prior, Products, Spread},
    model::{CLOCK, FRICTION, Model, RESTITUTION, specification},
};

/// Steps of a kick's differences: relative speed and angle (rad).
const KICK: (f64, f64) = (0.004, 0.004);
/// Iterations at the most, and those after which a hopeless fit shows.
pub(crate) const ITERATIONS: usize = 12;
pub(crate) const GLANCE: usize = 3;
/// The fit ends when no value moves by more than this share of its standard error.
const SETTLED: f64 = 0.05;
/// Standard errors within which 95 % lie.
pub(crate) const NINETY_FIVE: f64 = 1.96;
/// A step that loses more log-likelihood than this is taken back.
const LOSS: f64 = 0.05;
/// Damping (Marquardt 1963), relative to what the strikes tell of each value: its factors after a step that was good and one that
/// was not, and where the fit gives up.
const DAMPING: (f64, f64, f64) = (0.1, 10.0, 1e4);

/// The strikes, with their launches.
pub(crate) struct Field<'a> {
    pub(crate) rig: &'a Rig,
    pub(crate) strikes: Vec<&'a Strike>,
    pub(crate) launches: Vec<Launch>,
    pub(crate) base: Base,
    pub(crate) gyration: f64,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub(crate) model: Model,
    pub(crate) estimated: Estimated,
    pub(crate) kicks: Vec<SVector<f64, NUISANCES>>,
    pub(crate) taken: Arc<Taken>,
}

/// Each strike's columns about a model.
#[derive(Debug)]
pub(crate) struct Taken {
    pub(crate) columns: Vec<Columns>,
    products: Vec<Products>,
}

impl Fitted {
    /// Log-likelihood.
    pub(crate) fn likelihood(&self) -> f64 {
        self.estimated.likelihood_here
    }

    /// Whether no value would move by more than a small share of its standard error.
    fn is_settled(&self) -> bool {
        let Some(covariance) = self.estimated.information.clone().try_inverse() else {
            return false;
        };
        self.model.free.iter().enumerate().all(|(i, free)| {
            let from = self.model.values[i];
            let to = (from + self.estimated.beta[i]).clamp(free.low, free.high);
            (to - from).abs() < SETTLED * covariance[(i, i)].max(0.0).sqrt()
        })
    }

    /// Of the model's values, with the priors, which keep what the data do not tell from being infinite.
    pub(crate) fn covariance(&self) -> Option<DMatrix<f64>> {
        let mut information = self.estimated.information.clone();
        for (i, free) in self.model.free.iter().enumerate() {
            information[(i, i)] += free.width.powi(-2);
        }
        information.try_inverse()
    }

    /// An effect whose strength may as well be none: each of its 95 % intervals holds that.
    pub(crate) fn unsure(&self) -> Option<usize> {
        let covariance = self.covariance()?;
        (0..self.model.parts.len()).find(|part| {
            let name = self.model.parts[*part].name;
            let free = self.model.free.iter().enumerate();
            free.filter_map(|(i, free)| {
                let (_, parameter) = free.of.as_ref().filter(|(of, _)| of == part)?;
                let spec = specification(name, parameter);
                // A cap is a strength, too: none is the end of its range.
                let tells =
                    free.is_strength || spec.neutral == spec.low || spec.neutral == spec.high;
                tells.then_some((i, spec.neutral))
            })
            .all(|(i, neutral)| {
                let error = covariance[(i, i)].max(0.0).sqrt();
                (self.model.values[i] - neutral).abs() < NINETY_FIVE * error
            })
        })
    }
}

fn kick(clock: f64, b: &SVector<f64, NUISANCES>) -> Kick {
    Kick {
        speed: b[0],
        angle: b[1],
        delay: clock + b[2],
        rest: Point::new(b[3], b[4]),
        ..Kick::default()
    }
}

/// Measured coordinates: all x, then all y.
fn measured(strike: &Strike) -> DVector<f64> {
    DVector::from_iterator(
        2 * strike.track.len(),
        strike.track.x.iter().chain(&strike.track.y).copied(),
    )
}

pub(crate) fn stack(points: &[Point]) -> DVector<f64> {
    DVector::from_iterator(
        2 * points.len(),
        points.iter().map(|p| p.x).chain(points.iter().map(|p| p.y)),
    )
}

/// The columns of one strike about a model.
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    /// By the nuisances.
    pub(crate) nuisances: DMatrix<f64>,
    /// By the model's values.
    pub(crate) values: DMatrix<f64>,
    /// Measured less simulated, as if the nuisances were none.
    pub(crate) residual: DVector<f64>,
}

impl<'a> Field<'a> {
    /// Strikes with their launches.
    pub(crate) fn new(rig: &'a Rig, strikes: Vec<&'a Strike>, launches: Vec<Launch>) -> Self {
        Self {
            rig,
            strikes,
            launches,
            base: Base::of(&rig.object),
            gyration: planar::gyration(rig),
        }
    }

    /// The same strikes, their launches taken around the blows of a fitted model: far from a launch's own blow its parabola
    /// leaves MuJoCo. As it stands where an object would not leave the tip.
    pub(crate) fn about(&self, world: &World, fitted: &Fitted) -> Result<Self, WorldError> {
        let model = &fitted.model;
        let effects = model.effects(self.rig, &model.values)?;
        let blows: Vec<Blow> = self
            .strikes
            .iter()
            .map(|strike| {
                let delivered =
                    world::effects::deliver(&effects, strike.command, &strike.conditions);
                Blow::of(
                    &effects,
                    model.values[RESTITUTION],
                    delivered,
                    &strike.conditions,
                )
            })
            .collect();
        let launches: Option<Vec<Launch>> = launches_about(self.rig, world, &blows)?
            .into_iter()
            .collect();
        Ok(Self::new(
            self.rig,
            self.strikes.clone(),
            launches.unwrap_or_else(|| self.launches.clone()),
        ))
    }

    /// The planar world of a model at these values.
    pub(crate) fn planar<'e>(&self, values: &[f64], effects: &'e [Box<dyn Effect>]) -> Planar<'e> {
        Planar::of(
            [values[FRICTION], values[RESTITUTION]],
            self.base,
            self.gyration,
            effects,
        )
    }

    /// One strike's frames.
    pub(crate) fn frames(
        &self,
        planar: &Planar<'_>,
        i: usize,
        clock: f64,
        b: &SVector<f64, NUISANCES>,
    ) -> Option<Frames> {
        planar.strike(&self.strikes[i].into(), &self.launches[i], &kick(clock, b))
    }

    /// The same, to be done.
    pub(crate) fn job<'j>(
        &'j self,
        planar: &'j Planar<'j>,
        i: usize,
        clock: f64,
        b: &SVector<f64, NUISANCES>,
    ) -> Job<'j> {
        Job {
            planar,
            shot: self.strikes[i].into(),
            launch: &self.launches[i],
            kick: kick(clock, b),
        }
    }

    /// Whether a strike's track comes this near (m) to a point.
    pub(crate) fn passes(&self, i: usize, point: Point, radius: f64) -> bool {
        let strike = self.strikes[i];
        (0..strike.track.len()).any(|frame| strike.track.point(frame).distance(point) < radius)
            || strike.initial.distance(point) < radius
    }

    /// The columns of every strike about a model; `None` where a strike does not come to rest.
    pub(crate) fn columns(
        &self,
        model: &Model,
        kicks: &[SVector<f64, NUISANCES>],
    ) -> Result<Option<Vec<Columns>>, WorldError> {
        // A world a step beside, for each value; the clock's column comes with the frames.
        let mut beside = Vec::new();
        for (place, free) in model.free.iter().enumerate() {
            let mut values = model.values.clone();
            let step = if values[place] + free.step > free.high {
                -free.step
            } else {
                free.step
            };
            values[place] += step;
            let effects = model.effects(self.rig, &values)?;
            beside.push((values, effects, step));
        }
        let effects = model.effects(self.rig, &model.values)?;
        let here = self.planar(&model.values, &effects);
        let worlds: Vec<Planar<'_>> = beside
            .iter()
            .enumerate()
            .filter(|(place, _)| *place != CLOCK)
            .map(|(_, (values, effects, _))| self.planar(values, effects))
            .collect();
        let clock = model.values[CLOCK];
        Ok((0..self.strikes.len())
            .into_par_iter()
            .map(|i| {
                let b = kicks[i];
                let kicked = |place: usize, step: f64| {
                    let mut b = b;
                    b[place] += step;
                    (&here, b)
                };
                let mut jobs = vec![(&here, b), kicked(0, KICK.0), kicked(1, KICK.1)];
                jobs.extend(worlds.iter().map(|planar| (planar, b)));
                let jobs: Vec<Job<'_>> = jobs
                    .iter()
                    .map(|(planar, b)| self.job(planar, i, clock, b))
                    .collect();
                let mut found = planar::strikes(&jobs).into_iter();
                let frames = found.next()??;
                let at = stack(&frames.at);
                let n = frames.at.len();
                let delay = stack(&frames.rate);
                let mut moved = |step: f64| Some((stack(&found.next()??.at) - &at) / step);
                let mut nuisances = DMatrix::zeros(2 * n, NUISANCES);
                nuisances.set_column(0, &moved(KICK.0)?);
                nuisances.set_column(1, &moved(KICK.1)?);
                nuisances.set_column(2, &delay);
                nuisances.view_mut((0, 3), (n, 1)).fill(1.0);
                nuisances.view_mut((n, 4), (n, 1)).fill(1.0);
                let mut values = DMatrix::zeros(2 * n, model.free.len());
                for (place, (_, _, step)) in beside.iter().enumerate() {
                    let column = match place {
                        CLOCK => delay.clone(),
                        _ => moved(*step)?,
                    };
                    values.set_column(place, &column);
                }
                let residual = measured(self.strikes[i]) - at + &nuisances * b;
                Some(Columns {
                    nuisances,
                    values,
                    residual,
                })
            })
            .collect())
    }

    /// The frames that a strike's columns were taken about.
    pub(crate) fn simulated(
        &self,
        i: usize,
        columns: &Columns,
        b: &SVector<f64, NUISANCES>,
    ) -> DVector<f64> {
        measured(self.strikes[i]) - (&columns.residual - &columns.nuisances * b)
    }

    fn taken(
        &self,
        model: &Model,
        kicks: &[SVector<f64, NUISANCES>],
    ) -> Result<Option<Taken>, WorldError> {
        let columns = self.columns(model, kicks)?;
        Ok(columns.map(|columns| Taken {
            products: columns.par_iter().map(Columns::products).collect(),
            columns,
        }))
    }

    /// A model where it stands, with the step that a fit would take from there; `None` where a strike does not come to rest.
    fn stands(
        &self,
        model: Model,
        kicks: Vec<SVector<f64, NUISANCES>>,
        spread: &Spread,
        damping: f64,
    ) -> Result<Option<Fitted>, WorldError> {
        let taken = self.taken(&model, &kicks)?;
        Ok(taken.and_then(|taken| {
            Some(Fitted {
                estimated: held(&model, &taken.products, spread, damping)?,
                model,
                kicks,
                taken: Arc::new(taken),
            })
        }))
    }

    /// Fits a model from where it stands; `None` where it diverges.
    pub(crate) fn fit(
        &self,
        model: &Model,
        spread: &Spread,
        kicks: &[SVector<f64, NUISANCES>],
        iterations: usize,
    ) -> Result<Option<Fitted>, WorldError> {
        self.stands(model.clone(), kicks.to_vec(), spread, 0.0)?
            .map(|first| self.proceed(first, iterations - 1))
            .transpose()
    }

    /// Fits on from where a fit was left, its last step perhaps damped.
    pub(crate) fn further(
        &self,
        mut left: Fitted,
        iterations: usize,
    ) -> Result<Fitted, WorldError> {
        let spread = left.estimated.spread;
        if let Some(whole) = held(&left.model, &left.taken.products, &spread, 0.0) {
            left.estimated = whole;
        }
        self.proceed(left, iterations)
    }

    /// So many good steps at the most.
    fn proceed(&self, mut best: Fitted, iterations: usize) -> Result<Fitted, WorldError> {
        let mut damping = 0.0;
        let mut accepted = 0;
        let mut is_settled = best.is_settled();
        while accepted < iterations && !is_settled {
            let mut model = best.model.clone();
            for (place, free) in best.model.free.iter().enumerate() {
                let moved = model.values[place] + best.estimated.beta[place];
                model.values[place] = moved.clamp(free.low, free.high);
            }
            let mut kicks = best.estimated.nuisances.clone();
            centre(&mut model, &mut kicks);
            let spread = best.estimated.spread;
            let found = self.stands(model, kicks, &spread, damping)?;
            match found.filter(|found| found.likelihood() > best.likelihood() - LOSS) {
                Some(found) => {
                    best = found;
                    is_settled = best.is_settled();
                    damping *= DAMPING.0;
                    accepted += 1;
                }
                // The columns mislead so far away: nearer, and the scatter with it.
                None => {
                    damping = f64::max(1.0, damping * DAMPING.1);
                    let products = &best.taken.products;
                    match held(&best.model, products, &spread, damping) {
                        Some(nearer) if damping <= DAMPING.2 => best.estimated = nearer,
                        _ => break,
                    }
                }
            }
        }
        Ok(best)
    }
}

impl Columns {
    fn products(&self) -> Products {
        let p = self.values.ncols();
        let mut x = DMatrix::zeros(self.values.nrows(), p + 1);
        x.columns_mut(0, p).copy_from(&self.values);
        x.set_column(p, &self.residual);
        Products::new(&self.nuisances, &x)
    }
}

/// A Gaussian about where each value began, wide enough to move none that the data tell.
pub(crate) fn prior(model: &Model) -> Prior {
    let p = model.free.len();
    Prior {
        precision: DVector::from_fn(p, |i, _| model.free[i].width.powi(-2)),
        away: DVector::from_fn(p, |i, _| model.free[i].centre - model.values[i]),
    }
}

/// Mean of the kicks on speed, as a logarithm, that restitution takes over: Gauss–Newton creeps along the line on which both do the
/// same.
const COMMON: f64 = 0.05;

fn centre(model: &mut Model, kicks: &mut [SVector<f64, NUISANCES>]) {
    let mean = kicks.iter().map(|b| b[0]).sum::<f64>() / kicks.len() as f64;
    if mean.abs() < COMMON {
        return;
    }
    let free = &model.free[RESTITUTION];
    let was = model.values[RESTITUTION];
    let is = ((1.0 + was) * mean.exp() - 1.0).clamp(free.low, free.high);
    model.values[RESTITUTION] = is;
    let taken = ((1.0 + is) / (1.0 + was)).ln();
    kicks.iter_mut().for_each(|b| b[0] -= taken);
}

/// Precision by which a value is held.
const HELD: f64 = 1e15;

/// Estimates, with values held that stand at a bound and would go beyond, and all of them damped.
fn held(model: &Model, products: &[Products], spread: &Spread, damping: f64) -> Option<Estimated> {
    let mut prior = prior(model);
    if damping > 0.0 {
        let free = mixed::estimate(products, &prior, spread)?;
        for i in 0..model.free.len() {
            prior.precision[i] += damping * free.information[(i, i)];
            prior.away[i] *= prior.precision[i].recip() * model.free[i].width.powi(-2);
        }
    }
    loop {
        let estimated = mixed::estimate(products, &prior, spread)?;
        let mut is_new = false;
        for (i, free) in model.free.iter().enumerate() {
            let (value, by) = (model.values[i], estimated.beta[i]);
            let is_beyond = (value <= free.low && by < 0.0) || (value >= free.high && by > 0.0);
            if is_beyond && prior.precision[i] < HELD {
                (prior.precision[i], prior.away[i]) = (HELD, 0.0);
                is_new = true;
            }
        }
        if !is_new {
            return Some(estimated);
        }
    }
}
