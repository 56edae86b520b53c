//! The steps: write aside, sync, rename, sync the folder.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::{Error, faults};

const PARTIAL: &str = "partial";

/// A file being written.
pub struct Output {
    file: File,
    at: u64,
    /// Where what was written ends: beyond it there may be room that was reserved.
    end: u64,
}

impl Output {
    pub(crate) fn new(file: File) -> Self {
        Self {
            file,
            at: 0,
            end: 0,
        }
    }

    /// The file, as long as what was written; what was reserved and is not used is given back.
    pub(crate) fn finish(self) -> io::Result<File> {
        self.file.set_len(self.end)?;
        Ok(self.file)
    }
}

impl io::Seek for Output {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        let to = match to {
            io::SeekFrom::End(offset) => {
                let place = self.end.checked_add_signed(offset);
                io::SeekFrom::Start(place.ok_or(io::ErrorKind::InvalidInput)?)
            }
            other => other,
        };
        self.at = self.file.seek(to)?;
        Ok(self.at)
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let file = &mut self.file;
        // A kill in the middle of a write leaves a part of it.
        faults::step_torn(|| file.write_all(&bytes[..bytes.len() / 2]))?;
        let count = file.write(bytes)?;
        self.at += count as u64;
        self.end = self.end.max(self.at);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes a file that is whole or absent: `fill` gives its content. Where it fails the old file stays.
pub fn write<E: From<Error>>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<Output>) -> Result<(), E>,
) -> Result<(), E> {
    write_as("", path, fill)
}

/// Writes a file that others may write at the same time: `writer` is a name that none of them has. Each writes aside under a name of its
/// own, and the last one's file stays.
pub fn write_as<E: From<Error>>(
    writer: &str,
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<Output>) -> Result<(), E>,
) -> Result<(), E> {
    let aside = partial(path, writer);
    let written = fill_and_sync(&aside, fill).and_then(|()| rename(&aside, path).map_err(E::from));
    if written.is_err() && !faults::dead() {
        // The first error is the one to report; what stays is swept by the next run.
        let _ = fs::remove_file(&aside);
    }
    written
}

/// Writes a file with this content, whole or absent.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write(path, |file| {
        file.write_all(bytes)
            .map_err(|source| Error::new("write", path, source))
    })
}

fn fill_and_sync<E: From<Error>>(
    aside: &Path,
    fill: impl FnOnce(&mut BufWriter<Output>) -> Result<(), E>,
) -> Result<(), E> {
    let failed = |action| move |source| E::from(Error::new(action, aside, source));
    faults::step()
        .and_then(|()| File::create(aside))
        .map_err(failed("create"))
        .and_then(|file| {
            let mut file = BufWriter::new(Output::new(file));
            fill(&mut file)?;
            file.flush().map_err(failed("write"))?;
            // Without its buffer, whose drop would write again.
            let (Output { file, .. }, _) = file.into_parts();
            faults::step()
                .and_then(|()| file.sync_all())
                .map_err(failed("sync"))
        })
}

/// Appends to a file, which is made where there is none, from the length `end` on (what lies behind is cut off), and
/// syncs it. Where it fails, a part of `bytes` may stay: the file's format must show a torn end.
pub fn append(path: &Path, end: u64, bytes: &[u8]) -> Result<(), Error> {
    let failed = |action| move |source| Error::new(action, path, source);
    let is_new = !path.exists();
    let file = faults::step()
        .and_then(|()| OpenOptions::new().create(true).append(true).open(path))
        .map_err(failed("open"))?;
    faults::step()
        .and_then(|()| file.set_len(end))
        .map_err(failed("cut"))?;
    let mut output = Output::new(file);
    output.write_all(bytes).map_err(failed("write"))?;
    faults::step()
        .and_then(|()| output.file.sync_data())
        .map_err(failed("sync"))?;
    match path.parent() {
        Some(parent) if is_new => sync_dir(parent),
        _ => Ok(()),
    }
}

/// Renames a file or folder over its place, within one folder or between two of one disk, and syncs the folder.
pub fn rename(from: &Path, to: &Path) -> Result<(), Error> {
    faults::step()
        .and_then(|()| fs::rename(from, to))
        .map_err(|source| Error::new("rename to", to, source))?;
    to.parent().map_or(Ok(()), sync_dir)
}

