//! The log of a strike: whole or absent, never over another one, and kept wherever it can be once the strike was made.

use std::io::{ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::{env, fs};

use durable::Aside;
use logs::write::{Lineage, Received, RecordingWriter, Samples, WriteError};
use values::Topics;

/// Where a log goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Destination {
    /// This file, which must not exist yet.
    File(PathBuf),
    /// The next free `strike_NNNNNN.mcap` of this folder.
    Next(PathBuf),
}

/// Why a log was not written. Texts complete "failed to …".
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "each text says what is wrong")]
pub enum LogError {
    #[error("log to {}: the file is there already and logs are never overwritten; give another --log", .0.display())]
    Exists(PathBuf),
    #[error("{0}; give a folder that can be written to: --log of strike, --out of collect")]
    File(#[from] durable::Error),
    #[error(
        "write the log at once: its folder was taken away, or full, and it was written there at a second attempt; leave the folder as it is \
         while carom works in it, and call again"
    )]
    Again,
    #[error("{why}; what could be written of it is in {}, a log that is cut off", path.display())]
    CutOff { path: PathBuf, why: Box<LogError> },
    #[error(transparent)]
    Content(#[from] WriteError),
}

/// A log that was written.
#[derive(Debug)]
pub struct WrittenLog {
    /// Where it lies.
    pub path: PathBuf,
    /// Why it does not lie where it was to, or only at a second attempt.
    pub moved: Option<LogError>,
}

/// A log that is open, under no name yet. Opened before the robot moves, so that no strike is lost for want of a place.
#[derive(Debug)]
pub struct OpenLog {
    destination: Destination,
    aside: Aside,
    lineage: Lineage,
}

impl OpenLog {
    /// Opens a log beside its destination. Errors if the destination is taken or its folder cannot be written to.
    pub fn open(destination: Destination) -> Result<Self, LogError> {
        if let Destination::File(path) = &destination
            && path.exists()
        {
            return Err(LogError::Exists(path.clone()));
        }
        let aside = Aside::create(destination.folder(), ASIDE)?;
        Ok(Self {
            destination,
            aside,
            lineage: Lineage::new(),
        })
    }

    /// Sets where the strike comes from (program, version, plan); it is written into the log.
    pub fn about(mut self, lineage: Lineage) -> Self {
        self.lineage = lineage;
        self
    }

    /// Allocates `bytes` on the disk now, so that a disk that fills up while the arm strikes loses nothing.
    pub fn reserve(mut self, bytes: u64) -> Result<Self, LogError> {
        self.aside.reserve(bytes)?;
        Ok(self)
    }

    /// Writes one strike, syncs it and gives it its name. The strike was made: where its name was taken meanwhile, the next free
    /// one beside it is used; where its folder is gone, it is made again; and where it cannot be written to any more, the system's folder
    /// for temporary files is used.
    /// Errors only where that fails too.
    pub fn write(self, samples: &Samples, topics: &Topics) -> Result<WrittenLog, LogError> {
        self.write_with(samples, &[], topics)
    }

    /// Writes one strike as [`write`](Self::write) does, with the messages of live topics as they were received, in order of time.
    pub fn write_with(
        self,
        samples: &Samples,
        received: &[Received],
        topics: &Topics,
    ) -> Result<WrittenLog, LogError> {
        let Self {
            destination,
            aside,
            lineage,
        } = self;
        let recorded = (samples, received, &lineage);
        match write(aside, &destination, recorded, topics) {
            Ok(kept) => Ok(kept),
            Err(moved) => {
                let rescue = |to: Destination| {
                    let aside = Aside::create(to.folder(), ASIDE)?;
                    write(aside, &to, recorded, topics)
                };
                // The folder may be gone, and is made again: what is looked for there is found.
                if let Ok(kept) = rescue(destination.clone()) {
                    return Ok(WrittenLog {
                        moved: Some(LogError::Again),
                        ..kept
                    });
                }
                match rescue(Destination::Next(env::temp_dir())) {
                    Ok(kept) => Ok(WrittenLog {
                        moved: Some(moved),
                        ..kept
                    }),
                    Err(_) => Err(match write_what_fits(&destination, recorded, topics) {
                        Some(path) => LogError::CutOff {
                            path,
                            why: Box::new(moved),
                        },
                        None => moved,
                    }),
                }
            }
        }
    }
}

