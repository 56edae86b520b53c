//! Gauss–Newton with step control over the freed parameters, the scatter re-estimated as it goes.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use stage::Progress;
use values::{Rig, Strike};
use world::{World, WorldError, parameter};

use crate::{
    SysidError,
    compare::{Batch, Launch, measured},
    scatter::{self, Evidence, NUISANCES, Spread},
};

/// Steps of the central differences, relative to a parameter's range: small ones read the noise of the contact.
const DIFFERENCE: f64 = 0.01;
/// Steps of the differences by relative speed, angle (rad) and clock (s).
const LAUNCH_STEP: (f64, f64, f64) = (0.01, 0.01, 1e-3);
const MOST_ITERATIONS: u32 = 15;
/// The fit ends when no parameter moves by more than this share of its standard error.
const SETTLED: f64 = 0.02;
/// A strike further out than this many times the median weighs less (Huber).
const OUTLYING: f64 = 4.0;

/// A fit and all that its intervals need.
pub(crate) struct Fitted {
    pub(crate) world: World,
    pub(crate) free: Vec<String>,
    pub(crate) spread: Spread,
    /// Σ Jᵀ·Σ⁻¹·J over strikes.
    pub(crate) information: DMatrix<f64>,
    /// Jᵀ·Σ⁻¹·r of each strike.
    pub(crate) scores: Vec<DVector<f64>>,
    pub(crate) rms: f64,
    pub(crate) iterations: u32,
    pub(crate) simulations: u64,
}

impl Fitted {
    /// Sentences on parameters that ended at a bound of their range.
    pub(crate) fn at_bounds(&self) -> Vec<String> {
        self.free
            .iter()
            .filter_map(|name| {
                let spec = parameter(name).ok()?;
                let value = self.world.value(name).ok()?;
                let margin = 1e-3 * (spec.high - spec.low);
                (value < spec.low + margin || value > spec.high - margin)
                    .then(|| format!("{name} ended at the bound of its range, {value:.4}: the model lacks something, or the rig file is off"))
            })
            .collect()
    }
}

/// Derivatives of every strike's track by the nuisances; they change little as parameters do.
pub(crate) fn nuisances(
    rig: &Rig,
    world: &World,
    strikes: &[&Strike],
    base: &Batch,
) -> Result<Vec<DMatrix<f64>>, WorldError> {
    let (speed, turn, delay) = LAUNCH_STEP;
    let faster = Batch::launched(
        rig,
        world,
        strikes,
        Launch {
            speed_factor: 1.0 + speed,
            turn: 0.0,
        },
    )?;
    let turned = Batch::launched(
        rig,
        world,
        strikes,
        Launch {
            speed_factor: 1.0,
            turn,
        },
    )?;
    Ok(strikes
        .iter()
        .enumerate()
        .map(|(i, strike)| {
            let (t, n) = (&strike.track.t, strike.track.len());
            let here = base.track(i, t, 0.0);
            let mut columns = DMatrix::zeros(2 * n, NUISANCES);
            columns.set_column(0, &((faster.track(i, t, 0.0) - &here) / speed));
            columns.set_column(1, &((turned.track(i, t, 0.0) - &here) / turn));
            columns.set_column(
                2,
                &((base.track(i, t, delay) - base.track(i, t, -delay)) / (2.0 * delay)),
            );
            columns.view_mut((0, 3), (n, 1)).fill(1.0);
            columns.view_mut((n, 4), (n, 1)).fill(1.0);
            columns
        })
        .collect())
}

/// Derivatives of every strike's track by the named parameters, by central differences kept within their ranges.
pub(crate) fn sensitivities(
    rig: &Rig,
    world: &World,
    strikes: &[&Strike],
    names: &[String],
) -> Result<Vec<DMatrix<f64>>, WorldError> {
    let mut columns: Vec<DMatrix<f64>> = strikes
        .iter()
        .map(|strike| DMatrix::zeros(2 * strike.track.len(), names.len()))
        .collect();
    for (column, name) in names.iter().enumerate() {
        let spec = parameter(name)?;
        let (value, step) = (world.value(name)?, DIFFERENCE * (spec.high - spec.low));
        let (low, high) = ((value - step).max(spec.low), (value + step).min(spec.high));
        let below = Batch::new(rig, &world.clone().with(name, low), strikes)?;
        let above = Batch::new(rig, &world.clone().with(name, high), strikes)?;
        for (i, strike) in strikes.iter().enumerate() {
            let t = &strike.track.t;
            let slope = (above.track(i, t, 0.0) - below.track(i, t, 0.0)) / (high - low);
            columns[i].set_column(column, &slope);
        }
    }
    Ok(columns)
}

