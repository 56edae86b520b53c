//! The library: every effect that a world can hold.

use std::{
    collections::BTreeMap,
    fmt::{self, Display, Formatter},
    sync::OnceLock,
};

use values::Rig;

use super::{
    action::Effect,
    added::AddedEffect,
    parameters::{Parameters, Values},
    spec::EffectSpec,
};
use crate::{WorldError, parameter::in_range};

/// The library.
pub const EFFECTS: &[&EffectSpec] = &[
    &super::viscous_drag::SPEC,
    &super::quadratic_drag::SPEC,
    &super::speed_weakening_friction::SPEC,
    &super::anisotropic_friction::SPEC,
    &super::friction_patch::SPEC,
    &super::friction_drift::SPEC,
    &super::friction_by_session::SPEC,
    &super::table_tilt::SPEC,
    &super::table_bowl::SPEC,
    &super::striker_speed_error::SPEC,
    &super::striker_angle_bias::SPEC,
    &super::speed_dependent_restitution::SPEC,
    &super::off_centre_contact::SPEC,
    &super::camera_rotation::SPEC,
    &super::camera_distortion::SPEC,
    &super::striker_angle_error::SPEC,
    &super::striker_angle_by_session::SPEC,
    &super::restitution_drift::SPEC,
    &super::friction_gradient::SPEC,
    &super::friction_step::SPEC,
    &super::camera_lean::SPEC,
    &super::friction_map::SPEC,
    &super::table_map::SPEC,
    &super::friction_line::SPEC,
    &super::striker_error_by_place::SPEC,
    &super::local_pull::SPEC,
    &super::local_push::SPEC,
    &super::path_curl::SPEC,
    &super::air_whirl::SPEC,
    &super::camera_stretch::SPEC,
    &super::camera_seam::SPEC,
    &super::friction_from_start::SPEC,
    &super::table_tilt_by_session::SPEC,
];

/// Number of valid parameters that an error lists where another is not known.
const TOLD: usize = 12;

/// Effects of other crates.
static MORE: OnceLock<Vec<&'static EffectSpec>> = OnceLock::new();

/// Adds effects of another crate to the library of this process; `false` where that was done before, and nothing is added.
/// To be called before a world is read, fitted or simulated.
pub fn extend_library(more: &[&'static EffectSpec]) -> bool {
    MORE.set(more.to_vec()).is_ok()
}

/// Every effect: [`EFFECTS`], then those of [`extend_library`].
pub fn library() -> impl Iterator<Item = &'static EffectSpec> {
    let more = MORE.get().into_iter().flatten();
    EFFECTS.iter().chain(more).copied()
}

/// The effect of that name; the error lists the valid ones.
pub fn effect(name: &str) -> Result<&'static EffectSpec, WorldError> {
    library()
        .find(|spec| spec.name == name)
        .ok_or_else(|| WorldError::UnknownEffect {
            name: name.into(),
            known: library()
                .map(|spec| spec.name)
                .collect::<Vec<_>>()
                .join(", "),
        })
}

/// Values of an added effect, each parameter known and in range; listed parameters left out are neutral.
pub fn values(added: &AddedEffect) -> Result<Values, WorldError> {
    let spec = effect(&added.name)?;
    let listed = match spec.parameters {
        Parameters::Listed(listed) => listed,
        Parameters::BySession { .. } => &[],
    };
    let mut values: BTreeMap<String, f64> = listed
        .iter()
        .map(|p| (p.name.to_string(), p.neutral))
        .collect();
    for (name, estimate) in &added.parameters {
        let full = format!("{}.{name}", added.name);
        let Some(p) = spec.parameter(name) else {
            // A map has a hundred.
            let (told, more) = listed.split_at(listed.len().min(TOLD));
            let known: Vec<_> = told.iter().map(|p| p.name).collect();
            let more = match more.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            return Err(WorldError::UnknownParameter {
                name: full,
                hint: String::new(),
                known: known.join(", ") + &more,
            });
        };
        in_range(&full, estimate.value, p.low, p.high, p.unit)?;
        values.insert(name.clone(), estimate.value);
    }
    Ok(Values {
        all: values,
        given: added.parameters.keys().cloned().collect(),
    })
}

/// Whether an added effect is known and its values lie in their ranges.
pub fn check(added: &AddedEffect) -> Result<(), WorldError> {
    values(added).map(|_| ())
}

/// Builds an added effect.
pub fn build(added: &AddedEffect, rig: &Rig) -> Result<Box<dyn Effect>, WorldError> {
    Ok((effect(&added.name)?.build)(&values(added)?, rig))
}

/// An added effect's values in a sentence; of one that is not valid, its name.
impl Display for AddedEffect {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let stated = effect(&self.name).and_then(|spec| Ok((spec.statement)(&values(self)?)));
        f.pad(stated.as_deref().unwrap_or(&self.name))
    }
}
