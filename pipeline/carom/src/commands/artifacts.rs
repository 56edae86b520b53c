//! `carom artifacts`: the store of versions.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Subcommand;
use serde_json::{Value, json};
use store::objects::Place;
use store::{Artifact, ArtifactError, Key, Manifest, Signer, Store};

use crate::Error;
use crate::args::{SignArgs, StoreArgs, VersionArgs, examples};
use crate::difference::difference;
use crate::error::{Output, to_json};
use crate::fetching::object_error;
use crate::publishing::store_error;
use crate::signing::{self, SecretSigner};

/// `carom artifacts`.
#[derive(Debug, Subcommand)]
pub enum ArtifactsCommand {
    /// List the versions.
    #[command(after_help = examples(&["carom artifacts list --artifacts artifacts/demo"]))]
    List(StoreArgs),
    /// Show a version's manifest.
    #[command(after_help = examples(&["carom artifacts show v0001 --artifacts artifacts/demo"]))]
    Show(VersionArgs),
    /// Show what changed between two versions: logs, rig, worlds, effects, commands, stop errors.
    #[command(after_help = examples(&[
        "carom artifacts diff v0001 v0002 --artifacts artifacts/demo",
        "carom artifacts diff runs/monday runs/tuesday --json",
    ]))]
    Diff {
        /// A version, or the folder of a run, of which its latest is taken.
        before: String,
        /// The other version; what it has beside the first is told.
        after: String,
        /// Folder of the run whose versions are named.
        #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
        artifacts: PathBuf,
    },
    /// Print a version's world as MJCF, which opens in MuJoCo's viewer.
    #[command(after_help = examples(&["carom artifacts mjcf --artifacts artifacts/demo > world.xml"]))]
    Mjcf(VersionArgs),
    /// Check a version's hashes, shapes and schemas, and its signature where a public key is given.
    #[command(after_help = examples(&["carom artifacts verify --artifacts artifacts/demo --key carom.pub"]))]
    Verify {
        /// What to check.
        #[command(flatten)]
        version: VersionArgs,
        /// Public key that must have signed it.
        #[arg(long, value_name = "FILE")]
        key: Option<PathBuf>,
    },
    /// Sign the latest version.
    #[command(after_help = examples(&["carom artifacts sign --artifacts artifacts/demo --key carom.key"]))]
    Sign {
        /// Folder of a run.
        #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
        artifacts: PathBuf,
        /// Secret key.
        #[arg(long, value_name = "FILE")]
        key: PathBuf,
    },
    /// Make an earlier version the latest; where versions are signed it is signed anew, so that robots take it.
    #[command(after_help = examples(&[
        "carom artifacts rollback v0001 --artifacts artifacts/demo",
        "carom artifacts rollback --artifacts artifacts/demo --key carom.key",
    ]))]
    Rollback {
        /// Version to go back to [default: the one before the latest].
        version: Option<String>,
        /// Folder of a run.
        #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
        artifacts: PathBuf,
        /// Who signs.
        #[command(flatten)]
        sign: SignArgs,
    },
    /// Publish a version into a store by URL, and make it the one in use there, if nobody else did meanwhile.
    #[command(after_help = examples(&[
        "carom artifacts push s3://bucket/table-3 --artifacts artifacts/demo",
        "carom artifacts push s3://bucket/table-3 --over v0007 --key carom.key",
    ]))]
    Push {
        /// s3://BUCKET/PREFIX, gs://BUCKET/PREFIX, az://CONTAINER/PREFIX or file:///PATH; credentials are taken from the environment.
        url: String,
        /// Version to publish, which is given the next number there [default: the latest].
        #[arg(long, value_name = "VERSION")]
        version: Option<String>,
        /// Only if this version is the one in use there [default: whichever is when this begins].
        #[arg(long, value_name = "VERSION")]
        over: Option<String>,
        /// Folder of a run.
        #[arg(long, value_name = "DIR", default_value = "artifacts/demo")]
        artifacts: PathBuf,
        /// Who signs.
        #[command(flatten)]
        sign: SignArgs,
    },
}

/// Does what was asked.
pub fn run(command: &ArtifactsCommand) -> Result<Output, Error> {
    match command {
        ArtifactsCommand::List(args) => list(&args.artifacts),
        ArtifactsCommand::Show(args) => show(&args.artifacts, args.version.as_deref()),
        ArtifactsCommand::Diff {
            before,
            after,
            artifacts,
        } => diff(artifacts, before, after),
        ArtifactsCommand::Mjcf(args) => mjcf(&args.artifacts, args.version.as_deref()),
        ArtifactsCommand::Verify { version, key } => {
            let key = key.as_deref().map(signing::public_key).transpose()?;
            verify(&version.artifacts, version.version.as_deref(), key.as_ref())
        }
        ArtifactsCommand::Sign { artifacts, key } => sign(&signing::store(artifacts, Some(key))?),
        ArtifactsCommand::Rollback {
            version,
            artifacts,
            sign,
        } => {
            let store = signing::store(artifacts, sign.key.as_deref())?;
            rollback(&store, version.as_deref())
        }
        ArtifactsCommand::Push {
            url,
            version,
            over,
            artifacts,
            sign,
        } => {
            let artifact = Store::open(artifacts).load(version.as_deref());
            let signer = sign.key.as_deref().map(SecretSigner::load).transpose()?;
            push(artifact.map_err(store_error)?, url, over.as_deref(), signer)
        }
    }
}

