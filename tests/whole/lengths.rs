//! A file holds one idea: none of the workspace is longer than 400 lines, and half of them have at most 120.

use std::fs;
use std::path::{Path, PathBuf};

const MOST_LINES: usize = 400;
const MOST_AT_MEDIAN: usize = 120;

#[test]
fn files_are_short() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut lengths: Vec<(usize, PathBuf)> = Vec::new();
    for floor in ["pipeline", "stages", "artifacts", "datasets", "tests"] {
        for path in sources(&root.join(floor)) {
            let lines = fs::read_to_string(&path).unwrap().lines().count();
            lengths.push((lines, path));
        }
    }
    assert!(
        lengths.len() > 200,
        "only {} files were read",
        lengths.len()
    );
    lengths.sort();
    let median = lengths[lengths.len() / 2].0;
    assert!(
        median <= MOST_AT_MEDIAN,
        "half of the files have more than {median} lines"
    );
    let long: Vec<_> = lengths
        .iter()
        .filter(|(lines, _)| *lines > MOST_LINES)
        .collect();
    assert!(
        long.is_empty(),
        "split these by what they are about: {long:#?}"
    );
}

/// The Rust files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}
