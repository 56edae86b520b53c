//! A recipe: which logs make a dataset, how they are read and what is left out.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use values::{Interval, Rig, Strike};

use crate::Error;
use crate::fetching::Fetch;
use crate::inputs::{find_logs, load_rig};

/// `NAME.toml`; paths are relative to its folder.
///
/// ```toml
/// logs = ["../../runs/june", "../../runs/july_*.mcap", "s3://bucket/august"]   # folders, globs, files, URLs
/// rig = "rig.toml"
/// seed = 0                    # deals strikes into learning and judging
///
/// [filters]
/// speed = [0.4, 1.0]          # commanded, m/s
/// angle = [-0.8, 0.8]         # commanded, rad
/// without = ["test_drive.mcap"]
/// whole_logs = true           # none that is cut off or damaged
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    logs: Vec<String>,
    rig: PathBuf,
    /// Seed of the split into training and held-out strikes.
    #[serde(default)]
    pub seed: u64,
    /// What is left out.
    #[serde(default)]
    pub filters: Filters,
    #[serde(skip)]
    folder: PathBuf,
}

/// What is left out of a dataset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Filters {
    /// Commanded speeds that are kept, in m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<Interval>,
    /// Commanded angles that are kept, in rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<Interval>,
    /// Names of logs that are left out.
    pub without: BTreeSet<String>,
    /// Whether logs that are cut off or damaged are left out.
    pub whole_logs: bool,
}

impl Filters {
    /// Whether a log is left out by its name, with as many of its folders as the recipe names.
    pub fn leave_out(&self, log: &Path) -> bool {
        self.without.iter().any(|name| log.ends_with(name))
    }
}

impl Recipe {
    /// Reads a recipe.
    pub fn load(path: &Path) -> Result<Self, Error> {
        let text = fs::read_to_string(path).map_err(|error| Error::unreadable(path, &error))?;
        let recipe: Self = toml::from_str(&text).map_err(|error| {
            Error::input(format!(
                "read the recipe {}: {}; it holds `logs`, `rig`, `seed` and `[filters]`",
                path.display(),
                error.to_string().trim_end()
            ))
        })?;
        Ok(recipe.within(path.parent().unwrap_or(Path::new(""))))
    }

    /// A recipe that is read from a file in this folder.
    pub fn within(self, folder: &Path) -> Self {
        Self {
            folder: folder.into(),
            ..self
        }
    }

    pub fn rig(&self) -> Result<Rig, Error> {
        load_rig(&self.rig_file())
    }

    pub fn rig_file(&self) -> PathBuf {
        self.folder.join(&self.rig)
    }

    /// Every log that it names, and those in `elsewhere` (files, folders).
    pub fn find_logs(&self, elsewhere: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
        let paths = self.named(elsewhere)?;
        let is_remote = paths.iter().any(|path| store::objects::is_url(path));
        let rig = is_remote.then(|| self.rig()).transpose()?;
        let fetch = Fetch {
            rig: rig.as_ref(),
            run: None,
        };
        find_logs(&paths, &fetch)
    }

    /// The files, folders and URLs that it names, and `elsewhere`.
    pub fn named(&self, elsewhere: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
        let mut paths = elsewhere.to_vec();
        for name in &self.logs {
            let path = match store::objects::is_url(Path::new(name)) {
                true => PathBuf::from(name),
                false => self.folder.join(name),
            };
            if !name.contains(['*', '?', '[']) {
                // On another machine the logs may lie elsewhere alone.
                if path.exists() || elsewhere.is_empty() || store::objects::is_url(&path) {
                    paths.push(path);
                }
                continue;
            }
            let bad = |why: String| Error::input(format!("find the logs {name}: {why}"));
            let before = paths.len();
            // The folder's name is no pattern, whatever characters it has.
            let folder = glob::Pattern::escape(&self.folder.to_string_lossy());
            let pattern = Path::new(&folder).join(name);
            let pattern = pattern.to_string_lossy();
            for found in glob::glob(&pattern).map_err(|error| bad(error.to_string()))? {
                paths.push(found.map_err(|error| bad(error.to_string()))?);
            }
            if paths.len() == before && elsewhere.is_empty() {
                return Err(bad(format!("nothing matches {pattern}")));
            }
        }
        Ok(paths)
    }
}

impl Filters {
    pub fn keeps(&self, strike: &Strike) -> bool {
        let within = |bounds: Option<Interval>, value| bounds.is_none_or(|b| b.contains(value));
        within(self.speed, strike.command.speed) && within(self.angle, strike.command.angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_with_brackets_in_its_name_is_no_pattern() {
        let dir = tempfile::tempdir().expect("folder");
        let folder = dir.path().join("ds[1]");
        fs::create_dir(&folder).expect("folder");
        for name in ["a_1.mcap", "a_2.mcap", "b.mcap"] {
            fs::write(folder.join(name), "").expect("file");
        }
        let path = folder.join("recipe.toml");
        fs::write(&path, "logs = [\"a_*.mcap\"]\nrig = \"rig.toml\"\n").expect("recipe");
        let recipe = Recipe::load(&path).expect("a recipe");
        let found = recipe
            .find_logs(&[])
            .unwrap_or_else(|error| panic!("failed to {error}"));
        assert_eq!(found.len(), 2, "{found:?}");
    }
}
