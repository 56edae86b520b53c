//! Friction that differs from log to log: another day, object or surface.

use std::collections::BTreeMap;

use values::Rig;

use super::{
    action::{Acts, Effect, Slide},
    spec::{EffectParameter, EffectSpec, Family, Parameters, Values},
    start::{Column, Experiment, FitStart},
    wording,
};

/// Friction by session; parameters are named by session, each the relative change of friction in it.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_by_session",
    parameters: Parameters::BySession(EffectParameter {
        name: "session",
        unit: "",
        low: -0.9,
        high: 3.0,
        neutral: 0.0,
        scale: 0.15,
    }),
    family: Family::FrictionByOrder,
    equivalent: &[],
    contains: &[],
    is_last_resort: false,
    source: "an effect of the group, as in mixed models (Laird and Ware 1982)",
    starts: sessions,
    build: |values: &Values, _: &Rig| {
        Box::new(FrictionBySession {
            factors: values
                .iter()
                .map(|(session, change)| (session.to_string(), 1.0 + change))
                .collect(),
        })
    },
    statement: |values| {
        let sessions: Vec<_> = values
            .iter()
            .map(|(session, change)| format!("{} in {session}", wording::higher(change)))
            .collect();
        if sessions.is_empty() {
            "friction is the same in every session".into()
        } else {
            format!("friction is {}", sessions.join(", "))
        }
    },
};

struct FrictionBySession {
    factors: BTreeMap<String, f64>,
}

impl Effect for FrictionBySession {
    fn acts(&self) -> Acts {
        Acts::Strike
    }

    fn friction_factor(&self, slide: &Slide<'_>) -> f64 {
        self.factors
            .get(&slide.conditions.session)
            .copied()
            .unwrap_or(1.0)
    }
}

/// One session is the friction that all have: the columns of the others tell the differences.
fn sessions(experiment: &Experiment<'_>) -> Vec<FitStart> {
    match experiment.sessions()[..] {
        [] | [_] => Vec::new(),
        [_, ref others @ ..] => {
            let column = |name: &&str| Column::new(&[], (*name, 0.02));
            vec![FitStart::new(others.iter().map(column).collect(), others)]
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn it_changes_the_track() {
        Bench::with("friction_by_session", &[("monday.mcap", 0.15)])
            .during("monday.mcap", 3.0)
            .assert_changes_track();
    }

    #[test]
    fn each_session_stops_by_its_formula_and_others_as_the_world() {
        let changes = [("monday.mcap", 0.3), ("tuesday.mcap", -0.2)];
        for (session, factor) in [
            ("monday.mcap", 1.3),
            ("tuesday.mcap", 0.8),
            ("friday.mcap", 1.0),
            ("", 1.0),
        ] {
            let slid = Bench::with("friction_by_session", &changes)
                .during(session, 0.0)
                .slide(0.9, 0.0);
            slid.assert_distance(slid.speed().powi(2) / (2.0 * DRY * factor));
        }
    }
}