impl Destination {
    fn folder(&self) -> &Path {
        match self {
            Self::Next(folder) => folder,
            Self::File(path) => match path.parent() {
                Some(folder) if !folder.as_os_str().is_empty() => folder,
                _ => Path::new("."),
            },
        }
    }
}

/// Writes as much of a log as the system lets, under a name that no reader of the folder takes for a log. None where that is nothing.
fn write_what_fits(
    destination: &Destination,
    recorded: (&Samples, &[Received], &Lineage),
    topics: &Topics,
) -> Option<PathBuf> {
    let folder = destination.folder();
    let paths =
        (1..=HIGHEST).map(|number| folder.join(format!("{PREFIX}cut_off_{number}.partial_log")));
    let begin = |path: PathBuf| match fs::File::create_new(&path) {
        Ok(file) => Some(Some((file, path))),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => None,
        Err(_) => Some(None),
    };
    let (file, path) = paths.into_iter().find_map(begin)??;
    // Its error is the one that the caller has.
    let _ = fill(std::io::BufWriter::new(file), recorded, topics);
    let written = fs::metadata(&path).map_or(0, |found| found.len());
    if written == 0 {
        let _ = fs::remove_file(&path);
    }
    (written > 0).then_some(path)
}

fn fill(
    file: impl Write + Seek,
    (samples, received, lineage): (&Samples, &[Received], &Lineage),
    topics: &Topics,
) -> Result<(), LogError> {
    let mut writer = if received.is_empty() {
        RecordingWriter::new(file, topics)?
    } else {
        RecordingWriter::beside_received(file, topics)?
    };
    writer.write_with(samples, received)?;
    if !lineage.is_empty() {
        writer.lineage(lineage)?;
    }
    writer.finish()?;
    Ok(())
}

/// Fills the file and names it.
fn write(
    mut aside: Aside,
    destination: &Destination,
    recorded: (&Samples, &[Received], &Lineage),
    topics: &Topics,
) -> Result<WrittenLog, LogError> {
    aside.fill(|file| fill(file, recorded, topics))?;
    match destination {
        Destination::Next(folder) => Ok(WrittenLog {
            path: first_free(&aside, numbered(folder))?,
            moved: None,
        }),
        Destination::File(path) if aside.name(path)? => Ok(WrittenLog {
            path: path.clone(),
            moved: None,
        }),
        Destination::File(path) => Ok(WrittenLog {
            path: first_free(&aside, beside(path))?,
            moved: Some(LogError::Exists(path.clone())),
        }),
    }
}

/// Gives the file the first of these names that is free.
fn first_free(aside: &Aside, names: impl Iterator<Item = PathBuf>) -> Result<PathBuf, LogError> {
    for path in names {
        if aside.name(&path)? {
            return Ok(path);
        }
    }
    unreachable!("names are counted on without end")
}

/// `strike_NNNNNN.mcap` after the highest that is there; another executor may take one meanwhile.
fn numbered(folder: &Path) -> impl Iterator<Item = PathBuf> {
    (highest(folder) + 1..).map(move |number| folder.join(format!("{PREFIX}{number:06}{SUFFIX}")))
}

/// `NAME_2.mcap` and on for `NAME.mcap`.
fn beside(path: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path
        .extension()
        .map(|ending| format!(".{}", ending.to_string_lossy()))
        .unwrap_or_default();
    (2u64..).map(move |number| path.with_file_name(format!("{stem}_{number}{ending}")))
}

const ASIDE: &str = "strike";
const PREFIX: &str = "strike_";
const SUFFIX: &str = ".mcap";
/// Highest number in a log's name that is counted on from: no robot makes so many strikes, and stamps of the embedded rig, five seconds a strike,
/// would leave the range of their clock.
pub(crate) const HIGHEST: usize = 999_999_999;

