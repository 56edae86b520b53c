//! URLs told from paths, and an object as its store tells of it.

use std::path::{Path, PathBuf};

/// Whether that is a URL, and no path.
pub fn is_url(path: &Path) -> bool {
    path.to_str().is_some_and(|text| text.contains("://"))
}

/// The path that a `file://` URL names; none for other ones.
pub fn path_of(url: &Path) -> Option<PathBuf> {
    url.to_str()?.strip_prefix("file://").map(PathBuf::from)
}

/// A folder of this user's own programs: the one that the variable of the environment names, or the one below their home; none where neither is set.
pub fn own_folder(variable: &str, below_home: &str) -> Option<PathBuf> {
    let set = |name| {
        std::env::var_os(name)
            .map(PathBuf::from)
            .filter(|path| path.is_absolute())
    };
    set(variable).or_else(|| Some(set("HOME")?.join(below_home)))
}

/// An object as a list tells of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Its name below the prefix, with `/` between its parts; empty where the URL names the object itself.
    pub name: String,
    /// Bytes.
    pub size: u64,
    /// What changes when its content does: the store's ETag, or the time of its last change.
    pub tag: String,
    /// Seconds since 1970.
    pub modified: i64,
}
