//! Logs by URL: copies of what is needed of them, which are read as any other log. A copy is made again where its log has another ETag.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use logs::part::{Source, Wanted, copy, is_copied};
use rayon::prelude::*;
use store::objects::{Object, ObjectError, Place};
use values::Rig;

use crate::Error;

/// Where a run keeps copies.
const FOLDER: &str = "objects";
/// What rosbag2 writes beside the files of a recording.
const METADATA: &str = "metadata.yaml";
/// File of checksums as `sha256sum` writes it: it says what a log's bytes are, without reading them all.
const SUMS: &str = "SHA256SUMS";

/// What is needed of logs, and where copies of it lie.
pub struct Fetch<'a> {
    /// Whose topics are needed; none for all.
    pub rig: Option<&'a Rig>,
    /// Folder of a run, or of this user where there is none.
    pub run: Option<&'a Path>,
}

impl Fetch<'_> {
    /// Copies the logs below a URL; gives the copies' paths.
    pub fn logs(&self, url: &str) -> Result<Vec<PathBuf>, Error> {
        let place = Place::open(url).map_err(object_error)?;
        let folder = match self.run {
            Some(run) => run.join(FOLDER),
            None => own_folder()?,
        };
        let folder = place.below(&folder);
        let listed = place.list().map_err(object_error)?;
        let sums = sums(&place, &listed)?;
        let wanted = self.rig.map(wanted);
        let file =
            |object: &Object| PathBuf::from(object.name.rsplit('/').next().unwrap_or_default());
        let is_log = |object: &&Object| match object.name.as_str() {
            "" => true,
            _ => logs::is_log(&file(object)) || file(object) == Path::new(METADATA),
        };
        let found: Vec<&Object> = listed.iter().filter(is_log).collect();
        let copies = found.par_iter().map(|object| {
            let source = Source {
                size: object.size,
                tag: &object.tag,
                sha256: sums.get(&object.name).map(String::as_str),
                wanted: wanted.as_ref(),
            };
            // A name that would lead out of the folder is no log's.
            let parts = object.name.split('/').filter(|part| *part != "..");
            let path = parts
                .filter(|part| !part.is_empty())
                .fold(folder.clone(), |path, part| path.join(part));
            if !is_copied(&source, &path) {
                durable::create_dir(path.parent().unwrap_or(&folder))?;
                let mut read = |range| place.read(object, range);
                copy(&source, &path, &writer(), &mut read).map_err(object_error)?;
            }
            Ok(path)
        });
        let copies: Vec<PathBuf> = copies.collect::<Result<_, Error>>()?;
        let logs: Vec<PathBuf> = copies
            .into_iter()
            .filter(|path| !path.ends_with(METADATA))
            .collect();
        if logs.is_empty() {
            return Err(Error::input(format!(
                "find logs in {}: there is no *.mcap or *.db3 below it; mend the URL, or copy logs there",
                place.url()
            )));
        }
        Ok(logs)
    }
}

/// Removes what killed programs left, from the folder of a run that works alone.
pub fn sweep(dir: &Path) -> Result<(), Error> {
    let folder = dir.join(FOLDER);
    if folder.is_dir() {
        durable::sweep(&folder)?;
    }
    Ok(())
}

/// The topics of a rig; images where no centroids are logged.
fn wanted(rig: &Rig) -> Wanted {
    let topics = &rig.topics;
    let names = [
        &topics.centroid.name,
        &topics.command.name,
        &topics.state.topic.name,
        &topics.pose.topic.name,
    ];
    let image = topics.image.as_ref();
    Wanted {
        topics: names.into_iter().cloned().collect(),
        instead: image.map(|image| (image.name.clone(), topics.centroid.name.clone())),
    }
}

/// The hashes that lie beside the logs, by the logs' names. One of a log that was replaced after it was hashed, or that two logs have, is not
/// believed.
fn sums(place: &Place, listed: &[Object]) -> Result<BTreeMap<String, String>, Error> {
    let mut sums = BTreeMap::new();
    for file in listed.iter().filter(|object| object.name.ends_with(SUMS)) {
        let (bytes, _) = place.get(&file.name).map_err(object_error)?;
        let folder = file.name.trim_end_matches(SUMS);
        for line in String::from_utf8_lossy(&bytes).lines() {
            let Some((sha256, name)) = line.split_once([' ', '\t']) else {
                continue;
            };
            let name = name
                .trim_start_matches([' ', '\t', '*'])
                .trim_start_matches("./");
            let name = format!("{folder}{name}");
            let log = listed.iter().find(|object| object.name == name);
            let is_hash = sha256.len() == 64 && sha256.bytes().all(|byte| byte.is_ascii_hexdigit());
            if is_hash && log.is_some_and(|log| log.modified <= file.modified) {
                sums.insert(name, sha256.to_ascii_lowercase());
            }
        }
    }
    // Two logs are not alike: such hashes are read from the logs.
    let all: Vec<String> = sums.values().cloned().collect();
    sums.retain(|_, sha256| all.iter().filter(|other| *other == sha256).count() == 1);
    Ok(sums)
}

/// A name that no other program has that copies the same log now, on whatever machine.
fn writer() -> String {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    format!(
        "{}_{}",
        std::process::id(),
        now.map_or(0, |now| now.as_nanos())
    )
}

/// For commands that have no run: kept between them.
fn own_folder() -> Result<PathBuf, Error> {
    let cache = store::objects::own_folder("XDG_CACHE_HOME", ".cache");
    let cache = cache.ok_or_else(|| {
        Error::input(
            "find a folder for copies of logs: neither XDG_CACHE_HOME nor HOME is set; set one",
        )
    })?;
    Ok(cache.join("carom").join(FOLDER))
}

/// An error of a store with the exit code that it has.
pub fn object_error(error: ObjectError) -> Error {
    match error {
        ObjectError::Url { .. } | ObjectError::NotFound { .. } => Error::input(error),
        error => Error::failed(error),
    }
}
