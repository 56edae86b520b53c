//! One set of strikes: made by the rig, read from its logs, identified, diagnosed.

use std::path::Path;
use std::time::Instant;

use diagnose::{Diagnose, Diagnosed, Input, Verdict};
use ingest::{Ingest, assemble, ingest_log};
use rig::{PlannedStrike, StrikeTruth, Truth, demo};
use serde::{Deserialize, Serialize};
use stage::{Progress, Stage};
use values::{Rig, Strike};
use world::World;

#[derive(Clone, Debug)]
pub(super) struct Make<'t> {
    pub truth: &'t Truth,
    pub strikes: usize,
    /// Number of sessions; none: as the demo has it.
    pub sessions: Option<usize>,
    /// Strikes in place of random ones.
    pub plan: Option<Vec<PlannedStrike>>,
    /// Strikes that are made and then missing from the logs, by their order.
    pub missing: std::ops::Range<usize>,
}

impl<'t> Make<'t> {
    /// A design of `strikes` random strikes, in sessions as the demo has them.
    pub(super) fn random(truth: &'t Truth, strikes: usize) -> Self {
        Self {
            truth,
            strikes,
            sessions: None,
            plan: None,
            missing: 0..0,
        }
    }
}

pub(super) struct Made {
    /// The rig file that goes with them.
    pub rig: Rig,
    pub strikes: Vec<Strike>,
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
    let all = assemble(outcomes).0.into_iter();
    // Ranks among those that are there: of the others no log knows.
    let there = all.filter(|strike| !make.missing.contains(&(strike.conditions.order as usize)));
    Some(Made {
        rig,
        strikes: there
            .zip(0..)
            .map(|(strike, order)| strike.among_all(order))
            .collect(),
        really: really.strikes,
    })
}

/// The identified world that a user has, from friction as believed where that is given; or why there is none.
pub(super) fn identified(
    rig: &Rig,
    strikes: &[Strike],
    believed_friction: Option<f64>,
) -> Result<World, String> {
    let mut world = World::nominal();
    if let Some(friction) = believed_friction {
        world = world.with("friction", friction);
    }
    let input = sysid::Input {
        rig: rig.clone(),
        world,
        strikes: strikes.to_vec(),
        later: Vec::new(),
    };
    let fit = sysid::Sysid::default()
        .run(&input, &Progress::hidden())
        .map_err(|error| error.to_string())?;
    Ok(fit.world)
}

pub struct DiagnosedSet {
    pub truth: Truth,
    pub really: Vec<StrikeTruth>,
    pub input: Input,
    pub found: Diagnosed,
    /// Seconds that identification took, and those that the diagnosis took.
    pub seconds: (f64, f64),
}

/// Makes a set and diagnoses it. `None` where the rig cannot make it, an error where identification or diagnosis gives one.
pub(super) fn diagnosed(
    make: Make<'_>,
    believed_friction: Option<f64>,
) -> Option<Result<DiagnosedSet, String>> {
    let truth = make.truth.clone();
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let made = strikes(make, folder.path())?;
    Some(found(truth, made, believed_friction))
}

fn found(truth: Truth, made: Made, believed_friction: Option<f64>) -> Result<DiagnosedSet, String> {
    let begun = Instant::now();
    let world = identified(&made.rig, &made.strikes, believed_friction)?;
    let identification = begun.elapsed().as_secs_f64();
    let input = Input::of(made.rig, world, made.strikes);
    let settings = Diagnose {
        next_strikes: 0,
        ..Diagnose::default()
    };
    let begun = Instant::now();
    let found = settings
        .run(&input, &Progress::hidden())
        .map_err(|error| error.to_string())?;
    Ok(DiagnosedSet {
        truth,
        really: made.really,
        input,
        found,
        seconds: (identification, begun.elapsed().as_secs_f64()),
    })
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

    /// This answer without classes: what a person reads who reads names alone.
    pub(super) fn by_name_alone(&self) -> Self {
        let named = self
            .named
            .iter()
            .map(|(name, _)| (name.clone(), Vec::new()));
        Self {
            named: named.collect(),
            ..self.clone()
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
