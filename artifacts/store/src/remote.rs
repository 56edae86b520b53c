//! A store behind a URL: a version is put there, and copied from there, as files of the same names.
//!
//! An object store has no lock, but conditions: each file of a version is written only where there is none of its name, the manifest as the
//! last, and `latest` is replaced only if it is what it was. Whoever is overtaken leaves at most files that nothing names.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::objects::{ObjectError, Place};
use durable::Error;

use crate::files::{MANIFEST, encode};
use crate::store::{LATEST, VERSIONS};
use crate::{ArtifactError, Contents, Key, SIGNATURE, Signer, Store, load, version};

/// Number of version numbers that are tried where others, or what a stopped publisher left, have them.
const TRIES: usize = 50;

/// Publishes contents as a new version there, signed where there is a signer, and makes it the one in use, if the one in use is still what it
/// was as this began (and the one that `over` names, where it does); else [`ArtifactError::Overtaken`]. Gives its name. Where the version in
/// use has these contents already, nothing is written.
pub fn push(
    contents: &Contents,
    to: &Place,
    over: Option<&str>,
    signer: Option<Arc<dyn Signer>>,
) -> Result<String, ArtifactError> {
    let overtaken = |expected: Option<String>, found: Option<String>| ArtifactError::Overtaken {
        store: to.url().into(),
        expected,
        found,
    };
    let scratch = tempfile::tempdir()
        .map_err(|source| Error::new("make a folder in", &std::env::temp_dir(), source))?;
    // What is there, without the files that a manifest lists: it numbers and signs as any store does.
    let mirror = Store {
        dir: scratch.path().into(),
        signer,
    };
    let tag = match to.get(LATEST) {
        Ok((bytes, tag)) => {
            durable::write_bytes(&mirror.dir.join(LATEST), &bytes)?;
            tag
        }
        Err(error) if error.is_not_found() => None,
        Err(error) => return Err(error.into()),
    };
    let before = match mirror.latest() {
        Ok(before) => Some(before),
        Err(ArtifactError::NoLatest { .. }) => None,
        Err(error) => return Err(error),
    };
    for object in to.list()? {
        let parts: Vec<&str> = object.name.split('/').collect();
        if let [VERSIONS, name, file] = parts[..]
            && version::number(name).is_some()
        {
            let folder = mirror.version_dir(name);
            durable::create_dir(&folder)?;
            // Who signs counts on from the highest of all signatures.
            let is_of_use = mirror.signer.is_some() || before.as_deref() == Some(name);
            if is_of_use && [MANIFEST, SIGNATURE].contains(&file) {
                durable::write_bytes(&folder.join(file), &to.get(&object.name)?.0)?;
            }
        }
    }
    if over.is_some() && over != before.as_deref() {
        return Err(overtaken(over.map(String::from), before));
    }
    if let Some(before) = &before {
        let there = load::manifest_bytes(&mirror.version_dir(before), before);
        let ours = encode(contents).0.to_json();
        if there.is_ok_and(|there| there == ours.as_bytes()) {
            return Ok(before.clone());
        }
    }
    for _ in 0..TRIES {
        let version = mirror.keep_candidate(contents)?;
        let folder = mirror.version_dir(&version);
        if !put(&folder, to, &version)? {
            // The number is another's.
            durable::remove_dir(&folder)?;
            durable::create_dir(&folder)?;
            continue;
        }
        if to.swap(LATEST, format!("{version}\n").as_bytes(), tag.as_deref())? {
            return Ok(version);
        }
        let found = String::from_utf8_lossy(&to.get(LATEST)?.0)
            .trim_end()
            .into();
        return Err(overtaken(before, Some(found)));
    }
    Err(overtaken(before.clone(), before))
}

