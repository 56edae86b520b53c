//! Fits a launch map: two Gaussian processes over commanded speed and angle, each with its own lengths, amplitude, slopes and noise.
//!
//! Each is Bayesian linear regression on the map's features ([`store::launch_map`]). Its five hyperparameters are those of the
//! greatest posterior: marginal likelihood (Rasmussen and Williams 2006, section 5.4) times log-normal priors, by Nelder and Mead's
//! method. The priors matter where strikes are few: they keep the map small and smooth until the strikes say otherwise.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use nlopt::{Algorithm, Nlopt, Target};
use store::LaunchMap;
use store::launch_map::{FEATURES, LINEAR, Parts, SmoothMap, features, spectrum};
use values::{Command, LaunchResidual};

/// Hyperparameters, all as logarithms: deviation of the smooth part, its two lengths (half widths of the commands), deviation of the
/// constant and the slopes, deviation from strike to strike.
type Hyper = [f64; 5];

/// Medians of the priors: 3 % (or 0.03 rad) of a smooth part, of slopes and of scatter, lengths of half the commands' range. No more is
/// missing than scatters, until the strikes say otherwise; the priors are wide enough for ten times that.
const MEDIANS: [f64; 5] = [0.03, 1.0, 1.0, 0.03, 0.03];
/// Standard deviations of their logarithms.
const WIDTHS: [f64; 5] = [1.0, 0.7, 0.7, 1.0, 1.0];
/// Values that are tried: shorter lengths than the least the features cannot show.
const LOWS: [f64; 5] = [1e-4, 0.35, 0.35, 1e-4, 1e-4];
const HIGHS: [f64; 5] = [2.0, 8.0, 8.0, 2.0, 1.0];
/// Where the first fit starts: smooth and small, or bent and large.
const STARTS: [Hyper; 2] = [[0.05, 1.5, 1.5, 0.1, 0.05], [0.3, 0.6, 0.6, 0.2, 0.1]];
/// Evaluations of the posterior from each start, and from the hyperparameters of nearly the same strikes.
const EVALUATIONS: u32 = 250;
const WARM_EVALUATIONS: u32 = 80;
/// A weight of which the strikes say so little beside its prior changes the posterior by as little: of 67 most, where the map is smooth.
const UNTOLD: f64 = 1e-8;
/// Below this half width commands hardly differ: m/s, rad.
const NARROW: f64 = 1e-3;

/// One strike to learn from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Launch {
    pub(crate) command: Command,
    pub(crate) residual: LaunchResidual,
}

/// A map, and the hyperparameters that it was fitted with: of speed and of angle.
pub(crate) struct Fitted {
    pub(crate) map: LaunchMap,
    pub(crate) hyper: [Hyper; 2],
}

/// Fits the map to these strikes, at least one; from nearby hyperparameters where there are any. None where a number is not finite.
pub(crate) fn fit_launch_map(launches: &[Launch], near: Option<[Hyper; 2]>) -> Option<Fitted> {
    let range = |of: fn(&Launch) -> f64| {
        let (low, high) = launches
            .iter()
            .map(of)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
        (0.5 * (low + high), (0.5 * (high - low)).max(NARROW))
    };
    let (speed, angle) = (
        range(|launch| launch.command.speed),
        range(|launch| launch.command.angle),
    );
    let (centre, half_width) = ([speed.0, angle.0], [speed.1, angle.1]);
    let rows: Vec<[f64; FEATURES]> = launches
        .iter()
        .map(|launch| features(centre, half_width, launch.command))
        .collect();
    let design = DMatrix::from_fn(rows.len(), FEATURES, |i, j| rows[i][j]);
    let gram = design.tr_mul(&design);
    let part = |of: fn(&LaunchResidual) -> f64, near: Option<Hyper>| {
        let targets = DVector::from_iterator(
            launches.len(),
            launches.iter().map(|launch| of(&launch.residual)),
        );
        Regression::new(&design, &gram, &targets).fit(near)
    };
    let (speed, by_speed) = part(|residual| residual.speed, near.map(|near| near[0]))?;
    let (angle, by_angle) = part(|residual| residual.angle, near.map(|near| near[1]))?;
    let parts = Parts {
        centre,
        half_width,
        speed,
        angle,
    };
    let map = LaunchMap::new(parts).ok()?;
    let hyper = [by_speed, by_angle];
    Some(Fitted { map, hyper })
}

/// What the marginal likelihood needs of the strikes.
struct Regression<'g> {
    /// ΦᵀΦ, Φᵀy, yᵀy.
    gram: &'g DMatrix<f64>,
    projected: DVector<f64>,
    square: f64,
    rows: f64,
}

