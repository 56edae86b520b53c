//! The candidates: every effect of the library that these strikes can determine, with where fits of it begin.

use std::collections::BTreeMap;

use values::{Rig, Strike};
use world::effects::{Column, EffectSpec, Experiment, FitStart, Naming, Origin, effect, library};

use crate::model::Part;
use crate::smooth::family;

/// One effect that may be missing.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) name: &'static str,
    pub(crate) starts: Vec<FitStart>,
}

/// The candidates that are named in this way.
pub(crate) fn candidates(rig: &Rig, strikes: &[&Strike], naming: Naming) -> Vec<Candidate> {
    let experiment = Experiment { rig, strikes };
    library()
        .filter(|spec| spec.naming == naming)
        .map(|spec| Candidate {
            name: spec.name,
            starts: (spec.starts)(&experiment)
                .into_iter()
                .filter(|start| start.columns.iter().all(|column| is_in_range(spec, column)))
                .collect(),
        })
        .filter(|candidate| !candidate.starts.is_empty())
        .collect()
}

/// Whether an effect acts on a strike as a whole, and not on its picture: on its launch, or on its friction all the way.
pub(crate) fn is_of_whole_strikes(name: &str) -> bool {
    let is_seen = effect(name).is_ok_and(|spec| spec.origin == Origin::Camera);
    let mut family = family(name).iter();
    !is_seen && family.all(|covariate| covariate.is_of_whole_strikes())
}

/// Whether an effect is stated as a cause, and never named.
pub(crate) fn is_never_named(name: &str) -> bool {
    effect(name).is_ok_and(|spec| spec.naming == Naming::Never)
}

/// Whether an effect may have a column's parameters: fast strikes start caps beyond what a robot reaches.
fn is_in_range(spec: &EffectSpec, column: &Column) -> bool {
    column
        .form
        .iter()
        .chain([&column.strength])
        .all(|(name, value)| {
            spec.parameter(name)
                .is_some_and(|p| (p.low..=p.high).contains(value))
        })
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
        parameters: start.parameters(&spec(name).parameters, coefficients),
        free: start.free.clone(),
        strengths: start.strengths(),
        within: start.within.clone(),
        shrinks_to: start.shrinks_to,
    }
}

fn spec(name: &str) -> &'static EffectSpec {
    effect(name).expect("a candidate is an effect of the library")
}

#[cfg(test)]
mod tests {
    use values::{Command, Conditions, Point, Shape, Split, Track};

    use super::*;

    #[test]
    fn fits_begin_within_the_ranges_of_the_library_however_fast_the_strikes() {
        let strikes: Vec<Strike> = (0..40)
            .map(|i| Strike {
                id: i.to_string(),
                log: "a.mcap".into(),
                index: i,
                t_start: f64::from(i),
                initial: Point::new(0.3, 0.0),
                stop: Point::new(0.9, 0.1),
                command: Command {
                    speed: 0.5 + 0.1 * f64::from(i),
                    angle: 0.01 * f64::from(i),
                },
                track: Track::default(),
                split: Split::Train,
                conditions: Conditions::default(),
                delivered: None,
            })
            .collect();
        let strikes: Vec<&Strike> = strikes.iter().collect();
        let candidates = candidates(&Rig::demo(Shape::Cylinder), &strikes, Naming::Ordinary);
        assert!(candidates.iter().any(|c| c.name == "striker_speed_error"));
        for candidate in candidates {
            for column in candidate.starts.iter().flat_map(|start| &start.columns) {
                assert!(is_in_range(spec(candidate.name), column), "{column:?}");
            }
        }
    }
}