/// The highest number that a log in the folder has; 0 where there is none.
pub fn highest(folder: &Path) -> usize {
    let number = |name: &str| {
        name.strip_prefix(PREFIX)?
            .strip_suffix(SUFFIX)?
            .parse()
            .ok()
            .filter(|number| *number <= HIGHEST)
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
        let kept = OpenLog::open(destination)?.write(&Samples::default(), &Topics::default())?;
        Ok(kept.path)
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
    fn a_log_for_which_room_was_taken_is_the_same_log() {
        let dir = tempfile::tempdir().expect("folder");
        let written = |name: &str, room: u64| {
            let log = OpenLog::open(Destination::File(dir.path().join(name))).expect("opens");
            let log = log.reserve(room).expect("reserves");
            let samples = Samples {
                commands: vec![logs::write::Stamped::at(1, values::Point::new(0.5, 0.0))],
                ..Samples::default()
            };
            let kept = log.write(&samples, &Topics::default()).expect("writes");
            fs::read(kept.path).expect("is there")
        };
        assert!(written("with", 1 << 20) == written("without", 0));
    }

    #[test]
    fn a_number_beyond_counting_is_passed_over() {
        let dir = tempfile::tempdir().expect("folder");
        for number in [usize::MAX, HIGHEST + 1] {
            fs::write(dir.path().join(format!("strike_{number}.mcap")), "").expect("writes");
        }
        let next = || write(Destination::Next(dir.path().into())).expect("writes");
        assert_eq!(next(), dir.path().join("strike_000001.mcap"));
        fs::write(dir.path().join(format!("strike_{HIGHEST}.mcap")), "").expect("writes");
        // The names after the last one that counts are still free or taken.
        assert_eq!(next(), dir.path().join("strike_1000000001.mcap"));
    }

    #[test]
    fn two_executors_take_two_names() {
        let dir = tempfile::tempdir().expect("folder");
        let open = || OpenLog::open(Destination::Next(dir.path().into())).expect("opens");
        let (one, two) = (open(), open());
        let name = |log: OpenLog| {
            log.write(&Samples::default(), &Topics::default())
                .expect("writes")
                .path
        };
        assert_ne!(name(one), name(two));
        let left: Vec<_> = fs::read_dir(dir.path()).expect("folder").collect();
        assert_eq!(left.len(), 2, "nothing is left aside");
    }

    #[test]
    fn a_strike_is_kept_whichever_step_of_its_log_fails() {
        for step in 1.. {
            let dir = tempfile::tempdir().expect("folder");
            let destination = Destination::Next(dir.path().into());
            let log = OpenLog::open(destination).expect("opens");
            let (kept, failed) =
                durable::faults::once(step, || log.write(&Samples::default(), &Topics::default()));
            let kept = kept.expect("kept");
            assert!(kept.path.exists(), "step {step}");
            assert_eq!(kept.moved.is_some(), failed, "step {step}");
            if !kept.path.starts_with(dir.path()) {
                fs::remove_file(kept.path).expect("removes");
            }
            if !failed {
                assert!(
                    step > 4,
                    "write, sync, link and sync of the folder each failed"
                );
                break;
            }
        }
    }

    #[test]
    fn of_a_log_that_fits_nowhere_the_beginning_is_kept_and_named() {
        let dir = tempfile::tempdir().expect("folder");
        for _ in 0..2 {
            let log = OpenLog::open(Destination::Next(dir.path().into())).expect("opens");
            let write = || log.write(&Samples::default(), &Topics::default());
            let (failed, _) = durable::faults::after(1, write);
            let error = failed.expect_err("no file can be ended");
            let LogError::CutOff { path, .. } = &error else {
                panic!("{error}");
            };
            assert!(fs::metadata(path).expect("is there").len() > 0);
            assert!(error.to_string().contains(&path.display().to_string()));
        }
        let begun = fs::read_dir(dir.path()).expect("folder").flatten();
        let names = begun.map(|entry| entry.file_name().into_string().expect("text"));
        assert_eq!(names.filter(|name| name.contains("cut_off")).count(), 2);
        assert_eq!(highest(dir.path()), 0, "it is no log");
    }

    #[test]
    fn a_place_that_cannot_be_written_to_is_reported_before_the_strike() {
        let dir = tempfile::tempdir().expect("folder");
        let file = dir.path().join("file");
        fs::write(&file, "").expect("writes");
        let error = OpenLog::open(Destination::Next(file.join("strikes"))).expect_err("no folder");
        assert!(error.to_string().contains("--log"), "{error}");
    }
}