/// A version into a store by URL.
fn push(
    artifact: Artifact,
    url: &str,
    over: Option<&str>,
    signer: Option<SecretSigner>,
) -> Result<Output, Error> {
    let place = Place::open(url).map_err(object_error)?;
    let from = artifact.version.clone();
    let signer = signer.map(|signer| Arc::new(signer) as Arc<dyn Signer>);
    let pushed = store::push(&artifact.into(), &place, over, signer).map_err(|error| match error {
        ArtifactError::Overtaken { .. } => Error::Refused(error.to_string()),
        error => store_error(error),
    });
    let version = pushed?;
    let text = format!("{from} is {version} in {}, and in use there\n", place.url());
    let json = json!({ "from": from, "version": version, "url": place.url() });
    Ok(Output::done(json, text))
}

/// The world of a version as MJCF, for MuJoCo's viewer.
fn mjcf(dir: &Path, version: Option<&str>) -> Result<Output, Error> {
    let artifact = Store::open(dir).load(version).map_err(store_error)?;
    let calibrated = artifact.effect.as_ref().unwrap_or(&artifact.sysid);
    let text = world::mjcf(&artifact.rig, &calibrated.world).map_err(Error::failed)?;
    Ok(Output::done(
        json!({ "artifact": artifact.version, "mjcf": text }),
        format!("{}\n", text.trim_end()),
    ))
}

/// What changed between two versions.
fn diff(dir: &Path, before: &str, after: &str) -> Result<Output, Error> {
    let load = |name: &str| {
        let folder = Path::new(name);
        let loaded = match folder.is_dir() {
            true => Store::open(folder).load(None),
            false => Store::open(dir).load(Some(name)),
        };
        loaded.map_err(store_error)
    };
    let found = difference(&load(before)?, &load(after)?)?;
    Ok(Output::done(to_json(&found)?, found.text()))
}

/// All versions, oldest first.
fn list(dir: &Path) -> Result<Output, Error> {
    if !dir.is_dir() {
        return Err(Error::input(format!(
            "list the versions in {}: there is no such folder; `--artifacts` names the folder of a run",
            dir.display()
        )));
    }
    let versions = Store::open(dir).list().map_err(store_error)?;
    let mut rows = Vec::new();
    let mut text = String::new();
    for listing in versions {
        let mark = if listing.is_latest { "latest" } else { "" };
        let said = match &listing.manifest {
            Ok(manifest) => describe(manifest),
            Err(error) => format!("failed to {error}"),
        };
        let line = format!("{:<8} {mark:<7} {said}", listing.version);
        let _ = writeln!(text, "{}", line.trim_end());
        rows.push(json!({
            "version": listing.version,
            "latest": listing.is_latest,
            "manifest": listing.manifest.as_ref().ok(),
            "error": listing.manifest.as_ref().err().map(ToString::to_string),
        }));
    }
    if rows.is_empty() {
        text = format!("no versions in {}\n", dir.display());
    }
    Ok(Output::done(Value::Array(rows), text))
}

fn describe(manifest: &Manifest) -> String {
    let model = manifest.provenance.default_model;
    let logs = manifest.provenance.inputs.len();
    match manifest.provenance.metrics.get(&model) {
        Some(metrics) => format!(
            "{model:<15} {:.2} ± {:.2} cm on {} held-out strikes, from {logs} logs",
            metrics.mean * 100.0,
            metrics.sd * 100.0,
            metrics.n
        ),
        None => format!("{model:<15} not evaluated, from {logs} logs"),
    }
}

/// A version's manifest.
fn show(dir: &Path, version: Option<&str>) -> Result<Output, Error> {
    let manifest = Store::open(dir).show(version).map_err(store_error)?;
    Ok(Output::done(to_json(&manifest)?, manifest.to_json()))
}

/// Whether a version is whole, and signed by a key where one is given.
fn verify(dir: &Path, version: Option<&str>, key: Option<&Key>) -> Result<Output, Error> {
    let store = Store::open(dir);
    let (artifact, sequence) = match key {
        Some(key) => store
            .load_trusted(version, key)
            .map(|(artifact, sequence)| (artifact, Some(sequence))),
        None => store.load(version).map(|artifact| (artifact, None)),
    }
    .map_err(store_error)?;
    let files = artifact.manifest.files.len();
    let mut text = format!(
        "{} is whole: {files} files with the hashes, shapes and versions that its manifest names\n",
        artifact.version
    );
    if let Some(sequence) = sequence {
        text += &format!("it is signed by the key, as number {sequence}\n");
    }
    Ok(Output::done(
        json!({ "version": artifact.version, "files": files, "whole": true, "sequence": sequence }),
        text,
    ))
}

/// Signs the version in use.
fn sign(store: &Store) -> Result<Output, Error> {
    let version = store.sign().map_err(store_error)?;
    let text = format!("{version} is signed\n");
    Ok(Output::done(json!({ "version": version }), text))
}

/// Makes another version the latest.
fn rollback(store: &Store, version: Option<&str>) -> Result<Output, Error> {
    let version = store.rollback(version).map_err(store_error)?;
    let text = format!("latest is {version}\n");
    Ok(Output::done(json!({ "latest": version }), text))
}
