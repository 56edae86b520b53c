//! A table that changed for good: when, in what, and a version that follows it.

use std::collections::BTreeSet;

use judge::{HeldOut, stop_errors};
use serde::{Deserialize, Serialize};
use stage::Run;
use store::{Artifact, Calibrated, Contents, Moved, TrainedRegion};
use values::{Interval, Split, StopErrors, Strike};
use world::{Session, Shift};

use super::held_out_gate::{HeldOutGate, compare, noise_floor, unseen};
use crate::Error;
use crate::score::{default_model, fitted, moved, varies};

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
        provenance.trained_region = widened(provenance.trained_region, &strikes);
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

    /// Whether strikes since that the version in use did not learn from, each predicted by a shift that it had no part in, stop no
    /// farther from where the moved version says than from where the version in use does: hardly any strike is held out soon after a change.
    pub fn compare_cross_fitted(
        &self,
        run: &Run,
        current: &Artifact,
    ) -> Result<HeldOutGate, Error> {
        let judges = unseen(self.strikes, f64::NEG_INFINITY, [current]);
        let judges: BTreeSet<&str> = judges.iter().map(|strike| strike.id.as_str()).collect();
        let judging = |errors: Vec<Option<f64>>| -> Vec<Option<f64>> {
            let each = self.strikes.iter().zip(errors);
            each.filter(|(strike, _)| judges.contains(strike.id.as_str()))
                .map(|(_, error)| error)
                .collect()
        };
        let by_current = judging(predicted(run, current, Shift::default(), self.strikes)?);
        let by_moved = judging(self.cross_fitted(run, self.strikes)?);
        let floor = noise_floor(current);
        Ok(compare(&current.version, floor, &by_current, &by_moved))
    }

    /// Each strike's error by the base, moved by what the strikes of the other folds show. Slopes are those where all of them have the table.
    fn cross_fitted(&self, run: &Run, strikes: &[Strike]) -> Result<Vec<Option<f64>>, Error> {
        let mut errors = vec![None; strikes.len()];
        let Some(all) = fitted(run, self.base, strikes)? else {
            return Ok(errors);
        };
        let known = varies(self.base);
        for fold in 0..FOLDS {
            let is_in = |order: f64| order as usize % FOLDS == fold;
            let others = all.seen.0.iter().filter(|(order, _)| !is_in(*order));
            let Some((step, _)) = known.fit(&Session(others.copied().collect())) else {
                continue;
            };
            let places = (0..strikes.len()).filter(|place| is_in(strikes[*place].conditions.order));
            let places: Vec<usize> = places.collect();
            let judged: Vec<Strike> = places.iter().map(|place| strikes[*place].clone()).collect();
            let predicted = predicted(run, self.base, all.about.and(step), &judged)?;
            for (place, error) in places.into_iter().zip(predicted) {
                errors[place] = error;
            }
        }
        Ok(errors)
    }
}

/// A trained region with the lengths and stops of these strikes' paths, too: a table that brakes more stops objects nearer.
fn widened(region: TrainedRegion, strikes: &[Strike]) -> TrainedRegion {
    let Some(since) = TrainedRegion::of(strikes.iter().map(|s| (s.initial, s.stop))) else {
        return region;
    };
    let both = |a: Interval, b: Interval| Interval::new(a.low.min(b.low), a.high.max(b.high));
    TrainedRegion {
        distance: both(region.distance, since.distance),
        stop_x: both(region.stop_x, since.stop_x),
        stop_y: both(region.stop_y, since.stop_y),
        ..region
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
