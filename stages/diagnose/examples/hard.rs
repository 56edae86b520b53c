//! Diagnoses sets of a hard table and prints what was found in each: `hard KIND HIDDEN STRIKES FIRST COUNT`.

#[expect(
    dead_code,
    reason = "tests use the other designs and what depends on the order"
)]
#[path = "../tests/support/table.rs"]
mod table;

use diagnose::{Diagnose, Input};
use stage::{Progress, Stage};
use table::{Hidden, Noise, Plan, Table};
use world::World;

fn noise(name: &str) -> Noise {
    match name {
        "mu2" => Noise::Friction(0.02),
        "mu4" => Noise::Friction(0.04),
        "rho5" => Noise::Correlated(0.5),
        "rho9" => Noise::Correlated(0.9),
        "jit5" => Noise::Jitter(0.005),
        "t3" => Noise::HeavyTails,
        "stray" => Noise::Stray,
        "grow" => Noise::GrowsWithSpeed,
        "mix" => Noise::Mixed,
        "all" => Noise::All,
        _ => Noise::Ideal,
    }
}

fn hidden(name: &str, size: f64) -> Vec<Hidden> {
    let one = |name: &str| match name {
        "wear" => Hidden::SaturatingWear(0.08 * size),
        "rect" => Hidden::Rectangle(0.2 * size),
        "cap" => Hidden::SoftCap(1.5 / size),
        "drag" => Hidden::Drag(0.15 * size),
        "tilt" => Hidden::Tilt(0.003 * size, -0.002 * size),
        "gain" => Hidden::AngleGain(0.06 * size),
        "grad" => Hidden::Gradient(0.3 * size),
        "step" => Hidden::Step(0.1 * size),
        "grain" => Hidden::Grain(0.1 * size),
        "stribeck" => Hidden::Stribeck(0.15 * size),
        "lean" => Hidden::Lean(0.035 * size),
        "wander" => Hidden::Wander(0.01 * size),
        "speed_wave" => Hidden::SpeedWave(0.08 * size, 0.2),
        "angle_wave" => Hidden::AngleWave(0.04 * size, 0.4),
        "magnus" => Hidden::Magnus(0.05 * size),
        _ => Hidden::Nothing,
    };
    name.split('+').map(one).collect()
}

/// The real strikes beside this checkout; a fifth of the settings judges.
fn real(seed: u64) -> (values::Rig, Vec<values::Strike>) {
    let folder = std::path::Path::new("../shared/kuka-strikes");
    let rig = values::Rig::load(&folder.join("rig.toml")).expect("the rig file is accepted");
    let mut logs: Vec<_> = std::fs::read_dir(folder.join("logs"))
        .expect("logs")
        .map(|entry| entry.expect("a file").path())
        .collect();
    logs.sort();
    let outcomes = logs
        .iter()
        .map(|log| {
            ingest::ingest_log(log, &rig, &ingest::Ingest::default()).expect("the log is read")
        })
        .collect();
    let (mut strikes, _) = ingest::assemble(outcomes);
    for strike in &mut strikes {
        let key = |v: f64| (v * 1e3).round() as i64 as u64;
        let mut hash = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        for part in [key(strike.command.speed), key(strike.command.angle)] {
            hash = (hash ^ part).wrapping_mul(0xff51_afd7_ed55_8ccd);
            hash ^= hash >> 33;
        }
        strike.split = if hash.is_multiple_of(5) {
            values::Split::Test
        } else {
            values::Split::Train
        };
    }
    (rig, strikes)
}