/// The posterior of some weights under some hyperparameters, each weight in units of its prior deviation.
struct Posterior {
    deviations: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
    weights: DVector<f64>,
    log_evidence: f64,
}

impl<'g> Regression<'g> {
    fn new(design: &DMatrix<f64>, gram: &'g DMatrix<f64>, targets: &DVector<f64>) -> Self {
        Self {
            gram,
            projected: design.tr_mul(targets),
            square: targets.norm_squared(),
            rows: targets.len() as f64,
        }
    }

    /// Variance of each weight before any strike.
    fn prior(hyper: &Hyper) -> Vec<f64> {
        let [amplitude, first, second, slope, _] = hyper.map(f64::exp);
        let mut prior = vec![slope * slope; LINEAR];
        prior.extend(spectrum(amplitude * amplitude, [first, second]));
        prior
    }

    /// Posterior of the weights of which the strikes say at least this share of what the prior says; of all where it is zero.
    fn posterior(&self, hyper: &Hyper, least: f64) -> Option<Posterior> {
        let noise = (2.0 * hyper[4]).exp();
        let prior = Self::prior(hyper);
        let says = |i: &usize| prior[*i] * self.gram[(*i, *i)] / noise >= least;
        let among: Vec<usize> = (0..FEATURES).filter(says).collect();
        let count = among.len();
        let deviations = DVector::from_iterator(count, among.iter().map(|i| prior[*i].sqrt()));
        let mut scaled = DMatrix::identity(count, count);
        for (b, j) in among.iter().enumerate() {
            // The factor is made from the lower half alone.
            for (a, i) in among.iter().enumerate().skip(b) {
                scaled[(a, b)] += deviations[a] * deviations[b] * self.gram[(*i, *j)] / noise;
            }
        }
        let factor = Cholesky::new(scaled)?;
        let projected = among.iter().map(|i| self.projected[*i]);
        let pull = DVector::from_iterator(count, projected).component_mul(&deviations) / noise;
        let weights = factor.solve(&pull);
        let root: f64 = factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
        let distance = self.square / noise - pull.dot(&weights);
        let log_evidence = -0.5 * (distance + self.rows * noise.ln()) - root;
        Some(Posterior {
            deviations,
            factor,
            weights,
            log_evidence,
        })
    }

    /// The logarithm of the hyperparameters' posterior, but for a constant; very small where there is none.
    fn log_posterior(&self, hyper: &Hyper) -> f64 {
        let surprise: f64 = (0..hyper.len())
            .map(|i| ((hyper[i] - MEDIANS[i].ln()) / WIDTHS[i]).powi(2))
            .sum();
        let evidence = self
            .posterior(hyper, UNTOLD)
            .map(|posterior| posterior.log_evidence);
        let evidence = evidence.filter(|evidence| evidence.is_finite());
        evidence.map_or(-1e12, |evidence| evidence - 0.5 * surprise)
    }

    fn climb(&self, start: Hyper, evaluations: u32) -> (Hyper, f64) {
        let objective = |x: &[f64], _: Option<&mut [f64]>, _: &mut ()| {
            self.log_posterior(&std::array::from_fn(|i| x[i]))
        };
        let mut best = start.to_vec();
        let mut optimizer = Nlopt::new(
            Algorithm::Neldermead,
            best.len(),
            objective,
            Target::Maximize,
            (),
        );
        let set = optimizer
            .set_lower_bounds(&LOWS.map(f64::ln))
            .and_then(|_| optimizer.set_upper_bounds(&HIGHS.map(f64::ln)))
            .and_then(|_| optimizer.set_initial_step(&[0.5; 5]))
            .and_then(|_| optimizer.set_ftol_abs(1e-3))
            .and_then(|_| optimizer.set_maxeval(evaluations));
        if set.is_ok() {
            // Whether it met its tolerance or ran out of evaluations, `best` is the best that it found.
            let _ = optimizer.optimize(&mut best);
        }
        let best: Hyper = std::array::from_fn(|i| best[i].clamp(LOWS[i].ln(), HIGHS[i].ln()));
        let height = self.log_posterior(&best);
        (best, height)
    }

