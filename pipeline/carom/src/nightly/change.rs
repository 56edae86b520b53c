//! A table that changed for good: when, in what, and a version that follows it.

use judge::{HeldOut, stop_errors};
use serde::{Deserialize, Serialize};
use stage::Run;
use store::{Artifact, Calibrated, Contents, InputFile, Logged, Moved};
use values::{Split, StopErrors, Strike};
use world::Shift;

use super::held_out_gate::{HeldOutGate, compare, noise_floor};
use crate::Error;
use crate::score::{default_model, fitted, moved};

/// Folds of a cross-fit: each strike is predicted by a shift that it had no part in.
const FOLDS: usize = 5;

/// A change for good, from the night that it was found on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// The version that was in use: what is learnt since stands on it.
    pub version: String,
    /// Stamp of the first strike after it, in seconds since the epoch of the logs' clock.
    pub since: f64,
    /// What changed, in words.
    pub what: String,
}

impl Change {
    /// For a person.
    pub fn sentence(&self) -> String {
        format!(
            "changed for good: {} (found against {}, since stamp {:.0} s)",
            self.what, self.version, self.since
        )
    }
}

/// The version before a change, moved to where the strikes since have the table.
pub struct MovedVersion {
    /// What would be published.
    pub contents: Contents,
    /// How the table differs, beside the version before.
    pub shift: Shift,
}

/// What the candidate is computed from.
pub struct Since<'a> {
    /// The version before the change.
    pub base: &'a Artifact,
    /// All strikes since, in order of time.
    pub strikes: &'a [Strike],
    /// All strikes, and all logs, that the night read.
    pub all: Logged,
    /// The logs.
    pub inputs: Vec<InputFile>,
}

impl Since<'_> {
    /// The candidate that learnt from the training strikes since the change; none of too few.
    pub fn moved(&self, run: &Run) -> Result<Option<MovedVersion>, Error> {
        let learnt_from = |strike: &&Strike| strike.split != Split::Test;
        let strikes: Vec<Strike> = self.strikes.iter().filter(learnt_from).cloned().collect();
        let Some(fitted) = fitted(run, self.base, &strikes)? else {
            return Ok(None);
        };
        let shift = fitted.shift;
        let errors = self.cross_fitted(run, self.strikes)?;
        let of = |calibrated: &Calibrated| Calibrated {
            world: moved(&calibrated.world, shift),
            residual: calibrated.residual.clone(),
        };
        let base = &self.base.manifest.provenance;
        let mut provenance = base.clone();
        provenance
            .metrics
            .retain(|model, _| *model == base.default_model);
        if let Some(errors) = StopErrors::of(errors.into_iter().flatten()) {
            provenance.metrics.insert(base.default_model, errors);
        }
        for varies in provenance.varies.values_mut() {
            *varies = varies.moved(fitted.certainty);
        }
        provenance.strikes = Some(self.all);
        provenance.inputs = self.inputs.clone();
        provenance.moved = Some(Moved {
            version: self.base.version.clone(),
            strikes: fitted.seen.0.len(),
        });
        Ok(Some(MovedVersion {
            contents: Contents {
                rig: self.base.rig.clone(),
                sysid: of(&self.base.sysid),
                effect: self.base.effect.as_ref().map(of),
                provenance,
            },
            shift,
        }))
    }

    /// Whether strikes since, each predicted by a shift that it had no part in, stop nearer to where the moved version says than to
    /// where the version in use does: for the night of a change, when hardly any strike is held out.
    pub fn compare_cross_fitted(
        &self,
        run: &Run,
        current: &Artifact,
    ) -> Result<HeldOutGate, Error> {
        let by_current = predicted(run, current, Shift::default(), self.strikes)?;
        let by_moved = self.cross_fitted(run, self.strikes)?;
        let floor = noise_floor(current);
        Ok(compare(&current.version, floor, &by_current, &by_moved))
    }

    /// Each strike's error by the base, moved by what the strikes of the other folds show.
    fn cross_fitted(&self, run: &Run, strikes: &[Strike]) -> Result<Vec<Option<f64>>, Error> {
        let mut errors = vec![None; strikes.len()];
        for fold in 0..FOLDS {
            let part = |is_in: bool| -> (Vec<usize>, Vec<Strike>) {
                let chosen = strikes.iter().enumerate();
                let chosen = chosen.filter(|(place, _)| (place % FOLDS == fold) == is_in);
                chosen
                    .map(|(place, strike)| (place, strike.clone()))
                    .unzip()
            };
            let (_, others) = part(false);
            let Some(fitted) = fitted(run, self.base, &others)? else {
                continue;
            };
            let (places, judged) = part(true);
            for (place, error) in
                places
                    .into_iter()
                    .zip(predicted(run, self.base, fitted.shift, &judged)?)
            {
                errors[place] = error;
            }
        }
        Ok(errors)
    }
}

/// Stop errors of a version's default model, its table moved.
fn predicted(
    run: &Run,
    version: &Artifact,
    shift: Shift,
    strikes: &[Strike],
) -> Result<Vec<Option<f64>>, Error> {
    let mut model = default_model(version);
    model.world = moved(&model.world, shift);
    let mut judges: Vec<HeldOut> = strikes.iter().map(HeldOut::from).collect();
    for judge in &mut judges {
        // A session that the version does not know.
        judge.conditions.session = String::new();
    }
    Ok(stop_errors(run, &model, &judges)?)
}
