//! The linear mixed model of strikes: what a strike's residual is evidence of when its launch scatters.
//!
//! r = X·β + G·b + ε for each strike: β common to all, b ~ N(0, P) its own launch, clock, resting place and friction, ε the camera's noise, made
//! independent beforehand ([`crate::noise`]). Friction also wanders over the order of strikes ([`crate::wander`]): γ ~ N(0, σ_w²) is common to all
//! strikes, acts as friction of φᵀγ and is integrated out as b is. All that is needed of a strike are the products of its columns, a few dozen
//! numbers in place of its frames. Variances by expectation and maximisation (Laird and Ware 1982).

mod components;
mod estimate;
mod marginal;
mod products;
mod reduced;

pub(crate) use components::{
    ANGLE, ESTIMATED, FRICTION, GREATEST, NUISANCES, SPEED, VarianceComponents,
};
pub(crate) use estimate::{Estimated, estimate, estimate_within};
pub(crate) use marginal::Prior;
pub(crate) use products::{Products, posterior};
