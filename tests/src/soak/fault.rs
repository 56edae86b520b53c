//! What goes wrong in a night.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::folder::{Ended, Folder, WORKED, ended};

values::named! {
    /// What goes wrong in a night.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Fault {
        /// Killed at a step on the disk, in the middle of a write.
        KilledAtStep = "killed at a step",
        KilledAtMoment = "killed at a moment",
        DiskFull = "disk full",
        /// A step fails otherwise.
        DiskBroken = "disk broken",
        LogCut = "log cut",
        LogFlipped = "log flipped",
        LogCopied = "log copied",
        /// A file among the logs is none.
        LogForeign = "foreign file",
        /// Bytes of the cache are changed, or cut off.
        CacheDamaged = "cache damaged",
        VersionDamaged = "version damaged",
        TwoAtOnce = "two at once",
    }
}

impl Fault {
    pub fn draw(random: &mut ChaCha8Rng) -> Self {
        Self::ALL[random.random_range(0..Self::ALL.len())]
    }

    /// Runs a night with the fault, and mends what a person would.
    pub fn strike(
        self,
        folder: &mut Folder,
        last: &Ended,
        random: &mut ChaCha8Rng,
    ) -> anyhow::Result<()> {
        let step = random.random_range(1..=last.steps.max(1));
        match self {
            Self::KilledAtStep => {
                let ended = folder.struck("kill", step)?;
                ensure!(
                    ended.code == -1 || WORKED.contains(&ended.code),
                    "{ended:?}"
                );
            }
            Self::KilledAtMoment => {
                let mut child = folder.begin("kill", 0)?;
                thread::sleep(moment(last.took, random));
                child.kill()?;
                child.wait_with_output()?;
            }
            Self::DiskFull | Self::DiskBroken => {
                let fault = if self == Self::DiskFull { "full" } else { "io" };
                let ended = folder.struck(fault, step)?;
                // Past its last step the night went well.
                ensure!(
                    ended.code == 1 || ended.steps < step,
                    "step {step}: {ended:?}"
                );
            }
            Self::LogCut => changed(&folder.newest_log(), folder, |bytes| {
                bytes.truncate(random.random_range(0..bytes.len()));
            })?,
            Self::LogFlipped => changed(&folder.newest_log(), folder, |bytes| flip(bytes, random))?,
            Self::LogCopied => {
                let copy = folder.logs().join("copy.mcap");
                fs::copy(folder.newest_log(), &copy)?;
                let ended = folder.night()?;
                fs::remove_file(copy)?;
                ensure!([3, 4].contains(&ended.code), "{ended:?}");
            }
            Self::LogForeign => {
                let foreign = folder.logs().join("foreign.mcap");
                fs::write(&foreign, "no log")?;
                let ended = folder.night()?;
                fs::remove_file(foreign)?;
                ensure!([3, 4].contains(&ended.code), "{ended:?}");
                ensure!(
                    ended.json["left_out"][0]["log"] == "foreign.mcap",
                    "{ended:?}"
                );
            }
            Self::CacheDamaged => {
                for _ in 0..3 {
                    let path = any_file(&folder.run().join("cache"), random)?;
                    let mut bytes = fs::read(&path)?;
                    flip(&mut bytes, random);
                    if random.random() {
                        bytes.truncate(bytes.len() / 2);
                    }
                    fs::write(path, bytes)?;
                }
                let ended = folder.night()?;
                ensure!(WORKED.contains(&ended.code), "{ended:?}");
            }
            Self::VersionDamaged => {
                let path = any_file(&folder.run().join("versions"), random)?;
                let is_in_use =
                    path.starts_with(folder.run().join("versions").join(folder.latest()?));
                let whole = fs::read(&path)?;
                let mut bytes = whole.clone();
                flip(&mut bytes, random);
                fs::write(&path, &bytes)?;
                let ended = folder.night()?;
                // From the robot's copy; of a version that was removed meanwhile there is nothing to mend.
                if path.exists() {
                    fs::write(&path, whole)?;
                }
                // A signature is looked at by those who hold its key.
                let is_seen = is_in_use && path.extension().is_none_or(|end| end != "minisig");
                ensure!(ended.code == 2 || !is_seen, "{}: {ended:?}", path.display());
                ensure!(
                    WORKED.contains(&ended.code) || is_in_use,
                    "{}: {ended:?}",
                    path.display()
                );
            }
            Self::TwoAtOnce => {
                let begun = Instant::now();
                let nights = [folder.begin("kill", 0)?, folder.begin("kill", 0)?];
                let mut codes = Vec::new();
                for night in nights {
                    codes.push(ended(&night.wait_with_output()?, begun.elapsed()).code);
                }
                let worked = codes.iter().filter(|code| WORKED.contains(code)).count();
                let busy = codes.iter().filter(|code| **code == 75).count();
                ensure!(worked >= 1 && worked + busy == 2, "{codes:?}");
            }
        }
        Ok(())
    }
}

/// A night with a log that is not whole; the whole one comes the next day.
fn changed(log: &Path, folder: &Folder, change: impl FnOnce(&mut Vec<u8>)) -> anyhow::Result<()> {
    let whole = fs::read(log)?;
    let mut bytes = whole.clone();
    change(&mut bytes);
    fs::write(log, &bytes)?;
    let ended = folder.night()?;
    fs::write(log, whole)?;
    // A flip in what nobody reads, such as the index, is reported or harmless.
    ensure!(WORKED.contains(&ended.code), "{ended:?}");
    Ok(())
}

fn flip(bytes: &mut [u8], random: &mut ChaCha8Rng) {
    if !bytes.is_empty() {
        let at = random.random_range(0..bytes.len());
        bytes[at] ^= 1 << random.random_range(0..8_u32);
    }
}

/// Any file of a folder and those below it, locks aside.
fn any_file(folder: &Path, random: &mut ChaCha8Rng) -> anyhow::Result<PathBuf> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path
                .file_name()
                .is_some_and(|name| name != "lock" && name != ".lock")
            {
                files.push(path);
            }
        }
    }
    files.sort();
    ensure!(
        !files.is_empty(),
        "there is no file in {}",
        folder.display()
    );
    files
        .get(random.random_range(0..files.len()))
        .cloned()
        .context("a file")
}

/// A moment within a night that took so long.
fn moment(took: Duration, random: &mut ChaCha8Rng) -> Duration {
    took.mul_f64(random.random_range(0.0..1.1))
}
