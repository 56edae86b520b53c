//! Whether a version may move this robot: signed by the configured key, and none newer was seen before.
//!
//! Every signature counts on from the one before (see [`store::Key`]). The highest count that was loaded is kept, with the hash
//! of its manifest, in a file of the robot's own; a version with a lower count, whatever `latest` says, is an old one passed off
//! as new, and one with the same count and another manifest comes from a second store. Going back is
//! an act of whoever holds the secret key: `carom artifacts rollback --key` signs the earlier version with the next count.

use std::path::{Path, PathBuf};
use std::{fs, io};

use durable::LockError;
use serde::{Deserialize, Serialize};
use store::{Artifact, ArtifactError, Key, Store};

use crate::count::locked;

/// A public key, and the newest version that was seen of it.
#[derive(Clone, Debug)]
pub struct Trust {
    key: Key,
    seen: PathBuf,
}

/// The record of the newest version seen.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Seen {
    sequence: u64,
    version: String,
    /// SHA-256 of its manifest, as the manifest itself says it; none in older files.
    #[serde(default)]
    manifest: Option<String>,
}

impl Seen {
    /// Whether another record may be of the same version.
    fn may_be(&self, other: &Self) -> bool {
        self.version == other.version
            && match (&self.manifest, &other.manifest) {
                (Some(one), Some(other)) => one == other,
                _ => true,
            }
    }
}

/// Why a version is not trusted, or cannot be judged. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum TrustError {
    #[error(transparent)]
    Artifact(#[from] ArtifactError),
    #[error(
        "load {version}: it is older than {newest}, which was loaded here before (signature {sequence} after {seen}); to go \
         back, sign it anew with `carom artifacts rollback {version} --key FILE` and copy the store again"
    )]
    Older {
        version: String,
        sequence: u64,
        newest: String,
        seen: u64,
    },
    #[error(
        "load {version}: its signature counts {sequence}, and so did that of another {newest}, which was loaded here before; \
         publish with one key from one store"
    )]
    Twice {
        version: String,
        sequence: u64,
        newest: String,
    },
    #[error("use the key {}: {why}; give the public key that `carom key new` wrote", path.display())]
    BadKey { path: PathBuf, why: String },
    #[error(
        "find the newest version seen in {}: {why}; remove the file only if you know that the version to load is the newest",
        path.display()
    )]
    BadSeen { path: PathBuf, why: String },
    #[error(transparent)]
    Unkept(#[from] durable::Error),
    #[error("read and keep the newest version seen: {0}")]
    Locked(#[from] LockError),
    #[error(
        "use a robot that moves: no key is configured, so that nobody vouches for the artifact; give `--key FILE` or a strike.toml"
    )]
    NoKey,
    #[error(
        "use a robot that moves: its own rig file is not configured, so that nobody says where it may go; give `--rig FILE` or a \
         strike.toml"
    )]
    NoRig,
}

impl Trust {
    /// Reads a public key's file; `seen` is where to keep what was seen of it: beside it with the ending `seen` unless given.
    pub fn open(key: &Path, seen: Option<&Path>) -> Result<Self, TrustError> {
        let bad = |why: String| TrustError::BadKey {
            path: key.into(),
            why,
        };
        let text = fs::read_to_string(key).map_err(|error| bad(error.to_string()))?;
        Ok(Self {
            key: Key::parse(&text).map_err(bad)?,
            seen: seen.map_or_else(|| key.with_extension("seen"), Path::to_path_buf),
        })
    }

    /// The public key.
    pub fn key(&self) -> &Key {
        &self.key
    }

    /// Loads a version (the one in use unless named) after every check. `fits` says whether it is this robot's; only one that is becomes the newest
    /// seen.
    pub fn load<E: From<TrustError>>(
        &self,
        store: &Store,
        version: Option<&str>,
        fits: impl FnOnce(&Artifact) -> Result<(), E>,
    ) -> Result<Artifact, E> {
        let (artifact, sequence) = store
            .load_trusted(version, &self.key)
            .map_err(TrustError::from)?;
        // Read, compared and written under one lock: of two executors, the later one sees what the earlier one kept.
        let _lock = locked(&self.lock_path()).map_err(TrustError::from)?;
        let seen = self.seen()?;
        let version = &artifact.version;
        let now = Seen {
            sequence,
            version: version.clone(),
            manifest: Some(artifact.manifest.sha256.clone()),
        };
        match &seen {
            Some(seen) if sequence < seen.sequence => {
                return Err(TrustError::Older {
                    version: version.clone(),
                    sequence,
                    newest: seen.version.clone(),
                    seen: seen.sequence,
                }
                .into());
            }
            Some(seen) if sequence == seen.sequence && !now.may_be(seen) => {
                return Err(TrustError::Twice {
                    version: version.clone(),
                    sequence,
                    newest: seen.version.clone(),
                }
                .into());
            }
            _ => {}
        }
        fits(&artifact)?;
        if seen.as_ref() != Some(&now) {
            self.keep(&now)?;
        }
        Ok(artifact)
    }

    fn lock_path(&self) -> PathBuf {
        let mut name = std::ffi::OsString::from(".");
        name.push(self.seen.file_name().unwrap_or_default());
        name.push(".lock");
        self.seen.with_file_name(name)
    }

    fn seen(&self) -> Result<Option<Seen>, TrustError> {
        let bad = |why: String| TrustError::BadSeen {
            path: self.seen.clone(),
            why,
        };
        match fs::read(&self.seen) {
            Ok(bytes) => serde_json::from_slice(&bytes)
                .map(Some)
                .map_err(|error| bad(error.to_string())),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(bad(error.to_string())),
        }
    }

    fn keep(&self, seen: &Seen) -> Result<(), TrustError> {
        let text = serde_json::to_string(seen).expect("plain data with text keys");
        Ok(durable::write_bytes(
            &self.seen,
            format!("{text}\n").as_bytes(),
        )?)
    }
}

/// Whether a robot may be used with what is configured: one that moves needs a key and a rig file of its own.
pub fn allows(has_key: bool, has_rig: bool, moves: bool) -> Result<(), TrustError> {
    match (moves, has_key, has_rig) {
        (true, false, _) => Err(TrustError::NoKey),
        (true, true, false) => Err(TrustError::NoRig),
        _ => Ok(()),
    }
}
