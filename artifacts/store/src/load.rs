//! Reads a version and checks all of it, the cheapest and most decisive checks first.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use durable::sha256;
use semver::{Version, VersionReq};
use serde::Deserialize;
use values::{Interval, Rig};
use world::World;

use crate::files::{MAIN, MANIFEST, PLAIN, RIG, identity};
use crate::{
    Artifact, ArtifactError, Calibrated, Fault, Key, LONGEST_FILE, Manifest, Provenance,
    ResidualModel, SCHEMA_VERSION, SIGNATURE,
};

/// Longest manifest that is read, in bytes: one of a hundred thousand logs is shorter.
const LONGEST_MANIFEST: u64 = 1 << 25;

type Files = BTreeMap<String, Vec<u8>>;

/// The version in a folder, under the name that it has or is to have.
pub(crate) fn load(dir: &Path, version: &str) -> Result<Artifact, ArtifactError> {
    let bytes = manifest_bytes(dir, version)?;
    load_with(dir, version, &bytes).map_err(|fault| fault.of(version))
}

/// A version, checked, and the count of its signature, after checking that this key signed it. Nothing of a version is looked at
/// before its signature holds.
pub(crate) fn load_trusted(
    dir: &Path,
    version: &str,
    key: &Key,
) -> Result<(Artifact, u64), ArtifactError> {
    let bytes = manifest_bytes(dir, version)?;
    let sequence = key.check(dir, version, &bytes);
    let loaded = sequence.and_then(|sequence| Ok((load_with(dir, version, &bytes)?, sequence)));
    loaded.map_err(|fault| fault.of(version))
}

fn load_with(dir: &Path, version: &str, manifest: &[u8]) -> Result<Artifact, Fault> {
    let manifest = parse(manifest)?;
    programs(&manifest)?;
    let expected = file_list(&manifest)?;
    no_extra(dir, &expected)?;
    let files = contents(dir, &manifest)?;

    let rig = rig(&files, &manifest)?;
    let main = calibrated(&files, MAIN)?;
    let (sysid, effect) = match files.contains_key(PLAIN[0]) {
        false => (main, None),
        true => (calibrated(&files, PLAIN)?, Some(main)),
    };
    let artifact = Artifact {
        version: version.into(),
        manifest,
        rig,
        sysid,
        effect,
    };
    models(&artifact)?;
    numbers(&artifact.manifest)?;
    Ok(artifact)
}

/// The manifest alone, of a schema that is known.
pub(crate) fn manifest(dir: &Path, version: &str) -> Result<Manifest, ArtifactError> {
    parse(&manifest_bytes(dir, version)?).map_err(|fault| fault.of(version))
}

pub(crate) fn manifest_bytes(dir: &Path, version: &str) -> Result<Vec<u8>, ArtifactError> {
    let path = dir.join(MANIFEST);
    let bytes = match read(&path, LONGEST_MANIFEST) {
        Err(error) if error.kind() == ErrorKind::NotFound => Err(Fault::NoManifest),
        Err(error) => Err(durable::Error::new("read", &path, error).into()),
        Ok(bytes) if bytes.len() as u64 > LONGEST_MANIFEST => {
            let why = format!("longer than {LONGEST_MANIFEST} bytes");
            Err(Fault::BadManifest(why))
        }
        Ok(bytes) => Ok(bytes),
    };
    bytes.map_err(|fault| fault.of(version))
}

/// The files that a manifest lists, which are those of a version.
pub(crate) fn listed(manifest: &[u8], version: &str) -> Result<BTreeSet<String>, ArtifactError> {
    let listed = parse(manifest).and_then(|manifest| file_list(&manifest));
    listed.map_err(|fault| fault.of(version))
}

fn parse(bytes: &[u8]) -> Result<Manifest, Fault> {
    let bad = |error: serde_json::Error| Fault::BadManifest(error.to_string());
    // First the schema alone: of another one, nothing else is known.
    #[derive(Deserialize)]
    struct Schema {
        schema: u64,
    }
    let Schema { schema } = serde_json::from_slice(bytes).map_err(bad)?;
    if schema != u64::from(SCHEMA_VERSION) {
        return Err(Fault::UnknownSchema(schema));
    }
    let manifest: Manifest = serde_json::from_slice(bytes).map_err(bad)?;
    let found = manifest.seal(bytes);
    if found == manifest.sha256 {
        Ok(manifest)
    } else {
        Err(Fault::WrongHash {
            file: MANIFEST.into(),
            found,
            expected: manifest.sha256,
        })
    }
}

fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A carom that computes the same (compatible by semantic versioning), and the very same MuJoCo.
fn programs(manifest: &Manifest) -> Result<(), Fault> {
    let here = env!("CARGO_PKG_VERSION");
    let is_compatible = Version::parse(&manifest.carom).is_ok_and(|found| {
        VersionReq::parse(&format!("{}.{}", found.major, found.minor))
            .is_ok_and(|request| Version::parse(here).is_ok_and(|here| request.matches(&here)))
    });
    if !is_compatible {
        return Err(Fault::OtherCarom(manifest.carom.clone()));
    }
    if manifest.mujoco == world::mujoco_version() {
        Ok(())
    } else {
        Err(Fault::OtherMujoco(manifest.mujoco.clone()))
    }
}

