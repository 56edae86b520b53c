//! The real strikes of a KUKA arm, beside the checkout: every model judged on commands, and on whole sessions, that it did not learn
//! from.

mod judged;
mod page;
mod pictures;

use std::path::{Path, PathBuf};

use anyhow::Context;
use ingest::{Ingest, assemble, ingest_log};
use rayon::prelude::*;
use values::{Rig, Strike};

pub use judged::{Fold, Judged, judge, session_folds, setting_folds};
pub use page::page;
pub use pictures::{gaps, launches};

/// Rig and strikes of a folder with `rig.toml` and `logs/`.
pub fn load(folder: &Path) -> anyhow::Result<(Rig, Vec<Strike>)> {
    let rig = Rig::load(&folder.join("rig.toml"))?;
    let mut logs: Vec<PathBuf> = std::fs::read_dir(folder.join("logs"))
        .with_context(|| format!("no logs under {}", folder.display()))?
        .map(|entry| Ok(entry?.path()))
        .collect::<std::io::Result<_>>()?;
    logs.sort();
    let outcomes = logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()))
        .collect::<Result<_, _>>()?;
    Ok((rig, assemble(outcomes).0))
}

/// Judges every fold, side by side, in their order.
pub fn judge_all(rig: &Rig, strikes: &[Strike], folds: &[Fold]) -> anyhow::Result<Vec<Judged>> {
    folds
        .par_iter()
        .map(|fold| judge(rig, strikes, fold))
        .collect()
}
