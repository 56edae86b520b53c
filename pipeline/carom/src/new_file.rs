//! A file that is written once and never over another.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use crate::Error;

/// Permissions of an ordinary file, before the user's mask.
pub const ORDINARY: u32 = 0o666;

/// Writes a file that must not be there yet, with these permissions; it is on disk when this returns.
pub fn write_new(path: &Path, mode: u32, bytes: &[u8]) -> Result<(), Error> {
    let created = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(mode)
        .open(path);
    let mut file = created.map_err(|error| {
        let help = match error.kind() {
            ErrorKind::AlreadyExists => "nothing is overwritten, name another file",
            _ => "name a file in a folder that is there and may be written to",
        };
        Error::input(format!("create {}: {error}; {help}", path.display()))
    })?;
    let written = file.write_all(bytes).and_then(|()| file.sync_all());
    written.map_err(|error| Error::failed(format!("write {}: {error}", path.display())))
}