/// The names that the manifest lists, which must be those of a version: without or with an effect, and each world with
/// or without a residual.
fn file_list(manifest: &Manifest) -> Result<BTreeSet<String>, Fault> {
    let listed: BTreeSet<String> = manifest.files.keys().cloned().collect();
    let has = |name: &str| listed.contains(name);
    let mut expected = vec![RIG, MAIN[0]];
    expected.extend(has(MAIN[1]).then_some(MAIN[1]));
    if has(PLAIN[0]) || has(PLAIN[1]) {
        expected.push(PLAIN[0]);
        expected.extend(has(PLAIN[1]).then_some(PLAIN[1]));
    }
    let expected: BTreeSet<String> = expected.into_iter().map(String::from).collect();
    if listed == expected {
        Ok(listed)
    } else {
        let names = |names: BTreeSet<String>| names.into_iter().collect::<Vec<_>>().join(", ");
        Err(Fault::FileList(names(listed), names(expected)))
    }
}

fn no_extra(dir: &Path, listed: &BTreeSet<String>) -> Result<(), Fault> {
    let failed = |source| durable::Error::new("list", dir, source);
    let mut extra = Vec::new();
    for entry in fs::read_dir(dir).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        // Links and folders are no files of a version, whatever their name.
        let is_file = entry.file_type().map_err(failed)?.is_file();
        let is_beside = name == MANIFEST || name == SIGNATURE;
        if !is_file || !(is_beside || listed.contains(&name)) {
            extra.push(name);
        }
    }
    match extra.into_iter().min() {
        None => Ok(()),
        Some(file) => Err(Fault::ExtraFile(file)),
    }
}

/// Every listed file's content, of the length and hash that the manifest says.
fn contents(dir: &Path, manifest: &Manifest) -> Result<Files, Fault> {
    let mut files = Files::new();
    for (name, expected) in &manifest.files {
        let (file, path) = (name.clone(), dir.join(name));
        let failed = |source: io::Error| match source.kind() {
            ErrorKind::NotFound => Fault::MissingFile(name.clone()),
            _ => durable::Error::new("read", &path, source).into(),
        };
        let size = fs::metadata(&path).map_err(failed)?.len();
        if size != expected.size {
            return Err(Fault::WrongSize {
                file,
                found: size,
                expected: expected.size,
            });
        }
        if size > LONGEST_FILE {
            return Err(Fault::TooLong(file, size));
        }
        let bytes = read(&path, size).map_err(failed)?;
        let found = sha256(&bytes);
        if found != expected.sha256 {
            return Err(Fault::WrongHash {
                file,
                found,
                expected: expected.sha256.clone(),
            });
        }
        files.insert(name.clone(), bytes);
    }
    Ok(files)
}

fn text<'a>(files: &'a Files, name: &str) -> Result<&'a str, String> {
    let bytes = files.get(name).map_or(&[][..], Vec::as_slice);
    std::str::from_utf8(bytes).map_err(|error| error.to_string())
}

fn rig(files: &Files, manifest: &Manifest) -> Result<Rig, Fault> {
    let rig = text(files, RIG)
        .map_err(values::RigError::Parse)
        .and_then(Rig::parse)
        .map_err(Fault::BadRig)?;
    let found = identity(&rig);
    if found == manifest.rig {
        Ok(rig)
    } else {
        Err(Fault::OtherRig(found, manifest.rig.clone()))
    }
}

fn calibrated(files: &Files, [world, residual]: [&str; 2]) -> Result<Calibrated, Fault> {
    let parsed = text(files, world)
        .and_then(|text| World::parse(text).map_err(|error| format!("failed to {error}")))
        .map_err(|why| Fault::BadWorld(world.into(), why))?;
    let network = files.get(residual).map(|bytes| {
        ResidualModel::from_safetensors(bytes)
            .map_err(|why| Fault::BadNetwork(residual.into(), why))
    });
    Ok(Calibrated {
        world: parsed,
        residual: network.transpose()?,
    })
}

/// Every model that the manifest names is there.
fn models(artifact: &Artifact) -> Result<(), Fault> {
    let has = artifact.models();
    let provenance = &artifact.manifest.provenance;
    match provenance
        .metrics
        .keys()
        .chain(provenance.explained.keys())
        .chain(provenance.varies.keys())
        .chain([&provenance.default_model])
        .find(|model| !has.contains(model))
    {
        None => Ok(()),
        Some(model) => {
            let has: Vec<_> = has.iter().map(|model| model.name()).collect();
            Err(Fault::NoModel(*model, has.join(", ")))
        }
    }
}

/// Numbers that the executor relies on are finite, and intervals are not reversed.
fn numbers(manifest: &Manifest) -> Result<(), Fault> {
    let bad = |name: String, why| Err(Fault::BadNumber(name, why));
    let Provenance {
        trained_region,
        explained,
        varies,
        metrics,
        ..
    } = &manifest.provenance;
    let bounds = trained_region.bounds();
    let bounds = bounds.map(|(name, bound)| (name.to_string(), bound));
    let explain = explained.iter().flat_map(|(model, explained)| {
        let both = [
            ("d_speed", explained.d_speed),
            ("d_angle", explained.d_angle),
        ];
        both.map(|(name, bound)| (format!("explained.{model}.{name}"), bound))
    });
    for (name, Interval { low, high }) in bounds.chain(explain) {
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return bad(name, format!("[{low}, {high}] is no interval"));
        }
    }
    for (model, explained) in explained {
        for (name, share) in explained.shares() {
            if !(share >= 0.0 && share.is_finite()) {
                return bad(
                    format!("explained.{model}.{name}"),
                    format!("{share} is no share"),
                );
            }
        }
    }
    for (model, varies) in varies {
        if let Err(why) = varies.check() {
            return bad(format!("varies.{model}"), why);
        }
    }
    for (model, errors) in metrics {
        let numbers = [errors.mean, errors.sd, errors.median, errors.p95];
        if let Some(number) = numbers
            .iter()
            .find(|number| !(**number >= 0.0 && number.is_finite()))
        {
            return bad(
                format!("metrics.{model}"),
                format!("{number} is no stop error"),
            );
        }
    }
    Ok(())
}
