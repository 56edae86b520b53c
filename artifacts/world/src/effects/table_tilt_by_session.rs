//! A table that slopes otherwise from log to log: it was moved or levelled between them.

use std::collections::BTreeMap;

use values::Point;

use super::{
    Acts, EffectParameter, EffectSpec, Experiment, Family, FitStart, Naming, Origin, Parameters,
    Values, formula::forcing, wording,
};
use crate::GRAVITY;

/// What follows a session in the name of its slope along +y; that along +x has the session's own.
const ALONG_Y: &str = " tilt_y";

/// Table tilt by session; parameters are named by session, each the slope down along +x in it, and by session and ` tilt_y`, the slope down along
/// +y. A session that is not known has their mean.
pub const SPEC: EffectSpec = EffectSpec {
    name: "table_tilt_by_session",
    parameters: Parameters::BySession {
        parameter: EffectParameter::new("session", "rad", [-0.3, 0.3], 0.005),
        is_relative: false,
    },
    family: Family::ForceBySession,
    origin: Origin::Table,
    equivalent: &[],
    contains: &[],
    naming: Naming::Never,
    source: "weight on an inclined plane, as an effect of the group (Laird and Ware 1982)",
    starts: sessions,
    build: |values, _| {
        let slopes = slopes(values);
        let sum = slopes
            .values()
            .fold(Point::default(), |sum, slope| sum + *slope);
        let unknown = sum * (1.0 / slopes.len().max(1) as f64);
        forcing(Acts::Strike, move |slide| {
            let slope = slopes.get(&slide.conditions.session).unwrap_or(&unknown);
            Point::new(slope.x.sin(), slope.y.sin()) * GRAVITY
        })
    },
    statement: |values| {
        let sessions: Vec<_> = slopes(values)
            .into_iter()
            .map(|(session, down)| {
                let towards = wording::degrees(down.bearing());
                format!(
                    "by {:.1} mm per metre towards {towards} from +x in {session}",
                    1000.0 * down.norm()
                )
            })
            .collect();
        format!(
            "the table slopes down otherwise in each session: {}; it was moved or levelled between them, or a draught came from elsewhere: level it, \
             fix it, and log again",
            sessions.join(", ")
        )
    },
};

/// The slope down along x and y in each session.
fn slopes(values: &Values) -> BTreeMap<String, Point> {
    let mut slopes: BTreeMap<String, Point> = BTreeMap::new();
    for (name, slope) in values.iter() {
        match name.strip_suffix(ALONG_Y) {
            Some(session) => slopes.entry(session.into()).or_default().y = slope,
            None => slopes.entry(name.into()).or_default().x = slope,
        }
    }
    slopes
}

fn sessions(experiment: &Experiment<'_>) -> Vec<FitStart> {
    let sessions = experiment.sessions();
    if sessions.len() < 2 {
        return Vec::new();
    }
    let along_y = sessions.iter().map(|session| format!("{session}{ALONG_Y}"));
    let names: Vec<String> = sessions
        .iter()
        .map(|s| s.to_string())
        .chain(along_y)
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    FitStart::each(&names, 0.002)
}

#[cfg(test)]
mod tests {
    use values::Point;

    use super::GRAVITY;
    use crate::effects::tests::Bench;

    #[test]
    fn each_session_slopes_by_its_formula_and_others_by_the_mean() {
        let slopes = [
            ("monday.mcap", 0.01),
            ("tuesday.mcap", 0.0),
            ("tuesday.mcap tilt_y", 0.02),
        ];
        for (session, slope) in [
            ("monday.mcap", Point::new(0.01, 0.0)),
            ("tuesday.mcap", Point::new(0.0, 0.02)),
            ("friday.mcap", Point::new(0.005, 0.01)),
        ] {
            let bench = Bench::with("table_tilt_by_session", &slopes).during(session, 0.0);
            let pull = Point::new(slope.x.sin(), slope.y.sin()) * GRAVITY;
            bench.slide(0.9, 0.2).assert_integrates(|_, _| pull);
        }
    }
}
