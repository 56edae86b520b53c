//! A sweep over end points: each effect is fitted to the stops alone, and the least BIC names.

use nalgebra::DMatrix;

use super::endpoints::Calibration;
use super::fits::{BASE, Candidate, Fits, Fitted, STEP};

/// Probability by chance below which a sweep names: carom's own.
const ALARM: f64 = 0.01;

/// Where a sweep of each effect begins, a line a start; it fits all parameters that are listed.
const SWEPT: &str = "\
viscous_drag: rate 0.2
quadratic_drag: coefficient 0.2
speed_weakening_friction: rise 0.2, speed 0.2
speed_weakening_friction: rise 0.2, speed 0.5
anisotropic_friction: contrast 0.05, direction 0.0
anisotropic_friction: contrast 0.05, direction 0.8
anisotropic_friction: contrast 0.05, direction -0.8
friction_patch: center_x 0.45, center_y -0.08, radius 0.08, change 0.1
friction_patch: center_x 0.45, center_y 0.08, radius 0.08, change 0.1
friction_patch: center_x 0.55, center_y -0.08, radius 0.08, change 0.1
friction_patch: center_x 0.55, center_y 0.08, radius 0.08, change 0.1
friction_drift: rate 0.05
table_tilt: tilt_x 0.001, tilt_y 0.001
table_bowl: curvature 0.02, center_x 0.45, center_y 0.0
table_bowl: curvature -0.02, center_x 0.45, center_y 0.0
striker_speed_error: offset -0.02
striker_speed_error: offset 0.0, cap 0.8
striker_angle_bias: bias 0.01
speed_dependent_restitution: slope 0.1
off_centre_contact: offset 0.001
camera_rotation: angle 0.01
camera_distortion: k1 0.05";

/// The starts of [`SWEPT`].
fn listed() -> impl Iterator<Item = Candidate> {
    SWEPT.lines().map(|line| {
        let value = |entry: &str| {
            let (name, value) = entry.split_once(' ')?;
            Some((name.to_owned(), value.parse().ok()?))
        };
        let (name, values) = line.split_once(": ").expect("a name and values");
        let parameters: Option<Vec<_>> = values.split(", ").map(value).collect();
        Candidate {
            name: name.into(),
            parameters: parameters.expect("a parameter and a number each"),
        }
    })
}

impl Fits<'_> {
    /// The effect that BIC prefers over end points, where its gain is more than chance makes: calibrated at 1 % by a parametric
    /// bootstrap of the fitted null, choice included, as carom's alarm is.
    pub(super) fn swept(&self, by_session: &[Candidate], seed: u64) -> Option<String> {
        let rows = 2.0 * self.strikes.len() as f64;
        let bic = |fitted: &Fitted, freed: usize| {
            rows * (fitted.square / rows).ln() + freed as f64 * rows.ln()
        };
        let null = Candidate {
            name: String::new(),
            parameters: Vec::new(),
        };
        let base = self.fit(&null, false, false)?;
        let candidates: Vec<Candidate> = listed().chain(by_session.iter().cloned()).collect();
        if self.calibration(&null, &base, &candidates)?.p_value(seed) >= ALARM {
            return None;
        }
        let mut best: Option<(f64, &str)> = None;
        for candidate in &candidates {
            let Some(fitted) = self.fit(candidate, false, false) else {
                continue;
            };
            let found = bic(&fitted, 2 + candidate.parameters.len());
            if best.is_none_or(|(least, _)| found < least) {
                best = Some((found, &candidate.name));
            }
        }
        best.map(|(_, name)| name.to_string())
    }

    /// The end points' slopes at the fitted null, by friction and restitution and by each candidate about its start.
    fn calibration(
        &self,
        null: &Candidate,
        base: &Fitted,
        candidates: &[Candidate],
    ) -> Option<Calibration> {
        let residual = self.residuals(null, &base.values, false)?;
        let slope = |candidate: &Candidate, values: &[f64], at: usize, step: f64| {
            let mut beside = values.to_vec();
            beside[at] += step;
            let there = self.residuals(candidate, &beside, false)?;
            Some((there - self.residuals(candidate, values, false)?) / step)
        };
        let nuisances = [0, 1].map(|at| slope(null, &base.values, at, STEP[at]));
        let [Some(by_friction), Some(by_restitution)] = nuisances else {
            return None;
        };
        let mut directions = Vec::new();
        for candidate in candidates {
            let mut values = base.values.clone();
            values.extend(candidate.parameters.iter().map(|(_, value)| *value));
            let Some(there) = self.residuals(candidate, &values, false) else {
                continue;
            };
            let mut columns = vec![there - &residual];
            for (i, (_, _, scale)) in candidate.ranges().iter().enumerate() {
                columns.extend(slope(candidate, &values, BASE + i, 0.05 * scale));
            }
            directions.push((candidate.parameters.len(), DMatrix::from_columns(&columns)));
        }
        let strikes = self.strikes.iter();
        let paths = strikes.map(|(strike, _)| strike.stop - strike.initial);
        Some(Calibration::new(
            residual,
            DMatrix::from_columns(&[by_friction, by_restitution]),
            &directions,
            paths.collect(),
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_start_names_parameters_that_the_effect_has() {
        for candidate in listed() {
            let has = candidate.ranges().len();
            assert_eq!(has, candidate.parameters.len(), "{}", candidate.name);
        }
    }
}
