//! Reads a version and checks all of it, the cheapest and most decisive checks first.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use durable::sha256;
use semver::{Version, VersionReq};
use serde::Deserialize;
use values::{Rig, StopErrors};
use world::World;

use crate::files::{MAIN, MANIFEST, PLAIN, RIG, identity};
use crate::{
    Artifact, ArtifactError, Calibrated, Key, Manifest, ResidualModel, SCHEMA_VERSION, SIGNATURE,
};

/// Longest manifest that is read, in bytes: one of a hundred thousand logs is shorter.
const LONGEST_MANIFEST: u64 = 1 << 25;

/// Longest file of a version that is read, in bytes. A world or a rig is some kilobytes, an ensemble of networks below a megabyte.
const LONGEST_FILE: u64 = 1 << 26;

type Files = BTreeMap<String, Vec<u8>>;

/// The version in a folder, under the name that it has or is to have.
pub(crate) fn load(dir: &Path, version: &str) -> Result<Artifact, ArtifactError> {
    let bytes = manifest_bytes(dir, version)?;
    load_with(dir, version, &bytes)
}

/// The same, after checking that this key signed it, and the count of its signature. Nothing of a version is looked at
/// before its signature holds.
pub(crate) fn load_trusted(
    dir: &Path,
    version: &str,
    key: &Key,
) -> Result<(Artifact, u64), ArtifactError> {
    let bytes = manifest_bytes(dir, version)?;
    let sequence = key.check(dir, version, &bytes)?;
    Ok((load_with(dir, version, &bytes)?, sequence))
}

fn load_with(dir: &Path, version: &str, manifest: &[u8]) -> Result<Artifact, ArtifactError> {
    let manifest = parse(manifest, version)?;
    programs(&manifest, version)?;
    let expected = file_list(&manifest, version)?;
    no_extra(dir, version, &expected)?;
    let files = contents(dir, version, &manifest)?;

    let rig = rig(&files, version, &manifest)?;
    let main = calibrated(&files, version, MAIN)?;
    let (sysid, effect) = match files.contains_key(PLAIN[0]) {
        false => (main, None),
        true => (calibrated(&files, version, PLAIN)?, Some(main)),
    };
    let artifact = Artifact {
        version: version.into(),
        manifest,
        rig,
        sysid,
        effect,
    };
    models(&artifact)?;
    numbers(&artifact.manifest, version)?;
    Ok(artifact)
}

/// The manifest alone, of a schema that is known.
pub(crate) fn manifest(dir: &Path, version: &str) -> Result<Manifest, ArtifactError> {
    parse(&manifest_bytes(dir, version)?, version)
}

fn bad_manifest(version: &str, why: String) -> ArtifactError {
    ArtifactError::BadManifest {
        version: version.into(),
        why,
    }
}

/// The manifest as it lies there.
pub(crate) fn manifest_bytes(dir: &Path, version: &str) -> Result<Vec<u8>, ArtifactError> {
    let path = dir.join(MANIFEST);
    match read(&path, LONGEST_MANIFEST) {
        Err(error) if error.kind() == ErrorKind::NotFound => Err(ArtifactError::NoManifest {
            version: version.into(),
        }),
        Err(error) => Err(durable::Error::new("read", &path, error).into()),
        Ok(bytes) if bytes.len() as u64 > LONGEST_MANIFEST => Err(bad_manifest(
            version,
            format!("longer than {LONGEST_MANIFEST} bytes"),
        )),
        Ok(bytes) => Ok(bytes),
    }
}

fn parse(bytes: &[u8], version: &str) -> Result<Manifest, ArtifactError> {
    let bad = |error: serde_json::Error| bad_manifest(version, error.to_string());
    // First the schema alone: of another one, nothing else is known.
    #[derive(Deserialize)]
    struct Schema {
        schema: u64,
    }
    let Schema { schema } = serde_json::from_slice(bytes).map_err(bad)?;
    if schema != u64::from(SCHEMA_VERSION) {
        return Err(ArtifactError::UnknownSchema {
            version: version.into(),
            found: schema,
            known: SCHEMA_VERSION,
        });
    }
    let manifest: Manifest = serde_json::from_slice(bytes).map_err(bad)?;
    let found = manifest.seal(bytes);
    if found == manifest.sha256 {
        Ok(manifest)
    } else {
        Err(ArtifactError::WrongHash {
            version: version.into(),
            file: MANIFEST.into(),
            found,
            expected: manifest.sha256,
        })
    }
}

/// Reads at most one byte more than `most`.
fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A carom that computes the same (compatible by semantic versioning), and the very same MuJoCo.
fn programs(manifest: &Manifest, version: &str) -> Result<(), ArtifactError> {
    let here = env!("CARGO_PKG_VERSION");
    let is_compatible = Version::parse(&manifest.carom).is_ok_and(|found| {
        VersionReq::parse(&format!("{}.{}", found.major, found.minor))
            .is_ok_and(|request| Version::parse(here).is_ok_and(|here| request.matches(&here)))
    });
    if !is_compatible {
        return Err(ArtifactError::OtherCarom {
            version: version.into(),
            found: manifest.carom.clone(),
            here: here.into(),
        });
    }
    let here = world::mujoco_version();
    if manifest.mujoco == here {
        Ok(())
    } else {
        Err(ArtifactError::OtherMujoco {
            version: version.into(),
            found: manifest.mujoco.clone(),
            here,
        })
    }
}

