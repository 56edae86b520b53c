//! The first gate between a candidate and the robot: held-out strikes.

use std::collections::BTreeMap;

use evaluate::{Candidate, Judge, Predict};
use serde::{Deserialize, Serialize};
use stage::Run;
use statrs::distribution::{ContinuousCDF, StudentsT};
use store::Artifact;
use values::{Rig, Split, Strike};

use crate::Error;

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
    /// Whether it passes: the gain is above zero at `level`, and it predicts no fewer strikes.
    pub passed: bool,
    /// How often a candidate has been compared with this version in use, this comparison included.
    #[serde(default = "once")]
    pub asked: u32,
    /// One-sided level of this comparison ([`level`]).
    #[serde(default = "first_level")]
    pub level: f64,
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

/// The chance that a version in use is ever replaced by one that is no better, over all nights.
const CHANCE: f64 = 0.025;

fn once() -> u32 {
    1
}

fn first_level() -> f64 {
    level(1)
}

/// The one-sided level of the `asked`-th comparison with the same version in use. The same held-out strikes are asked every night:
/// at a fixed level a candidate that is no better would pass some night. The levels of all comparisons sum to [`CHANCE`]
/// (Bonferroni; Σ 1/k² = π²/6), however the comparisons depend on each other.
fn level(asked: u32) -> f64 {
    let basel = std::f64::consts::PI.powi(2) / 6.0;
    CHANCE / (basel * f64::from(asked.max(1)).powi(2))
}

/// Compares the default models of both; `asked` counts the comparisons with this version in use, this one included.
pub fn compare_held_out(
    run: &Run,
    current: &Artifact,
    candidate: &Artifact,
    strikes: &[Strike],
    asked: u32,
) -> Result<HeldOutGate, Error> {
    let judges: Vec<Judge> = strikes.iter().map(Judge::from).collect();
    let errors = |artifact| unseen_errors(run, &candidate.rig, &default_model(artifact), &judges);
    let (version, current) = (&current.version, errors(current)?);
    Ok(compare(version, &current, &errors(candidate)?, asked))
}

/// One model's stop errors, in the order of the strikes, each predicted as if the model had never seen the strike's session. Where
/// sessions differ, a candidate that learnt from tonight's session would beat a version that did not, and be no better tomorrow.
fn unseen_errors(
    run: &Run,
    rig: &Rig,
    candidate: &Candidate,
    judges: &[Judge],
) -> Result<Vec<Option<f64>>, Error> {
    let mut errors = BTreeMap::new();
    for (model, judges) in evaluate::unseen(rig, candidate, judges) {
        // What a strike said of a model before is kept.
        let predicted = run.items(&Predict, &model, &judges)?;
        for (judge, predicted) in judges.into_iter().zip(predicted) {
            let error = predicted.stop.map(|stop| stop.distance(judge.stop));
            errors.insert(judge.strike_id, error);
        }
    }
    let error = |judge: &Judge| errors.get(&judge.strike_id).copied().flatten();
    Ok(judges.iter().map(error).collect())
}

fn default_model(artifact: &Artifact) -> Candidate {
    let model = artifact.manifest.provenance.default_model;
    // Loading has checked that it is there.
    let (world, residual) = artifact
        .model(model)
        .unwrap_or_else(|| (artifact.sysid.world.clone(), None));
    Candidate {
        name: model.to_string(),
        world,
        residual: residual.cloned(),
    }
}

