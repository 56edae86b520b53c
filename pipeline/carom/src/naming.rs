//! Names of logs in tables and messages: the file's, and as many folders above it as distinguish it from others.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use ingest::LogFile;

/// A name for each file, given by its path and its content: the shortest end of the path that no other content has.
pub fn names(files: &[(&Path, &str)]) -> Vec<String> {
    let mut names = vec![String::new(); files.len()];
    let mut alike: Vec<usize> = (0..files.len()).collect();
    let mut depth = 0;
    while !alike.is_empty() {
        depth += 1;
        let mut contents: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
        for &file in &alike {
            let (path, content) = files[file];
            names[file] = end(path, depth);
            let named = contents.entry(names[file].clone()).or_default();
            named.insert(content);
        }
        alike.retain(|&file| {
            let is_whole = depth >= files[file].0.components().count();
            !is_whole && contents[&names[file]].len() > 1
        });
    }
    names
}

/// Gives logs of one file name and several contents names that differ.
pub fn name_logs(logs: &mut [LogFile]) {
    let files = logs
        .iter()
        .map(|log| (log.path.as_path(), log.sha256.as_str()));
    let names = names(&files.collect::<Vec<_>>());
    for (log, name) in logs.iter_mut().zip(names) {
        log.name = name;
    }
}

/// The last parts of a path, so many.
fn end(path: &Path, parts: usize) -> String {
    let first = path.components().count().saturating_sub(parts);
    let end: PathBuf = path.components().skip(first).collect();
    end.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(files: &[(&str, &str)]) -> Vec<String> {
        let files: Vec<_> = files
            .iter()
            .map(|(path, c)| (Path::new(path), *c))
            .collect();
        names(&files)
    }

    #[test]
    fn a_file_name_is_enough_where_no_other_content_has_it() {
        let copies = [("/a/1.mcap", "x"), ("/b/1.mcap", "x"), ("/b/2.mcap", "y")];
        assert_eq!(named(&copies), ["1.mcap", "1.mcap", "2.mcap"]);
        assert_eq!(named(&[]), [""; 0]);
    }

    #[test]
    fn other_contents_of_one_file_name_are_distinguished_by_as_few_folders_as_do() {
        let files = [
            ("/r/mon/d0/s.mcap", "x"),
            ("/r/tue/d0/s.mcap", "y"),
            ("/r/tue/d1/s.mcap", "z"),
            ("/s.mcap", "w"),
            ("/r/t.mcap", "v"),
        ];
        assert_eq!(
            named(&files),
            [
                "mon/d0/s.mcap",
                "tue/d0/s.mcap",
                "d1/s.mcap",
                "/s.mcap",
                "t.mcap"
            ]
        );
    }
}
