//! Smooth dependences: small bumps over a covariate (the table, a speed, the order of strikes …) whose heights are Gaussian with one common
//! standard deviation, by marginal likelihood. They stand for what an effect of another form than the library's would leave, and are drawn as maps.

pub(crate) mod bumps;
pub(crate) mod covariate;
pub(crate) mod ridge;

use self::{
    bumps::bumps,
    covariate::{Covariate, family},
    ridge::Ridge,
};
use crate::{
    fit::Fitted,
    score::{RandomColumns, Replicates, ScoreTest},
    sessions::is_by_session,
    strikes::PreparedStrikes,
};

/// Columns for what a wrong form of the effects held would leave: smooth dependences of their families, each as large as the marginal likelihood
/// would have it. They stand beside a model while it is asked whether it lacks another effect. Friction of its own for each session is no form.
pub(crate) fn family_columns(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
) -> Vec<RandomColumns> {
    let parts = fitted.model.parts.iter();
    let mut covariates: Vec<Covariate> = parts
        .flat_map(|part| {
            let over = family(part.name).iter().copied();
            over.filter(|over| *over != Covariate::Wear || !is_by_session(part.name))
        })
        .collect();
    covariates.sort_unstable();
    covariates.dedup();
    let mut random: Vec<RandomColumns> = Vec::new();
    for covariate in covariates {
        let Some(test) = ScoreTest::new(prepared, fitted, &random, Replicates::NONE) else {
            break;
        };
        let Some(bumps) = bumps(prepared, fitted, &test, covariate) else {
            continue;
        };
        let scores = test.scores(bumps.count(), &bumps.moved);
        let ridge = Ridge::new(&scores, bumps.scale);
        if ridge.variance > 0.0 {
            random.push(RandomColumns {
                moved: bumps.moved,
                variance: ridge.variance,
            });
        }
    }
    random
}
