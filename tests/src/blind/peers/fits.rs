//! Least squares in the planar world, in which every strike weighs the same and launches do not scatter.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use values::{Point, Rig, Strike};
use world::effects::{self, Effect};
use world::launch::Launch;
use world::planar::{Deviation, Planar, StrikeInput, gyration};
use world::{AddedEffect, Estimate};

/// Friction, restitution and a turn common to all launches (rad).
pub(super) const BASE: usize = 3;
/// Where they start, steps of differences, and ranges.
const START: [f64; BASE] = [0.25, 0.5, 0.0];
pub(super) const STEP: [f64; BASE] = [0.002, 0.01, 0.003];
const RANGE: [(f64, f64); BASE] = [(0.03, 1.0), (-0.3, 0.95), (-0.4, 0.4)];
const ITERATIONS: usize = 10;

/// Strikes of one rig, prepared for fits.
pub(super) struct Fits<'s> {
    pub rig: &'s Rig,
    pub strikes: Vec<(&'s Strike, Launch)>,
}

/// A fit: values, and the sum of squares that it leaves, in m².
pub(super) struct Fitted {
    pub values: Vec<f64>,
    pub square: f64,
}

/// An effect with free parameters beside the base.
#[derive(Clone)]
pub(super) struct Candidate {
    pub name: String,
    pub parameters: Vec<(String, f64)>,
}

impl Candidate {
    fn effects(&self, rig: &Rig, values: &[f64]) -> Option<Vec<Box<dyn Effect>>> {
        if self.name.is_empty() {
            return Some(Vec::new());
        }
        let parameters: BTreeMap<String, Estimate> = self
            .parameters
            .iter()
            .zip(values)
            .map(|((name, _), value)| (name.clone(), Estimate::fixed(*value)))
            .collect();
        let name = self.name.clone();
        Some(vec![
            effects::build(&AddedEffect { name, parameters }, rig).ok()?,
        ])
    }

    /// Range and scale of its parameters.
    pub(super) fn ranges(&self) -> Vec<(f64, f64, f64)> {
        let spec = effects::effect(&self.name);
        self.parameters
            .iter()
            .filter_map(|(name, _)| spec.as_ref().ok()?.parameter(name))
            .map(|p| (p.low, p.high, p.scale))
            .collect()
    }
}

impl Fits<'_> {
    /// Residuals of stops, or of all frames, in m.
    pub(super) fn residuals(
        &self,
        candidate: &Candidate,
        values: &[f64],
        whole: bool,
    ) -> Option<DVector<f64>> {
        let (base, own) = values.split_at(BASE);
        let effects = candidate.effects(self.rig, own)?;
        let planar = Planar::of(
            [base[0], base[1]],
            world::Base::of(&self.rig.object),
            gyration(self.rig),
            &effects,
        );
        let deviation = Deviation {
            angle: base[2],
            delay: 0.5 / self.rig.camera.rate,
            ..Deviation::default()
        };
        let mut all = Vec::new();
        for (strike, launch) in &self.strikes {
            let times = if whole { &strike.track.t[..] } else { &[] };
            let input = StrikeInput {
                times,
                ..StrikeInput::from(*strike)
            };
            let frames = planar.strike(&input, launch, &deviation)?;
            let mut add = |a: Point, b: Point| all.extend([a.x - b.x, a.y - b.y]);
            for (i, at) in frames.at.iter().enumerate() {
                add(strike.track.point(i), *at);
            }
            add(strike.stop, frames.stop);
        }
        Some(all.into())
    }

    /// Levenberg and Marquardt from a candidate's start.
    pub(super) fn fit(
        &self,
        candidate: &Candidate,
        is_turned: bool,
        whole: bool,
    ) -> Option<Fitted> {
        let own = candidate.ranges();
        let mut values: Vec<f64> = START.to_vec();
        values.extend(candidate.parameters.iter().map(|(_, value)| *value));
        let ranges: Vec<(f64, f64)> = RANGE
            .into_iter()
            .chain(own.iter().map(|(low, high, _)| (*low, *high)))
            .collect();
        let steps: Vec<f64> = STEP
            .into_iter()
            .chain(own.iter().map(|(_, _, scale)| 0.05 * scale))
            .collect();
        let free: Vec<usize> = (0..values.len()).filter(|i| is_turned || *i != 2).collect();
        let mut residual = self.residuals(candidate, &values, whole)?;
        let mut damping = 1e-3;
        for _ in 0..ITERATIONS {
            let mut slopes = DMatrix::zeros(residual.len(), free.len());
            for (column, i) in free.iter().enumerate() {
                let mut beside = values.clone();
                let step = if beside[*i] + steps[*i] > ranges[*i].1 {
                    -steps[*i]
                } else {
                    steps[*i]
                };
                beside[*i] += step;
                let there = self.residuals(candidate, &beside, whole)?;
                slopes.set_column(column, &((there - &residual) / step));
            }
            let mut normal = slopes.tr_mul(&slopes);
            for i in 0..free.len() {
                normal[(i, i)] *= 1.0 + damping;
            }
            let by = normal.cholesky()?.solve(&slopes.tr_mul(&residual));
            let mut trial = values.clone();
            for (column, i) in free.iter().enumerate() {
                trial[*i] = (trial[*i] - by[column]).clamp(ranges[*i].0, ranges[*i].1);
            }
            match self.residuals(candidate, &trial, whole) {
                Some(there) if there.norm_squared() < residual.norm_squared() => {
                    let gained = 1.0 - there.norm_squared() / residual.norm_squared();
                    (values, residual) = (trial, there);
                    damping *= 0.2;
                    if gained < 1e-5 {
                        break;
                    }
                }
                _ => damping = (damping * 10.0).max(1e-2),
            }
        }
        Some(Fitted {
            square: residual.norm_squared(),
            values,
        })
    }

    /// Held-out strikes and their rms stop error with all freed that a round object's tracks depend on: friction, restitution,
    /// drag of the air, a turn of all launches.
    pub(super) fn freed(&self, judges: &Fits<'_>) -> Option<(usize, f64)> {
        let candidate = Candidate {
            name: "quadratic_drag".into(),
            parameters: vec![("coefficient".into(), 0.01)],
        };
        let fitted = self.fit(&candidate, true, true)?;
        let left = judges.residuals(&candidate, &fitted.values, false)?;
        let count = judges.strikes.len();
        Some((count, (left.norm_squared() / count.max(1) as f64).sqrt()))
    }
}
