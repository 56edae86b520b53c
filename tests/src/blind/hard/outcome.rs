//! What came of a hard set, and what repeats of its commands really scatter by.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rig::{Sim, StrikeTruth};
use serde::{Deserialize, Serialize};
use values::Point;

use super::super::coverage::{Covered, covered};
use super::super::grade::says_just;
use super::super::set;
use super::super::set::{Answer, DiagnosedSet};
use super::answers::is_nameable;
use super::cases::{Drawn, HardCase, draw};

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct HardOutcome {
    pub case: HardCase,
    /// What it was drawn to be; none where the rig could not make it.
    pub drawn: Option<Drawn>,
    pub answer: Answer,
    /// Parameters that have a truth, and the intervals found.
    pub covered: Vec<Covered>,
    /// What repeats of its commands really scatter by, in m.
    pub repeats: Option<f64>,
    /// The same of as many repeats as the set has strikes, drawn from all: the floor of whoever knows what each command does in the mean.
    #[serde(default)]
    pub few_repeats: Option<f64>,
}

impl HardOutcome {
    /// What is hidden, by the rig's names.
    pub fn hidden(&self) -> &[String] {
        self.drawn.as_ref().map_or(&[], |drawn| &drawn.hidden)
    }

    /// Whether just what is hidden was said.
    pub fn is_right(&self) -> bool {
        says_just(&self.answer, self.hidden())
    }

    /// Whether just what is hidden was said by names alone, without the classes that are said with them.
    pub fn is_right_by_name(&self) -> bool {
        says_just(&self.answer.by_name_alone(), self.hidden())
    }

    /// Whether what is hidden could be told at all.
    pub fn is_detectable(&self) -> bool {
        self.drawn.as_ref().is_some_and(Drawn::is_detectable)
    }

    /// The noise floor that the diagnosis states over what repeats really scatter by, and the stop error that it leaves over the same; none
    /// where either is not known.
    pub fn over_repeats(&self) -> Option<(f64, f64)> {
        let (strikes, _, after, floor) = self.answer.gap;
        let repeats = self.repeats.filter(|_| strikes > 0)?;
        Some((floor / repeats, after / repeats))
    }

    /// Whether more effects were named than there are names for what is hidden.
    pub fn has_a_name_too_many(&self) -> bool {
        let nameable = self.hidden().iter().filter(|h| is_nameable(h));
        self.answer.named.len() > nameable.count()
    }

    pub fn has_a_wrong_name(&self) -> bool {
        super::said(self.hidden(), &self.answer.named) < self.answer.named.len()
    }

    pub fn has_noise(&self, name: &str) -> bool {
        self.noise().contains(&name)
    }

    pub fn noise(&self) -> Vec<&'static str> {
        let truth = self.drawn.iter().map(|drawn| &drawn.truth);
        truth
            .flat_map(|truth| truth.noise.0.iter().map(rig::NoiseKind::name))
            .collect()
    }

    /// Whether the camera's scale is wrong.
    pub fn has_wrong_scale(&self) -> bool {
        let truth = self.drawn.iter().map(|drawn| &drawn.truth);
        truth
            .flat_map(|truth| &truth.hidden.0)
            .any(|effect| effect.name() == "camera_scale")
    }

    pub fn is_box(&self) -> bool {
        self.drawn
            .as_ref()
            .is_some_and(|drawn| drawn.truth.rig.object.shape() == values::Shape::Box)
    }
}

/// Draws a set and diagnoses it. `None` where the rig cannot make it, an error where identification or diagnosis gives one.
pub fn diagnosed_hard(case: &HardCase) -> Option<(Drawn, Result<DiagnosedSet, String>)> {
    let drawn = draw(case)?;
    let done = set::diagnosed(drawn.make(), None)?;
    Some((drawn, done))
}

/// Makes a set, diagnoses it and keeps what grading needs.
pub fn run_hard(case: &HardCase) -> HardOutcome {
    let mut outcome = HardOutcome {
        case: case.clone(),
        drawn: None,
        answer: Answer::none("impossible".into()),
        covered: Vec::new(),
        repeats: None,
        few_repeats: None,
    };
    let Some((drawn, done)) = diagnosed_hard(case) else {
        return outcome;
    };
    match done {
        Err(error) => outcome.answer = Answer::none(format!("error: {error}")),
        Ok(done) => {
            outcome.answer = Answer::of(&done.found, done.seconds);
            (outcome.repeats, outcome.few_repeats) = repeats(&drawn, &done.really).unzip();
            outcome.covered = covered(&drawn.hidden, false, &done);
        }
    }
    outcome.drawn = Some(drawn);
    outcome
}

/// Commands of the set that are repeated, and how often each is: the floor is then known to some 3 %.
const COMMANDS: usize = 40;
const TIMES: u64 = 12;
/// Frames this long after rest are free of stamps' errors, in s; so many must be seen.
const SETTLED: f64 = 0.1;
const FRAMES: usize = 5;

/// Root mean square distance of measured stops from their command's mean, in m: all noise of the set but a wander, which repeats of one hour
/// do not show; and that of as many, drawn from them, as the set has strikes. None where hardly a stop is seen.
pub(super) fn repeats(drawn: &Drawn, really: &[StrikeTruth]) -> Option<(f64, f64)> {
    let mut truth = drawn.truth.clone();
    truth
        .noise
        .0
        .retain(|kind| kind.name() != "friction_wander");
    let seed = truth.seed;
    let sims: Vec<Sim> = (1..=TIMES)
        .map(|time| {
            truth.seed = seed + 1_000_000_000 * time;
            Sim::from(truth.clone())
        })
        .collect::<Result<_, _>>()
        .ok()?;
    let step = really.len().div_ceil(COMMANDS).max(1);
    // Squared distances, each as large as if the command's mean were known.
    let mut squares = Vec::new();
    let mut freedom = 0.0;
    for strike in really.iter().step_by(step) {
        let stops: Vec<Point> = sims.iter().filter_map(|sim| again(sim, strike)).collect();
        if stops.len() < 2 {
            continue;
        }
        let sum = stops.iter().fold(Point::default(), |sum, stop| sum + *stop);
        let mean = sum * (1.0 / stops.len() as f64);
        let one = stops.len() as f64 / (stops.len() as f64 - 1.0);
        squares.extend(stops.iter().map(|s| one * s.distance(mean).powi(2)));
        freedom += stops.len() as f64 - 1.0;
    }
    let root_mean = |squares: &[f64]| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (freedom > 20.0).then(|| {
        let few = really
            .iter()
            .map(|_| squares[random.random_range(..squares.len())]);
        (root_mean(&squares), root_mean(&few.collect::<Vec<_>>()))
    })
}

/// Where the camera reports that the same strike stops: the median of its frames at rest, in m.
fn again(sim: &Sim, strike: &StrikeTruth) -> Option<Point> {
    let seen = sim.truth().see(strike.initial, strike.index());
    let recording = sim
        .clone()
        .after(strike.order)
        .in_session(strike.session)
        .strike(seen, strike.command);
    let rest = recording.truth.impact + ((recording.truth.rest_time + SETTLED) * 1e9) as u64;
    let frames = recording
        .samples
        .centroids
        .iter()
        .filter(|f| f.stamp > rest);
    let (mut x, mut y): (Vec<f64>, Vec<f64>) = frames.map(|f| (f.x, f.y)).unzip();
    if x.len() < FRAMES {
        return None;
    }
    x.sort_by(f64::total_cmp);
    y.sort_by(f64::total_cmp);
    Some(Point::new(x[x.len() / 2], y[y.len() / 2]))
}
