//! The first gate between a candidate and the robot: held-out strikes. A candidate that knows more is put to use unless it is worse.

use judge::{HeldOut, Model, unseen_stop_errors};
use serde::{Deserialize, Serialize};
use stage::Run;
use statrs::distribution::{ContinuousCDF, StudentsT};
use store::Artifact;
use values::{Split, Strike};

use crate::Error;
use crate::score::default_model;

/// Fewer strikes than these decide nothing.
pub const LEAST: usize = 8;
/// The latest so many judge: older ones say little of tonight's table.
const MOST: usize = 60;
/// A candidate may miss by so much more, as a share of what repeats scatter by: less than anybody would see.
const MARGIN: f64 = 0.1;
/// Chance that a candidate which is worse by just the margin passes a comparison.
const LEVEL: f64 = 0.05;

/// The latest strikes since `since` (stamp in s) that none of these versions learnt from: those that none learns from, as long as the
/// seed stays, and those made after all were computed.
pub fn unseen<const N: usize>(
    strikes: &[Strike],
    since: f64,
    versions: [&Artifact; N],
) -> Vec<Strike> {
    let known = versions.map(|version| {
        let known = version.manifest.provenance.strikes;
        known.map_or(f64::INFINITY, |known| known.last)
    });
    let known = known.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let is_unseen = |strike: &&Strike| {
        strike.t_start >= since && (strike.split == Split::Test || strike.t_start > known)
    };
    let all: Vec<Strike> = strikes.iter().filter(is_unseen).cloned().collect();
    all[all.len().saturating_sub(MOST)..].to_vec()
}

/// Whether the candidate's stop errors are no greater than those of the version in use, on strikes that neither learnt from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOutGate {
    /// Whether it passes: at 95 % it is worse by less than the margin, and it predicts no fewer strikes.
    pub passed: bool,
    /// Version that it is compared with.
    pub current: String,
    /// Strikes that both predict.
    pub strikes: usize,
    /// Mean stop error of the version in use on them, in m.
    pub current_mean: f64,
    /// Mean stop error of the candidate on them, in m.
    pub candidate_mean: f64,
    /// By how much the candidate may be worse, in m.
    pub margin: f64,
    /// By how much it is worse at most, at 95 %, in m; none for too few strikes.
    pub at_most: Option<f64>,
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
    let judges: Vec<HeldOut> = strikes.iter().map(HeldOut::from).collect();
    // Where sessions differ, a candidate that learnt from tonight's session would beat a version that did not, and be no better tomorrow.
    let errors = |artifact| {
        let model = Model {
            rig: candidate.rig.clone(),
            ..default_model(artifact)
        };
        unseen_stop_errors(run, &model, &judges)
    };
    Ok(compare(
        &current.version,
        noise_floor(current),
        &errors(current)?,
        &errors(candidate)?,
    ))
}

/// What a version's repeats scatter by: mean, in m.
pub fn noise_floor(version: &Artifact) -> Option<f64> {
    let floor = version.manifest.provenance.noise_floor;
    floor.map(|floor| floor.mean)
}

/// Paired by strike, by Student's t: strikes differ by far more than models do.
pub fn compare(
    version: &str,
    floor: Option<f64>,
    current: &[Option<f64>],
    candidate: &[Option<f64>],
) -> HeldOutGate {
    let pairs: Vec<(f64, f64)> = current
        .iter()
        .zip(candidate)
        .filter_map(|(current, candidate)| Some(((*current)?, (*candidate)?)))
        .collect();
    let n = pairs.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / n.max(1.0);
    let (current_mean, candidate_mean) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let worse = candidate_mean - current_mean;
    let failed = |errors: &[Option<f64>]| errors.iter().filter(|error| error.is_none()).count();
    let margin = MARGIN * floor.unwrap_or(current_mean);
    let at_most = (pairs.len() >= LEAST)
        .then(|| {
            let squares = pairs.iter().map(|(a, b)| (b - a - worse).powi(2));
            let error = (squares.sum::<f64>() / (n - 1.0) / n).sqrt();
            let student = StudentsT::new(0.0, 1.0, n - 1.0).ok()?;
            Some(worse + student.inverse_cdf(1.0 - LEVEL) * error)
        })
        .flatten();
    let (current_failed, candidate_failed) = (failed(current), failed(candidate));
    HeldOutGate {
        passed: at_most.is_some_and(|at_most| at_most <= margin)
            && candidate_failed <= current_failed,
        current: version.into(),
        strikes: pairs.len(),
        current_mean,
        candidate_mean,
        margin,
        at_most,
        current_failed,
        candidate_failed,
    }
}

impl HeldOutGate {
    /// Whether this candidate gains more than the other beside the version in use, by more than the margin. Each has strikes of its own that
    /// judge, so that their means are not compared.
    pub fn is_better_than(&self, other: &Self) -> bool {
        let gain = |gate: &Self| gate.current_mean - gate.candidate_mean;
        gain(self) > gain(other) + self.margin
    }

