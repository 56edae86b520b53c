//! What a run works on: its rig, its logs, its seed and whether it may add effects, kept in the run's folder so that later commands go on with them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use values::Rig;

use crate::Error;
use crate::args::LogsArgs;
use crate::fetching::Fetch;

/// Where a run keeps its inputs.
const FILE: &str = "inputs.json";

/// The inputs of a run, checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inputs {
    pub rig: Rig,
    /// Files, folders and URLs as they were named, with their whole paths: where new logs are looked for.
    #[serde(default)]
    pub named: Vec<PathBuf>,
    /// Every log, with its whole path, in order.
    pub logs: Vec<PathBuf>,
    /// Seed of the split into training and held-out strikes, and of training.
    pub seed: u64,
    /// Whether effects that the data name are kept out of the world.
    #[serde(default)]
    pub without_effects: bool,
}

impl Inputs {
    /// Inputs as named on the command line.
    pub fn named(args: &LogsArgs) -> Result<Self, Error> {
        Self::of(
            &args.logs,
            &args.rig,
            args.seed,
            args.without_effects,
            &args.out,
        )
    }

    /// Inputs from files, folders and URLs of logs, and a rig file, of a run in the folder `out`.
    pub fn of(
        named: &[PathBuf],
        rig: &Path,
        seed: u64,
        without_effects: bool,
        out: &Path,
    ) -> Result<Self, Error> {
        let whole = |path: &PathBuf| match store::objects::is_url(path) {
            true => Ok(path.clone()),
            false => fs::canonicalize(path).map_err(|error| Error::unreadable(path, &error)),
        };
        let rig = load_rig(rig)?;
        let fetch = Fetch {
            rig: Some(&rig),
            run: Some(out),
        };
        Ok(Self {
            logs: find_logs(named, &fetch)?,
            named: named.iter().map(whole).collect::<Result<_, _>>()?,
            seed,
            without_effects,
            rig,
        })
    }

    /// These inputs, with the logs that lie now where they were named.
    pub fn again(self, out: &Path) -> Result<Self, Error> {
        let named = if self.named.is_empty() {
            &self.logs
        } else {
            &self.named
        };
        let fetch = Fetch {
            rig: Some(&self.rig),
            run: Some(out),
        };
        Ok(Self {
            logs: find_logs(named, &fetch)?,
            ..self
        })
    }

    /// These inputs without the logs of these names.
    pub fn without(&self, names: &[String]) -> Self {
        let is_named = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            names.iter().any(|other| *other == name)
        };
        let mut inputs = self.clone();
        inputs.logs.retain(|path| !is_named(path));
        inputs
    }

    /// Inputs that an earlier command kept in the folder.
    pub fn kept(dir: &Path) -> Result<Self, Error> {
        let path = dir.join(FILE);
        let text = fs::read_to_string(&path).map_err(|error| {
            Error::input(format!(
                "read {}: {error}; `carom ingest LOGS --rig rig.toml --out {}` begins a run",
                path.display(),
                dir.display()
            ))
        })?;
        serde_json::from_str(&text).map_err(|error| {
            Error::input(format!(
                "read {}: {error}; begin the run anew with `carom ingest`",
                path.display()
            ))
        })
    }

    /// Keeps them in the folder.
    pub fn keep(&self, dir: &Path) -> Result<(), Error> {
        let mut text = serde_json::to_string_pretty(self).map_err(Error::failed)?;
        text.push('\n');
        Ok(durable::write_bytes(&dir.join(FILE), text.as_bytes())?)
    }
}

/// A rig file; the error names it.
pub fn load_rig(path: &Path) -> Result<Rig, Error> {
    Rig::load(path).map_err(|error| {
        let mend = if path.exists() {
            ""
        } else {
            "; `carom rig init --out rig.toml` writes one to be filled in"
        };
        Error::input(format!(
            "use the rig file {}: failed to {error}{mend}",
            path.display()
        ))
    })
}

