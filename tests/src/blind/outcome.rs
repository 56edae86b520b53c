//! One set: made, read, diagnosed.

use std::path::Path;

use diagnose::{Diagnose, Diagnosis, Found, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{PlannedStrike, Truth, demo};
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

/// Strikes of a truth, of a plan or at random, through its logs; `None` where they cannot be made.
pub fn strikes(
    truth: &Truth,
    count: usize,
    plan: Option<Vec<PlannedStrike>>,
    folder: &Path,
) -> Option<(Rig, Vec<Strike>)> {
    let settings = demo::Settings {
        strikes: count,
        truth: truth.clone(),
        plan,
        log_state: false,
        sessions: None,
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

/// The identified world that a user has, from friction as believed; or why there is none.
pub fn identified(
    case: &Case,
    truth: &Truth,
    rig: &Rig,
    strikes: &[Strike],
) -> Result<World, String> {
    let mut world = World::nominal(rig);
    if case.variant == "start" {
        let factor = if case.seed.is_multiple_of(2) {
            2.0
        } else {
            0.5
        };
        world = world.with("friction", truth.friction * factor);
    }
    let input = sysid::Input {
        rig: rig.clone(),
        world,
        strikes: strikes.to_vec(),
    };
    let fit = sysid::Sysid::default()
        .run(&input, &Progress::hidden())
        .map_err(|error| error.to_string())?;
    Ok(fit.world)
}

/// A set as it was made and what was found in it.
pub struct Diagnosed {
    /// What is hidden.
    pub truth: Truth,
    /// What the diagnosis was given.
    pub input: Input,
    /// What it found.
    pub found: Found,
    /// Seconds that identification and diagnosis took.
    pub seconds: f64,
}

/// Makes a set and diagnoses it. `None` where the rig cannot make it, an error where identification or diagnosis has none to
/// give.
pub fn diagnosed(case: &Case) -> Option<Result<Diagnosed, String>> {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let truth = hide::truth(case)?;
    let (rig, strikes) = strikes(&truth, case.strikes, None, folder.path())?;
    let begun = std::time::Instant::now();
    Some(identified(case, &truth, &rig, &strikes).and_then(|world| {
        let input = Input {
            rig,
            world,
            strikes,
        };
        let settings = Diagnose {
            next_strikes: 0,
            ..Diagnose::default()
        };
        let found = settings
            .run(&input, &Progress::hidden())
            .map_err(|error| error.to_string())?;
        Ok(Diagnosed {
            truth,
            input,
            found,
            seconds: begun.elapsed().as_secs_f64(),
        })
    }))
}

/// Makes a set, diagnoses it and keeps what grading needs.
pub fn run(case: &Case) -> Outcome {
    let nothing = |verdict: String| Outcome {
        case: case.clone(),
        verdict,
        named: Vec::new(),
        p_value: 1.0,
        gap: (0, 0.0, 0.0, 0.0),
        covered: Vec::new(),
        seconds: 0.0,
    };
    let done = match diagnosed(case) {
        None => return nothing("impossible".into()),
        Some(Err(error)) => return nothing(format!("error: {error}")),
        Some(Ok(done)) => done,
    };
    let Diagnosis {
        verdict,
        effects,
        gap,
        p_value,
        ..
    } = &done.found.diagnosis;
    Outcome {
        named: effects
            .iter()
            .map(|e| (e.name.clone(), e.equivalent.clone()))
            .collect(),
        p_value: *p_value,
        gap: (gap.heldout_strikes, gap.before, gap.after, gap.noise_floor),
        covered: covered(case, &done.truth, &done.found),
        seconds: done.seconds,
        ..nothing(
            match verdict {
                Verdict::Named => "named",
                Verdict::Consistent => "consistent",
                Verdict::Unexplained => "unexplained",
            }
            .into(),
        )
    }
}
