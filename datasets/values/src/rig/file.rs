//! Reading and writing `rig.toml`.

use std::path::Path;

use super::{Rig, RigError, check, keys};

impl Rig {
    /// Reads and checks a rig file. Errors name the file's line or the key, and how to mend it.
    pub fn load(path: &Path) -> Result<Self, RigError> {
        let text = std::fs::read_to_string(path).map_err(|source| RigError::Read {
            path: path.display().to_string(),
            source,
        })?;
        Self::parse(&text)
    }

    /// Parses and checks the text of a rig file: a value of this type that came from here holds positive,
    /// finite sizes that its shape needs, intervals that are not empty, and units that are plausible.
    pub fn parse(text: &str) -> Result<Self, RigError> {
        keys::check(text)?;
        let rig: Self = toml::from_str(text).map_err(|error| RigError::Parse(error.to_string()))?;
        check::check(&rig)?;
        Ok(rig)
    }

    /// A commented rig file to start from; it reads as [`Rig::demo`] with a cylinder.
    pub fn template() -> &'static str {
        include_str!("template.toml")
    }

    /// The text of a rig file that reads back as this value.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a rig is plain data")
    }
}
