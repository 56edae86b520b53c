//! The log of a strike: whole or absent, never over another one.

use std::fs;
use std::path::{Path, PathBuf};

use logs::write::{RecordingWriter, Samples, WriteError};
use tempfile::NamedTempFile;
use values::Topics;

/// Where a log goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// This file, which must not be there yet.
    File(PathBuf),
    /// The next free `strike_NNNNNN.mcap` of this folder.
    Next(PathBuf),
}

/// Why a log was not written. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file is there already.
    #[error("log to {}: the file is there already and logs are never overwritten; give another --log", .0.display())]
    Exists(PathBuf),
    /// The system refused a step.
    #[error("{step} {}: {source}; give a --log in a folder that can be written to", path.display())]
    File {
        /// What was tried.
        step: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The content could not be written.
    #[error(transparent)]
    Content(#[from] WriteError),
}

/// A log that is open, under no name yet. Opened before the robot moves, so that no strike is lost for want of a place.
#[derive(Debug)]
pub struct OpenLog {
    destination: Destination,
    aside: NamedTempFile,
}

impl OpenLog {
    /// Opens a log beside its destination. Errors if the destination is taken or its folder cannot be written to.
    pub fn open(destination: Destination) -> Result<Self, LogError> {
        let folder = match &destination {
            Destination::File(path) if path.exists() => {
                return Err(LogError::Exists(path.clone()));
            }
            Destination::File(path) => match path.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => folder,
                _ => Path::new("."),
            },
            Destination::Next(folder) => folder,
        };
        let failed = |step| {
            move |source| LogError::File {
                step,
                path: folder.to_path_buf(),
                source,
            }
        };
        fs::create_dir_all(folder).map_err(failed("create the folder"))?;
        let mut options = tempfile::Builder::new();
        options.prefix(".strike_").suffix(".partial");
        // A log is for all to read, as far as the umask lets them; a temporary file by itself is not.
        #[cfg(unix)]
        options.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let aside = options
            .tempfile_in(folder)
            .map_err(failed("create a log in"))?;
        Ok(Self { destination, aside })
    }

    /// Writes one strike, syncs it and gives it its name, which is returned.
    pub fn write(mut self, samples: &Samples, topics: &Topics) -> Result<PathBuf, LogError> {
        let mut writer = RecordingWriter::new(std::io::BufWriter::new(&mut self.aside), topics)?;
        writer.write(samples)?;
        drop(writer.finish()?);
        let aside = self.aside.path().to_path_buf();
        let synced = self.aside.as_file().sync_all();
        synced.map_err(|source| LogError::File {
            step: "sync",
            path: aside,
            source,
        })?;
        match self.destination {
            Destination::File(path) => match self.aside.persist_noclobber(&path) {
                Ok(_) => Ok(path),
                Err(refused) => Err(taken(&path, refused.error)),
            },
            Destination::Next(folder) => name_next(self.aside, &folder),
        }
    }
}

/// The first free name after the highest one taken; another executor may take it meanwhile.
fn name_next(mut aside: NamedTempFile, folder: &Path) -> Result<PathBuf, LogError> {
    let mut number = highest(folder) + 1;
    loop {
        let path = folder.join(format!("{PREFIX}{number:06}{SUFFIX}"));
        match aside.persist_noclobber(&path) {
            Ok(_) => return Ok(path),
            Err(refused) if refused.error.kind() == std::io::ErrorKind::AlreadyExists => {
                aside = refused.file;
                number += 1;
            }
            Err(refused) => return Err(taken(&path, refused.error)),
        }
    }
}

fn taken(path: &Path, source: std::io::Error) -> LogError {
    if source.kind() == std::io::ErrorKind::AlreadyExists {
        return LogError::Exists(path.to_path_buf());
    }
    LogError::File {
        step: "name the log",
        path: path.to_path_buf(),
        source,
    }
}

const PREFIX: &str = "strike_";
const SUFFIX: &str = ".mcap";

/// The highest number that a log in the folder has; 0 where there is none. A robot that is simulated counts its strikes
/// by it.
pub fn highest(folder: &Path) -> usize {
    let number = |name: &str| {
        name.strip_prefix(PREFIX)?
            .strip_suffix(SUFFIX)?
            .parse()
            .ok()
    };
    fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| number(entry.file_name().to_str()?))
        .max()
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(destination: Destination) -> Result<PathBuf, LogError> {
        OpenLog::open(destination)?.write(&Samples::default(), &Topics::default())
    }

    #[test]
    fn logs_are_numbered_on_and_never_overwritten() {
        let dir = tempfile::tempdir().expect("folder");
        let folder = dir.path().join("strikes");
        let next = || write(Destination::Next(folder.clone())).expect("writes");
        assert_eq!(next(), folder.join("strike_000001.mcap"));
        fs::write(folder.join("strike_000007.mcap"), "a log").expect("writes");
        fs::write(folder.join("strike_x.mcap"), "no number").expect("writes");
        assert_eq!(next(), folder.join("strike_000008.mcap"));
        assert_eq!(highest(&folder), 8);
        assert_eq!(
            fs::read(folder.join("strike_000007.mcap")).expect("is there"),
            b"a log"
        );
    }

    #[test]
    fn two_executors_take_two_names() {
        let dir = tempfile::tempdir().expect("folder");
        let open = || OpenLog::open(Destination::Next(dir.path().into())).expect("opens");
        let (one, two) = (open(), open());
        let name = |log: OpenLog| {
            log.write(&Samples::default(), &Topics::default())
                .expect("writes")
        };
        assert_ne!(name(one), name(two));
        let left: Vec<_> = fs::read_dir(dir.path()).expect("folder").collect();
        assert_eq!(left.len(), 2, "nothing is left aside");
    }

    #[test]
    fn a_file_that_is_there_is_kept() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("log.mcap");
        let late = OpenLog::open(Destination::File(path.clone())).expect("opens");
        fs::write(&path, "mine").expect("writes");
        assert!(matches!(
            OpenLog::open(Destination::File(path.clone())),
            Err(LogError::Exists(_))
        ));
        let written = late.write(&Samples::default(), &Topics::default());
        assert!(matches!(written, Err(LogError::Exists(_))));
        assert_eq!(fs::read(&path).expect("is there"), b"mine");
    }

    #[test]
    fn a_place_that_cannot_be_written_to_is_told_before_the_strike() {
        let dir = tempfile::tempdir().expect("folder");
        let file = dir.path().join("file");
        fs::write(&file, "").expect("writes");
        let error = OpenLog::open(Destination::Next(file.join("strikes"))).expect_err("no folder");
        assert!(error.to_string().contains("--log"), "{error}");
    }
}
