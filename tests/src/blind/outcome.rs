//! One set: made, read, diagnosed.

use std::path::Path;

use diagnose::{Diagnose, Diagnosis, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{Truth, demo};
use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Rig, Strike};
use world::World;

use super::cases::Case;
use super::compare::{Covered, covered};
use super::hide;

/// What came of a set.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    /// The set.
    pub case: Case,
    /// What was found: `named`, `consistent`, `unexplained`, or `impossible` where the rig could not make it.
    pub verdict: String,
    /// Effects named, each with those that the data cannot tell from it.
    pub named: Vec<(String, Vec<String>)>,
    /// Probability of the gap by chance.
    pub p_value: f64,
    /// Held-out strikes; rms stop error in m before and after, and the noise floor.
    pub gap: (usize, f64, f64, f64),
    /// Parameters whose form the rig shares: truth, and the interval found.
    pub covered: Vec<Covered>,
    /// Seconds that the diagnosis took, beside whatever else ran.
    pub seconds: f64,
}

/// Strikes of a truth, through its logs; `None` where they cannot be made.
pub fn strikes(truth: &Truth, count: usize, folder: &Path) -> Option<(Rig, Vec<Strike>)> {
    let settings = demo::Settings {
        strikes: count,
        truth: truth.clone(),
        plan: None,
        log_state: false,
    };
    let written = demo::write(&settings, folder).ok()?;
    let rig = Rig::load(&written.rig).expect("the demo's rig file is valid");
    let outcomes = written
        .logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()).expect("the demo's logs are readable"))
        .collect();
    Some((rig, assemble(outcomes).0))
}

/// Makes a set and diagnoses it.
pub fn run(case: &Case) -> Outcome {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let made = hide::truth(case)
        .and_then(|truth| Some((strikes(&truth, case.strikes, folder.path())?, truth)));
    let impossible = Outcome {
        case: case.clone(),
        verdict: "impossible".into(),
        named: Vec::new(),
        p_value: 1.0,
        gap: (0, 0.0, 0.0, 0.0),
        covered: Vec::new(),
        seconds: 0.0,
    };
    let Some(((rig, strikes), truth)) = made else {
        return impossible;
    };
    // What a user starts from: friction as believed. Identification is part of what is measured.
    let mut world = World::nominal(&rig);
    if case.variant == "start" {
        let factor = if case.seed % 2 == 0 { 2.0 } else { 0.5 };
        world = world.with("friction", truth.friction * factor);
    }
    let begun = std::time::Instant::now();
    let found = sysid::Sysid::default()
        .run(
            &sysid::Input {
                rig: rig.clone(),
                world,
                strikes: strikes.clone(),
            },
            &Progress::hidden(),
        )
        .map_err(|error| error.to_string())
        .and_then(|fit| {
            let input = Input {
                rig,
                world: fit.world,
                strikes,
            };
            Diagnose::default()
                .run(&input, &Progress::hidden())
                .map_err(|error| error.to_string())
        });
    let found = match found {
        Ok(found) => found,
        Err(error) => {
            return Outcome {
                verdict: format!("error: {error}"),
                ..impossible
            };
        }
    };
    let Diagnosis {
        verdict,
        effects,
        gap,
        p_value,
        ..
    } = &found.diagnosis;
    Outcome {
        case: case.clone(),
        verdict: match verdict {
            Verdict::Named => "named",
            Verdict::Consistent => "consistent",
            Verdict::Unexplained => "unexplained",
        }
        .into(),
        named: effects
            .iter()
            .map(|e| (e.name.clone(), e.equivalent.clone()))
            .collect(),
        p_value: *p_value,
        gap: (gap.heldout_strikes, gap.before, gap.after, gap.noise_floor),
        covered: covered(case, &truth, &found),
        seconds: begun.elapsed().as_secs_f64(),
    }
}
