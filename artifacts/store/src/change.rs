//! What changes a store: publishing, promoting, signing, rolling back and removing, each under the store's lock.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;

use durable::{Lock, LockError};

use crate::files::{MANIFEST, encode};
use crate::store::LATEST;
use crate::{ArtifactError, Contents, Key, SIGNATURE, Store, load, signature, version};

/// Versions that a rollback took out of use, a name a line; there only after a rollback.
const WITHDRAWN: &str = "withdrawn";
const LOCK: &str = ".lock";

impl Store {
    /// Publishes contents as a new version and makes it the one in use; gives its name. Where a whole version has the
    /// same contents already, that one is used and no new one made; if a rollback took that one out of use, `latest` stays
    /// where it is until [`Store::rollback`] names it.
    ///
    /// Whatever stops it, `latest` names a whole version, and a version is whole or absent. Where the version in use is
    /// signed, an unsigned one does not take its place.
    pub fn publish(&self, contents: &Contents) -> Result<String, ArtifactError> {
        durable::create_dir(&self.versions())?;
        let lock = self.lock()?;
        self.publish_locked(contents, &lock)
    }

    /// Keeps contents as a version that is not put to use; gives its name. [`Store::rollback`] puts it to use, if a person says so.
    pub fn keep_candidate(&self, contents: &Contents) -> Result<String, ArtifactError> {
        durable::create_dir(&self.versions())?;
        let _lock = self.lock()?;
        self.write_version(contents)
    }

    /// Publishes contents, if the version in use is still the `expected` one (none: nothing was published yet), which the contents were
    /// compared with; else [`ArtifactError::Overtaken`], and nothing is written. The check and the change are made under one lock.
    pub fn promote(
        &self,
        contents: &Contents,
        expected: Option<&str>,
    ) -> Result<String, ArtifactError> {
        durable::create_dir(&self.versions())?;
        let lock = self.lock()?;
        let found = match self.latest() {
            Ok(version) => Some(version),
            Err(ArtifactError::NoLatest { .. }) => None,
            Err(error) => return Err(error),
        };
        if found.as_deref() != expected {
            return Err(ArtifactError::Overtaken {
                store: self.name(),
                expected: expected.map(String::from),
                found,
            });
        }
        self.publish_locked(contents, &lock)
    }

    fn publish_locked(&self, contents: &Contents, _: &Lock) -> Result<String, ArtifactError> {
        let version = self.write_version(contents)?;
        // A `latest` that is missing or damaged is mended in any case.
        if self.latest().is_err() || !self.withdrawn()?.contains(&version) {
            self.use_version(&version)?;
        }
        Ok(version)
    }

    fn write_version(&self, contents: &Contents) -> Result<String, ArtifactError> {
        self.check_key()?;
        durable::sweep(&self.versions())?;
        let (manifest, files) = encode(contents);
        let manifest = manifest.to_json();
        let numbers = self.numbers()?;
        let same = numbers
            .iter()
            .rev()
            .map(|number| version::name(*number))
            .find(|version| {
                let path = self.version_dir(version).join(MANIFEST);
                fs::read(path).is_ok_and(|bytes| bytes == manifest.as_bytes())
                    && self.verify(Some(version)).is_ok()
            });
        let version = match same {
            Some(version) => version,
            None => {
                let version = version::name(numbers.last().map_or(1, |last| last + 1));
                let aside = self.versions().join(format!(".{version}.partial"));
                durable::create_dir(&aside)?;
                for (name, bytes) in &files {
                    durable::write_bytes(&aside.join(name), bytes)?;
                }
                durable::write_bytes(&aside.join(MANIFEST), manifest.as_bytes())?;
                if let Some(signer) = &self.signer {
                    let next = self.highest_sequence(signer.key())? + 1;
                    let text = signature::sign(&**signer, &version, manifest.as_bytes(), next)?;
                    durable::write_bytes(&aside.join(SIGNATURE), text.as_bytes())?;
                }
                load::load(&aside, &version)?;
                durable::rename(&aside, &self.version_dir(&version))?;
                version
            }
        };
        Ok(version)
    }

    /// Signs the version in use, also where another key did: so a store is handed over. Gives its name. [`Store::rollback`]
    /// signs others, by taking them into use.
    pub fn sign(&self) -> Result<String, ArtifactError> {
        durable::create_dir(&self.versions())?;
        let _lock = self.lock()?;
        durable::sweep(&self.versions())?;
        let version = self.verify(None)?;
        self.sign_version(&version)?;
        Ok(version)
    }

    /// Makes another version the one in use: the one named, or the whole one before the one in use. It is checked first.
    /// Versions after it up to the one in use are withdrawn: publishing their contents again does not bring them back.
    pub fn rollback(&self, to: Option<&str>) -> Result<String, ArtifactError> {
        durable::create_dir(&self.versions())?;
        let _lock = self.lock()?;
        self.check_key()?;
        durable::sweep(&self.versions())?;
        let version = match to {
            Some(version) => self.verify(Some(version))?,
            None => self.whole_before(&self.latest()?)?,
        };
        self.withdraw_after(&version)?;
        self.use_version(&version)?;
        Ok(version)
    }

    /// Signs a version where there is a signer, and makes it the one in use.
    fn use_version(&self, version: &str) -> Result<(), ArtifactError> {
        self.sign_version(version)?;
        self.set_latest(version)
    }

