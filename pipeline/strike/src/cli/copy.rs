//! Artifacts by URL: a copy on this computer, which strikes when the store cannot be reached.

use std::path::PathBuf;

use objects::{ObjectError, Place};
use store::{ArtifactError, Store};
use strike::{Args, Trust, TrustError, tell};

use super::Failure;
use super::load::{configured, trust};

/// The folder of the artifact: of a URL, a local copy as new as it can be had; of a path, that folder itself. A person is told what could not be
/// fetched.
pub fn local(args: &Args) -> Result<PathBuf, Failure> {
    let given = &args.artifacts;
    if let Some(path) = objects::path_of(given) {
        return Ok(path);
    }
    let Some(url) = given.to_str().filter(|_| objects::is_url(given)) else {
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
    let data = objects::own_folder("XDG_DATA_HOME", ".local/share");
    let data = data.ok_or_else(|| Failure::input("find a folder for the copy of the artifact: neither XDG_DATA_HOME nor HOME is set; set one"))?;
    Ok(data.join("carom/artifacts"))
}
