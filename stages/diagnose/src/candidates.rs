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

/// All candidates for these strikes.
pub(crate) fn candidates(rig: &Rig, strikes: &[&Strike]) -> Vec<Candidate> {
    let experiment = Experiment { rig, strikes };
    library()
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
    }
}

fn spec(name: &str) -> &'static EffectSpec {
    effect(name).expect("a candidate is an effect of the library")
}
