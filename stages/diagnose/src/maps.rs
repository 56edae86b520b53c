//! How much of the gap smooth maps would take: of the launch over commands, and of friction over the table.
//!
//! The maps are bumps whose heights have a common standard deviation by marginal likelihood ([`crate::smooth`]). What they
//! take is judged on stops of strikes that each fit leaves out, against a fit without a map on the same strikes.

use nalgebra::{DMatrix, DVector};
use values::Point;
use world::{GRAVITY, WorldError};

use crate::diagnosis::{MapPoint, SmoothMap};
use crate::fit::Fitted;
use crate::heldout::folds;
use crate::mixed::posterior;
use crate::score::{Replicates, ScoreTest, StrikeColumns};
use crate::smooth::{Bumps, Covariate, Ridge, bumps};
use crate::strikes::PreparedStrikes;

/// Names of the maps, and what they run over.
const MAPS: [(&str, Covariate); 2] = [
    ("launch", Covariate::Command),
    ("friction", Covariate::Surface),
];

/// Both maps beside a fitted model.
pub(crate) fn maps(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
) -> Result<Vec<SmoothMap>, WorldError> {
    let Some(test) = ScoreTest::new(prepared, fitted, &[], Replicates::NONE) else {
        return Ok(Vec::new());
    };
    let mut maps = Vec::new();
    for (name, covariate) in MAPS {
        let Some(bumps) = bumps(prepared, fitted, &test, covariate) else {
            continue;
        };
        let scores = test.scores(bumps.count(), &bumps.moved);
        let ridge = Ridge::new(&scores, bumps.scale);
        let Some([before, after]) = judged(prepared, fitted, &bumps, ridge.variance) else {
            continue;
        };
        let unit = match covariate {
            Covariate::Surface => GRAVITY * fitted.model.values[crate::model::FRICTION],
            _ => 1.0,
        };
        let change = |at: Point| bumps.height_at(at, &ridge.heights) * unit.recip();
        maps.push(SmoothMap {
            name: name.into(),
            before,
            after,
            share: (1.0 - (after / before.max(1e-12)).powi(2)).clamp(0.0, 1.0),
            points: bumps
                .middles()
                .into_iter()
                .map(|at| MapPoint {
                    at: [at.x, at.y],
                    change: [change(at).x, change(at).y],
                })
                .collect(),
        });
    }
    Ok(maps)
}

/// One strike's normal equations in the model's values and the bumps' heights together, and the position of its last frame with them.
struct Normal {
    information: DMatrix<f64>,
    score: DVector<f64>,
    /// The last frame's residual, and its derivatives.
    stop: Point,
    slopes: DMatrix<f64>,
}

/// Root mean square residuals of last frames, without and with the bumps, of strikes that took no part.
fn judged(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    bumps: &Bumps,
    variance: f64,
) -> Option<[f64; 2]> {
    let normals: Vec<Normal> = (0..prepared.strikes.len())
        .map(|i| normal(prepared, fitted, &bumps.moved, bumps.count(), i))
        .collect();
    let folds = folds(prepared);
    let own = fitted.model.free.len();
    let mut errors = [0.0; 2];
    for fold in folds
        .iter()
        .copied()
        .collect::<std::collections::BTreeSet<_>>()
    {
        for (square, count) in errors.iter_mut().zip([own, own + bumps.count()]) {
            if count > own && variance <= 0.0 {
                continue;
            }
            let mut information = DMatrix::zeros(count, count);
            let mut score = DVector::zeros(count);
            for (normal, _) in normals.iter().zip(&folds).filter(|(_, f)| **f != fold) {
                information += normal.information.view((0, 0), (count, count));
                score += normal.score.rows(0, count);
            }
            for k in 0..count {
                information[(k, k)] += match fitted.model.free.get(k) {
                    Some(free) => free.width.powi(-2),
                    None => variance.recip(),
                };
            }
            let change = information.cholesky()?.solve(&score);
            for (normal, _) in normals.iter().zip(&folds).filter(|(_, f)| **f == fold) {
                let moved = normal.slopes.columns(0, count) * &change;
                let left = normal.stop - Point::new(moved[0], moved[1]);
                *square += left.dot(left);
            }
        }
    }
    if variance <= 0.0 {
        errors[1] = errors[0];
    }
    Some(errors.map(|square| (square / normals.len().max(1) as f64).sqrt()))
}

fn normal(
    prepared: &PreparedStrikes<'_>,
    fitted: &Fitted,
    moved: &StrikeColumns,
    count: usize,
    i: usize,
) -> Normal {
    let whitened = &fitted.linearisation.whitened[i];
    let raw = &fitted.linearisation.raw[i];
    let components = &fitted.estimated.components;
    let (rows, own) = (raw.residual.len(), fitted.model.free.len());
    let mut all = whitened
        .values
        .clone()
        .resize_horizontally(own + count, 0.0);
    let mut slopes = DMatrix::zeros(2, own + count);
    let last = [rows / 2 - 1, rows - 1];
    for (k, row) in last.iter().enumerate() {
        for j in 0..own {
            slopes[(k, j)] = raw.values[(*row, j)];
        }
    }
    if let Some(columns) = &moved[i] {
        all.columns_mut(own, count).copy_from(columns);
        for j in 0..count {
            let restored = prepared.whitenings[i].restored(columns.column(j));
            for (k, row) in last.iter().enumerate() {
                slopes[(k, own + j)] = restored[*row];
            }
        }
    }
    let precision = components.camera.powi(-2);
    let g = &whitened.nuisances;
    let weighed = (&all - g * (posterior(g, components) * g.tr_mul(&all))) * precision;
    Normal {
        information: all.transpose() * &weighed,
        score: weighed.tr_mul(&whitened.residual),
        stop: Point::new(raw.residual[last[0]], raw.residual[last[1]]),
        slopes,
    }
}
