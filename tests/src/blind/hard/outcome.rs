//! What came of a hard set.

use serde::{Deserialize, Serialize};

use super::super::coverage::{Covered, covered};
use super::super::grade::says_just;
use super::super::set::{self, Answer, DiagnosedSet};
use super::answers::is_nameable;
use super::cases::{Drawn, HardCase, draw};
use super::repeats::repeats;

/// A set and what was said of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct HardOutcome {
    /// The set.
    pub case: HardCase,
    /// What it was drawn to be; none where the rig could not make it.
    pub drawn: Option<Drawn>,
    /// What was said.
    pub answer: Answer,
    /// Parameters that have a truth, and the intervals found.
    pub covered: Vec<Covered>,
    /// What repeats of its commands really scatter by, in m.
    pub repeats: Option<f64>,
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

    /// The same by names alone, without the classes that are said with them.
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

    /// Whether a name was said that is not what is hidden.
    pub fn has_a_wrong_name(&self) -> bool {
        super::said(self.hidden(), &self.answer.named) < self.answer.named.len()
    }

    /// Whether a kind of noise acts.
    pub fn has_noise(&self, name: &str) -> bool {
        self.noise().contains(&name)
    }

    /// The kinds of noise that act.
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

    /// Whether a box is struck.
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
    };
    let Some((drawn, done)) = diagnosed_hard(case) else {
        return outcome;
    };
    match done {
        Err(error) => outcome.answer = Answer::none(format!("error: {error}")),
        Ok(done) => {
            outcome.answer = Answer::of(&done.found, done.seconds);
            outcome.repeats = repeats(&drawn, &done.really);
            outcome.covered = covered(&drawn.hidden, false, &done);
        }
    }
    outcome.drawn = Some(drawn);
    outcome
}
