//! The store: `versions/` and `latest` in a run's folder.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::{Artifact, ArtifactError, Key, Manifest, Signer, load, version};

pub(crate) const VERSIONS: &str = "versions";
/// Names the version in use.
pub(crate) const LATEST: &str = "latest";

/// A store. Opening it touches nothing; reading needs no lock, for what is published never changes.
#[derive(Clone, Debug)]
pub struct Store {
    pub(crate) dir: PathBuf,
    pub(crate) signer: Option<Arc<dyn Signer>>,
}

/// A version as a list shows it: its manifest was read, its files were not.
#[derive(Debug)]
pub struct Listing {
    /// Name of the version, such as `v0003`.
    pub version: String,
    /// Whether it is the one in use.
    pub is_latest: bool,
    /// What it holds, or why it cannot be read.
    pub manifest: Result<Manifest, ArtifactError>,
}

impl Store {
    /// The store in a run's folder, whether or not anything was published there.
    pub fn open(dir: &Path) -> Self {
        Self {
            dir: dir.into(),
            signer: None,
        }
    }

    /// This store, signing what it puts to use.
    pub fn signed_by(self, signer: Arc<dyn Signer>) -> Self {
        Self {
            signer: Some(signer),
            ..self
        }
    }

    /// The folder of a version.
    pub fn version_dir(&self, version: &str) -> PathBuf {
        self.versions().join(version)
    }

    /// The name of the version in use.
    pub fn latest(&self) -> Result<String, ArtifactError> {
        let path = self.dir.join(LATEST);
        let bytes = fs::read(&path).map_err(|error| match error.kind() {
            ErrorKind::NotFound => ArtifactError::NoLatest { store: self.name() },
            _ => durable::Error::new("read", &path, error).into(),
        })?;
        let text = String::from_utf8_lossy(&bytes);
        let name = text.trim_end();
        match version::number(name) {
            Some(_) => Ok(name.into()),
            None => Err(ArtifactError::BadLatest {
                store: self.name(),
                found: name.chars().take(40).collect(),
            }),
        }
    }

    /// A version (the one in use unless named), after checking all of it.
    pub fn load(&self, version: Option<&str>) -> Result<Artifact, ArtifactError> {
        let version = self.find(version)?;
        load::load(&self.version_dir(&version), &version)
    }

    /// A version (the one in use unless named) that this key signed, after checking all of it, and the count of its
    /// signature. An executor keeps the highest that it has seen, and takes no version with a lower one.
    pub fn load_trusted(
        &self,
        version: Option<&str>,
        key: &Key,
    ) -> Result<(Artifact, u64), ArtifactError> {
        let version = self.find(version)?;
        load::load_trusted(&self.version_dir(&version), &version, key)
    }

    /// Checks all of a version (the one in use unless named); gives its name.
    pub fn verify(&self, version: Option<&str>) -> Result<String, ArtifactError> {
        self.load(version).map(|artifact| artifact.version)
    }

    /// The manifest of a version (the one in use unless named); its files are not read.
    pub fn show(&self, version: Option<&str>) -> Result<Manifest, ArtifactError> {
        let version = self.find(version)?;
        load::manifest(&self.version_dir(&version), &version)
    }

    /// All versions, oldest first.
    pub fn list(&self) -> Result<Vec<Listing>, ArtifactError> {
        let latest = self.latest().ok();
        let listing = |number| {
            let version = version::name(number);
            Listing {
                is_latest: latest.as_ref() == Some(&version),
                manifest: load::manifest(&self.version_dir(&version), &version),
                version,
            }
        };
        Ok(self.numbers()?.into_iter().map(listing).collect())
    }

    /// The name of an existing version: the one requested, or the one in use.
    pub(crate) fn find(&self, version: Option<&str>) -> Result<String, ArtifactError> {
        let version = version.map_or_else(|| self.latest(), |version| Ok(version.to_string()))?;
        let numbers = self.numbers()?;
        if version::number(&version).is_some_and(|number| numbers.contains(&number)) {
            return Ok(version);
        }
        let names: Vec<_> = numbers.into_iter().map(version::name).collect();
        let known = if names.is_empty() {
            "none".into()
        } else {
            names.join(", ")
        };
        Err(ArtifactError::NoVersion { version, known })
    }

    pub(crate) fn numbers(&self) -> Result<Vec<u64>, ArtifactError> {
        let dir = self.versions();
        let failed = |source| ArtifactError::from(durable::Error::new("list", &dir, source));
        let entries = match fs::read_dir(&dir) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(failed)?,
        };
        let mut numbers = Vec::new();
        for entry in entries {
            let entry = entry.map_err(failed)?;
            numbers.extend(version::number(&entry.file_name().to_string_lossy()));
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    pub(crate) fn versions(&self) -> PathBuf {
        self.dir.join(VERSIONS)
    }

    pub(crate) fn name(&self) -> String {
        self.dir.display().to_string()
    }
}
