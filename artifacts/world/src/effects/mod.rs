//! The effects that a world can hold beyond its parameters: each one file of the same shape.
//!
//! An effect has parameters (name, unit, range, prior scale), acts in one or more of four places (the command, the
//! model of the impact, friction and force during the slide, the measurement), says where fits of it begin, and states a
//! fitted value to a person.

mod action;
mod added;
mod air_whirl;
mod anisotropic_friction;
mod camera_distortion;
mod camera_lean;
mod camera_rotation;
mod camera_seam;
mod camera_stretch;
mod field;
mod footprint;
mod formula;
mod friction_by_session;
mod friction_drift;
mod friction_from_start;
mod friction_gradient;
mod friction_line;
mod friction_map;
mod friction_patch;
mod friction_step;
mod library;
mod local_pull;
mod local_push;
mod off_centre_contact;
mod parameters;
mod path_curl;
mod quadratic_drag;
mod restitution_drift;
mod sessions;
mod spec;
mod speed_dependent_restitution;
mod speed_weakening_friction;
mod start;
mod striker_angle_bias;
mod striker_angle_by_session;
mod striker_angle_error;
mod striker_error_by_place;
mod striker_speed_error;
mod table_bowl;
mod table_map;
mod table_tilt;
mod table_tilt_by_session;
#[cfg(test)]
mod tests;
mod viscous_drag;
mod wording;

pub use action::{Acts, Effect, Slide, deliver, observe, unobserve};
pub use added::AddedEffect;
pub use friction_drift::Drift;
pub use friction_patch::patch_edge;
pub use library::{EFFECTS, build, check, effect, extend_library, library, values};
pub use parameters::{EffectParameter, Parameters, Values};
pub use sessions::{Population, UNKNOWN, centred};
pub use spec::{EffectSpec, Family, Naming, Origin};
pub use start::{Column, Combine, Experiment, FitStart};