/// Every log that the paths name: files as they are, folders searched for logs with all below (`*.mcap`, `*.db3`, either with `.zstd` behind it; rosbag2
/// folders of several files are one log), copies of what URLs name. Sorted, each once.
pub fn find_logs(paths: &[PathBuf], fetch: &Fetch<'_>) -> Result<Vec<PathBuf>, Error> {
    let mut logs = Vec::new();
    for path in paths {
        let local = store::objects::path_of(path);
        if let (None, true, Some(url)) = (&local, store::objects::is_url(path), path.to_str()) {
            let mut folders: BTreeMap<PathBuf, Vec<PathBuf>> = BTreeMap::new();
            for copy in fetch.logs(url)? {
                let folder = copy.parent().unwrap_or(&copy).into();
                folders.entry(folder).or_default().push(copy);
            }
            for (folder, found) in folders {
                join_split(&folder, found, &mut logs);
            }
            continue;
        }
        let path = local.as_ref().unwrap_or(path);
        let metadata = fs::metadata(path).map_err(|error| Error::unreadable(path, &error))?;
        if metadata.is_dir() {
            let before = logs.len();
            search(path, &mut logs)?;
            if logs.len() == before {
                return Err(Error::input(format!(
                    "find logs in {}: there is no *.mcap, *.db3 or rosbag2 folder in it or below; record with `ros2 bag record -s mcap`",
                    path.display()
                )));
            }
        } else {
            logs.push(path.clone());
        }
    }
    // A dead link stays as it is named: reading reports what is wrong with it.
    let whole = |path: PathBuf| fs::canonicalize(&path).unwrap_or(path);
    let mut logs: Vec<PathBuf> = logs.into_iter().map(whole).collect();
    logs.sort();
    logs.dedup();
    Ok(logs)
}

fn search(folder: &Path, logs: &mut Vec<PathBuf>) -> Result<(), Error> {
    let unreadable = |error| Error::unreadable(folder, &error);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let path = entry.path();
        // A link to a folder is not followed: it may lead back.
        if entry.file_type().map_err(unreadable)?.is_dir() {
            search(&path, logs)?;
        } else if logs::is_log(&path) {
            found.push(path);
        }
    }
    join_split(folder, found, logs);
    Ok(())
}

/// Adds the logs of a folder; files of a recording that was split are one.
fn join_split(folder: &Path, mut found: Vec<PathBuf>, logs: &mut Vec<PathBuf>) {
    match logs::bag_files(folder) {
        Some(files) if files.len() > 1 => {
            found.retain(|path| !files.contains(path));
            logs.push(folder.into());
        }
        _ => {}
    }
    logs.append(&mut found);
}

#[cfg(test)]
mod tests {
    use super::*;

    const FETCH: Fetch<'_> = Fetch {
        rig: None,
        run: None,
    };

    #[test]
    fn folders_are_searched_with_all_below_and_each_log_is_named_once() {
        let dir = tempfile::tempdir().expect("folder");
        let below = dir.path().join("b/c");
        fs::create_dir_all(&below).expect("folders");
        for file in ["b/c/2.mcap", "1.MCAP", "notes.txt"] {
            fs::write(dir.path().join(file), "").expect("file");
        }
        let logs =
            find_logs(&[dir.path().into(), dir.path().join("1.MCAP")], &FETCH).expect("found");
        let names: Vec<_> = logs.iter().filter_map(|path| path.file_name()).collect();
        assert_eq!(names, ["1.MCAP", "2.mcap"]);
    }

    #[test]
    fn files_of_a_split_recording_are_one_log_and_those_of_a_whole_one_are_files() {
        let dir = tempfile::tempdir().expect("folder");
        for (bag, files) in [("split", &["0.db3", "1.db3"][..]), ("whole", &["0.mcap"])] {
            let folder = dir.path().join(bag);
            fs::create_dir(&folder).expect("folder");
            let mut text = "rosbag2_bagfile_information:\n  relative_file_paths:\n".to_owned();
            for file in files {
                fs::write(folder.join(file), "").expect("file");
                text += &format!("    - {file}\n");
            }
            fs::write(folder.join("metadata.yaml"), text).expect("metadata");
        }
        let logs = find_logs(&[dir.path().into()], &FETCH).expect("found");
        let names: Vec<_> = logs.iter().filter_map(|path| path.file_name()).collect();
        assert_eq!(names, ["split", "0.mcap"]);
    }

    #[test]
    fn a_folder_without_logs_and_a_path_that_is_not_there_are_bad_input() {
        let dir = tempfile::tempdir().expect("folder");
        for path in [dir.path().into(), dir.path().join("none.mcap")] {
            let error = find_logs(std::slice::from_ref(&path), &FETCH).expect_err("nothing there");
            assert!(matches!(error, Error::Input(_)), "{error}");
            assert!(error.to_string().contains(&path.display().to_string()));
        }
    }

    #[test]
    fn kept_inputs_read_back() {
        let dir = tempfile::tempdir().expect("folder");
        let inputs = Inputs {
            named: vec!["/logs".into()],
            rig: Rig::demo(values::Shape::Box),
            logs: vec!["/logs/a.mcap".into()],
            seed: 3,
            without_effects: true,
        };
        inputs.keep(dir.path()).expect("kept");
        assert_eq!(Inputs::kept(dir.path()).expect("read"), inputs);
        let error = Inputs::kept(&dir.path().join("none")).expect_err("no run");
        assert!(error.to_string().contains("carom ingest"), "{error}");
    }
}
