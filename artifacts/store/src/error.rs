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
    /// A version's manifest is not there.
    #[error("load {version}: it has no manifest.json; {MEND}")]
    NoManifest {
        /// The version.
        version: String,
    },
    /// A version's manifest is no manifest.
    #[error("load {version}: manifest.json is damaged ({why}); {MEND}")]
    BadManifest {
        /// The version.
        version: String,
        /// What is wrong with it.
        why: String,
    },
    /// A layout that this program does not know.
    #[error(
        "load {version}: its layout is schema {found}, this program knows {known}; use the carom that wrote it"
    )]
    UnknownSchema {
        /// The version.
        version: String,
        /// Its schema.
        found: u64,
        /// The schema that is known.
        known: u32,
    },
    /// Written by a carom that computes differently.
    #[error(
        "load {version}: carom {found} wrote it, this is carom {here}; use that one, or run again to publish anew"
    )]
    OtherCarom {
        /// The version.
        version: String,
        /// Version of carom that wrote it.
        found: String,
        /// Version of this program.
        here: String,
    },
    /// Identified with another MuJoCo.
    #[error(
        "load {version}: it was identified with MuJoCo {found}, here is {here}; install that one, or run again to publish anew"
    )]
    OtherMujoco {
        /// The version.
        version: String,
        /// MuJoCo of the version.
        found: String,
        /// MuJoCo that is loaded.
        here: String,
    },
    /// Nobody vouches for the version.
    #[error(
        "load {version}: it is not signed, and a key is configured; sign it with `carom artifacts sign --key FILE` where it was published"
    )]
    NotSigned {
        /// The version.
        version: String,
    },
    /// The signature is damaged, of another key, or of something else.
    #[error("load {version}: its signature does not hold ({why}); {MEND}")]
    BadSignature {
        /// The version.
        version: String,
        /// What is wrong with it.
        why: String,
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
    /// The manifest lists other files than a version has.
    #[error("load {version}: its manifest lists [{found}], a version holds [{expected}]; {MEND}")]
    FileList {
        /// The version.
        version: String,
        /// Files listed.
        found: String,
        /// Files that must be.
        expected: String,
    },
    /// A file is there that the manifest does not list.
    #[error("load {version}: {file} is no part of it; take it out of the version's folder")]
    ExtraFile {
        /// The version.
        version: String,
        /// The file.
        file: String,
    },
    /// A file is not there.
    #[error("load {version}: {file} is missing; {MEND}")]
    MissingFile {
        /// The version.
        version: String,
        /// The file.
        file: String,
    },
    /// A file is longer than any that a version has, whatever its manifest says.
    #[error("load {version}: {file} has {found} bytes, more than the {most} that are read; {MEND}")]
    TooLong {
        /// The version.
        version: String,
        /// The file.
        file: String,
        /// Its length in bytes.
        found: u64,
        /// The longest that is read, in bytes.
        most: u64,
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
    /// A file has another length than the manifest says.
    #[error("load {version}: {file} has {found} bytes instead of {expected}; {MEND}")]
    WrongSize {
        /// The version.
        version: String,
        /// The file.
        file: String,
        /// Its length in bytes.
        found: u64,
        /// The length that it must have, in bytes.
        expected: u64,
    },
    /// A file has another content than the manifest says.
    #[error("load {version}: {file} was changed (SHA-256 {found} instead of {expected}); {MEND}")]
    WrongHash {
        /// The version.
        version: String,
        /// The file.
        file: String,
        /// SHA-256 of its content.
        found: String,
        /// SHA-256 that it must have.
        expected: String,
    },
    /// `rig.toml` is no rig file.
    #[error("load {version}: rig.toml makes no sense ({source}); {MEND}")]
    BadRig {
        /// The version.
        version: String,
        /// What is wrong with it.
        source: values::RigError,
    },
    /// `rig.toml` is not the rig that the version was made for.
    #[error(
        "load {version}: rig.toml is another rig's (identity {found} instead of {expected}); {MEND}"
    )]
    OtherRig {
        /// The version.
        version: String,
        /// Identity of the file's rig.
        found: String,
        /// Identity that it must have.
        expected: String,
    },
    /// A world file makes no sense.
    #[error("load {version}: {file} makes no sense ({why}); {MEND}")]
    BadWorld {
        /// The version.
        version: String,
        /// The file.
        file: String,
        /// What is wrong with it.
        why: String,
    },
    /// A residual's weights make no sense.
    #[error("load {version}: {file} makes no sense (failed to {source}); {MEND}")]
    BadNetwork {
        /// The version.
        version: String,
        /// The file.
        file: String,
        /// What is wrong with it.
        source: ResidualModelError,
    },
    /// The manifest names a model that the version does not hold.
    #[error("load {version}: its manifest names the model {model}, it holds [{has}]; {MEND}")]
    NoModel {
        /// The version.
        version: String,
        /// The model.
        model: Model,
        /// Models that it holds.
        has: String,
    },
    /// A number of the manifest makes no sense.
    #[error("load {version}: {name} of its manifest makes no sense ({why}); {MEND}")]
    BadNumber {
        /// The version.
        version: String,
        /// Which number.
        name: String,
        /// What is wrong with it.
        why: String,
    },
}

const MEND: &str = "copy the version again from where it was published, go back with `carom artifacts rollback`, or publish anew with `carom run`";

fn name(version: &Option<String>) -> &str {
    version.as_deref().unwrap_or("no version")
}
