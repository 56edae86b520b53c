//! Diagnosis: where the calibrated world and the measured strikes disagree, which physical effect is missing, and how far
//! the gap shrinks with it.
//!
//! The strike is the unit of evidence: its launch scatters, so a whole track is worth far less than its frames ([`mixed`]).
//! What else a table and a camera scatter by is estimated first ([`noise`], [`null`]).
//! Worlds are tried in planar form ([`world::planar`]), which follows MuJoCo's to a twentieth of a millimetre, a hundred times as
//! fast. Whether: score tests of every candidate, against residuals drawn from the fitted world and its noise, confirmed by
//! flipped signs of whole strikes ([`evidence`]). Which: fits of the best candidates, forward, replaced and dropped again
//! ([`search`]); what they name must predict strikes that took no part ([`heldout`]). Whatever it is called: what depends on
//! commands, places and order, asked by permutations, before and beside the effects ([`question`]). The gap is judged in MuJoCo ([`gap`]).

mod alias;
mod arm;
mod before;
mod camera_drift;
mod candidates;
mod carry;
mod conclude;
mod constancy;
mod diagnosis;
mod error;
mod evidence;
mod facing;
mod fit;
mod fitted_world;
mod gap;
mod heldout;
mod linearisation;
mod load_shift;
mod maps;
mod mixed;
mod model;
mod next;
mod noise;
mod notes;
mod null;
mod question;
mod run;
mod score;
mod screen;
mod search;
mod sessions;
mod settings;
mod smooth;
mod strays;
mod strikes;
mod thresholds;
mod usable;
mod wander;
mod words;
mod wrong_sizes;

pub use before::CameBefore;
pub use diagnosis::{
    Detectable, Diagnosed, Diagnosis, Gap, GapDependence, MapPoint, NamedEffect, NextStrike, Noise,
    Parameter, Ranked, SmoothMap, StopResidual, Verdict,
};
pub use error::DiagnoseError;
pub use settings::{Diagnose, Input};
pub use thresholds::Thresholds;
pub use words::{
    Cause, Dependence, Gathered, NoiseKind, Note, Purpose, StrayStrikes, Summary, WhyNot,
};