/// The names that the manifest lists, which must be those of a version: without or with an effect, and each world with
/// or without a residual.
fn file_list(manifest: &Manifest, version: &str) -> Result<BTreeSet<String>, ArtifactError> {
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
        Err(ArtifactError::FileList {
            version: version.into(),
            found: names(listed),
            expected: names(expected),
        })
    }
}

fn no_extra(dir: &Path, version: &str, listed: &BTreeSet<String>) -> Result<(), ArtifactError> {
    let failed = |source| ArtifactError::from(durable::Error::new("list", dir, source));
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
        Some(file) => Err(ArtifactError::ExtraFile {
            version: version.into(),
            file,
        }),
    }
}

/// Every listed file's content, of the length and hash that the manifest says.
fn contents(dir: &Path, version: &str, manifest: &Manifest) -> Result<Files, ArtifactError> {
    let mut files = Files::new();
    for (name, expected) in &manifest.files {
        let (version, file, path) = (version.to_string(), name.clone(), dir.join(name));
        let failed = |source: io::Error| match source.kind() {
            ErrorKind::NotFound => ArtifactError::MissingFile {
                version: version.clone(),
                file: file.clone(),
            },
            _ => durable::Error::new("read", &path, source).into(),
        };
        let size = fs::metadata(&path).map_err(failed)?.len();
        if size != expected.size {
            return Err(ArtifactError::WrongSize {
                version,
                file,
                found: size,
                expected: expected.size,
            });
        }
        if size > LONGEST_FILE {
            return Err(ArtifactError::TooLong {
                version,
                file,
                found: size,
                most: LONGEST_FILE,
            });
        }
        let bytes = read(&path, size).map_err(failed)?;
        let found = sha256(&bytes);
        if found != expected.sha256 {
            return Err(ArtifactError::WrongHash {
                version,
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

fn rig(files: &Files, version: &str, manifest: &Manifest) -> Result<Rig, ArtifactError> {
    let rig = text(files, RIG)
        .map_err(values::RigError::Parse)
        .and_then(Rig::parse)
        .map_err(|source| ArtifactError::BadRig {
            version: version.into(),
            source,
        })?;
    let found = identity(&rig);
    if found == manifest.rig {
        Ok(rig)
    } else {
        Err(ArtifactError::OtherRig {
            version: version.into(),
            found,
            expected: manifest.rig.clone(),
        })
    }
}

/// A world, and its residual where the version lists one.
fn calibrated(
    files: &Files,
    version: &str,
    [world, residual]: [&str; 2],
) -> Result<Calibrated, ArtifactError> {
    let bad = |why| ArtifactError::BadWorld {
        version: version.into(),
        file: world.into(),
        why,
    };
    let parsed = text(files, world)
        .and_then(|text| World::parse(text).map_err(|error| format!("failed to {error}")))
        .map_err(bad)?;
    let network = files.get(residual).map(|bytes| {
        ResidualModel::from_safetensors(bytes).map_err(|source| ArtifactError::BadNetwork {
            version: version.into(),
            file: residual.into(),
            source,
        })
    });
    Ok(Calibrated {
        world: parsed,
        residual: network.transpose()?,
    })
}

/// Every model that the manifest names is there.
fn models(artifact: &Artifact) -> Result<(), ArtifactError> {
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
        Some(model) => Err(ArtifactError::NoModel {
            version: artifact.version.clone(),
            model: *model,
            has: has
                .iter()
                .map(|model| model.name())
                .collect::<Vec<_>>()
                .join(", "),
        }),
    }
}

/// Numbers that the executor relies on are finite, and intervals are not reversed.
fn numbers(manifest: &Manifest, version: &str) -> Result<(), ArtifactError> {
    let bad = |name: String, why| {
        Err(ArtifactError::BadNumber {
            version: version.into(),
            name,
            why,
        })
    };
    for (name, interval) in manifest.provenance.trained_region.bounds() {
        let is_interval =
            interval.low.is_finite() && interval.high.is_finite() && interval.low <= interval.high;
        if !is_interval {
            return bad(
                name.into(),
                format!("[{}, {}] is no interval", interval.low, interval.high),
            );
        }
    }
    for (model, explained) in &manifest.provenance.explained {
        for (name, interval) in [
            ("d_speed", explained.d_speed),
            ("d_angle", explained.d_angle),
        ] {
            if !(interval.low.is_finite()
                && interval.high.is_finite()
                && interval.low <= interval.high)
            {
                return bad(
                    format!("explained.{model}.{name}"),
                    format!("[{}, {}] is no interval", interval.low, interval.high),
                );
            }
        }
        for (name, share) in explained.shares() {
            if !(share >= 0.0 && share.is_finite()) {
                return bad(
                    format!("explained.{model}.{name}"),
                    format!("{share} is no share"),
                );
            }
        }
    }
    for (model, varies) in &manifest.provenance.varies {
        if let Err(why) = varies.check() {
            return bad(format!("varies.{model}"), why);
        }
    }
    for (
        model,
        StopErrors {
            mean,
            sd,
            median,
            p95,
            ..
        },
    ) in &manifest.provenance.metrics
    {
        if let Some(number) = [mean, sd, median, p95]
            .into_iter()
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