/// Writes the files of a version, the manifest last; whether all are there now as they are here.
fn put(folder: &Path, to: &Place, version: &str) -> Result<bool, ArtifactError> {
    let failed = |source| Error::new("list", folder, source);
    let entries = fs::read_dir(folder).map_err(failed)?;
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let mut names = names.collect::<Result<Vec<String>, _>>().map_err(failed)?;
    // All in one order: of two publishers the first file that differs decides.
    names.sort_by_key(|name| (name == MANIFEST, name.clone()));
    for name in names {
        let path = folder.join(&name);
        let bytes = fs::read(&path).map_err(|source| Error::new("read", &path, source))?;
        if !to.create(&format!("{VERSIONS}/{version}/{name}"), &bytes)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Copies a version (the one in use unless named) into the store of a folder; it is checked there, its signature too where there is a key, before
/// it has its name. Where that cannot be, and the copy has a whole one, that is used: then why, as a sentence. That no version is in use, or
/// not the one that is named, is an error in any case.
pub fn pull(
    from: &Place,
    copy: &Store,
    version: Option<&str>,
    key: Option<&Key>,
) -> Result<Option<String>, ArtifactError> {
    let named = named(from, version);
    let is_gone = matches!(&named, Err(ArtifactError::Object(error)) if error.is_not_found());
    let pulled = named.and_then(|named| {
        let manifest = from.get(&format!("{VERSIONS}/{named}/{MANIFEST}"))?.0;
        pulled(from, copy, &named, &manifest, key)?;
        match version {
            Some(_) => Ok(()),
            None => copy.set_latest(&named),
        }
    });
    let Err(error) = pulled else {
        return Ok(None);
    };
    let kept = match key {
        Some(key) => copy.load_trusted(version, key).map(|(kept, _)| kept),
        None => copy.load(version),
    };
    match kept {
        Ok(kept) if !is_gone => Ok(Some(format!(
            "failed to {error}: {} is used, the last that was copied to {} and verified",
            kept.version,
            copy.name()
        ))),
        _ => Err(error),
    }
}

/// The version that is named, or in use there.
fn named(from: &Place, version: Option<&str>) -> Result<String, ArtifactError> {
    let named = match version {
        Some(version) => version.to_owned(),
        None => String::from_utf8_lossy(&from.get(LATEST)?.0)
            .trim_end()
            .into(),
    };
    if version::number(&named).is_none() {
        return Err(ArtifactError::BadLatest {
            store: from.url().into(),
            found: named.chars().take(40).collect(),
        });
    }
    Ok(named)
}

fn pulled(
    from: &Place,
    copy: &Store,
    named: &str,
    manifest: &[u8],
    key: Option<&Key>,
) -> Result<(), ArtifactError> {
    let there = |file: &str| format!("{VERSIONS}/{named}/{file}");
    let signature = match from.get(&there(SIGNATURE)) {
        Ok((bytes, _)) => Some(bytes),
        Err(ObjectError::NotFound { .. }) => None,
        Err(error) => return Err(error.into()),
    };
    // Nothing is made here before a store has answered.
    durable::create_dir(&copy.versions())?;
    let _lock = copy.lock()?;
    durable::sweep(&copy.versions())?;
    let folder = copy.version_dir(named);
    let is_kept =
        |file: &str, bytes: &[u8]| fs::read(folder.join(file)).is_ok_and(|kept| kept == bytes);
    let is_signed = match &signature {
        Some(bytes) => is_kept(SIGNATURE, bytes),
        None => !folder.join(SIGNATURE).exists(),
    };
    let is_sound = |dir: &Path| match key {
        Some(key) => load::load_trusted(dir, named, key).map(drop),
        None => load::load(dir, named).map(drop),
    };
    if is_signed && is_kept(MANIFEST, manifest) && is_sound(&folder).is_ok() {
        return Ok(());
    }
    let aside = copy.versions().join(format!(".{named}.partial"));
    durable::create_dir(&aside)?;
    for file in load::listed(manifest, named)? {
        durable::write_bytes(&aside.join(&file), &from.get(&there(&file))?.0)?;
    }
    durable::write_bytes(&aside.join(MANIFEST), manifest)?;
    if let Some(bytes) = &signature {
        durable::write_bytes(&aside.join(SIGNATURE), bytes)?;
    }
    is_sound(&aside)?;
    durable::remove_dir(&folder)?;
    Ok(durable::rename(&aside, &folder)?)
}
