//! Where: smooth dependences of the gap on each covariate, with no physics assumed.
//!
//! Each is a set of small bumps (over the table, over speed, over strikes …) whose heights are Gaussian with one common
//! standard deviation; the gain in marginal likelihood says how much of the gap goes with that covariate, and what the same
//! bumps gain in replicates says whether it is real. What is left here after the best effects is what no candidate explains.
//! A dependence is reported net of what the model's own values (friction, restitution …) make up for.

pub(crate) mod bumps;
pub(crate) mod covariate;
mod peak;
mod restricted;
pub(crate) mod ridge;

use nalgebra::DMatrix;
use values::Point;
use world::WorldError;

use self::{
    bumps::bumps,
    covariate::{COVARIATES, Covariate, family},
    peak::Peak,
    restricted::{Restricted, restricted},
    ridge::Ridge,
};
use crate::{
    fit::Fitted,
    score::{RandomColumns, Replicates, ScoreTest},
    strikes::PreparedStrikes,
};

/// What a covariate has to do with the gap.
#[derive(Clone, Debug)]
pub(crate) struct Dependence {
    pub(crate) covariate: Covariate,
    /// Gain in marginal likelihood.
    pub(crate) gain: f64,
    /// The same in each replicate: those drawn, then those flipped.
    pub(crate) by_chance: Vec<f64>,
    /// Where it is strongest (in the covariate's unit; on the table x and y, in m), and how strong there: m/s², relative
    /// friction, relative speed, or rad.
    pub(crate) at: Point,
    pub(crate) peak: Point,
}

/// The first stream of random numbers of bumps; those of launches come before.
const STREAM: u64 = 8;

/// Every covariate's dependence at a fitted model.
pub(crate) fn dependences(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    replicates: Replicates,
) -> Result<Vec<Dependence>, WorldError> {
    match ScoreTest::new(prepared, fitted, &[], replicates) {
        Some(test) => dependences_of(prepared, fitted, &test),
        None => Ok(Vec::new()),
    }
}

/// The same of a test that is there.
pub(crate) fn dependences_of(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    test: &ScoreTest<'_, '_>,
) -> Result<Vec<Dependence>, WorldError> {
    let mut found = Vec::new();
    for covariate in COVARIATES {
        if let Some(launched) = launched(prepared, test, covariate) {
            found.push(launched);
            continue;
        }
        let Some(bumps) = bumps(prepared, fitted, test, covariate)? else {
            continue;
        };
        let scores = test.scores(bumps.places.len(), &bumps.moved);
        let normals = test.normals(bumps.count(), STREAM + covariate as u64);
        let ridge = Ridge::new(&scores, bumps.scale, &normals);
        let peak = Peak { prepared, test };
        let (at, peak) = peak.strongest(covariate, &scores, &bumps, &ridge.heights);
        found.push(Dependence {
            covariate,
            gain: ridge.gain,
            by_chance: ridge.by_chance,
            at,
            peak,
        });
    }
    Ok(found)
}

/// A dependence of launches on what was commanded, each side at its own scatter; none where random columns stand beside the model,
/// which have a variance of their own.
fn launched(
    prepared: &PreparedStrikes<'_>,
    test: &ScoreTest<'_, '_>,
    covariate: Covariate,
) -> Option<Dependence> {
    let commands = prepared.strikes.iter().map(|strike| strike.command);
    let at: Vec<f64> = match covariate {
        Covariate::Speed => commands.map(|command| command.speed).collect(),
        Covariate::Angle => commands.map(|command| command.angle).collect(),
        _ => return None,
    };
    if test.is_beside {
        return None;
    }
    let Restricted {
        gain,
        by_chance,
        strike,
        peak,
    } = restricted(test, &at)?;
    Some(Dependence {
        covariate,
        gain,
        by_chance,
        at: Point::new(at[strike], 0.0),
        peak,
    })
}

/// What a wrong form of the effects held would leave: smooth dependences of their families, each as large as the marginal
/// likelihood would have it. They stand beside a model while it is asked whether it lacks another effect.
pub(crate) fn family_columns(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
) -> Result<Vec<RandomColumns>, WorldError> {
    let parts = fitted.model.parts.iter();
    let mut covariates: Vec<Covariate> = parts
        .flat_map(|part| family(part.name).iter().copied())
        .collect();
    covariates.sort_unstable();
    covariates.dedup();
    let mut random: Vec<RandomColumns> = Vec::new();
    for covariate in covariates {
        let Some(test) = ScoreTest::new(prepared, fitted, &random, Replicates::NONE) else {
            break;
        };
        let Some(bumps) = bumps(prepared, fitted, &test, covariate)? else {
            continue;
        };
        let scores = test.scores(bumps.places.len(), &bumps.moved);
        let ridge = Ridge::new(&scores, bumps.scale, &DMatrix::zeros(0, 0));
        if ridge.variance > 0.0 {
            random.push(RandomColumns {
                moved: bumps.moved,
                variance: ridge.variance,
            });
        }
    }
    Ok(random)
}