/// Makes a folder and those above it.
pub fn create_dir(path: &Path) -> Result<(), Error> {
    if path.is_dir() {
        return Ok(());
    }
    faults::step()
        .and_then(|()| fs::create_dir_all(path))
        .map_err(|source| Error::new("create the folder", path, source))?;
    path.parent().map_or(Ok(()), sync_dir)
}

/// Removes a folder and all that it holds; none there is no error.
pub fn remove_dir(path: &Path) -> Result<(), Error> {
    match faults::step().and_then(|()| fs::remove_dir_all(path)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            Err(Error::new("remove", path, error))
        }
        _ => Ok(()),
    }
}

/// Syncs a folder, so that what was renamed into it stays there after a power cut.
pub fn sync_dir(path: &Path) -> Result<(), Error> {
    // The parent of a bare name is the empty path: the current folder.
    let path = if path.as_os_str().is_empty() {
        Path::new(".")
    } else {
        path
    };
    faults::step()
        .and_then(|()| File::open(path)?.sync_all())
        .map_err(|source| Error::new("sync the folder", path, source))
}

/// Removes what a killed writer left aside in a folder and the folders below it. Gives how many files and folders it removed.
pub fn sweep(dir: &Path) -> Result<usize, Error> {
    let failed = |source| Error::new("sweep", dir, source);
    let mut removed = 0;
    for entry in fs::read_dir(dir).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let path = entry.path();
        // Links are not followed: what they lead to is not ours.
        let is_dir = entry.file_type().map_err(failed)?.is_dir();
        match (is_partial(&path), is_dir) {
            (true, true) => remove_dir(&path)?,
            (true, false) => fs::remove_file(&path).map_err(failed)?,
            (false, true) => {
                removed += sweep(&path)?;
                continue;
            }
            (false, false) => continue,
        }
        removed += 1;
    }
    Ok(removed)
}

/// Whether a path is a file or folder written aside.
pub fn is_partial(path: &Path) -> bool {
    path.extension() == Some(OsStr::new(PARTIAL))
        && path
            .file_name()
            .is_some_and(|name| name.as_encoded_bytes().starts_with(b"."))
}

fn partial(path: &Path, writer: &str) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    for part in [writer, PARTIAL].iter().filter(|part| !part.is_empty()) {
        name.push(".");
        name.push(part);
    }
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_stopped_at_any_step_leaves_the_old_file_or_the_new_one() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("value");
        let (mut olds, mut steps) = (0, 1);
        loop {
            write_bytes(&path, b"old").expect("writes");
            let (result, struck) = faults::after(steps, || write_bytes(&path, b"newer"));
            let content = fs::read(&path).expect("is there");
            assert!(
                content == b"old" || content == b"newer",
                "step {steps}: {content:?}"
            );
            olds += usize::from(content == b"old");
            assert_eq!(result.is_err(), struck);
            if !struck {
                break;
            }
            steps += 1;
        }
        assert!(
            olds >= 4,
            "create, write, sync and rename were each stopped"
        );
        fs::write(dir.path().join(".other.partial"), "half").expect("writes");
        assert_eq!(sweep(dir.path()).expect("sweeps"), 1);
        assert_eq!(fs::read_dir(dir.path()).expect("folder").count(), 1);
    }

    #[test]
    fn a_step_that_fails_leaves_the_old_file_and_nothing_aside() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("value");
        for step in 1.. {
            write_bytes(&path, b"old").expect("writes");
            let (result, struck) = faults::once(step, || write_bytes(&path, b"newer"));
            assert_eq!(result.is_err(), struck);
            if !struck {
                break;
            }
            let text = result.expect_err("failed").to_string();
            assert!(text.contains("free some space"), "{text}");
            assert_eq!(fs::read_dir(dir.path()).expect("folder").count(), 1);
        }
    }

    #[test]
    fn a_failed_content_leaves_nothing_aside() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("value");
        let failed = write(&path, |_| {
            Err(Error::new("fill", &path, io::Error::other("no")))
        });
        assert!(failed.is_err());
        assert_eq!(fs::read_dir(dir.path()).expect("folder").count(), 0);
    }

    #[test]
    fn appending_cuts_what_lies_behind_the_end() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("value");
        append(&path, 0, b"abc-torn").expect("appends");
        append(&path, 3, b"def").expect("appends");
        assert_eq!(fs::read(&path).expect("is there"), b"abcdef");
    }
}
