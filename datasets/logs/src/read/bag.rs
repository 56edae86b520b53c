//! What a log is on disk: one file, or the folder of a rosbag2 recording that was split.
//!
//! Source: ros2/rosbag2, `rosbag2_storage` (`metadata.yaml`), `rosbag2_compression` (`.zstd` behind the name of a file that was
//! compressed as a whole).

use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;
use yaml_rust2::YamlLoader;

use crate::LogError;

/// What rosbag2 writes beside its files.
const METADATA: &str = "metadata.yaml";
/// Larger metadata is none.
const LARGEST_METADATA: u64 = 16 << 20;
/// A file that is packed as a whole unpacks to no more than this, in bytes.
const LARGEST_UNPACKED: u64 = 64 << 30;
/// How files begin that zstd packed, and SQLite's.
const ZSTD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];
const SQLITE: &[u8] = b"SQLite format 3\0";
/// How the names of logs end.
const ENDINGS: [&str; 4] = [".mcap", ".mcap.zstd", ".db3", ".db3.zstd"];

/// Whether a file's name is that of a log.
pub fn is_log(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.to_ascii_lowercase();
    ENDINGS.iter().any(|ending| name.ends_with(ending))
}

/// The files of a rosbag2 folder in the order in which they were recorded, as its metadata lists them, there or not; none where
/// the folder has no metadata that can be read.
pub fn bag_files(folder: &Path) -> Option<Vec<PathBuf>> {
    let mut text = String::new();
    let metadata = File::open(folder.join(METADATA)).ok()?;
    metadata
        .take(LARGEST_METADATA)
        .read_to_string(&mut text)
        .ok()?;
    let documents = YamlLoader::load_from_str(&text).ok()?;
    let listed = &documents.first()?["rosbag2_bagfile_information"]["relative_file_paths"];
    // Of a path, the name alone: early recorders wrote the folder before it, and nothing outside of the folder is the bag's.
    let names = listed
        .as_vec()?
        .iter()
        .filter_map(|path| Path::new(path.as_str()?).file_name());
    let files = names.map(|name| {
        let (file, packed) = (
            folder.join(name),
            folder.join(name).with_added_extension("zstd"),
        );
        if !file.exists() && packed.exists() {
            packed
        } else {
            file
        }
    });
    let files: Vec<_> = files.collect();
    (!files.is_empty()).then_some(files)
}

pub(super) fn files(log: &Path) -> Result<Vec<PathBuf>, LogError> {
    if !log.is_dir() {
        return Ok(vec![log.into()]);
    }
    bag_files(log).ok_or_else(|| LogError::NoBag {
        log: log.display().to_string(),
    })
}

/// SHA-256 of a log, in hex: of a file's bytes; of a folder, of its files' names and hashes in their order.
///
/// # Errors
/// A file cannot be read; a folder is no bag.
pub fn hash(log: &Path) -> Result<String, LogError> {
    if !log.is_dir() {
        return hash_file(log);
    }
    let mut joined = JoinedHash::default();
    for file in files(log)?.iter().filter(|file| file.exists()) {
        joined.add(file, &hash_file(file)?);
    }
    Ok(joined.finish())
}

#[derive(Default)]
pub(super) struct JoinedHash(Sha256);

impl JoinedHash {
    pub(super) fn add(&mut self, file: &Path, sha256: &str) {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        self.0.update(format!("{sha256}  {name}\n"));
    }

    pub(super) fn finish(self) -> String {
        durable::hex(&self.0.finalize())
    }
}

pub(super) fn hash_file(path: &Path) -> Result<String, LogError> {
    let io = |source| LogError::io(path.display(), source);
    if let Some(sha256) = crate::part::origin(path) {
        return Ok(sha256);
    }
    // A pipe would be waited for without end.
    if !fs::metadata(path).map_err(io)?.is_file() {
        return Err(io(std::io::Error::other("it is no file")));
    }
    let mut file = File::open(path).map_err(io)?;
    let mut hasher = Sha256::new();
    let mut buffer = vec![0; 256 << 10];
    loop {
        let read = file.read(&mut buffer).map_err(io)?;
        if read == 0 {
            return Ok(durable::hex(&hasher.finalize()));
        }
        hasher.update(&buffer[..read]);
    }
}

/// A file that is ready to be read.
pub(super) enum Opened {
    /// MCAP, or what is reported as none.
    Mcap(File),
    /// SQLite at this place.
    Sqlite(PathBuf),
    Unpacked(NamedTempFile, bool),
}

/// Opens a file by what it begins with; one that is packed as a whole is unpacked into the system's folder for temporary files.
pub(super) fn open(path: &Path) -> Result<Opened, LogError> {
    let io = |source| LogError::io(path.display(), source);
    let mut file = File::open(path).map_err(io)?;
    let begins = beginning(&mut file).map_err(io)?;
    if begins.starts_with(SQLITE) {
        return Ok(Opened::Sqlite(path.into()));
    }
    if !begins.starts_with(ZSTD) {
        return Ok(Opened::Mcap(file));
    }
    let mut unpacked = NamedTempFile::new().map_err(io)?;
    let mut packed = zstd::stream::read::Decoder::new(file).map_err(io)?;
    let (mut buffer, mut size) = (vec![0; 1 << 20], 0);
    loop {
        // What a cut or damage leaves is read, and the file within says where it ends.
        let read = packed.read(&mut buffer).unwrap_or(0);
        if read == 0 {
            break;
        }
        size += read as u64;
        if size > LARGEST_UNPACKED {
            return Err(LogError::TooLarge {
                log: path.display().to_string(),
                what: "unpacked file",
                offset: 0,
                size,
                limit: LARGEST_UNPACKED,
            });
        }
        unpacked.write_all(&buffer[..read]).map_err(io)?;
    }
    let is_sqlite = beginning(unpacked.as_file_mut())
        .map_err(io)?
        .starts_with(SQLITE);
    Ok(Opened::Unpacked(unpacked, is_sqlite))
}

fn beginning(file: &mut File) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.rewind()?;
    Read::by_ref(file)
        .take(SQLITE.len() as u64)
        .read_to_end(&mut bytes)?;
    file.rewind()?;
    Ok(bytes)
}
