//! Strikes as linear functions of a model's values and of each strike's nuisances, about a point.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use world::{
    WorldError,
    planar::{self, Job, Planar},
};

use crate::{
    mixed::{NUISANCES, Products},
    model::{CLOCK, Model},
    noise::{FrameNoise, Whitening},
    strikes::{Nuisances, PreparedStrikes, measured, stack},
    wander::Path,
};

/// Steps of the differences by a strike's own speed (relative), angle (rad) and friction (relative).
const STEPS: (f64, f64, f64) = (0.004, 0.004, 0.01);

/// One strike about a model: coordinates in m, all x, then all y.
#[derive(Clone, Debug)]
pub(crate) struct Linearised {
    /// Simulated frames.
    pub(crate) simulated: DVector<f64>,
    /// Derivatives by the nuisances.
    pub(crate) nuisances: DMatrix<f64>,
    /// Derivatives by the model's values.
    pub(crate) values: DMatrix<f64>,
    /// Measured less simulated, as if the nuisances were none.
    pub(crate) residual: DVector<f64>,
}

/// The same with independent errors: see [`Whitening`].
#[derive(Clone, Debug)]
pub(crate) struct Whitened {
    pub(crate) nuisances: DMatrix<f64>,
    pub(crate) values: DMatrix<f64>,
    pub(crate) residual: DVector<f64>,
}

/// All strikes about a model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Linearisation {
    /// As simulated; shared by the same linearisation under other noise.
    pub(crate) raw: Arc<Vec<Linearised>>,
    pub(crate) whitened: Vec<Whitened>,
    pub(crate) products: Vec<Products>,
}

impl Linearisation {
    /// Of strikes under their noise.
    pub(crate) fn new(prepared: &PreparedStrikes<'_>, raw: Arc<Vec<Linearised>>) -> Self {
        let (whitened, products) = raw
            .par_iter()
            .zip(&prepared.whitenings)
            .zip(&prepared.paths)
            .map(|((raw, whitening), path)| {
                let whitened = raw.whitened(whitening);
                let products = whitened.products(whitening, path);
                (whitened, products)
            })
            .unzip();
        Self {
            raw,
            whitened,
            products,
        }
    }
}

/// Products of all strikes under other noise.
pub(crate) fn products_under(
    prepared: &PreparedStrikes<'_>,
    raw: &[Linearised],
    noise: FrameNoise,
) -> Vec<Products> {
    raw.par_iter()
        .zip(&prepared.frames)
        .zip(&prepared.paths)
        .map(|((raw, frames), path)| {
            let whitening = Whitening::new(frames, noise);
            raw.whitened(&whitening).products(&whitening, path)
        })
        .collect()
}

impl Linearised {
    /// Every strike about a model; `None` where one does not come to rest.
    pub(crate) fn all(
        prepared: &PreparedStrikes<'_>,
        model: &Model,
        nuisances: &[Nuisances],
    ) -> Result<Option<Vec<Self>>, WorldError> {
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
            let effects = model.effects(prepared.rig, &values)?;
            beside.push((values, effects, step));
        }
        let effects = model.effects(prepared.rig, &model.values)?;
        let here = prepared.planar(&model.values, &effects);
        let worlds: Vec<(Planar<'_>, f64)> = beside
            .iter()
            .enumerate()
            .filter(|(place, _)| *place != CLOCK)
            .map(|(_, (values, effects, step))| (prepared.planar(values, effects), *step))
            .collect();
        let clock = model.values[CLOCK];
        Ok((0..prepared.strikes.len())
            .into_par_iter()
            .map(|i| Self::one(prepared, i, &here, &worlds, clock, &nuisances[i]))
            .collect())
    }

    /// `beside`: for each value but the clock, the world a step beside.
    fn one(
        prepared: &PreparedStrikes<'_>,
        i: usize,
        here: &Planar<'_>,
        beside: &[(Planar<'_>, f64)],
        clock: f64,
        b: &Nuisances,
    ) -> Option<Self> {
        let moved = |place: usize, step: f64| {
            let mut moved = *b;
            moved[place] += step;
            prepared.job(here, i, clock, &moved)
        };
        let (speed, angle, friction) = STEPS;
        let mut jobs: Vec<Job<'_>> = vec![
            prepared.job(here, i, clock, b),
            moved(0, speed),
            moved(1, angle),
            moved(5, friction),
        ];
        jobs.extend(
            beside
                .iter()
                .map(|(planar, _)| prepared.job(planar, i, clock, b)),
        );
        let mut found = planar::strikes(&jobs).into_iter();
        let frames = found.next()??;
        let simulated = stack(&frames.at);
        let n = frames.at.len();
        let delay = stack(&frames.rate);
        let mut slope = |step: f64| Some((stack(&found.next()??.at) - &simulated) / step);
        let mut nuisances = DMatrix::zeros(2 * n, NUISANCES);
        nuisances.set_column(0, &slope(speed)?);
        nuisances.set_column(1, &slope(angle)?);
        nuisances.set_column(5, &slope(friction)?);
        nuisances.set_column(2, &delay);
        nuisances.view_mut((0, 3), (n, 1)).fill(1.0);
        nuisances.view_mut((n, 4), (n, 1)).fill(1.0);
        let mut values = DMatrix::zeros(2 * n, beside.len() + 1);
        let mut steps = beside.iter().map(|(_, step)| *step);
        for place in 0..=beside.len() {
            let column = match place {
                CLOCK => delay.clone(),
                _ => slope(steps.next()?)?,
            };
            values.set_column(place, &column);
        }
        let residual = measured(prepared.strikes[i]) - &simulated + &nuisances * b;
        Some(Self {
            simulated,
            nuisances,
            values,
            residual,
        })
    }

    /// Speed of the simulated object at each frame, in m/s.
    pub(crate) fn speeds(&self) -> Vec<f64> {
        // The clock's column is the frames' rate of change.
        let n = self.simulated.len() / 2;
        let rate = self.values.column(CLOCK);
        (0..n).map(|k| rate[k].hypot(rate[n + k])).collect()
    }

    /// With independent errors.
    pub(crate) fn whitened(&self, whitening: &Whitening) -> Whitened {
        Whitened {
            nuisances: whitening.columns(&self.nuisances),
            values: whitening.columns(&self.values),
            residual: whitening.column(&self.residual),
        }
    }
}

impl Whitened {
    /// All that a fit needs of a strike.
    pub(crate) fn products(&self, whitening: &Whitening, path: &Path) -> Products {
        let p = self.values.ncols();
        let mut x = DMatrix::zeros(self.values.nrows(), p + 1);
        x.columns_mut(0, p).copy_from(&self.values);
        x.set_column(p, &self.residual);
        Products::new(&self.nuisances, &x, whitening, path)
    }
}
