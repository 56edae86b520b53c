//! What these strikes determine of the parameters that were not freed.

use nalgebra::DMatrix;
use values::{Rig, Shape, Strike};
use world::{PARAMETERS, WorldError};

use crate::{
    compare::StrikeSimulator,
    fit::{Fitted, MEANS, beside_means, own_derivatives},
    notes::Note,
    scatter::Evidence,
    slopes::{nuisances, sensitivities},
};

/// Number of strikes simulated: sensitivity shows in few.
const STRIKES: usize = 16;
/// Share of a parameter's range that its standard error would have to exceed for the data not to determine it.
const DETERMINED: f64 = 0.10;
/// Share of a parameter's effect left beside the freed ones below which it is not distinguished from them.
const APART: f64 = 0.02;
/// Twice the gain in log-likelihood from which a candidate is worth freeing: one false alarm in a thousand or so.
pub(crate) const WORTH: f64 = 12.0;

/// Which parameters the data could determine.
#[derive(Default)]
pub(crate) struct Identifiability {
    /// One for each group of parameters that cannot be determined.
    pub(crate) notes: Vec<Note>,
    /// A parameter that the data determine, and that explains more of them.
    pub(crate) worth_freeing: Option<String>,
    pub(crate) simulations: u64,
}

/// Parameters that may be freed without being asked for: those of the impact on a face, where the tip may slip.
fn candidates(rig: &Rig) -> &'static [&'static str] {
    match rig.object.shape() {
        Shape::Box => &["tip_friction"],
        Shape::Cylinder | Shape::Sphere => &[],
    }
}

/// A part of the strikes, which stand for all.
fn some<'s>(all: &[&'s Strike]) -> Vec<&'s Strike> {
    let stride = all.len().div_ceil(STRIKES);
    all.iter().step_by(stride).copied().collect()
}

/// Root mean square by which tracks of a part of the strikes differ from a fit's world, in m.
pub(crate) fn rms(rig: &Rig, fitted: &Fitted, all: &[&Strike]) -> Result<f64, WorldError> {
    let strikes = some(all);
    let lab = StrikeSimulator::mujoco(rig, &strikes);
    Ok(lab.simulate(&fitted.world, fitted.launch)?.rms(&strikes))
}

/// Tests every parameter that was not freed: its derivatives weighed as the residual is, with the freed ones projected off.
pub(crate) fn identifiability(
    rig: &Rig,
    fitted: &Fitted,
    strikes: &[&Strike],
) -> Result<Identifiability, WorldError> {
    let strikes = some(strikes);
    let others: Vec<String> = PARAMETERS
        .iter()
        .map(|spec| spec.name.to_string())
        .filter(|name| !fitted.free.contains(name))
        .collect();
    let lab = StrikeSimulator::mujoco(rig, &strikes).by_way(fitted.is_by_way);
    let slopes = |names| sensitivities(&lab, &fitted.world, fitted.launch, names);
    let (by_free, by_others) = (slopes(&fitted.free)?, slopes(&others)?);
    let batch = lab.simulate(&fitted.world, fitted.launch)?;
    let (mut launch, by_turn) = nuisances(&lab, &fitted.world, &batch)?;
    own_derivatives(
        rig.object.shape(),
        &fitted.world,
        &fitted.free,
        &by_free,
        &mut launch,
    )?;

    let free = fitted.free.len() + MEANS;
    let all = free + others.len();
    let mut information = DMatrix::<f64>::zeros(all, all);
    let mut score = nalgebra::DVector::<f64>::zeros(all);
    for (i, strike) in strikes.iter().enumerate() {
        let evidence = Evidence::new(
            strike.conditions.is_unstruck,
            batch.residual(i, strike),
            &launch[i],
            &fitted.components,
        );
        let mut slopes =
            beside_means(by_free[i].clone(), &by_turn[i], &launch[i]).resize_horizontally(all, 0.0);
        slopes
            .columns_mut(free, others.len())
            .copy_from(&by_others[i]);
        let weighed = evidence.weigh(&slopes);
        information += slopes.tr_mul(&weighed);
        score += weighed.tr_mul(&evidence.residual);
    }
    let freed_inverse = information
        .view((0, 0), (free, free))
        .into_owned()
        .try_inverse();
    let (mut blind, mut aliased, mut candidate) = (Vec::new(), Vec::new(), None::<(f64, String)>);
    for (i, name) in (free..).zip(&others) {
        let cross = information.view((0, i), (free, 1)).into_owned();
        let alone = information[(i, i)];
        let (apart, pull) = freed_inverse.as_ref().map_or((alone, score[i]), |inverse| {
            let coefficients = inverse * &cross;
            (
                alone - cross.tr_mul(&coefficients)[(0, 0)],
                score[i] - coefficients.column(0).dot(&score.rows(0, free)),
            )
        });
        let Some(spec) = PARAMETERS.iter().find(|spec| spec.name == name) else {
            continue;
        };
        let error =
            |information: f64| 1.0 / information.max(1e-300).sqrt() / (spec.high - spec.low);
        if error(alone) > DETERMINED {
            blind.push(name.clone());
        } else if apart < APART * alone || error(apart) > DETERMINED {
            aliased.push(name.clone());
        } else if candidates(rig).contains(&name.as_str()) {
            let gain = pull * pull / apart;
            if gain > WORTH && candidate.as_ref().is_none_or(|(best, _)| gain > *best) {
                candidate = Some((gain, name.clone()));
            }
        }
    }
    let mut notes = Vec::new();
    if !blind.is_empty() {
        notes.push(Note::Blind(blind));
    }
    if !aliased.is_empty() {
        notes.push(Note::Aliased {
            kept: aliased,
            freed: fitted.free.clone(),
        });
    }
    Ok(Identifiability {
        notes,
        worth_freeing: candidate.map(|(_, name)| name),
        simulations: (strikes.len() * (2 * (all - MEANS) + 3)) as u64,
    })
}