/// Strikes of the embedded rig.
fn embedded(hide: &str, strikes: usize, seed: u64) -> (values::Rig, Vec<values::Strike>) {
    let folder = tempfile::tempdir().expect("a folder");
    let hidden: Vec<&str> = hide.split('+').collect();
    let hidden = rig::Hidden::parse(&hidden).expect("an effect");
    let settings = rig::demo::Settings::new(values::Shape::Cylinder, strikes, seed, Some(hidden));
    let written = rig::demo::write(&settings, folder.path()).expect("writes");
    let rig = values::Rig::load(&written.rig).expect("the rig file is accepted");
    let outcomes = written
        .logs
        .iter()
        .map(|log| {
            ingest::ingest_log(log, &rig, &ingest::Ingest::default()).expect("the log is read")
        })
        .collect();
    (rig, ingest::assemble(outcomes).0)
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, or: f64| args.get(i).and_then(|a| a.parse().ok()).unwrap_or(or);
    let kinds = args.first().map_or("ideal", |s| s.as_str());
    let hides = args.get(1).map_or("none", |s| s.as_str());
    let (strikes, first, count) = (number(2, 160.0), number(3, 1.0), number(4, 1.0));
    let size = number(5, 1.0);
    for kind in kinds.split(',') {
        for hide in hides.split(',') {
            for seed in first as u64..first as u64 + count as u64 {
                let table = Table {
                    noise: noise(kind),
                    hidden: hidden(hide, size),
                    plan: Plan::Random,
                    strikes: strikes as usize,
                    seed,
                };
                let (rig, strikes) = if kind == "kuka" {
                    real(seed)
                } else if kind == "rig" {
                    embedded(hide, strikes as usize, seed)
                } else {
                    table.strike()
                };
                if std::env::var("DUMP").is_ok() {
                    for strike in strikes.iter().take(20) {
                        println!(
                            "S {:.3} {:.3} {:.3} {:.3} v2/d {:.3} n {}",
                            strike.command.speed,
                            strike.command.angle,
                            strike.path().bearing(),
                            strike.path().norm(),
                            strike.command.speed.powi(2) / strike.path().norm(),
                            strike.track.len()
                        );
                        for i in (0..strike.track.len()).step_by(5) {
                            let p = strike.track.point(i);
                            println!("  {:.4} {:.4} {:.4}", strike.track.t[i], p.x, p.y);
                        }
                    }
                }
                let begun = std::time::Instant::now();
                let identify = sysid::Input {
                    rig: rig.clone(),
                    world: World::nominal(),
                    strikes: strikes.clone(),
                    later: Vec::new(),
                };
                let world = match sysid::Sysid::default().run(&identify, &Progress::hidden()) {
                    Ok(fit) => {
                        if std::env::var("DUMP").is_ok() {
                            println!(
                                "{:#?} {:?} {} {}",
                                fit.world, fit.notes, fit.rms_before, fit.rms_after
                            );
                        }
                        fit.world
                    }
                    Err(error) => {
                        println!("{kind} {hide} {seed}: sysid {error}");
                        continue;
                    }
                };
                let identified = begun.elapsed().as_secs_f64();
                let input = Input::of(rig, world, strikes);
                let settings = Diagnose {
                    next_strikes: 0,
                    ..Diagnose::default()
                };
                let found = match settings.run(&input, &Progress::hidden()) {
                    Ok(found) => found.diagnosis,
                    Err(error) => {
                        println!("{kind} {hide} {seed}: {error}");
                        continue;
                    }
                };
                let names: Vec<String> = found
                    .effects
                    .iter()
                    .map(|e| format!("{}({:.0}){:?}", e.name, e.evidence, e.equivalent))
                    .collect();
                let n = &found.noise;
                println!(
                    "{kind} {hide} {seed}: {:?} p {:.4} {:.3} [{}] gap {:.1} -> {:.1} floor {:.1} mm | speed {:.3} angle {:.4} mu {:.4} cam {:.2e} rho {:.2} jit {:.1} ms out {} | {:.1} + {:.1} s",
                    found.verdict,
                    found.p_value,
                    found.p_value_signs,
                    names.join(" "),
                    1e3 * found.gap.before,
                    1e3 * found.gap.after,
                    1e3 * found.gap.noise_floor,
                    n.speed,
                    n.angle,
                    n.friction,
                    n.camera,
                    n.camera_correlation,
                    1e3 * n.stamp_jitter,
                    n.frames_left_out,
                    identified,
                    begun.elapsed().as_secs_f64() - identified,
                );
                for place in &found.r#where {
                    println!(
                        "    where {} p {:.4} share {:.2}: {}",
                        place.covariate, place.p_value, place.share, place.description
                    );
                }
                let mut ranking = found.ranking.clone();
                ranking.truncate(9);
                for rank in ranking {
                    println!("    rank {} {:.1}", rank.name, rank.evidence);
                }
                for map in &found.maps {
                    println!("    map {} share {:.2}", map.name, map.share);
                }
                for note in &found.notes {
                    println!("    {note}");
                }
            }
        }
    }
}
