//! What can be wrong with a store, and how to mend it.

use crate::{Model, ResidualModelError};

/// Why a version was not published, loaded or rolled back to. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum ArtifactError {
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] durable::Error),
    /// Another run publishes there (exit code 75).
    #[error("change the store {store}: another run does; try again when it has ended")]
    Busy {
        /// The store's folder.
        store: String,
    },
    /// Nothing was published there.
    #[error(
        "find a version in {store}: there is no `latest`; run `carom run` with `--out {store}` first, or name a version"
    )]
    NoLatest {
        /// The store's folder.
        store: String,
    },
    /// `latest` does not hold a version's name.
    #[error(
        "read {store}/latest: it holds {found:?}, which is no version's name; mend it with `carom artifacts rollback`"
    )]
    BadLatest {
        /// The store's folder.
        store: String,
        /// What it holds.
        found: String,
    },
    /// There is no such version.
    #[error("find version {version}: the store holds {known}")]
    NoVersion {
        /// The name requested.
        version: String,
        /// Names of all versions.
        known: String,
    },
    /// There is no version before the one in use.
    #[error("roll back from {version}: there is no version before it; name the one to use")]
    NothingBefore {
        /// The version in use.
        version: String,
    },
    /// A version is not what it should be.
    #[error("load {version}: {fault}")]
    Unsound {
        /// The version.
        version: String,
        /// What is wrong with it.
        fault: Fault,
    },
    /// Robots that check signatures would not take what is about to be put to use.
    #[error(
        "change the version in use of {store}: {version} is signed, and robots that check it would refuse what is not; give the secret key, `--key FILE`"
    )]
    NeedsKey {
        /// The store's folder.
        store: String,
        /// The version in use.
        version: String,
    },
    /// Robots that check the one key would not take what the other signs.
    #[error(
        "change the version in use of {store}: {version} is signed by another key, and robots that check that one would refuse \
         what this one signs; give that key, or hand over to this one with `carom artifacts sign --key FILE` and give the robots \
         its public key"
    )]
    OtherKey {
        /// The store's folder.
        store: String,
        /// The version in use.
        version: String,
    },
    /// The version could not be signed.
    #[error("sign {version}: failed to {why}")]
    Signing {
        /// The version.
        version: String,
        /// Why.
        why: String,
    },
    /// Another version came into use since the one that a promotion was decided against.
    #[error(
        "promote in {store}: {} is in use now, and the candidate was compared with {}; run again",
        name(found),
        name(expected)
    )]
    Overtaken {
        /// Folder of the store.
        store: String,
        /// The version in use when the decision was made.
        expected: Option<String>,
        /// The version in use now.
        found: Option<String>,
    },
}

/// What is wrong with a version; each text says how to mend it.
#[derive(Debug, thiserror::Error)]
pub enum Fault {
    /// A file of it could not be read.
    #[error(transparent)]
    Io(#[from] durable::Error),
    /// Its manifest is not there.
    #[error("it has no manifest.json; {MEND}")]
    NoManifest,
    /// Its manifest is no manifest, for this reason.
    #[error("manifest.json is damaged ({0}); {MEND}")]
    BadManifest(String),
    /// A layout that this program does not know.
    #[error("its layout is schema {0}, this program knows {known}; use the carom that wrote it", known = crate::SCHEMA_VERSION)]
    UnknownSchema(u64),
    /// Written by a carom of this version, which computes differently.
    #[error(
        "carom {0} wrote it, this is carom {here}; use that one, or run again to publish anew", here = env!("CARGO_PKG_VERSION")
    )]
    OtherCarom(String),
    /// Identified with another MuJoCo, of this version.
    #[error(
        "it was identified with MuJoCo {0}, here is {here}; install that one, or run again to publish anew", here = world::mujoco_version()
    )]
    OtherMujoco(String),
    /// Nobody vouches for it.
    #[error(
        "it is not signed, and a key is configured; sign it with `carom artifacts sign --key FILE` where it was published"
    )]
    NotSigned,
    /// The signature is damaged, of another key, or of something else.
    #[error("its signature does not hold ({0}); {MEND}")]
    BadSignature(String),
    /// The manifest lists these files, and not those that a version has.
    #[error("its manifest lists [{0}], a version holds [{1}]; {MEND}")]
    FileList(String, String),
    /// A file is there that the manifest does not list.
    #[error("{0} is no part of it; take it out of the version's folder")]
    ExtraFile(String),
    /// A file is not there.
    #[error("{0} is missing; {MEND}")]
    MissingFile(String),
    /// A file has more bytes than any that a version has, whatever its manifest says.
    #[error("{0} has {1} bytes, more than the {most} that are read; {MEND}", most = crate::LONGEST_FILE)]
    TooLong(String, u64),
    /// A file has another length in bytes than the manifest says.
    #[error("{file} has {found} bytes instead of {expected}; {MEND}")]
    WrongSize {
        /// The file.
        file: String,
        /// Its length.
        found: u64,
        /// The length that it must have.
        expected: u64,
    },
    /// A file has another content than the manifest says.
    #[error("{file} was changed (SHA-256 {found} instead of {expected}); {MEND}")]
    WrongHash {
        /// The file.
        file: String,
        /// SHA-256 of its content.
        found: String,
        /// SHA-256 that it must have.
        expected: String,
    },
    /// `rig.toml` is no rig file.
    #[error("rig.toml makes no sense ({0}); {MEND}")]
    BadRig(values::RigError),
    /// `rig.toml` is of the first identity, and the version was made for the second.
    #[error("rig.toml is another rig's (identity {0} instead of {1}); {MEND}")]
    OtherRig(String, String),
    /// A world file makes no sense, for this reason.
    #[error("{0} makes no sense ({1}); {MEND}")]
    BadWorld(String, String),
    /// A residual's weights make no sense.
    #[error("{0} makes no sense (failed to {1}); {MEND}")]
    BadNetwork(String, ResidualModelError),
    /// The manifest names a model that the version does not hold; those that it does.
    #[error("its manifest names the model {0}, it holds [{1}]; {MEND}")]
    NoModel(Model, String),
    /// A number of the manifest makes no sense, for this reason.
    #[error("{0} of its manifest makes no sense ({1}); {MEND}")]
    BadNumber(String, String),
}

impl Fault {
    /// The error of this version.
    pub(crate) fn of(self, version: &str) -> ArtifactError {
        match self {
            Self::Io(error) => error.into(),
            fault => ArtifactError::Unsound {
                version: version.into(),
                fault,
            },
        }
    }
}

const MEND: &str = "copy the version again from where it was published, go back with `carom artifacts rollback`, or publish anew with `carom run`";

fn name(version: &Option<String>) -> &str {
    version.as_deref().unwrap_or("no version")
}