/// Paired by strike, by Student's t: strikes differ by far more than models do.
fn compare(
    version: &str,
    current: &[Option<f64>],
    candidate: &[Option<f64>],
    asked: u32,
) -> HeldOutGate {
    let pairs: Vec<(f64, f64)> = current
        .iter()
        .zip(candidate)
        .filter_map(|(current, candidate)| Some(((*current)?, (*candidate)?)))
        .collect();
    let n = pairs.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / n.max(1.0);
    let gain = mean(|(current, candidate)| current - candidate);
    let failed = |errors: &[Option<f64>]| errors.iter().filter(|error| error.is_none()).count();
    let level = level(asked);
    let bounds = (pairs.len() >= LEAST)
        .then(|| {
            let squares = pairs.iter().map(|(a, b)| (a - b - gain).powi(2));
            let error = (squares.sum::<f64>() / (n - 1.0) / n).sqrt();
            let student = StudentsT::new(0.0, 1.0, n - 1.0).ok()?;
            let width = student.inverse_cdf(0.975) * error;
            let lowest = gain - student.inverse_cdf(1.0 - level) * error;
            Some(([gain - width, gain + width], lowest))
        })
        .flatten();
    let is_better = bounds.is_some_and(|(_, lowest)| lowest > 0.0);
    let (current_failed, candidate_failed) = (failed(current), failed(candidate));
    HeldOutGate {
        passed: is_better && candidate_failed <= current_failed,
        asked,
        level,
        current: version.into(),
        strikes: pairs.len(),
        current_mean: mean(|(current, _)| *current),
        candidate_mean: mean(|(_, candidate)| *candidate),
        gain,
        interval: bounds.map(|(interval, _)| interval),
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
        } else if low > 0.0 && self.candidate_failed > self.current_failed {
            "better where it predicts, but it predicts fewer strikes"
        } else if low > 0.0 {
            "not better beyond the chance that so many comparisons leave"
        } else if high < 0.0 {
            "worse"
        } else {
            "no better than chance"
        };
        let asked = match self.asked {
            1 => String::new(),
            asked => format!(
                " (comparison {asked} with {}: it passes at {:.2} % in place of {:.1} %)",
                self.current,
                100.0 * self.level,
                100.0 * level(1)
            ),
        };
        format!(
            "on {} held-out strikes it misses by {:.2} mm, {} by {:.2} mm: a gain of {:.2} mm, 95 % [{:.2}, {:.2}]: {verdict}{asked}",
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
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use values::{Command, Conditions, Point, Shape};
    use world::{AddedEffect, Estimate, Simulator, World};

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
        let beats = compare("v0001", &current, &better, 1);
        assert!(beats.passed, "{beats:?}");
        assert!(beats.sentence().ends_with("better"), "{}", beats.sentence());
        let worse = compare("v0001", &better, &current, 1);
        assert!(!worse.passed && worse.sentence().ends_with("worse"));
        // Better on the mean, by chance: half of the strikes gain, half lose.
        let chance = errors(|strike| {
            let sign = if strike % 2 == 0 { -1.1 } else { 1.0 };
            0.002 + hard(strike) + 0.001 * sign
        });
        let beats = compare("v0001", &current, &chance, 1);
        assert!(beats.gain > 0.0 && !beats.passed, "{beats:?}");
        let same = compare("v0001", &current, &current, 1);
        assert!(!same.passed, "{same:?}");
    }

    #[test]
    fn what_a_candidate_learnt_of_the_strikes_own_session_is_no_gain() {
        let rig = Rig::demo(Shape::Cylinder);
        let plain = World::nominal(&rig).with("friction", 0.25);
        let mut knows = plain.clone();
        knows.effects.push(AddedEffect {
            name: "friction_by_session".into(),
            parameters: [("monday", 0.2), ("tuesday", -0.2)]
                .map(|(name, value)| (name.to_string(), Estimate::fixed(value)))
                .into(),
        });
        let (initial, command) = (
            Point::new(0.3, 0.0),
            Command {
                speed: 0.8,
                angle: 0.1,
            },
        );
        let simulator = Simulator::new(&rig, &knows).expect("a world");
        let judges: Vec<Judge> = ["monday", "tuesday"]
            .into_iter()
            .map(|session| {
                let conditions = Conditions {
                    session: session.into(),
                    order: 0.0,
                    yaw: None,
                };
                let struck = simulator.worker().strike(initial, command, &conditions);
                Judge {
                    strike_id: session.into(),
                    initial,
                    stop: struck.expect("rests").stop,
                    command,
                    conditions,
                }
            })
            .collect();
        let dir = tempfile::tempdir().expect("folder");
        let options = stage::Options {
            engine: "test".into(),
            is_quiet: true,
        };
        let run = Run::open(dir.path(), options).expect("a run");
        let errors = |world: &World| {
            let candidate = Candidate {
                name: "effect".into(),
                world: world.clone(),
                residual: None,
            };
            unseen_errors(&run, &rig, &candidate, &judges).expect("predicts")
        };
        // It predicts its own sessions to the micrometre, and knows nothing of a third.
        for (knowing, plain) in errors(&knows).into_iter().zip(errors(&plain)) {
            let (knowing, plain) = (knowing.expect("simulated"), plain.expect("simulated"));
            assert!(plain > 0.02 && knowing > plain, "{knowing} {plain}");
        }
    }

    #[test]
    fn few_strikes_and_strikes_that_are_not_predicted_do_not_pass() {
        let (current, better) = (
            errors(|_| 0.01),
            errors(|strike| 0.001 + 0.1 * hard(strike)),
        );
        let few = compare("v0001", &current[..LEAST - 1], &better[..LEAST - 1], 1);
        assert!(!few.passed && few.interval.is_none());
        assert!(few.sentence().contains("too few"));
        let mut failing = better.clone();
        failing[3] = None;
        let beats = compare("v0001", &current, &failing, 1);
        assert!(!beats.passed && beats.candidate_failed == 1);
        assert!(beats.sentence().contains("predicts fewer"));
        let none = compare("v0001", &[], &[], 1);
        assert!(!none.passed && none.gain == 0.0);
    }

    /// Nights at which a candidate that is no better is compared with the version in use.
    const NIGHTS: u32 = 60;

    /// Shares of versions in use that some night replaces by a candidate that is no better: by the levels here, and by the first
    /// level every night.
    fn replaced_for_nothing(versions: u64) -> [f64; 2] {
        let mut replaced = [0_u32; 2];
        for version in 0..versions {
            let mut rng = ChaCha8Rng::seed_from_u64(version);
            let mut noise = || Some(0.005 + 0.001 * rng.random_range(-1.0..1.0));
            let mut is_replaced = [false; 2];
            for night in 1..=NIGHTS {
                let current: Vec<_> = (0..40).map(|_| noise()).collect();
                let candidate: Vec<_> = (0..40).map(|_| noise()).collect();
                for (place, asked) in [night, 1].into_iter().enumerate() {
                    is_replaced[place] |= compare("v0001", &current, &candidate, asked).passed;
                }
            }
            for (count, is_replaced) in replaced.iter_mut().zip(is_replaced) {
                *count += u32::from(is_replaced);
            }
        }
        replaced.map(|count| f64::from(count) / versions as f64)
    }

    #[test]
    fn asking_every_night_replaces_no_more_versions_by_chance_than_asking_once() {
        let [here, at_one_level] = replaced_for_nothing(400);
        // Standard error of 2.5 % of 400: 0.8 %.
        assert!(here <= CHANCE + 0.016, "{here}");
        assert!(
            at_one_level > 0.2,
            "{at_one_level}: the test could not fail"
        );
    }
}