    /// Signs a version as the newest put to use, unless it is already, or there is no signer.
    fn sign_version(&self, version: &str) -> Result<(), ArtifactError> {
        let Some(signer) = &self.signer else {
            return Ok(());
        };
        let dir = self.version_dir(version);
        let manifest = load::manifest_bytes(&dir, version)?;
        let highest = self.highest_sequence(signer.key())?;
        if highest > 0
            && signer
                .key()
                .check(&dir, version, &manifest)
                .is_ok_and(|sequence| sequence == highest)
        {
            return Ok(());
        }
        let text = signature::sign(&**signer, version, &manifest, highest + 1)?;
        // Aside in the folder above: in its own, a reader would take it for a file too many.
        let aside = self.versions().join(format!(".{version}.minisig.partial"));
        durable::write_bytes(&aside, text.as_bytes())?;
        Ok(durable::rename(&aside, &dir.join(SIGNATURE))?)
    }

    /// The highest count that this key signed here; 0 where it signed nothing.
    fn highest_sequence(&self, key: &Key) -> Result<u64, ArtifactError> {
        let sequence = |number| {
            let version = version::name(number);
            let dir = self.version_dir(&version);
            let manifest = load::manifest_bytes(&dir, &version).ok()?;
            key.check(&dir, &version, &manifest).ok()
        };
        Ok(self
            .numbers()?
            .into_iter()
            .filter_map(sequence)
            .max()
            .unwrap_or(0))
    }

    /// Whether the version in use may be replaced: where it is signed, that takes a signer with the same key.
    pub fn check_key(&self) -> Result<(), ArtifactError> {
        let Ok(version) = self.latest() else {
            return Ok(());
        };
        let (store, dir) = (self.name(), self.version_dir(&version));
        match &self.signer {
            None if signature::is_signed(&dir) => Err(ArtifactError::NeedsKey { store, version }),
            Some(signer) if signer.key().is_anothers(&dir) => {
                Err(ArtifactError::OtherKey { store, version })
            }
            _ => Ok(()),
        }
    }

    /// Removes the oldest versions beyond the newest `keep`, never the one in use; gives their names.
    pub fn retain(&self, keep: usize) -> Result<Vec<String>, ArtifactError> {
        durable::create_dir(&self.versions())?;
        let _lock = self.lock()?;
        durable::sweep(&self.versions())?;
        let latest = self.latest()?;
        let numbers = self.numbers()?;
        let old = &numbers[..numbers.len().saturating_sub(keep)];
        let mut removed: Vec<String> = old.iter().map(|number| version::name(*number)).collect();
        removed.retain(|version| *version != latest);
        for version in &removed {
            // Gone under its name at once; a kill leaves what the next writer sweeps.
            let aside = self.versions().join(format!(".{version}.partial"));
            durable::rename(&self.version_dir(version), &aside)?;
            durable::remove_dir(&aside)?;
        }
        Ok(removed)
    }

    /// Withdraws the versions after `version` up to the one in use; it itself is withdrawn no more.
    fn withdraw_after(&self, version: &str) -> Result<(), ArtifactError> {
        let before = self.withdrawn()?;
        let mut withdrawn = before.clone();
        withdrawn.remove(version);
        let latest = self.latest().ok().and_then(|name| version::number(&name));
        let passed = self
            .numbers()?
            .into_iter()
            .filter(|number| Some(*number) > version::number(version) && Some(*number) <= latest);
        withdrawn.extend(passed.map(version::name));
        if withdrawn == before {
            return Ok(());
        }
        let text: String = withdrawn.iter().map(|name| format!("{name}\n")).collect();
        Ok(durable::write_bytes(
            &self.dir.join(WITHDRAWN),
            text.as_bytes(),
        )?)
    }

    /// Names of the versions that a rollback took out of use.
    fn withdrawn(&self) -> Result<BTreeSet<String>, ArtifactError> {
        let path = self.dir.join(WITHDRAWN);
        match fs::read(&path) {
            Ok(bytes) => Ok(String::from_utf8_lossy(&bytes)
                .lines()
                .map(String::from)
                .collect()),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(BTreeSet::new()),
            Err(error) => Err(durable::Error::new("read", &path, error).into()),
        }
    }

    /// The newest whole version before this one; where none is whole, what is wrong with the newest.
    fn whole_before(&self, latest: &str) -> Result<String, ArtifactError> {
        let number = version::number(latest);
        let before = self
            .numbers()?
            .into_iter()
            .rev()
            .filter(|other| Some(*other) < number);
        let mut first_error = None;
        for other in before {
            match self.verify(Some(&version::name(other))) {
                Ok(version) => return Ok(version),
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        Err(first_error.unwrap_or_else(|| ArtifactError::NothingBefore {
            version: latest.into(),
        }))
    }

    pub(crate) fn set_latest(&self, version: &str) -> Result<(), ArtifactError> {
        if self.latest().is_ok_and(|latest| latest == version) {
            return Ok(());
        }
        Ok(durable::write_bytes(
            &self.dir.join(LATEST),
            format!("{version}\n").as_bytes(),
        )?)
    }

    pub(crate) fn lock(&self) -> Result<Lock, ArtifactError> {
        Lock::acquire(&self.versions().join(LOCK)).map_err(|error| match error {
            LockError::Busy { .. } => ArtifactError::Busy { store: self.name() },
            LockError::Io(error) => error.into(),
        })
    }
}