fn evidence(
    strikes: &[&Strike],
    batch: &Batch,
    nuisances: &[DMatrix<f64>],
    spread: &Spread,
) -> Vec<Evidence> {
    strikes
        .par_iter()
        .enumerate()
        .map(|(i, strike)| {
            let residual = measured(strike) - batch.track(i, &strike.track.t, 0.0);
            Evidence::new(residual, nuisances[i].clone(), spread)
        })
        .collect()
}

/// Huber weights by strike: one, less for strikes far beyond the median.
fn weights(evidence: &[Evidence]) -> Vec<f64> {
    let distances: Vec<f64> = evidence
        .iter()
        .map(|e| (e.distance() / e.residual.len() as f64).sqrt())
        .collect();
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = OUTLYING * sorted[sorted.len() / 2];
    distances
        .iter()
        .map(|d| if *d > limit { limit / d } else { 1.0 })
        .collect()
}

/// Fits the named parameters from where `world` stands.
pub(crate) fn fit(
    rig: &Rig,
    world: &World,
    strikes: &[&Strike],
    free: Vec<String>,
    progress: &Progress,
) -> Result<Fitted, SysidError> {
    let specs: Vec<_> = free
        .iter()
        .map(|name| parameter(name))
        .collect::<Result<_, _>>()?;
    let mut world = world.clone();
    let mut spread = Spread::initial(rig.camera.noise, 1.0 / rig.camera.rate);
    let mut batch = Batch::new(rig, &world, strikes)?;
    let mut simulations = strikes.len() as u64;
    let mut iterations = 0;
    loop {
        iterations += 1;
        let launch = nuisances(rig, &world, strikes, &batch)?;
        let slopes = sensitivities(rig, &world, strikes, &free)?;
        simulations += (strikes.len() * (2 + 2 * free.len())) as u64;
        let mut all = evidence(strikes, &batch, &launch, &spread);
        for _ in 0..8 {
            spread = scatter::update(&spread, &all, free.len());
            all = evidence(strikes, &batch, &launch, &spread);
        }
        let weights = weights(&all);
        let mut information = DMatrix::zeros(free.len(), free.len());
        let mut scores = Vec::with_capacity(strikes.len());
        for ((evidence, slope), weight) in all.iter().zip(&slopes).zip(&weights) {
            let weighed = evidence.weigh(slope);
            information += slope.tr_mul(&weighed) * *weight;
            scores.push(weighed.tr_mul(&evidence.residual) * *weight);
        }
        let score: DVector<f64> = scores
            .iter()
            .fold(DVector::zeros(free.len()), |sum, s| sum + s);
        let Some(factor) = information.clone().cholesky() else {
            return Err(SysidError::Singular {
                names: free.join(", "),
            });
        };
        let step = factor.solve(&score);
        let errors = factor.inverse().diagonal().map(f64::sqrt);
        let settled = step
            .iter()
            .zip(errors.iter())
            .all(|(s, e)| s.abs() < SETTLED * e);
        progress.set_message(format!(
            "iteration {iterations}, residual {:.2} mm",
            1e3 * batch.rms(strikes)
        ));
        if settled || iterations == MOST_ITERATIONS {
            world.scatter = spread.scatter();
            let rms = batch.rms(strikes);
            return Ok(Fitted {
                world,
                free,
                spread,
                information,
                scores,
                rms,
                iterations,
                simulations,
            });
        }
        let now: f64 = all
            .iter()
            .zip(&weights)
            .map(|(e, w)| w * e.distance())
            .sum();
        // Halve the step until the objective falls; a step that never does ends the fit at the next look.
        let mut share = 1.0;
        for _ in 0..6 {
            let mut trial = world.clone();
            for (i, spec) in specs.iter().enumerate() {
                let value = world.value(spec.name)? + share * step[i];
                trial = trial.with(spec.name, value.clamp(spec.low, spec.high));
            }
            simulations += strikes.len() as u64;
            if let Ok(tried) = Batch::new(rig, &trial, strikes) {
                let then: f64 = evidence(strikes, &tried, &launch, &spread)
                    .iter()
                    .zip(&weights)
                    .map(|(e, w)| w * e.distance())
                    .sum();
                if then <= now * (1.0 + 1e-9) {
                    (world, batch) = (trial, tried);
                    break;
                }
            }
            share *= 0.4;
        }
        if share < 0.01 {
            iterations = MOST_ITERATIONS - 1;
        }
    }
}
