//! What can be wrong with a store, and how to mend it.

use crate::{Model, ResidualModelError};

/// Why a version was not published, loaded or rolled back to. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum ArtifactError {
    #[error(transparent)]
    Io(#[from] durable::Error),
    #[error(transparent)]
    Object(#[from] crate::objects::ObjectError),
    #[error("change the store {store}: another run does; try again when it has ended")]
    Busy { store: String },
    #[error(
        "find a version in {store}: there is no `latest`, as nothing was published there, or candidates that were refused; `carom artifacts list --out {store}` lists these, `carom run` with that folder says why, and a version can be named"
    )]
    NoLatest { store: String },
    #[error(
        "read {store}/latest: it holds {found:?}, which is no version's name; mend it with `carom artifacts rollback`"
    )]
    BadLatest { store: String, found: String },
    #[error("find version {version}: the store holds {known}")]
    NoVersion { version: String, known: String },
    #[error("roll back from {version}: there is no version before it; name the one to use")]
    NothingBefore { version: String },
    #[error("load {version}: {fault}")]
    Unsound { version: String, fault: Fault },
    #[error(
        "change the version in use of {store}: {version} is signed, and robots that check it would refuse what is not; give the secret key, `--key FILE`"
    )]
    NeedsKey { store: String, version: String },
    #[error(
        "change the version in use of {store}: {version} is signed by another key, and robots that check that one would refuse \
         what this one signs; give that key, or hand over to this one with `carom artifacts sign --key FILE` and give the robots \
         its public key"
    )]
    OtherKey { store: String, version: String },
    #[error("sign {version}: failed to {why}")]
    Signing { version: String, why: String },
    #[error(
        "promote in {store}: {} is in use now, and the candidate was compared with {}; run again",
        name(found),
        name(expected)
    )]
    Overtaken {
        store: String,
        expected: Option<String>,
        found: Option<String>,
    },
}

/// What is wrong with a version; each text says how to mend it.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum Fault {
    #[error(transparent)]
    Io(#[from] durable::Error),
    #[error("it has no manifest.json; {MEND}")]
    NoManifest,
    #[error("manifest.json is damaged ({0}); {MEND}")]
    BadManifest(String),
    #[error("its layout is schema {0}, this program knows {known}; use the carom that wrote it", known = crate::SCHEMA_VERSION)]
    UnknownSchema(u64),
    #[error(
        "carom {0} wrote it, this is carom {here}; use that one, or run again to publish anew", here = env!("CARGO_PKG_VERSION")
    )]
    OtherCarom(String),
    #[error(
        "it was identified with MuJoCo {0}, here is {here}; install that one, or run again to publish anew", here = world::mujoco_version()
    )]
    OtherMujoco(String),
    #[error(
        "it is not signed, and a key is configured; sign it with `carom artifacts sign --key FILE` where it was published"
    )]
    NotSigned,
    #[error("its signature does not hold ({0}); {MEND}")]
    BadSignature(String),
    #[error("its manifest lists [{0}], a version holds [{1}]; {MEND}")]
    FileList(String, String),
    #[error("{0} is no part of it; take it out of the version's folder")]
    ExtraFile(String),
    #[error("{0} is missing; {MEND}")]
    MissingFile(String),
    #[error("{0} has {1} bytes, more than the {most} that are read; {MEND}", most = crate::LONGEST_FILE)]
    TooLong(String, u64),
    #[error("{file} has {found} bytes instead of {expected}; {MEND}")]
    WrongSize {
        file: String,
        found: u64,
        expected: u64,
    },
    #[error("{file} was changed (SHA-256 {found} instead of {expected}); {MEND}")]
    WrongHash {
        file: String,
        found: String,
        expected: String,
    },
    #[error("rig.toml makes no sense ({0}); {MEND}")]
    BadRig(values::RigError),
    #[error("rig.toml is another rig's (identity {0} instead of {1}); {MEND}")]
    OtherRig(String, String),
    #[error("{0} makes no sense ({1}); {MEND}")]
    BadWorld(String, String),
    #[error("{0} makes no sense (failed to {1}); {MEND}")]
    BadNetwork(String, ResidualModelError),
    #[error("its manifest names the model {0}, it holds [{1}]; {MEND}")]
    NoModel(Model, String),
    #[error("{0} of its manifest makes no sense ({1}); {MEND}")]
    BadNumber(String, String),
}

impl Fault {
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
