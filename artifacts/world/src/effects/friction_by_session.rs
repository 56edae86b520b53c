//! Friction that differs from log to log: another day, object or surface.

use super::{
    Acts, Column, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin,
    Parameters, formula::braking, sessions::BySession, wording,
};

/// Friction by session; parameters are named by session, each the relative change of friction in it from the mean over
/// sessions, which is the world's friction and that of sessions that are not known.
pub const SPEC: EffectSpec = EffectSpec {
    name: "friction_by_session",
    parameters: Parameters::BySession {
        parameter: EffectParameter::new("session", "", [-0.9, 3.0], 0.15),
        is_relative: true,
    },
    family: Family::FrictionByOrder,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Ordinary,
    source: "an effect of the group, as in mixed models (Laird and Ware 1982)",
    starts: sessions,
    build: |values, _| {
        let change = BySession::relative(values);
        braking(Acts::Strike, move |slide| {
            1.0 + change.value(&slide.conditions.session)
        })
    },
    statement: |values| {
        let sessions: Vec<_> = BySession::relative(values)
            .known()
            .map(|(session, change)| format!("{} in {session}", wording::higher(change)))
            .collect();
        if sessions.is_empty() {
            "friction is the same in every session".into()
        } else {
            format!("friction is {} than in their mean", sessions.join(", "))
        }
    },
};

/// The first session's factor is fixed, for the mean is friction's own: the columns of the others are their differences from it.
fn sessions(experiment: &Experiment<'_>) -> Vec<FitStart> {
    match experiment.sessions()[..] {
        [] | [_] => Vec::new(),
        [first, ref others @ ..] => {
            let still = [(first, 0.0)];
            let column = |name: &&str| Column::new(&still, (*name, 0.02));
            vec![FitStart::new(others.iter().map(column).collect(), others)]
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::effects::tests::{Bench, DRY};

    #[test]
    fn each_session_stops_by_its_formula_and_others_by_the_mean() {
        // Taken from their mean, 1.1.
        let changes = [("monday.mcap", 0.3), ("tuesday.mcap", -0.1)];
        for (session, factor) in [
            ("monday.mcap", 1.3 / 1.1),
            ("tuesday.mcap", 0.9 / 1.1),
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
