//! One set of strikes: made by the rig, read from its logs, identified, diagnosed.

use std::path::Path;

use diagnose::{Diagnose, Diagnosed, Input, Thresholds, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{PlannedStrike, StrikeTruth, Truth, demo};
use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Rig, Strike};
use world::World;

/// What to make.
#[derive(Clone, Debug)]
pub(super) struct Make<'t> {
    /// The rig.
    pub truth: &'t Truth,
    /// How many random strikes.
    pub strikes: usize,
    /// How many sessions; none: as the demo has it.
    pub sessions: Option<usize>,
    /// Strikes in place of random ones.
    pub plan: Option<Vec<PlannedStrike>>,
}

/// Strikes as they were read.
pub(super) struct Made {
    /// The rig file that goes with them.
    pub rig: Rig,
    /// The strikes that were read from the logs.
    pub strikes: Vec<Strike>,
    /// All strikes as they really were.
    pub really: Vec<StrikeTruth>,
}

/// Strikes through their logs; `None` where they cannot be made.
pub(super) fn strikes(make: Make<'_>, folder: &Path) -> Option<Made> {
    let settings = demo::Settings {
        strikes: make.strikes,
        truth: make.truth.clone(),
        plan: make.plan,
        log_state: false,
        log_pose: false,
        sessions: make.sessions,
    };
    let written = demo::write(&settings, folder).ok()?;
    let rig = Rig::load(&written.rig).expect("the demo's rig file is valid");
    let outcomes = written
        .logs
        .iter()
        .map(|log| ingest_log(log, &rig, &Ingest::default()).expect("the demo's logs are readable"))
        .collect();
    let really = Truth::load(&written.truth).expect("the demo's truth is readable");
    Some(Made {
        rig,
        strikes: assemble(outcomes).0,
        really: really.strikes,
    })
}

/// The identified world that a user has, from friction as believed where that is given; or why there is none.
pub(super) fn identified(
    rig: &Rig,
    strikes: &[Strike],
    believed_friction: Option<f64>,
) -> Result<World, String> {
    let mut world = World::nominal(rig);
    if let Some(friction) = believed_friction {
        world = world.with("friction", friction);
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

/// A set as it was read, and what was found in it.
pub struct DiagnosedSet {
    /// What is hidden.
    pub truth: Truth,
    /// All strikes as they really were.
    pub really: Vec<StrikeTruth>,
    /// What the diagnosis was given.
    pub input: Input,
    /// What it found.
    pub found: Diagnosed,
    /// Seconds that identification took, and those that the diagnosis took.
    pub seconds: (f64, f64),
}

/// A set as it was read and identified.
pub(super) struct IdentifiedSet {
    /// All strikes as they really were.
    pub really: Vec<StrikeTruth>,
    /// What a diagnosis is given.
    pub input: Input,
    /// Seconds that identification took.
    pub seconds: f64,
}

/// Makes a set and identifies its world. `None` where the rig cannot make it, an error where identification gives one.
pub(super) fn identified_set(
    make: Make<'_>,
    believed_friction: Option<f64>,
) -> Option<Result<IdentifiedSet, String>> {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let Made {
        rig,
        strikes,
        really,
    } = strikes(make, folder.path())?;
    let begun = std::time::Instant::now();
    Some(
        identified(&rig, &strikes, believed_friction).map(|world| IdentifiedSet {
            really,
            input: Input {
                rig,
                world,
                strikes,
            },
            seconds: begun.elapsed().as_secs_f64(),
        }),
    )
}

/// A diagnosis by these thresholds, and the seconds that it took.
pub(super) fn diagnosis(input: &Input, thresholds: Thresholds) -> Result<(Diagnosed, f64), String> {
    let settings = Diagnose {
        next_strikes: 0,
        thresholds,
        ..Diagnose::default()
    };
    let begun = std::time::Instant::now();
    let found = settings
        .run(input, &Progress::hidden())
        .map_err(|error| error.to_string())?;
    Ok((found, begun.elapsed().as_secs_f64()))
}

/// Makes a set and diagnoses it. `None` where the rig cannot make it, an error where identification or diagnosis gives one.
pub(super) fn diagnosed(
    make: Make<'_>,
    believed_friction: Option<f64>,
) -> Option<Result<DiagnosedSet, String>> {
    let truth = make.truth.clone();
    let set = identified_set(make, believed_friction)?;
    Some(set.and_then(|set| {
        let (found, seconds) = diagnosis(&set.input, Thresholds::default())?;
        Ok(DiagnosedSet {
            truth,
            really: set.really,
            input: set.input,
            found,
            seconds: (set.seconds, seconds),
        })
    }))
}

/// What a diagnosis said of a set.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Answer {
    /// `named`, `consistent`, `unexplained`; `impossible` where the rig could not make the set, `error: …` where identification or
    /// diagnosis gave one.
    pub verdict: String,
    /// Effects named, each with those that the data cannot distinguish from it.
    pub named: Vec<(String, Vec<String>)>,
    /// Probability of the gap by chance.
    pub p_value: f64,
    /// Held-out strikes; rms stop error in m before and after, and the noise floor.
    pub gap: (usize, f64, f64, f64),
    /// Seconds that identification and diagnosis took, beside whatever else ran.
    pub seconds: f64,
    /// Seconds of them that the diagnosis took.
    #[serde(default)]
    pub diagnosis_seconds: f64,
}

impl Answer {
    /// What there is to say without a diagnosis.
    pub(super) fn none(verdict: String) -> Self {
        Self {
            verdict,
            named: Vec::new(),
            p_value: 1.0,
            gap: (0, 0.0, 0.0, 0.0),
            seconds: 0.0,
            diagnosis_seconds: 0.0,
        }
    }

    /// From what was found in these seconds of identification and diagnosis.
    pub(super) fn of(found: &Diagnosed, seconds: (f64, f64)) -> Self {
        let found = &found.diagnosis;
        let gap = &found.gap;
        Self {
            verdict: match found.verdict {
                Verdict::Named => "named",
                Verdict::Consistent => "consistent",
                Verdict::Unexplained => "unexplained",
            }
            .into(),
            named: found
                .effects
                .iter()
                .map(|e| (e.name.clone(), e.equivalent.clone()))
                .collect(),
            p_value: found.p_value,
            gap: (gap.heldout_strikes, gap.before, gap.after, gap.noise_floor),
            seconds: seconds.0 + seconds.1,
            diagnosis_seconds: seconds.1,
        }
    }

    /// The names, each with its class in brackets; without names, the verdict.
    pub fn text(&self) -> String {
        if self.named.is_empty() {
            return self.verdict.clone();
        }
        self.named
            .iter()
            .map(|(name, equivalent)| match equivalent.as_slice() {
                [] => name.clone(),
                others => format!("{name} [{}]", others.join(", ")),
            })
            .collect::<Vec<_>>()
            .join(" + ")
    }
}
