//! What this robot trusts: a file on its own computer, not among what is copied to it.

use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::Deserialize;

/// The configuration; paths are relative to the folder of its file.
///
/// ```toml
/// key = "carom.pub"     # versions must be signed by this key
/// rig = "rig.toml"      # and be this robot's own
/// seen = "carom.seen"   # the newest version seen is kept here
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Public key, in minisign's format, that versions must be signed by.
    pub key: Option<PathBuf>,
    /// This robot's own rig file.
    pub rig: Option<PathBuf>,
    /// Where the newest version seen is kept; beside the key unless given.
    pub seen: Option<PathBuf>,
}

/// A configuration that cannot be used. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum ConfigError {
    #[error("read the configuration {}: {source}", path.display())]
    Unreadable { path: PathBuf, source: io::Error },
    #[error("read the configuration {}: {why}; it may hold `key`, `rig` and `seen`", path.display())]
    Malformed { path: PathBuf, why: String },
}

impl Config {
    /// Reads a configuration.
    pub fn load(path: &Path) -> Result<Self, ConfigError> {
        let text = fs::read_to_string(path).map_err(|source| ConfigError::Unreadable {
            path: path.into(),
            source,
        })?;
        let config: Self = toml::from_str(&text).map_err(|error| ConfigError::Malformed {
            path: path.into(),
            why: error.message().into(),
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let from_there = |path: Option<PathBuf>| path.map(|path| folder.join(path));
        Ok(Self {
            key: from_there(config.key),
            rig: from_there(config.rig),
            seen: from_there(config.seen),
        })
    }

    /// The configuration `strike.toml` beside a program; of one that is called through a link, beside the link, or else beside what it leads
    /// to. Empty where there is none.
    pub fn beside(program: &Path) -> Result<Self, ConfigError> {
        let beside = |program: &Path| program.with_file_name("strike.toml");
        let mut places = vec![beside(program)];
        places.extend(program.canonicalize().ok().map(|real| beside(&real)));
        for path in places {
            match Self::load(&path) {
                Err(ConfigError::Unreadable { source, .. })
                    if source.kind() == io::ErrorKind::NotFound => {}
                loaded => return loaded,
            }
        }
        Ok(Self::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_to_the_files_folder_and_what_is_not_known_is_named() {
        let dir = tempfile::tempdir().expect("folder");
        let program = dir.path().join("strike");
        assert_eq!(Config::beside(&program).expect("none"), Config::default());
        let path = dir.path().join("strike.toml");
        fs::write(&path, "key = \"carom.pub\"\nrig = \"/etc/rig.toml\"\n").expect("writes");
        let config = Config::beside(&program).expect("read");
        assert_eq!(config.key, Some(dir.path().join("carom.pub")));
        assert_eq!(config.rig, Some("/etc/rig.toml".into()));
        // Through a link from elsewhere, too; beside the link it counts first.
        fs::write(&program, "").expect("writes");
        let bin = dir.path().join("bin");
        fs::create_dir(&bin).expect("folder");
        let link = bin.join("strike");
        std::os::unix::fs::symlink(&program, &link).expect("links");
        let rig = |config: Config| config.rig;
        assert_eq!(
            rig(Config::beside(&link).expect("read")),
            Some("/etc/rig.toml".into())
        );
        fs::write(bin.join("strike.toml"), "rig = \"own.toml\"\n").expect("writes");
        assert_eq!(
            rig(Config::beside(&link).expect("read")),
            Some(bin.join("own.toml"))
        );
        fs::write(&path, "kye = \"carom.pub\"\n").expect("writes");
        let error = Config::beside(&program).expect_err("unknown").to_string();
        assert!(error.contains("kye") && error.contains("`key`"), "{error}");
    }
}
