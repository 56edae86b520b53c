//! A file that is opened before its name is decided, and that never takes another file's place.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};

use crate::write::{Output, sync_dir};
use crate::{Error, faults};

/// Names that are tried for the file aside before the folder is given up.
const TRIES: u32 = 1_000;

/// A file written aside in its folder, under the name `.NAME.N.partial`. Dropped without a name, it is removed.
#[derive(Debug)]
pub struct Aside {
    path: PathBuf,
    file: Option<File>,
}

impl Aside {
    /// Creates a file aside in a folder, which is made where there is none. Errors where it cannot be written to.
    pub fn create(folder: &Path, name: &str) -> Result<Self, Error> {
        crate::create_dir(folder)?;
        let mut last = io::Error::from(ErrorKind::AlreadyExists);
        for number in 0..TRIES {
            let process = std::process::id();
            let path = folder.join(format!(".{name}.{process}_{number}.partial"));
            let create = || OpenOptions::new().write(true).create_new(true).open(&path);
            match faults::step().and_then(|()| create()) {
                Ok(file) => {
                    let file = Some(file);
                    return Ok(Self { path, file });
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists => last = error,
                Err(error) => return Err(Error::new("create a file in", folder, error)),
            }
        }
        Err(Error::new("create a file in", folder, last))
    }

    /// Writes so many zeros into the file that is to be filled, so that the disk has the room for it then. Errors where it has none.
    pub fn reserve(&mut self, bytes: u64) -> Result<(), Error> {
        let path = &self.path;
        let Some(file) = &mut self.file else {
            return Ok(());
        };
        let mut zeros = |bytes: u64| -> io::Result<()> {
            io::copy(&mut io::repeat(0).take(bytes), file)?;
            file.rewind()
        };
        faults::step()
            .and_then(|()| zeros(bytes))
            .map_err(|source| Error::new("reserve room in", path, source))
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
        Ok(faults::step()
            .and_then(|()| file.sync_all())
            .map_err(failed("sync"))?)
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
        path.parent().map_or(Ok(()), sync_dir)?;
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
        let dir = tempfile::tempdir().expect("folder");
        let mut aside = Aside::create(dir.path(), "value").expect("creates");
        aside.reserve(3 << 20).expect("reserves");
        let held = fs::read_dir(dir.path()).expect("folder").next();
        let held = held.expect("a file").expect("read").metadata();
        assert_eq!(held.expect("there").len(), 3 << 20);
        aside
            .fill(|file| {
                file.write_all(b"short")
                    .map_err(|error| Error::new("write", dir.path(), error))
            })
            .expect("fills");
        assert!(aside.name(&dir.path().join("value")).expect("names"));
        assert_eq!(fs::read(dir.path().join("value")).expect("there"), b"short");
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
