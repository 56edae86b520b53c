//! A hundred nights with a fault in each: `soak --nights 100 --strikes 2 --seed 7`.

use std::time::Instant;

use anyhow::Context;
use clap::Parser;
use tests::soak::{Settings, soak};

/// Runs nights on growing data, a random fault in each, and checks what must hold.
#[derive(Debug, Parser)]
struct Args {
    /// Nights.
    #[arg(long, default_value_t = 100)]
    nights: usize,
    /// Strikes of the first night: all in one session, and enough for a version that the gates let pass.
    #[arg(long, default_value_t = 19)]
    first: usize,
    /// Strikes of each night after it.
    #[arg(long, default_value_t = 2)]
    strikes: usize,
    /// Draws strikes and faults.
    #[arg(long, default_value_t = 7)]
    seed: u64,
}

fn main() -> anyhow::Result<()> {
    let Args {
        nights,
        first,
        strikes,
        seed,
    } = Args::parse();
    let faulty = std::env::current_exe()?.with_file_name("faulty");
    let settings = Settings {
        nights,
        first,
        strikes,
        seed,
    };
    let begun = Instant::now();
    let soaked = soak(&faulty, settings, &mut |line| println!("{line}")).context("soak")?;
    let memory = soaked.memory_ends().map_or_else(String::new, |ends| {
        let [middle, last] = ends.map(|bytes| bytes >> 20);
        format!("; memory {middle} MiB in the middle third of the nights, {last} MiB in the last")
    });
    println!(
        "{nights} nights in {:.0} s: {} strikes, none lost; {} promoted, {} more after a fault; {} in use{memory}",
        begun.elapsed().as_secs_f64(),
        soaked.strikes,
        soaked.promoted,
        soaked.promoted_after_fault,
        soaked.latest
    );
    for (fault, count) in &soaked.faults {
        println!("{count:>4} {fault}");
    }
    Ok(())
}
