//! An effect as a world holds it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::Estimate;

/// An effect added to the world, with the values of its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AddedEffect {
    /// Its name in the library, such as `viscous_drag`.
    pub name: String,
    /// Its parameters, by name.
    pub parameters: BTreeMap<String, Estimate>,
}

impl AddedEffect {
    /// An effect whose parameters have these values, which nothing estimated.
    pub fn fixed(name: &str, parameters: &[(&str, f64)]) -> Self {
        let fixed = |(name, value): &(&str, f64)| (name.to_string(), Estimate::fixed(*value));
        Self {
            name: name.into(),
            parameters: parameters.iter().map(fixed).collect(),
        }
    }

    /// An effect as tests list it: `name: parameter = value, …`.
    #[cfg(test)]
    pub(crate) fn listed(line: &str) -> Self {
        let (name, parameters) = line.split_once(": ").expect("an effect");
        let value = |one: &'_ str| {
            let (name, value) = one.split_once(" = ").expect("a parameter");
            let value = value.parse().expect("a number");
            (name.to_owned(), Estimate::fixed(value))
        };
        Self {
            name: name.into(),
            parameters: parameters.split(", ").map(value).collect(),
        }
    }
}
