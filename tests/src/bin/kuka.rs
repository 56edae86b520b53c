//! Judges every model on the real strikes beside this checkout, and writes the page and the pictures of what was found.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use diagnose::Diagnose;
use stage::{Progress, Stage};
use sysid::Sysid;
use tests::kuka;
use world::World;

/// Judges models on real strikes, and writes a page about them.
#[derive(Debug, Parser)]
struct Args {
    /// The folder with `rig.toml` and `logs/`.
    #[arg(long, default_value = "../shared/kuka-strikes")]
    strikes: PathBuf,
    /// Deals of the settings into five parts.
    #[arg(long, default_value_t = 8)]
    seeds: u64,
    /// The first deal's seed.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// The page; its pictures go into a folder of its name beside it.
    #[arg(long, default_value = "tests/KUKA.md")]
    page: PathBuf,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let (rig, strikes) = kuka::load(&args.strikes)?;
    let seeds: Vec<u64> = (args.first..args.first + args.seeds).collect();
    let settings: Vec<_> = seeds
        .iter()
        .flat_map(|seed| kuka::setting_folds(&strikes, *seed))
        .collect();
    let sessions = kuka::session_folds(&strikes, args.first);
    let by_setting = kuka::judge_all(&rig, &strikes, &settings)?;
    let by_session = kuka::judge_all(&rig, &strikes, &sessions)?;

    let fit = Sysid::default().run(
        &sysid::Input {
            rig: rig.clone(),
            world: World::nominal(),
            strikes: strikes.clone(),
            later: Vec::new(),
        },
        &Progress::hidden(),
    )?;
    let input = diagnose::Input::of(rig, fit.world, strikes);
    let found = Diagnose::default().run(&input, &Progress::hidden())?;
    let folder = args
        .page
        .with_extension("")
        .to_string_lossy()
        .to_lowercase();
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    kuka::launches(&input.strikes, &folder.join("launches.svg"))?;
    kuka::gaps(&input.strikes, &found, &folder.join("gaps.svg"))?;
    let page = kuka::page(&input.strikes, &by_setting, &by_session, &found.diagnosis)?;
    fs::write(&args.page, &page)?;
    print!("{page}");
    Ok(())
}
