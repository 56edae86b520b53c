//! How well a version predicts other strikes than it was fitted to. A table that changed shows here.

mod drift;

use judge::{Candidate, Evaluation, HeldOut, evaluate};
use stage::Run;
use store::{Artifact, Logged, Model};
use values::Strike;

use self::drift::{LEAST, model_of};
use crate::Error;
use crate::noise::identified;

pub use self::drift::{Drift, default_model, drift, fitted, moved, step, varies};

/// How well every model of a version predicts strikes, and whether the table is where the version has it.
pub fn judge(
    run: &Run,
    artifact: &Artifact,
    strikes: &[Strike],
) -> Result<(Evaluation, Option<Drift>), Error> {
    let used = artifact.effect.as_ref().unwrap_or(&artifact.sysid);
    let judges: Vec<HeldOut> = strikes.iter().map(HeldOut::from).collect();
    let noise = identified(&artifact.rig, &used.world);
    let mut evaluation = evaluate(run, &candidates(artifact), &judges, &noise)?;
    // What the strikes that it was computed from showed of repeats.
    let published = artifact.manifest.provenance.noise_floor;
    evaluation.noise_floor = published.or(evaluation.noise_floor);
    Ok((evaluation, drift(run, artifact, strikes)?))
}

/// Why drift from a version cannot be judged.
pub fn drift_unknown() -> String {
    format!("cannot judge drift: fewer than {LEAST} strikes show a free slide")
}

/// Strikes made after those that the version was computed from follow them in order, for effects that drift.
pub fn follow_known_strikes(known: Logged, strikes: &mut [Strike]) {
    let later = strikes
        .iter_mut()
        .filter(|strike| strike.t_start > known.last);
    for (place, strike) in later.enumerate() {
        strike.conditions.order = (known.count + place) as f64;
    }
}

fn candidates(artifact: &Artifact) -> Vec<Candidate> {
    let candidate = |name: Model| {
        Some(Candidate {
            name: name.to_string(),
            model: model_of(artifact, name)?,
        })
    };
    artifact
        .models()
        .into_iter()
        .filter_map(candidate)
        .collect()
}

#[cfg(test)]
mod tests {
    use values::{Command, Conditions, Point, Split};

    use super::*;

    #[test]
    fn later_strikes_go_on_in_the_order_of_those_that_the_version_knows() {
        let strike = |(order, t_start): (usize, f64)| Strike {
            t_start,
            split: Split::Test,
            conditions: Conditions {
                order: order as f64,
                ..Conditions::default()
            },
            ..Strike::bare(Command::new(1.0, 0.0), Point::default(), Point::default())
        };
        let stamps = [7.0, 8.0, 9.0, 10.0];
        let mut strikes: Vec<Strike> = stamps.into_iter().enumerate().map(strike).collect();
        let known = Logged {
            count: 50,
            last: 8.0,
        };
        follow_known_strikes(known, &mut strikes);
        let orders: Vec<f64> = strikes
            .iter()
            .map(|strike| strike.conditions.order)
            .collect();
        assert_eq!(orders, [0.0, 1.0, 50.0, 51.0]);
    }
}