    /// For a person: a line.
    pub fn sentence(&self) -> String {
        let mm = |metres: f64| metres * 1e3;
        let Some(at_most) = self.at_most else {
            return format!(
                "nothing is compared yet: {} held-out strikes, {LEAST} at the least",
                self.strikes
            );
        };
        let verdict = if self.passed {
            "not worse"
        } else if at_most <= self.margin {
            "predicts fewer strikes"
        } else {
            "perhaps worse"
        };
        format!(
            "{verdict}: {:.2} mm on {} held-out strikes, {} {:.2} mm (at most {:+.2} mm at 95 %, {:+.2} mm allowed)",
            mm(self.candidate_mean),
            self.strikes,
            self.current,
            mm(self.current_mean),
            mm(at_most),
            mm(self.margin)
        )
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    fn errors(of: impl Fn(usize) -> f64) -> Vec<Option<f64>> {
        (0..40).map(|strike| Some(of(strike))).collect()
    }

    /// Strikes that differ by far more than models do.
    fn hard(strike: usize) -> f64 {
        0.001 * (strike % 10) as f64
    }

    fn compare(current: &[Option<f64>], candidate: &[Option<f64>]) -> HeldOutGate {
        super::compare("v0001", Some(0.002), current, candidate)
    }

    #[test]
    fn what_is_as_good_or_better_passes_and_what_is_worse_does_not() {
        let current = errors(|strike| 0.002 + hard(strike));
        let same = compare(&current, &current);
        assert!(
            same.passed && (same.margin - 2e-4).abs() < 1e-12,
            "{same:?}"
        );
        let better = errors(|strike| 0.0014 + hard(strike) + 0.0001 * (strike % 3) as f64);
        assert!(compare(&current, &better).passed);
        let worse = compare(&better, &current);
        assert!(!worse.passed && worse.sentence().starts_with("perhaps worse"));
        // As good on the mean, but nobody knows: half of the strikes gain, half lose.
        let unknown = errors(|strike| {
            let sign = if strike % 2 == 0 { -1.0 } else { 1.0 };
            0.002 + hard(strike) + 0.001 * sign
        });
        let unknown = compare(&current, &unknown);
        assert!(!unknown.passed, "{unknown:?}");
        assert!(!unknown.sentence().contains('\n'));
    }

    #[test]
    fn few_strikes_and_strikes_that_are_not_predicted_do_not_pass() {
        let (current, better) = (
            errors(|_| 0.01),
            errors(|strike| 0.001 + 0.1 * hard(strike)),
        );
        let few = compare(&current[..LEAST - 1], &better[..LEAST - 1]);
        assert!(!few.passed && few.at_most.is_none());
        let mut failing = better.clone();
        failing[3] = None;
        let beats = compare(&current, &failing);
        assert!(!beats.passed && beats.candidate_failed == 1);
        assert!(beats.sentence().contains("predicts fewer"));
        let none = compare(&[], &[]);
        assert!(!none.passed && none.current_mean == 0.0);
    }

    #[test]
    fn of_two_that_pass_the_later_one_is_taken_only_where_it_gains_more_by_a_margin() {
        let current = errors(|strike| 0.01 + hard(strike));
        let gains = |by: f64| compare(&current, &errors(|strike| 0.01 - by + hard(strike)));
        assert!(gains(0.004).is_better_than(&gains(0.001)));
        assert!(!gains(0.0011).is_better_than(&gains(0.001)));
        // Judged by strikes that are harder for both.
        let harder = compare(
            &errors(|strike| 0.03 + hard(strike)),
            &errors(|strike| 0.02 + hard(strike)),
        );
        assert!(harder.is_better_than(&gains(0.004)));
    }

    /// Nights of a lab that learns a mean of six parameters, 25 strikes a night, a tenth of them held out.
    #[derive(Default)]
    struct Lab {
        nights: usize,
        /// Strikes learnt from, and the error of what was learnt, in units of what repeats scatter by.
        learnt: f64,
        error: [f64; 6],
        /// The strikes that judge: what each depends on, its scatter, its night, whether it is held out for good.
        strikes: Vec<([f64; 6], f64, usize, bool)>,
        /// What each night's sessions differ by.
        sessions: f64,
    }

    /// What a lab learnt: its error, and the nights that it learnt from.
    type Learnt = ([f64; 6], usize);

    impl Lab {
        fn night(&mut self, random: &mut ChaCha8Rng) -> Learnt {
            let mut normal = || -> f64 { StandardNormal.sample(&mut *random) };
            let session = self.sessions * normal();
            self.nights += 1;
            for strike in 0..25 {
                let is_held_out = (self.nights * 25 + strike).is_multiple_of(10);
                let at = [(); 6].map(|()| normal());
                self.strikes
                    .push((at, session + normal(), self.nights, is_held_out));
            }
            // The latest are enough to judge by.
            let old = self.strikes.len().saturating_sub(1000);
            self.strikes.drain(..old);
            // The posterior mean after 22.5 more: its error is drawn towards what the new strikes show.
            for error in &mut self.error {
                let new = normal() / 22.5f64.sqrt();
                *error = (self.learnt * *error + 22.5 * new) / (self.learnt + 22.5);
            }
            self.learnt += 22.5;
            (self.error, self.nights)
        }

        /// The gate, on the latest strikes that neither learnt from.
        fn gate(&self, candidate: Learnt, current: Learnt) -> HeldOutGate {
            let known = candidate.1.max(current.1);
            let is_unseen = |strike: &&([f64; 6], f64, usize, bool)| strike.3 || strike.2 > known;
            let unseen: Vec<_> = self.strikes.iter().filter(is_unseen).collect();
            let latest = &unseen[unseen.len().saturating_sub(MOST)..];
            let misses = |error: [f64; 6]| -> Vec<Option<f64>> {
                let miss = |(at, scatter, ..): &&([f64; 6], f64, usize, bool)| {
                    let off: f64 = at.iter().zip(error).map(|(x, e)| x * e).sum();
                    Some((off + scatter).abs())
                };
                latest.iter().map(miss).collect()
            };
            let floor = Some((2.0 / std::f64::consts::PI).sqrt());
            super::compare("v0001", floor, &misses(current.0), &misses(candidate.0))
        }
    }

    /// Mean miss of a version with this error on strikes to come, in units of what repeats scatter by.
    fn expected(error: &[f64; 6]) -> f64 {
        (1.0 + error.iter().map(|e| e * e).sum::<f64>()).sqrt()
    }

    /// Shares of nights with a version in use that is worse by more than 5 % than what it replaced, and of nights on which one that is
    /// better by more than 1 % had been held back for more than three; how many nights the version in use was behind at most.
    fn thousand_nights(seed: u64, sessions: f64) -> (f64, f64, usize) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut lab = Lab {
            sessions,
            ..Lab::default()
        };
        let (mut in_use, mut waiting): (Option<Learnt>, Option<Learnt>) = (None, None);
        let (mut replaced, mut waited) = (f64::INFINITY, 0);
        let (mut nights, mut worse, mut held_back, mut behind) = (0, 0, 0, 0);
        for _ in 0..1000 {
            let mut candidate = lab.night(&mut random);
            // One learning in fifty fails.
            if random.random::<f64>() < 0.02 {
                candidate.0[0] += 0.2 + 2.0 * random.random::<f64>();
            }
            let chosen = match in_use {
                None => Some(candidate),
                Some(current) => [Some(candidate), waiting]
                    .into_iter()
                    .flatten()
                    .filter(|learnt| learnt.1 > current.1)
                    .map(|learnt| (learnt, lab.gate(learnt, current)))
                    .filter(|(_, gate)| gate.passed)
                    .reduce(|best, one| {
                        if one.1.is_better_than(&best.1) {
                            one
                        } else {
                            best
                        }
                    })
                    .map(|(learnt, _)| learnt),
            };
            if let Some(chosen) = chosen {
                replaced = in_use.map_or(f64::INFINITY, |(error, _)| expected(&error));
                in_use = Some(chosen);
            }
            waiting = Some(candidate);
            let (error, known) = in_use.expect("published");
            let now = expected(&error);
            // Better by more than a hundredth, and not in use.
            let is_better = expected(&candidate.0) < 0.99 * now;
            waited = if is_better { waited + 1 } else { 0 };
            nights += 1;
            worse += usize::from(now > 1.05 * replaced);
            held_back += usize::from(waited > 3);
            behind = behind.max(lab.nights - known);
        }
        let share = |count: usize| count as f64 / f64::from(nights);
        (share(worse), share(held_back), behind)
    }

    #[test]
    fn a_thousand_nights_hardly_ever_use_a_worse_version_or_hold_a_better_one_back() {
        const LABS: u64 = 16;
        for sessions in [0.0, 1.0] {
            let of_labs: Vec<_> = (0..LABS)
                .map(|lab| thousand_nights(lab, sessions))
                .collect();
            let mean = |of: fn(&(f64, f64, usize)) -> f64| {
                of_labs.iter().map(of).sum::<f64>() / LABS as f64
            };
            let (worse, held_back) = (mean(|lab| lab.0), mean(|lab| lab.1));
            let behind = of_labs.iter().map(|lab| lab.2).max();
            println!(
                "sessions {sessions}: worse {worse:.4}, held back {held_back:.4}, behind at most {behind:?} nights"
            );
            assert!(worse <= 0.005, "{worse}");
            assert!(held_back <= 0.01, "{held_back}");
        }
    }
}
