//! 95 % intervals from how strikes differ.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use values::Strike;
use world::{Estimate, World, parameter};

use crate::{SysidError, fit::Fitted, scatter::Evidence};

/// Variance of each of what was fitted: the larger of the model's, A⁻¹, and the jackknife's A⁻¹·B·A⁻¹, B from each strike's own
/// score s at the fit to all others, (1 − A_i·A⁻¹)⁻¹·s (Bell and McCaffrey 2002, "CR3"). None where A, the sum of the strikes'
/// `informations` and what was known before, is singular. `scores`: at the fit.
pub(crate) fn variances(
    scores: &[DVector<f64>],
    informations: &[DMatrix<f64>],
    whole: &DMatrix<f64>,
) -> Option<DVector<f64>> {
    let (n, p) = (scores.len() as f64, whole.ncols());
    let inverse = whole.clone().try_inverse()?;
    let mut between = DMatrix::zeros(p, p);
    for (score, own) in scores.iter().zip(informations) {
        // A strike pulls the fit towards itself: without it, its score would have been this.
        let kept = DMatrix::identity(p, p) - own * &inverse;
        let away = kept.lu().solve(score).unwrap_or_else(|| score.clone());
        between += &away * away.transpose();
    }
    let sandwich = &inverse * (between * ((n - 1.0) / n)) * &inverse;
    Some(inverse.diagonal().sup(&sandwich.diagonal()))
}

/// Error that all tracks may share and this world does not have, as a share of the way gone: the integration of a roll is known to so much, and no
/// lens or table to less than a third of it.
const SHARED: f64 = 0.003;

/// Error of each fitted value if all tracks are off by [`SHARED`] of their ways at each frame, all alike. A ball that rolls far shows its sliding in
/// a few frames, which the rest of its way outweighs. None where nothing is determined.
pub(crate) fn shared(fitted: &Fitted, strikes: &[&Strike]) -> Option<DVector<f64>> {
    let inverse = fitted.information.clone().try_inverse()?;
    let mut pulls: Vec<DVector<f64>> = Vec::new();
    for (i, strike) in strikes.iter().enumerate() {
        let (residual, nuisances) = (&fitted.residuals[i], &fitted.slopes.by_nuisance[i]);
        let evidence = Evidence::new(false, residual.clone(), nuisances, &fitted.components);
        let weighed = evidence.weigh(&fitted.slopes.by_fitted[i]) * fitted.weights[i];
        let frames = strike.track.len();
        pulls.resize_with(pulls.len().max(frames), || DVector::zeros(inverse.nrows()));
        for (frame, pull) in pulls.iter_mut().take(frames).enumerate() {
            let gone = strike.track.point(frame) - strike.initial;
            *pull += weighed.row(frame).transpose() * gone.x;
            *pull += weighed.row(frames + frame).transpose() * gone.y;
        }
    }
    let squares = pulls
        .iter()
        .map(|pull| (&inverse * pull).map(|off| off * off));
    let sum = squares.fold(DVector::zeros(inverse.nrows()), |sum, square| sum + square);
    Some(sum.map(|sum: f64| SHARED * sum.sqrt()))
}

/// Quantile of Student's t with as many degrees of freedom as strikes less what was fitted.
pub(crate) fn quantile(strikes: usize, fitted: usize, probability: f64) -> f64 {
    let freedom = strikes.saturating_sub(fitted).max(1) as f64;
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(probability))
}

/// Least number of groups that tell how groups differ.
const FEWEST: usize = 3;
/// Contiguous parts of the order whose means may differ: longer than most wanders are alike.
const BLOCKS: usize = 6;
/// Probability below which groups of strikes differ by more than their strikes make them.
const DIFFER: f64 = 0.01;

/// By how many times the intervals of strikes that differ each by itself are too narrow for each fitted value, where strikes differ by groups: by
/// sessions, or early and late, as where an arm or a table wanders. A group's score is one observation then. 1 where groups are few, or do not
/// differ so.
fn by_groups(fitted: &Fitted, strikes: &[&Strike], variances: &DVector<f64>) -> Vec<f64> {
    // Slides that no strike began have no place in the order.
    let of = |i: usize| &strikes[i].conditions;
    let mut struck: Vec<usize> = (0..strikes.len()).filter(|i| !of(*i).is_unstruck).collect();
    struck.sort_by(|a, b| of(*a).order.total_cmp(&of(*b).order));
    let session = |i: &usize| of(*i).session.as_str();
    let names: BTreeSet<&str> = struck.iter().map(session).collect();
    let of_session = |i| names.range(..session(i)).count();
    let sessions: Vec<usize> = struck.iter().map(of_session).collect();
    let blocks = (0..struck.len()).map(|place| BLOCKS * place / struck.len());
    let groupings = [(names.len(), sessions), (BLOCKS, blocks.collect())];
    let mut times = vec![1.0; variances.len()];
    let Some(inverse) = fitted.information.clone().try_inverse() else {
        return times;
    };
    let normal = quantile(fitted.scores.len(), variances.len(), 0.975);
    for (count, group) in groupings {
        let freedom = count as f64 - 1.0;
        let (Ok(chance), true) = (
            ChiSquared::new(freedom),
            count >= FEWEST && struck.len() >= 3 * count,
        ) else {
            continue;
        };
        let mut sums = vec![DVector::zeros(variances.len()); count];
        for (i, group) in struck.iter().zip(group) {
            sums[group] += &fitted.scores[*i];
        }
        let scale = count as f64 / freedom;
        let own = quantile(count, 1, 0.975);
        for (i, times) in times.iter_mut().enumerate() {
            let off = sums
                .iter()
                .map(|sum| inverse.row(i).transpose().dot(sum).powi(2));
            let ratio = scale * off.sum::<f64>() / variances[i];
            if ratio > chance.inverse_cdf(1.0 - DIFFER) / freedom {
                *times = f64::max(*times, ratio.sqrt() * own / normal);
            }
        }
    }
    times
}

/// The fitted world with its 95 % intervals. `unseen`: relative variance of the difference between friction's mean over all strikes and that over
/// those used ([`crate::wander`]). `shared`: further error of each value ([`shared`]). `strikes`: those that were fitted, in their order.
pub(crate) fn with_intervals(
    fitted: &Fitted,
    unseen: f64,
    shared: Option<&DVector<f64>>,
    strikes: &[&Strike],
) -> Result<World, SysidError> {
    let Some(variances) = variances(&fitted.scores, &fitted.informations, &fitted.information)
    else {
        return Err(SysidError::Singular {
            names: fitted.free.join(", "),
        });
    };
    let quantile = quantile(fitted.scores.len(), variances.len(), 0.975);
    let times = by_groups(fitted, strikes, &variances);
    let mut world = fitted.world.clone();
    for (i, name) in fitted.free.iter().enumerate() {
        let spec = parameter(name)?;
        let value = world.value(name)?;
        let mut variance = variances[i] * times[i] * times[i];
        if name == "friction" {
            variance += value * value * unseen;
        }
        let half = quantile * variance.sqrt() + shared.map_or(0.0, |shared| shared[i]);
        let estimate = Estimate::with_interval(
            value,
            (value - half).max(spec.low),
            (value + half).min(spec.high),
        );
        world.parameters.insert(name.clone(), estimate);
    }
    Ok(world)
}
