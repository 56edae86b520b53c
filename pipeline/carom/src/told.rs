//! What workers find out about files and tell one another, so that not each of them reads every log. Nothing that is published stands on
//! it: a run that works alone finds out by itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use rayon::prelude::*;
use stage::Run;

/// What `find` says of each file, side by side; none where it says nothing. Workers begin at different files, and believe what another one said
/// of a file of this path, size and time of change.
pub fn of_each(
    run: &Run,
    what: &str,
    files: &[PathBuf],
    find: impl Fn(&Path) -> Option<String> + Sync,
) -> Vec<Option<String>> {
    let writer = run.writer();
    if writer.is_empty() || files.is_empty() {
        return files.par_iter().map(|file| find(file)).collect();
    }
    // A run that begins removes it with all that workers say.
    let folder = run.dir().join("cache/work/told");
    // Where it cannot be written nothing is told.
    let _ = fs::create_dir_all(&folder);
    let told = |file: &PathBuf| {
        let Some(name) = name(what, file) else {
            return find(file);
        };
        let place = folder.join(name);
        let kept = fs::read_to_string(&place).ok();
        // One that is cut short does not end its line.
        if let Some(said) = kept.as_deref().and_then(|text| text.strip_suffix('\n')) {
            return Some(said.into());
        }
        let said = find(file)?;
        let aside = place.with_extension(writer);
        let _ = fs::write(&aside, format!("{said}\n")).and_then(|()| fs::rename(&aside, &place));
        Some(said)
    };
    let bytes = writer.bytes();
    let first = bytes.fold(0, |sum: usize, byte| {
        (131 * sum + usize::from(byte)) % 1_000_003
    });
    let first = first % files.len();
    let mut files = files.to_vec();
    files.rotate_left(first);
    let mut said: Vec<_> = files.par_iter().map(told).collect();
    said.rotate_right(first);
    said
}

/// A name for what is asked of a file as it is now; none of what is no file.
fn name(what: &str, file: &Path) -> Option<String> {
    let metadata = fs::metadata(file).ok().filter(fs::Metadata::is_file)?;
    let changed = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    let known = (what, file, metadata.len(), changed.as_nanos());
    Some(durable::sha256(format!("{known:?}").as_bytes()))
}