    fn fit(&self, near: Option<Hyper>) -> Option<(SmoothMap, Hyper)> {
        let hyper = match near {
            Some(near) => self.climb(near, WARM_EVALUATIONS).0,
            None => {
                STARTS
                    .iter()
                    .map(|start| self.climb(start.map(f64::ln), EVALUATIONS))
                    .max_by(|a, b| a.1.total_cmp(&b.1))?
                    .0
            }
        };
        let posterior = self.posterior(&hyper, 0.0)?;
        let scale = &posterior.deviations;
        let inverse = posterior.factor.inverse();
        let covariance = (0..FEATURES * FEATURES)
            .map(|k| (k / FEATURES, k % FEATURES))
            .map(|(i, j)| {
                // Both halves alike, to the last bit.
                let (i, j) = (i.min(j), i.max(j));
                scale[i] * scale[j] * inverse[(i, j)]
            });
        let map = SmoothMap {
            weights: posterior
                .weights
                .component_mul(scale)
                .iter()
                .copied()
                .collect(),
            covariance: covariance.collect(),
            prior: Self::prior(&hyper),
            scatter: (2.0 * hyper[4]).exp(),
        };
        Some((map, hyper))
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    use super::*;

    /// Strikes whose launch scatters by 2 % and 0.02 rad about `truth`.
    fn launches(count: usize, seed: u64, truth: fn(Command) -> LaunchResidual) -> Vec<Launch> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let noise = Normal::new(0.0, 0.02).expect("finite");
        (0..count)
            .map(|_| {
                let command = Command::new(rng.random_range(0.4..1.6), rng.random_range(-0.6..0.6));
                let LaunchResidual { speed, angle } = truth(command);
                let residual = LaunchResidual {
                    speed: speed + noise.sample(&mut rng),
                    angle: angle + noise.sample(&mut rng),
                };
                Launch { command, residual }
            })
            .collect()
    }

    fn bent(command: Command) -> LaunchResidual {
        LaunchResidual {
            speed: -0.3 * (command.speed - 0.7).max(0.0) + 0.1 * (3.0 * command.angle).sin(),
            angle: 0.2 * command.angle - 0.1 * command.speed,
        }
    }

    fn nothing(_: Command) -> LaunchResidual {
        LaunchResidual {
            speed: 0.0,
            angle: 0.0,
        }
    }

    fn errors(map: &LaunchMap, truth: fn(Command) -> LaunchResidual) -> [f64; 2] {
        let others = launches(300, 99, truth);
        let sum = others.iter().fold([0.0; 2], |sum, launch| {
            let (offset, truth) = (map.offset(launch.command), truth(launch.command));
            [
                sum[0] + (offset.speed - truth.speed).powi(2),
                sum[1] + (offset.angle - truth.angle).powi(2),
            ]
        });
        sum.map(|sum| (sum / others.len() as f64).sqrt())
    }

    #[test]
    fn a_bent_map_is_learnt_to_a_fraction_of_the_scatter() {
        let fitted = fit_launch_map(&launches(150, 1, bent), None).expect("finite");
        let [speed, angle] = errors(&fitted.map, bent);
        assert!(speed < 0.012 && angle < 0.008, "{speed} {angle}");
        let scatter = fitted.map.parts().speed.scatter.sqrt();
        assert!((0.016..0.026).contains(&scatter), "{scatter}");
    }

    #[test]
    fn where_there_is_nothing_it_says_nearly_nothing() {
        for count in [8, 20, 60] {
            let seeds = 20;
            let sum = (0..seeds).fold([0.0; 2], |sum, seed| {
                let launches = launches(count, 100 + seed, nothing);
                let fitted = fit_launch_map(&launches, None).expect("finite");
                let [speed, angle] = errors(&fitted.map, nothing);
                [sum[0] + speed, sum[1] + angle]
            });
            // A plane through as many strikes, unshrunk, errs by √(3/n) of the scatter where they lie, and by more at the corners.
            let plane = 0.02 * (6.0 / count as f64).sqrt();
            let mean = sum.map(|sum| sum / seeds as f64);
            assert!(mean.iter().all(|mean| *mean < plane), "{count}: {mean:?}");
        }
    }

    #[test]
    fn its_deviation_for_one_more_strike_holds() {
        let fitted = fit_launch_map(&launches(40, 3, bent), None).expect("finite");
        let inside = launches(400, 4, bent)
            .iter()
            .filter(|launch| {
                let offset = fitted.map.offset(launch.command);
                (launch.residual.speed - offset.speed).abs() < 1.96 * offset.deviation[0]
            })
            .count();
        assert!((360..=398).contains(&inside), "{inside} of 400 within 95 %");
    }

    #[test]
    fn the_same_strikes_give_the_same_map_and_alike_commands_do_no_harm() {
        let strikes = launches(30, 5, bent);
        let fit = |strikes: &[Launch]| fit_launch_map(strikes, None).expect("finite").map;
        assert_eq!(fit(&strikes), fit(&strikes));
        let mut alike = strikes;
        for launch in &mut alike {
            launch.command.angle = 0.1;
        }
        let offset = fit(&alike).offset(alike[0].command);
        assert!(offset.speed.is_finite() && offset.deviation[0].is_finite());
    }
}
