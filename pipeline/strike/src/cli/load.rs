//! The artifact to strike with, and the rig within whose limits it is used.

use std::path::{Path, PathBuf};
use std::{env, io};

use store::objects::{ObjectError, Place};
use store::{Artifact, ArtifactError, Store};
use strike::{Args, Config, Reason, Trust, TrustError, allows, identity, tell};
use values::Rig;

use super::Failure;

/// The artifact, and the rig within whose limits it is used: this robot's own where its file is given. Nothing else is
/// opened, and no robot, before the artifact has passed every check.
pub fn load(args: &Args) -> Result<(Artifact, Rig), Failure> {
    let config = configured(args)?;
    allows(
        config.key.is_some(),
        config.rig.is_some(),
        args.robot.moves(),
    )?;
    let own = match &config.rig {
        None => None,
        Some(path) => Some((path, load_rig(path)?)),
    };
    let trust = trust(&config)?;
    let is_own = |artifact: &Artifact| match &own {
        None => Ok(()),
        Some((path, rig)) => identity::check(&artifact.rig, rig).map_err(|other| {
            Failure::refused(Reason::OtherRig, format!("{}: {other}", path.display()))
        }),
    };
    let (store, version) = (Store::open(&args.artifacts), args.version.as_deref());
    let artifact = if let Some(trust) = trust {
        trust.load(&store, version, is_own)?
    } else {
        let artifact = store.load(version).map_err(Failure::input)?;
        is_own(&artifact)?;
        if !args.quiet {
            tell(&format!(
                "strike: no key is configured: {} is whole, but nobody vouches for it (see --key)",
                artifact.version
            ));
        }
        artifact
    };
    let rig = match own {
        Some((_, rig)) => rig,
        None => artifact.rig.clone(),
    };
    Ok((artifact, rig))
}

/// Whom to trust, where a key is configured.
pub(super) fn trust(config: &Config) -> Result<Option<Trust>, Failure> {
    let open = |key: &PathBuf| Trust::open(key, config.seen.as_deref());
    Ok(config.key.as_ref().map(open).transpose()?)
}

/// What is configured, and what the command line says in its place.
pub(super) fn configured(args: &Args) -> Result<Config, Failure> {
    let file = match &args.config {
        Some(path) => Config::load(path),
        None => {
            let program = called().map_err(|error| {
                Failure::failed(format!("find strike.toml beside this program: {error}"))
            })?;
            Config::beside(&program)
        }
    }
    .map_err(Failure::input)?;
    Ok(Config {
        key: args.key.clone().or(file.key),
        rig: args.rig.clone().or(file.rig),
        seen: args.seen.clone().or(file.seen),
    })
}

/// The file by which this program was called: a link, where it was called through one.
fn called() -> io::Result<PathBuf> {
    let name = env::args_os().next().map(PathBuf::from).unwrap_or_default();
    let real = env::current_exe()?;
    let folders = match name.components().count() {
        1 => env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect(),
        _ => vec![PathBuf::new()],
    };
    let is_this = |path: &PathBuf| path.canonicalize().is_ok_and(|path| path == real);
    let mut paths = folders.iter().map(|folder| folder.join(&name));
    Ok(paths.find(is_this).unwrap_or(real))
}

fn load_rig(path: &Path) -> Result<Rig, Failure> {
    Rig::load(path).map_err(|error| {
        Failure::input(format!(
            "use the rig file {}: failed to {error}",
            path.display()
        ))
    })
}

/// The folder of the artifact: of a URL, a local copy as new as it can be had; of a path, that folder itself. A person is told what could not be
/// fetched.
pub fn local(args: &Args) -> Result<PathBuf, Failure> {
    let given = &args.artifacts;
    if let Some(path) = store::objects::path_of(given) {
        return Ok(path);
    }
    let Some(url) = given.to_str().filter(|_| store::objects::is_url(given)) else {
        return Ok(given.clone());
    };
    let place = Place::open(url).map_err(Failure::input)?;
    let folder = place.below(&own_folder()?);
    let trust = trust(&configured(args)?)?;
    let key = trust.as_ref().map(Trust::key);
    let offline = store::pull(&place, &Store::open(&folder), args.version.as_deref(), key);
    let offline = offline.map_err(|error| match error {
        ArtifactError::Busy { .. } => Failure::Busy(error.to_string()),
        ArtifactError::Object(ObjectError::Store { .. }) => Failure::failed(error),
        error => TrustError::from(error).into(),
    });
    if let Some(why) = offline? {
        tell(&format!("strike: {why}"));
    }
    Ok(folder)
}

/// The folder for what this user's programs keep: a copy is needed when nothing else is there.
fn own_folder() -> Result<PathBuf, Failure> {
    let data = store::objects::own_folder("XDG_DATA_HOME", ".local/share");
    let data = data.ok_or_else(|| Failure::input("find a folder for the copy of the artifact: neither XDG_DATA_HOME nor HOME is set; set one"))?;
    Ok(data.join("carom/artifacts"))
}
