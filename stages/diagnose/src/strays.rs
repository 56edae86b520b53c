//! The diagnosis of the strikes that do not stray ([`Strays`]), and where those that do gather.

use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
};

use stage::Progress;
use values::{Rig, Sentence, Strays, Strike};

use crate::{
    Diagnose, DiagnoseError, Diagnosed, Input,
    diagnosis::{Diagnosis, StopResidual, Verdict},
    words::{Cause, Dependence, Gathered, StrayStrikes},
};

/// Rounds in which strays are left out: without the first the others scatter by less, which shows the next.
const ROUNDS: usize = 3;

/// Strikes that stop far from where the others do.
#[derive(Default)]
pub(crate) struct Astray {
    pub(crate) told: Option<StrayStrikes>,
    /// Their ids.
    pub(crate) ids: Vec<String>,
    /// The residuals of those that were left out.
    pub(crate) residuals: Vec<StopResidual>,
}

impl Astray {
    /// Whether a dependence on the order, or on anything that was logged by which stops move more than the strikes that do not stray scatter, is what these
    /// stray by.
    pub(crate) fn are_explained(&self, diagnosis: &Diagnosis) -> bool {
        let others = self.told.as_ref().map_or(0.0, |told| told.others);
        let known = diagnosis.cause.as_ref().and_then(Sentence::finding);
        let is_known = match known {
            None => false,
            Some(Cause::Dependence(Dependence { size, form, .. })) => {
                form.is_some() || *size >= others
            }
            Some(_) => true,
        };
        diagnosis.verdict == Verdict::Unexplained && is_known
    }
}

/// The strikes of these residuals, in their order.
fn strikes_of<'s>(strikes: &'s [Strike], residuals: &[StopResidual]) -> Vec<&'s Strike> {
    let by_id: BTreeMap<&str, &Strike> = strikes
        .iter()
        .map(|strike| (strike.id.as_str(), strike))
        .collect();
    let each = residuals.iter();
    each.map(|residual| by_id[residual.strike_id.as_str()])
        .collect()
}

/// Strikes that stop far from where the others do, without what is named, and with it.
fn strays(rig: &Rig, strikes: &[&Strike], residuals: &[StopResidual]) -> [Strays; 2] {
    let ways: Vec<f64> = strikes.iter().map(|strike| strike.path().norm()).collect();
    let of = |error: fn(&StopResidual) -> [f64; 2]| {
        let errors: Vec<[f64; 2]> = residuals.iter().map(error).collect();
        Strays::of(&errors, &ways, rig.camera.noise)
    };
    [
        of(|residual| residual.before),
        of(|residual| residual.after),
    ]
}

/// The strikes that do not stray, and the residuals of those that do.
fn others(
    input: &Input,
    residuals: &[StopResidual],
    strays: &Strays,
) -> (Input, Vec<StopResidual>) {
    let astray = residuals.iter().zip(&strays.which);
    let astray = astray.filter(|(_, is_stray)| **is_stray);
    let astray: Vec<StopResidual> = astray.map(|(residual, _)| residual.clone()).collect();
    let ids: BTreeSet<&str> = astray.iter().map(|r| r.strike_id.as_str()).collect();
    let is_other = |strike: &&Strike| !ids.contains(strike.id.as_str());
    let others = Input {
        rig: input.rig.clone(),
        world: input.world.clone(),
        strikes: input.strikes.iter().filter(is_other).cloned().collect(),
        came_before: input.came_before.clone(),
    };
    (others, astray)
}

/// Share of the strikes beyond which they are the latest.
const LATEST: f64 = 0.95;

impl Gathered {
    /// Along the first of what was logged that strays follow.
    pub(crate) fn of(strays: &Strays, strikes: &[&Strike]) -> Option<Self> {
        let along = |of: fn(&Strike) -> f64| {
            let values: Vec<f64> = strikes.iter().map(|strike| of(strike)).collect();
            strays.gathered(&values)
        };
        let last = strikes.iter().map(|strike| strike.conditions.order);
        let last = last.fold(0.0, f64::max);
        let order = along(|strike| strike.conditions.order);
        let order = order.map(|[from, to]| Self::Order {
            from: from as usize,
            to: to as usize,
            is_latest: to > LATEST * last,
        });
        order
            .or_else(|| along(|s| s.command.speed).map(|[from, to]| Self::Speed(from, to)))
            .or_else(|| along(|s| s.command.angle).map(|[from, to]| Self::Angle(from, to)))
            .or_else(|| along(|s| s.initial.x).map(|[from, to]| Self::X(from, to)))
            .or_else(|| along(|s| s.initial.y).map(|[from, to]| Self::Y(from, to)))
    }
}

impl Diagnose {
    /// The diagnosis of the strikes that do not stray: what stands by itself does not stand on a few others.
    pub(crate) fn beside_strays(
        &self,
        input: &Input,
        progress: &Progress,
    ) -> Result<(Diagnosed, Astray), DiagnoseError> {
        let mut found = self.as_delivered(input, progress)?;
        let of = found.residuals.len();
        let (mut input, mut astray) = (Cow::Borrowed(input), Astray::default());
        for _ in 0..ROUNDS {
            let strikes = strikes_of(&input.strikes, &found.residuals);
            let [before, after] = strays(&input.rig, &strikes, &found.residuals);
            if !after.are_beyond_tails() {
                break;
            }
            // What follows from what was logged is no stray. Where what is named explains less than half of them, it may stand on them, and leave more
            // where it is wrong; but not in the order of strikes.
            let gathered = Gathered::of(&after, &strikes);
            let is_in_order = matches!(gathered, Some(Gathered::Order { .. }));
            let (strays, gathered) = match !is_in_order && before.count() < 2 * after.count() {
                true => {
                    let gathered = Gathered::of(&before, &strikes);
                    (before, gathered)
                }
                false => (after, gathered),
            };
            // What is named makes them: it is of the others.
            if !strays.are_beyond_tails() {
                break;
            }
            let left_out = astray.residuals.iter().map(|r| r.strike_id.clone());
            let now = strikes.iter().zip(&strays.which);
            let now = now.filter(|(_, is_stray)| **is_stray);
            let ids: Vec<String> = left_out.chain(now.map(|(s, _)| s.id.clone())).collect();
            let is_gathered = gathered.is_some();
            let round = Astray {
                told: Some(StrayStrikes {
                    count: ids.len(),
                    of,
                    others: strays.others,
                    gathered,
                }),
                ids,
                residuals: astray.residuals.clone(),
            };
            if !is_gathered && round.are_explained(&found.diagnosis) {
                break;
            }
            astray = round;
            if is_gathered {
                break;
            }
            let (others, residuals) = others(&input, &found.residuals, &strays);
            match self.as_delivered(&others, progress) {
                Ok(again) => found = again,
                Err(DiagnoseError::TooFewStrikes { .. } | DiagnoseError::NoFit { .. }) => break,
                Err(error) => return Err(error),
            }
            astray.residuals.extend(residuals);
            input = Cow::Owned(others);
        }
        Ok((found, astray))
    }
}
