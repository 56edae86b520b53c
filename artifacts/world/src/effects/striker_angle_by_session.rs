//! A direction that errs differently from log to log: the camera or the table was moved between them.

use super::{
    EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    formula::delivering, sessions::BySession, wording,
};

/// Striker angle by session; parameters are named by session, each the error δ of the angle in it, counter-clockwise. A session
/// that is not known has their mean.
pub const SPEC: EffectSpec = EffectSpec {
    name: "striker_angle_by_session",
    parameters: Parameters::BySession {
        parameter: EffectParameter::new("session", "rad", [-0.5, 0.5], 0.02),
        is_relative: false,
    },
    family: Family::LaunchAngleByOrder,
    origin: Origin::Camera,
    equivalent: &[],
    contains: &["striker_angle_bias"],
    naming: Naming::Ordinary,
    source: "an effect of the group, as in mixed models (Laird and Ware 1982), on the direction of the launch",
    starts: sessions,
    build: |values, _| {
        let bias = BySession::new(values);
        delivering(move |command, _, conditions| command.turned(bias.value(&conditions.session)))
    },
    statement: |values| {
        let sessions: Vec<_> = BySession::new(values)
            .known()
            .map(|(session, bias)| {
                let side = wording::side(bias);
                format!("{:.1}° to the {side} in {session}", bias.abs().to_degrees())
            })
            .collect();
        if sessions.is_empty() {
            "objects leave in the same direction in every session".into()
        } else {
            format!(
                "objects leave {} of the commanded direction",
                sessions.join(", ")
            )
        }
    },
};

fn sessions(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let names = experiment.sessions();
    if names.len() < 2 {
        return Vec::new();
    }
    FitStart::each(&names, 0.005)
}

#[cfg(test)]
mod tests {
    use values::{Command, Conditions, Point, Rig, Shape, Strike};

    use super::*;
    use crate::effects::tests::{Bench, assert_near};

    #[test]
    fn each_column_of_its_start_turns_one_session_and_the_fit_begins_with_all() {
        let strike = |session: &str| Strike {
            log: session.into(),
            conditions: Conditions {
                session: session.into(),
                ..Conditions::default()
            },
            ..Strike::bare(
                Command::new(0.7, 0.0),
                Point::default(),
                Point::new(0.5, 0.0),
            )
        };
        let strikes = ["monday.mcap", "tuesday.mcap", "friday.mcap"].map(strike);
        let strikes: Vec<&Strike> = strikes.iter().collect();
        let rig = Rig::demo(Shape::Cylinder);
        let starts = sessions(&Experiment {
            rig: &rig,
            strikes: &strikes,
        });
        let start = &starts[0];
        for column in &start.columns {
            let all = column.form.iter().chain([&column.strength]).cloned();
            let values: std::collections::BTreeMap<String, f64> = all.collect();
            let turned = values.values().filter(|value| **value != 0.0).count();
            assert_eq!((values.len(), turned), (3, 1), "{column:?}");
        }
        let begun = start.parameters(&SPEC.parameters, &[1.0, 2.0, 3.0]);
        let mut values: Vec<f64> = begun.values().copied().collect();
        values.sort_by(f64::total_cmp);
        assert_eq!(values, [0.005, 0.01, 0.015]);
    }

    #[test]
    fn each_session_strikes_by_its_formula_and_others_by_the_mean() {
        let biases = [("monday.mcap", 0.05), ("tuesday.mcap", -0.01)];
        for (session, bias) in [
            ("monday.mcap", 0.05),
            ("tuesday.mcap", -0.01),
            ("friday.mcap", 0.02),
            ("", 0.02),
        ] {
            let stop = Bench::with("striker_angle_by_session", &biases)
                .during(session, 0.0)
                .strike(0.8, 0.1)
                .stop;
            assert_near(stop, Bench::plain().strike(0.8, 0.1 + bias).stop, 1e-6);
        }
    }
}
