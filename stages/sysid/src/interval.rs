//! 95 % intervals from how strikes differ.

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, StudentsT};
use world::{Estimate, World, parameter};

use crate::{SysidError, fit::Fitted};

/// The fitted world with intervals: the larger of the model's variance A⁻¹ and the jackknife's A⁻¹·B·A⁻¹, B from each
/// strike's own score s at the fit to all others, (1 − A_i·A⁻¹)⁻¹·s (Bell and McCaffrey 2002, "CR3"), at Student's t with as many
/// degrees of freedom as strikes less parameters. `unseen`: relative variance that friction's mean over all strikes has beside that
/// over those that were used ([`crate::wander`]).
pub(crate) fn with_intervals(fitted: &Fitted, unseen: f64) -> Result<World, SysidError> {
    let (n, p) = (fitted.scores.len() as f64, fitted.information.ncols());
    let Some(inverse) = fitted.information.clone().try_inverse() else {
        return Err(SysidError::Singular {
            names: fitted.free.join(", "),
        });
    };
    let mut between = DMatrix::zeros(p, p);
    for (score, own) in fitted.scores.iter().zip(&fitted.informations) {
        // A strike pulls the fit towards itself: without it, its score would have been this.
        let kept = DMatrix::identity(p, p) - own * &inverse;
        let away = kept.lu().solve(score).unwrap_or_else(|| score.clone());
        between += &away * away.transpose();
    }
    let freedom = (n - p as f64).max(1.0);
    let sandwich = &inverse * (between * ((n - 1.0) / n)) * &inverse;
    let quantile = StudentsT::new(0.0, 1.0, freedom).map_or(1.96, |t| t.inverse_cdf(0.975));
    let mut world = fitted.world.clone();
    for (i, name) in fitted.free.iter().enumerate() {
        let spec = parameter(name)?;
        let value = world.value(name)?;
        let mut variance = inverse[(i, i)].max(sandwich[(i, i)]);
        if name == "friction" {
            variance += value * value * unseen;
        }
        let half = quantile * variance.sqrt();
        let estimate = Estimate::with_interval(
            value,
            (value - half).max(spec.low),
            (value + half).min(spec.high),
        );
        world.parameters.insert(name.clone(), estimate);
    }
    Ok(world)
}
