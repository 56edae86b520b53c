//! The candidates: every effect of the library that these strikes can tell, with where fits of it begin.

use std::collections::BTreeMap;

use values::{Rig, Strike};
use world::effects::{Column, EffectSpec, Experiment, FitStart, effect, library};

use crate::model::Part;

/// One effect that may be missing.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) name: &'static str,
    pub(crate) starts: Vec<FitStart>,
}

/// All candidates for these strikes, those of last resort left out.
pub(crate) fn candidates(rig: &Rig, strikes: &[&Strike]) -> Vec<Candidate> {
    all(rig, strikes, false)
}

/// Those that are tried only where no other is enough: smooth fields that could take the form of many.
#[expect(dead_code, reason = "the search does not yet ask for them")]
pub(crate) fn last_resorts(rig: &Rig, strikes: &[&Strike]) -> Vec<Candidate> {
    all(rig, strikes, true)
}

fn all(rig: &Rig, strikes: &[&Strike], is_last_resort: bool) -> Vec<Candidate> {
    let experiment = Experiment { rig, strikes };
    library()
        .filter(|spec| spec.is_last_resort == is_last_resort)
        .map(|spec| Candidate {
            name: spec.name,
            starts: (spec.starts)(&experiment),
        })
        .filter(|candidate| !candidate.starts.is_empty())
        .collect()
}

/// A little of an effect: a column's parameters.
pub(crate) fn little(name: &'static str, column: &Column) -> Part {
    let parameters = column.form.iter().chain([&column.strength]);
    Part {
        name,
        parameters: parameters.cloned().collect(),
        free: Vec::new(),
        strengths: Vec::new(),
        within: BTreeMap::new(),
        shrinks_to: None,
    }
}

/// The effect where a fit of it begins, given the coefficients of the start's columns.
pub(crate) fn begun(name: &'static str, start: &FitStart, coefficients: &[f64]) -> Part {
    Part {
        name,
        parameters: start.parameters(spec(name), coefficients),
        free: start.free.clone(),
        strengths: start.strengths(),
        within: start.within.clone(),
        shrinks_to: start.shrinks_to,
    }
}

fn spec(name: &str) -> &'static EffectSpec {
    effect(name).expect("a candidate is an effect of the library")
}
