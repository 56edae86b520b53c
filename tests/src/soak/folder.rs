//! The folder that the nights work in, and the programs that do.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use serde_json::Value;
use store::Store;
use values::{Split, split_of};

use crate::carom;

/// Exit codes of a night that did its work: done, with input rejected, refused by a gate.
pub const WORKED: [i32; 3] = [0, 3, 4];

const KEEP: usize = 5;
/// Strikes of the first night that are held out: a first version is judged by so many.
const HELD_OUT: usize = 8;

/// Logs, a key, a run, and how many strikes each log holds.
#[derive(Debug)]
pub struct Folder {
    folder: tempfile::TempDir,
    faulty: PathBuf,
    seed: u64,
    /// Seed of the split: the first by which enough of the first night's strikes are held out to judge a first version.
    split: u64,
    /// Strikes that each whole log gives.
    expected: BTreeMap<PathBuf, usize>,
}

#[derive(Clone, Debug)]
pub struct Ended {
    /// Exit code of the program; −1 where it was killed.
    pub code: i32,
    pub json: Value,
    pub steps: u64,
    /// Peak memory of the program, in bytes.
    pub memory: u64,
    pub took: Duration,
    pub printed: String,
}

impl Ended {
    pub fn status(&self) -> &str {
        self.json["status"].as_str().unwrap_or("")
    }
}

impl Folder {
    pub fn new(faulty: &Path, seed: u64) -> anyhow::Result<Self> {
        let folder = Self {
            folder: tempfile::tempdir()?,
            faulty: faulty.into(),
            seed,
            split: 0,
            expected: BTreeMap::new(),
        };
        fs::create_dir(folder.logs())?;
        let key = folder.path("carom.key");
        carom(&format!("key new --out {}", text(&key)?))?;
        Ok(folder)
    }

    pub fn logs(&self) -> PathBuf {
        self.path("logs")
    }

    pub fn run(&self) -> PathBuf {
        self.path("run")
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn log(&self, night: usize) -> PathBuf {
        self.logs().join(format!("night_{night:04}.mcap"))
    }

    pub fn newest_log(&self) -> PathBuf {
        self.log(self.expected.len() - 1)
    }

    /// Logs strikes of the demo's rig, other ones each night.
    pub fn log_strikes(&mut self, night: usize, strikes: usize) -> anyhow::Result<()> {
        let demo = self.path("demo");
        let _ = fs::remove_dir_all(&demo);
        let seed = self.seed * 10_000 + night as u64;
        carom(&format!(
            "demo --strikes {strikes} --seed {seed} --out {}",
            text(&demo)?
        ))?;
        let log = self.log(night);
        fs::copy(demo.join("logs/session_000.mcap"), &log)?;
        fs::copy(demo.join("rig.toml"), self.path("rig.toml"))?;
        let (rig, scratch) = (self.path("rig.toml"), self.path("scratch"));
        let (log_path, rig, scratch_path) = (text(&log)?, text(&rig)?, text(&scratch)?);
        let alone = carom(&format!(
            "ingest {log_path} --rig {rig} --out {scratch_path}"
        ))?;
        let kept = alone.json["strikes"].as_u64().context("a count")?;
        if night == 0 {
            let strikes = tables::read_strikes(&scratch)?;
            let held_out = |seed: &u64| {
                let is_held_out = |s: &&values::Strike| split_of(&s.id, *seed) != Split::Train;
                strikes.iter().filter(is_held_out).count() >= HELD_OUT
            };
            self.split = (0..10_000).find(held_out).context("more first strikes")?;
        }
        self.expected.insert(log, usize::try_from(kept)?);
        Ok(())
    }

    /// A night, struck by a fault at a step; 0 for none.
    pub fn begin(&self, fault: &str, step: u64) -> anyhow::Result<Child> {
        let (logs, rig, run, key) = (
            self.logs(),
            self.path("rig.toml"),
            self.run(),
            self.path("carom.key"),
        );
        let keep = KEEP.to_string();
        let child = Command::new(&self.faulty)
            .args([
                fault,
                &step.to_string(),
                "nightly",
                text(&logs)?,
                "--rig",
                text(&rig)?,
            ])
            .args(["--out", text(&run)?, "--key", text(&key)?, "--keep", &keep])
            .args(["--seed", &self.split.to_string()])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        child.with_context(|| format!("start {}", self.faulty.display()))
    }

    pub fn night(&self) -> anyhow::Result<Ended> {
        self.struck("kill", 0)
    }

    pub fn struck(&self, fault: &str, step: u64) -> anyhow::Result<Ended> {
        let begun = Instant::now();
        let output = self.begin(fault, step)?.wait_with_output()?;
        Ok(ended(&output, begun.elapsed()))
    }

    /// The version in use: one that loads, as every other does.
    pub fn latest(&self) -> anyhow::Result<String> {
        let store = Store::open(&self.run());
        let failed = |error| anyhow::anyhow!("failed to {error}");
        for listing in store.list().map_err(failed)? {
            store.verify(Some(&listing.version)).map_err(failed)?;
        }
        store.verify(None).map_err(failed)
    }

    /// Whether a version was published after another, and is the newest.
    pub fn is_next(&self, version: &str, before: &str) -> anyhow::Result<bool> {
        let list = Store::open(&self.run()).list()?;
        let newest = list.last().context("a version")?;
        ensure!(list.len() <= KEEP + 1, "{} versions are kept", list.len());
        Ok(version > before && newest.version == version)
    }

    /// Checks that the tables hold every strike of every log, once; gives their number.
    pub fn holds_every_strike(&self) -> anyhow::Result<usize> {
        let expected: usize = self.expected.values().sum();
        let strikes = tables::read_strikes(&self.run())?;
        let mut by_log: BTreeMap<PathBuf, usize> = BTreeMap::new();
        for strike in &strikes {
            *by_log.entry(self.logs().join(&strike.log)).or_default() += 1;
        }
        if strikes.len() != expected
            || by_log
                .iter()
                .any(|(log, count)| self.expected.get(log) != Some(count))
        {
            bail!(
                "the tables hold {} strikes of {expected}: {by_log:?}",
                strikes.len()
            );
        }
        Ok(expected)
    }
}

pub fn ended(output: &Output, took: Duration) -> Ended {
    let printed = String::from_utf8_lossy(&output.stderr).into_owned();
    let line = printed.lines().last().unwrap_or("");
    let number = |name: &str| {
        let (before, _) = line.split_once(name)?;
        before.split_whitespace().last()?.parse().ok()
    };
    Ended {
        code: output.status.code().unwrap_or(-1),
        json: serde_json::from_slice(&output.stdout).unwrap_or(Value::Null),
        steps: number(" steps").unwrap_or(0),
        memory: number(" bytes").unwrap_or(0),
        took,
        printed,
    }
}

/// Peak resident memory of this program, in bytes; none where the system does not report it.
pub fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(kilobytes << 10)
}

fn text(path: &Path) -> anyhow::Result<&str> {
    path.to_str().context("a path that is text")
}
