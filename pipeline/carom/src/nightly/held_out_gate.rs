//! The first gate between a candidate and the robot: held-out strikes.

use evaluate::{Candidate, Evaluation, Judge};
use serde::{Deserialize, Serialize};
use stage::Run;
use statrs::distribution::{ContinuousCDF, StudentsT};
use store::Artifact;
use values::{Split, Strike};

use crate::Error;
use crate::noise::identified;
use crate::pipeline::judge;

/// Fewer strikes than these decide nothing.
const LEAST: usize = 8;

/// Strikes that no version learnt from, as long as the seed stays.
pub fn held_out(strikes: &[Strike]) -> Vec<Strike> {
    let is_held_out = |strike: &&Strike| strike.split == Split::Test;
    strikes.iter().filter(is_held_out).cloned().collect()
}

/// Whether the candidate's stop errors are smaller than those of the version in use, on the same held-out strikes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOutGate {
    /// Whether it passes: the whole interval is above zero, and it predicts no fewer strikes.
    pub passed: bool,
    /// Version that it is compared with.
    pub current: String,
    /// Strikes that both predict.
    pub strikes: usize,
    /// Mean stop error of the version in use on them, in m.
    pub current_mean: f64,
    /// Mean stop error of the candidate on them, in m.
    pub candidate_mean: f64,
    /// By how much the candidate is better, strike by strike: mean, in m.
    pub gain: f64,
    /// 95 % interval of the gain, in m; none for too few strikes.
    pub interval: Option<[f64; 2]>,
    /// Strikes that the version in use does not predict.
    pub current_failed: usize,
    /// Strikes that the candidate does not predict.
    pub candidate_failed: usize,
}

/// Compares the default models of both.
pub fn compare_held_out(
    run: &Run,
    current: &Artifact,
    candidate: &Artifact,
    strikes: &[Strike],
) -> Result<HeldOutGate, Error> {
    let used = candidate.effect.as_ref().unwrap_or(&candidate.sysid);
    let judges: Vec<Judge> = strikes.iter().map(Judge::from).collect();
    let models = [("current", current), ("candidate", candidate)]
        .map(|(name, artifact)| default_model(name, artifact));
    let noise = identified(&candidate.rig, &used.world);
    // What a strike said of a model before is kept.
    let evaluation = judge(run, &candidate.rig, &judges, &models, &noise)?;
    let errors = |name| errors(&evaluation, name);
    Ok(compare(
        &current.version,
        &errors("current"),
        &errors("candidate"),
    ))
}

fn default_model(name: &str, artifact: &Artifact) -> Candidate {
    let model = artifact.manifest.provenance.default_model;
    // Loading has checked that it is there.
    let (world, residual) = artifact
        .model(model)
        .unwrap_or_else(|| (artifact.sysid.world.clone(), None));
    Candidate {
        name: name.into(),
        world,
        residual: residual.cloned(),
    }
}

/// One model's errors, in the order of the strikes.
fn errors(evaluation: &Evaluation, model: &str) -> Vec<Option<f64>> {
    let rows = evaluation.predictions.iter();
    let rows = rows.filter(|row| row.model == model);
    rows.map(|row| row.error).collect()
}

/// Paired by strike, by Student's t: strikes differ by far more than models do.
fn compare(version: &str, current: &[Option<f64>], candidate: &[Option<f64>]) -> HeldOutGate {
    let pairs: Vec<(f64, f64)> = current
        .iter()
        .zip(candidate)
        .filter_map(|(current, candidate)| Some(((*current)?, (*candidate)?)))
        .collect();
    let n = pairs.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / n.max(1.0);
    let gain = mean(|(current, candidate)| current - candidate);
    let failed = |errors: &[Option<f64>]| errors.iter().filter(|error| error.is_none()).count();
    let interval = (pairs.len() >= LEAST)
        .then(|| {
            let squares = pairs.iter().map(|(a, b)| (a - b - gain).powi(2));
            let error = (squares.sum::<f64>() / (n - 1.0) / n).sqrt();
            let width = StudentsT::new(0.0, 1.0, n - 1.0).ok()?.inverse_cdf(0.975) * error;
            Some([gain - width, gain + width])
        })
        .flatten();
    let (current_failed, candidate_failed) = (failed(current), failed(candidate));
    HeldOutGate {
        passed: interval.is_some_and(|[low, _]| low > 0.0) && candidate_failed <= current_failed,
        current: version.into(),
        strikes: pairs.len(),
        current_mean: mean(|(current, _)| *current),
        candidate_mean: mean(|(_, candidate)| *candidate),
        gain,
        interval,
        current_failed,
        candidate_failed,
    }
}

impl HeldOutGate {
    /// For a person.
    pub fn sentence(&self) -> String {
        let mm = |metres: f64| metres * 1e3;
        let Some([low, high]) = self.interval else {
            return format!(
                "{} held-out strikes are too few to compare with {}: {LEAST} at the least",
                self.strikes, self.current
            );
        };
        let verdict = if self.passed {
            "better"
        } else if low > 0.0 {
            "better where it predicts, but it predicts fewer strikes"
        } else if high < 0.0 {
            "worse"
        } else {
            "no better than chance"
        };
        format!(
            "on {} held-out strikes it misses by {:.2} mm, {} by {:.2} mm: a gain of {:.2} mm, 95 % [{:.2}, {:.2}]: {verdict}",
            self.strikes,
            mm(self.candidate_mean),
            self.current,
            mm(self.current_mean),
            mm(self.gain),
            mm(low),
            mm(high)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(of: impl Fn(usize) -> f64) -> Vec<Option<f64>> {
        (0..40).map(|strike| Some(of(strike))).collect()
    }

    /// Strikes that differ by far more than models do.
    fn hard(strike: usize) -> f64 {
        0.001 * (strike % 10) as f64
    }

    #[test]
    fn a_small_gain_on_every_strike_passes_and_chance_does_not() {
        let current = errors(|strike| 0.002 + hard(strike));
        let better = errors(|strike| 0.0018 + hard(strike) + 0.0001 * (strike % 3) as f64);
        let beats = compare("v0001", &current, &better);
        assert!(beats.passed, "{beats:?}");
        assert!(beats.sentence().ends_with("better"), "{}", beats.sentence());
        let worse = compare("v0001", &better, &current);
        assert!(!worse.passed && worse.sentence().ends_with("worse"));
        // Better on the mean, by chance: half of the strikes gain, half lose.
        let chance = errors(|strike| {
            let sign = if strike % 2 == 0 { -1.1 } else { 1.0 };
            0.002 + hard(strike) + 0.001 * sign
        });
        let beats = compare("v0001", &current, &chance);
        assert!(beats.gain > 0.0 && !beats.passed, "{beats:?}");
        let same = compare("v0001", &current, &current);
        assert!(!same.passed, "{same:?}");
    }

    #[test]
    fn few_strikes_and_strikes_that_are_not_predicted_do_not_pass() {
        let (current, better) = (
            errors(|_| 0.01),
            errors(|strike| 0.001 + 0.1 * hard(strike)),
        );
        let few = compare("v0001", &current[..LEAST - 1], &better[..LEAST - 1]);
        assert!(!few.passed && few.interval.is_none());
        assert!(few.sentence().contains("too few"));
        let mut failing = better.clone();
        failing[3] = None;
        let beats = compare("v0001", &current, &failing);
        assert!(!beats.passed && beats.candidate_failed == 1);
        assert!(beats.sentence().contains("predicts fewer"));
        let none = compare("v0001", &[], &[]);
        assert!(!none.passed && none.gain == 0.0);
    }
}
