//! A file that is opened before its name is decided, and that never takes another file's place.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::{Errno, retry_on_intr};

use crate::write::{Output, is_partial};
use crate::{Error, faults};

/// Names that are tried for the file aside before the folder is given up.
const TRIES: u32 = 1_000;

/// A file written aside in its folder, under the name `.NAME.N.partial`. Dropped without a name, it is removed; where the program is killed,
/// the next one that is created there removes it.
#[derive(Debug)]
pub struct Aside {
    path: PathBuf,
    file: Option<File>,
    /// Once it is filled: locked until it is named.
    filled: Option<File>,
    /// Open from the start: naming a file takes no other one.
    folder: File,
}

impl Aside {
    /// Creates a file aside in a folder, which is made where there is none. Errors where it cannot be written to.
    pub fn create(folder: &Path, name: &str) -> Result<Self, Error> {
        crate::create_dir(folder)?;
        sweep_abandoned(folder, name);
        let held = File::open(folder).map_err(|error| Error::new("open", folder, error))?;
        let mut last = io::Error::from(ErrorKind::AlreadyExists);
        for number in 0..TRIES {
            let process = std::process::id();
            let path = folder.join(format!(".{name}.{process}_{number}.partial"));
            let create = || OpenOptions::new().write(true).create_new(true).open(&path);
            match faults::step().and_then(|()| create()) {
                // Another one may have swept it before it was locked; a disk without locks sweeps nothing.
                Ok(file)
                    if !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
                        && path.exists() =>
                {
                    return Ok(Self {
                        path,
                        file: Some(file),
                        filled: None,
                        folder: held,
                    });
                }
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::AlreadyExists => last = error,
                Err(error) => return Err(Error::new("create a file in", folder, error)),
            }
        }
        Err(Error::new("create a file in", folder, last))
    }

    /// Takes so many bytes of the disk for the file that is to be filled. Errors where it has none.
    pub fn reserve(&mut self, bytes: u64) -> Result<(), Error> {
        let allocate = |file: &File| fallocate(file, FallocateFlags::empty(), 0, bytes);
        self.reserve_by(bytes, allocate)
    }

    /// By what the file system has for it, and by zeros that are written where it has nothing.
    fn reserve_by(
        &mut self,
        bytes: u64,
        allocate: impl Fn(&File) -> rustix::io::Result<()>,
    ) -> Result<(), Error> {
        let Some(file) = self.file.as_mut().filter(|_| bytes > 0) else {
            return Ok(());
        };
        let mut take = || match retry_on_intr(|| allocate(file)) {
            Err(Errno::OPNOTSUPP | Errno::NOSYS) => {
                io::copy(&mut io::repeat(0).take(bytes), file)?;
                file.rewind()
            }
            taken => Ok(taken?),
        };
        faults::step()
            .and_then(|()| take())
            .map_err(|source| Error::new("reserve room in", &self.path, source))
    }

    /// Fills the file and syncs it. It can be filled once.
    pub fn fill<E: From<Error>>(
        &mut self,
        fill: impl FnOnce(&mut BufWriter<Output>) -> Result<(), E>,
    ) -> Result<(), E> {
        let path = &self.path;
        let failed = |action| move |source| Error::new(action, path, source);
        let file = self
            .file
            .take()
            .ok_or_else(|| io::Error::other("it was filled before"))
            .map_err(failed("write"))?;
        let mut file = BufWriter::new(Output::new(file));
        fill(&mut file)?;
        file.flush().map_err(failed("write"))?;
        // Without its buffer, whose drop would write again.
        let (output, _) = file.into_parts();
        let file = output.finish().map_err(failed("write"))?;
        faults::step()
            .and_then(|()| file.sync_all())
            .map_err(failed("sync"))?;
        self.filled = Some(file);
        Ok(())
    }

