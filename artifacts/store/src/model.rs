//! The models that a version can be struck with.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

values::named! {
    /// A way from a path to a command, the plainest first.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Model {
        /// The world before anything was measured.
        Nominal = "nominal",
        /// The identified world.
        Sysid = "sysid",
        /// The identified world, and the residual that is left of it.
        SysidResidual = "sysid_residual",
        /// The identified world with the effects that the data named.
        Effect = "effect",
        /// That, and the residual that is left of it.
        EffectResidual = "effect_residual",
    }
}

impl Model {
    /// The model of its world with what is left of that; the nominal world has none.
    pub fn with_residual(self) -> Self {
        match self {
            Self::Sysid => Self::SysidResidual,
            Self::Effect => Self::EffectResidual,
            model => model,
        }
    }

    /// The model of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no model has. Its text completes "failed to …".
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("find the model `{0}`: there are nominal, sysid, sysid_residual, effect, effect_residual")]
pub struct UnknownModel(String);

impl FromStr for Model {
    type Err = UnknownModel;

    fn from_str(name: &str) -> Result<Self, UnknownModel> {
        Self::from_name(name).ok_or_else(|| UnknownModel(name.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_files() {
        for model in Model::ALL {
            assert_eq!(model.name().parse(), Ok(model));
            let json = serde_json::to_string(&model).expect("a name");
            assert_eq!(json, format!("\"{model}\""));
        }
        let error = "sysd".parse::<Model>().expect_err("unknown").to_string();
        assert!(
            error.contains("`sysd`") && error.contains("sysid_residual"),
            "{error}"
        );
    }
}
