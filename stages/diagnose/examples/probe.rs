#![allow(missing_docs, clippy::all)]
use ingest::{Ingest, assemble, ingest_log};
use rig::{Hidden, demo};
use stage::{Progress, Stage};
use values::{Rig, Shape};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: usize = args[1].parse().unwrap();
    let seed: u64 = args[2].parse().unwrap();
    let shape = if args[3] == "box" {
        Shape::Box
    } else {
        Shape::Cylinder
    };
    let scale: f64 = args[4].parse().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let hidden = Hidden::parse(&args[5..]).unwrap().scaled(scale);
    let settings = demo::Settings::new(shape, n, seed, Some(hidden));
    let written = demo::write(&settings, folder.path()).unwrap();
    let rig = Rig::load(&written.rig).unwrap();
    let outcomes = written
        .logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()).unwrap())
        .collect();
    let (strikes, _) = assemble(outcomes);
    let world = world::World::nominal(&rig)
        .with("friction", 0.2)
        .with("restitution", 0.5);
    let t0 = std::time::Instant::now();
    let found = diagnose::Diagnose::default()
        .run(
            &diagnose::Input {
                rig: rig.clone(),
                world,
                strikes,
            },
            &Progress::hidden(),
        )
        .unwrap();
    let d = &found.diagnosis;
    println!(
        "{:?} in {:?} p {:.2e} gap {:?}",
        d.verdict,
        t0.elapsed(),
        d.p_value,
        (
            d.gap.heldout_strikes,
            d.gap.before,
            d.gap.after,
            d.gap.noise_floor
        )
    );
    println!("  {}", d.summary);
    for n in &d.notes {
        println!("  note {n}");
    }
    for w in d.r#where.iter().take(3) {
        println!(
            "  where {} p {:.1e} share {:.2}: {}",
            w.covariate, w.p_value, w.share, w.description
        );
    }
    for e in &d.effects {
        println!(
            "  NAMED {} {:.1} eq {:?} {:?}",
            e.name,
            e.evidence,
            e.equivalent,
            e.parameters
                .iter()
                .map(|(k, p)| format!("{k} {:.4} [{:.4} {:.4}]", p.value, p.low, p.high))
                .collect::<Vec<_>>()
        );
    }
    for r in d.ranking.iter().take(5) {
        println!("  rank {} {:.1}", r.name, r.evidence);
    }
    for s in d.next_strikes.iter().take(2) {
        println!("  next {:?}", s);
    }
    if args.len() < 6 || args[5] == "none" {
        for s in &d.detectable {
            println!(
                "  detectable {} {} {:.4} {}",
                s.name, s.parameter, s.least, s.unit
            );
        }
    }
}