    /// Gives the file its name, in the same folder, and syncs the folder. False where a file of that name is there, which is
    /// kept: another name may be tried.
    pub fn name(&self, path: &Path) -> Result<bool, Error> {
        let failed = |source| Error::new("name", path, source);
        // A link fails where the name is taken; a rename would replace what is there.
        match faults::step().and_then(|()| fs::hard_link(&self.path, path)) {
            Ok(()) => {}
            Err(error) if error.kind() == ErrorKind::AlreadyExists => return Ok(false),
            // A disk without links: the name is taken by an empty file first.
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::Unsupported | ErrorKind::PermissionDenied
                ) =>
            {
                match OpenOptions::new().write(true).create_new(true).open(path) {
                    Ok(_) => fs::rename(&self.path, path).map_err(failed)?,
                    Err(error) if error.kind() == ErrorKind::AlreadyExists => return Ok(false),
                    Err(error) => return Err(failed(error)),
                }
            }
            Err(error) => return Err(failed(error)),
        }
        faults::step()
            .and_then(|()| self.folder.sync_all())
            .map_err(|source| Error::new("sync the folder of", path, source))?;
        Ok(true)
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        if !faults::dead() {
            // Gone already where it was renamed; else a name of its own remains, or it is not wanted.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Removes files aside of that name that no program holds any more. What cannot be removed stays.
fn sweep_abandoned(folder: &Path, name: &str) {
    let begins = format!(".{name}.");
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, named) = (entry.path(), entry.file_name());
        let is_named = named.as_encoded_bytes().starts_with(begins.as_bytes());
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && is_named && is_partial(&path) {
            // The lock is held until it is removed: whoever creates one meanwhile sees that.
            if let Ok(file) = File::open(&path)
                && file.try_lock().is_ok()
            {
                let _ = fs::remove_file(&path);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, name: &str, content: &[u8]) -> Result<bool, Error> {
        let mut aside = Aside::create(folder, "value")?;
        aside.fill(|file| {
            file.write_all(content)
                .map_err(|error| Error::new("write", folder, error))
        })?;
        aside.name(&folder.join(name))
    }

    #[test]
    fn what_was_reserved_and_is_not_used_is_given_back() {
        // Of a file system that takes room, and of one that has nothing for it.
        for has_it in [true, false] {
            let dir = tempfile::tempdir().expect("folder");
            let mut aside = Aside::create(dir.path(), "value").expect("creates");
            match has_it {
                true => aside.reserve(3 << 20),
                false => aside.reserve_by(3 << 20, |_| Err(Errno::OPNOTSUPP)),
            }
            .expect("reserves");
            let held = fs::metadata(&aside.path).expect("there");
            assert!(std::os::unix::fs::MetadataExt::blocks(&held) * 512 >= 3 << 20);
            aside
                .fill(|file| {
                    file.write_all(b"short")
                        .map_err(|error| Error::new("write", dir.path(), error))
                })
                .expect("fills");
            assert!(aside.name(&dir.path().join("value")).expect("names"));
            assert_eq!(fs::read(dir.path().join("value")).expect("there"), b"short");
        }
    }

    #[test]
    fn room_that_no_disk_has_is_refused_before_anything_is_written() {
        let dir = tempfile::tempdir().expect("folder");
        let mut aside = Aside::create(dir.path(), "value").expect("creates");
        aside.reserve(1 << 60).expect_err("no room");
        assert_eq!(fs::metadata(&aside.path).expect("there").len(), 0);
    }

    #[test]
    fn what_a_killed_program_left_aside_is_removed_by_the_next_and_what_is_being_written_is_not() {
        let dir = tempfile::tempdir().expect("folder");
        for name in [".value.1_0.partial", ".other.1_0.partial", ".value.1_0"] {
            fs::write(dir.path().join(name), "begun").expect("writes");
        }
        let one = Aside::create(dir.path(), "value").expect("creates");
        let mut two = Aside::create(dir.path(), "value").expect("creates");
        two.fill(|_| Ok::<(), Error>(())).expect("fills");
        let _three = Aside::create(dir.path(), "value").expect("creates");
        assert!(one.path.exists() && two.path.exists());
        let is_there = |name: &str| dir.path().join(name).exists();
        assert!(!is_there(".value.1_0.partial"));
        assert!(is_there(".other.1_0.partial") && is_there(".value.1_0"));
    }

    #[test]
    fn the_end_of_a_file_is_that_of_what_was_written_and_not_of_what_was_reserved() {
        let dir = tempfile::tempdir().expect("folder");
        let mut aside = Aside::create(dir.path(), "value").expect("creates");
        aside.reserve(1 << 20).expect("reserves");
        // As a writer does that puts a length before what it has written, and goes on behind it.
        aside
            .fill(|file| {
                let mut write = || {
                    file.write_all(b"0 letters")?;
                    file.rewind()?;
                    file.write_all(b"7")?;
                    file.seek(io::SeekFrom::End(0))?;
                    file.write_all(b", the end")
                };
                write().map_err(|error| Error::new("write", dir.path(), error))
            })
            .expect("fills");
        assert!(aside.name(&dir.path().join("value")).expect("names"));
        let content = fs::read(dir.path().join("value")).expect("there");
        assert_eq!(content, b"7 letters, the end");
    }

    #[test]
    fn a_name_that_is_taken_is_kept() {
        let dir = tempfile::tempdir().expect("folder");
        assert!(write(dir.path(), "value", b"first").expect("writes"));
        assert!(!write(dir.path(), "value", b"second").expect("writes"));
        assert!(write(dir.path(), "other", b"second").expect("writes"));
        assert_eq!(fs::read(dir.path().join("value")).expect("there"), b"first");
        assert_eq!(fs::read_dir(dir.path()).expect("folder").count(), 2);
    }

    #[test]
    fn stopped_at_any_step_it_is_whole_or_absent() {
        for step in 1.. {
            let dir = tempfile::tempdir().expect("folder");
            let (result, struck) = faults::after(step, || write(dir.path(), "value", b"new"));
            assert_eq!(result.is_err(), struck, "step {step}");
            if let Ok(content) = fs::read(dir.path().join("value")) {
                assert_eq!(content, b"new", "step {step}");
            }
            if !struck {
                assert!(step > 4, "create, write, sync and link were each stopped");
                break;
            }
        }
    }
}
