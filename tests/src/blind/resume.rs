//! Runs sets in parallel and keeps each answer as it comes, so that a run that was stopped continues where it ended.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Context;
use serde::{Serialize, de::DeserializeOwned};

/// Lines of a file that can be read; one that a kill cut short is none.
pub fn lines<T: DeserializeOwned>(path: &Path) -> Vec<T> {
    fs::read_to_string(path)
        .unwrap_or_default()
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect()
}

pub fn beside(path: &Path, word: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}{word}.jsonl"))
}

/// One answer a case, in the cases' order. Answers that the file holds are not made again; it holds them all in the end. Cases are made side
/// by side, each on one thread of its own: in a pool that they share, a case that waits works on another, and its time is not its own.
pub fn resumed<C: Sync, T: DeserializeOwned + Serialize + Clone + Send>(
    path: &Path,
    cases: &[C],
    id_of_case: impl Fn(&C) -> &String + Sync,
    id_of_answer: impl Fn(&T) -> &String,
    make: impl Fn(&C) -> T + Sync,
) -> anyhow::Result<Vec<T>> {
    let mut known: BTreeMap<String, T> = lines(path)
        .into_iter()
        .map(|one: T| (id_of_answer(&one).clone(), one))
        .collect();
    let missing: Vec<&C> = cases
        .iter()
        .filter(|case| !known.contains_key(id_of_case(case)))
        .collect();
    eprintln!(
        "{}: {} sets, {} of them to run",
        path.display(),
        cases.len(),
        missing.len()
    );
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut file = fs::OpenOptions::new()
        .create(true)
        .append(true)
        .open(path)
        .with_context(|| format!("cannot write {}", path.display()))?;
    // A line that a kill cut short must not spoil the next one.
    file.write_all(b"\n")?;
    let file = Mutex::new(file);
    let bar = indicatif::ProgressBar::new(missing.len() as u64);
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism()?.get();
    let fresh: Vec<T> = std::thread::scope(|scope| {
        let work = || -> anyhow::Result<Vec<T>> {
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
            let mut all = Vec::new();
            while let Some(case) = missing.get(next.fetch_add(1, Ordering::Relaxed)) {
                let made = alone.install(|| make(case));
                let line = serde_json::to_string(&made)? + "\n";
                file.lock()
                    .map_err(|_| anyhow::anyhow!("another set failed"))?
                    .write_all(line.as_bytes())?;
                bar.inc(1);
                all.push(made);
            }
            Ok(all)
        };
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let mut fresh = Vec::new();
        for worker in workers {
            let made = worker.join();
            fresh.extend(made.map_err(|_| anyhow::anyhow!("a set panicked"))??);
        }
        anyhow::Ok(fresh)
    })?;
    known.extend(
        fresh
            .into_iter()
            .map(|one| (id_of_answer(&one).clone(), one)),
    );
    Ok(cases
        .iter()
        .filter_map(|case| known.get(id_of_case(case)))
        .cloned()
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_not_made_again_and_a_cut_line_is() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("outcomes.jsonl");
        fs::write(&path, "[\"a\",1]\n[\"b\",").expect("writable");
        let cases = ["a", "b", "c"].map(String::from);
        let made = resumed(
            &path,
            &cases,
            |case| case,
            |answer: &(String, u32)| &answer.0,
            |case| (case.clone(), 2),
        )
        .expect("it runs");
        let numbers: Vec<u32> = made.iter().map(|(_, n)| *n).collect();
        assert_eq!(numbers, [1, 2, 2]);
        assert_eq!(lines::<(String, u32)>(&path).len(), 3);
    }
}
