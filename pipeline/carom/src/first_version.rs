//! The gate that a version passes where none is in use that it could be compared with: enough strikes are held out to judge it, they are
//! predicted better than by the plainest means, intervals say something, and the latest strikes are of the table that the others are of.

use diagnose::Diagnosis;
use judge::{Candidate, HeldOut, Model, stop_errors};
use serde::{Deserialize, Serialize};
use stage::Run;
use sysid::Fit;
use values::{Point, Split, StopErrors, Strike};
use world::World;

use crate::Error;
use crate::growth::latest;

/// Least number of held-out strikes that judge.
const LEAST: usize = 8;
/// Number of strikes of which as many are held out in 99 of 100 deals, as 19 % are ([`Split`]); of 60 in nine of ten.
const ENOUGH: usize = 80;
/// Number of further strikes of which one more is held out, on average.
const FOR_ONE: usize = 5;
/// A model that comes this near to the noise floor is not refused for being no better than a plain prediction that does so, too: strikes
/// of one command are predicted by their mean.
const NEAR_FLOOR: f64 = 1.5;
const NEAR_PLAIN: f64 = 1.25;
/// Standard errors by which a few held-out strikes may lie above the floor by chance, and by which a model may miss them farther than another.
const ABOVE_FLOOR: f64 = 2.5;
const BESIDE: f64 = 2.0;
/// A model that misses by more than this part of how far objects slide, and by more than so many times what repeats scatter by, lacks what decides.
const OF_SLIDE: f64 = 0.1;
const FLOORS: f64 = 3.0;

/// Part of a parameter's range within which a value is as good as the greatest.
const AT_END: f64 = 0.01;

/// What the gate found. Stop errors are means in m over the strikes that every model predicts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FirstVersion {
    pub passed: bool,
    pub strikes: usize,
    /// Strikes that judge: those that fitted nothing; where they are fewer than eight, those of [`Split::Validation`], too, which identification
    /// did not look at, and effects did.
    pub held_out: usize,
    /// How many of these are of [`Split::Validation`], which the table of stop errors leaves out.
    #[serde(default)]
    pub validation: usize,
    /// The model that would be used.
    pub model: String,
    /// Stop error of that model, in m; none where nothing was held out.
    pub error: Option<f64>,
    /// Stop error, in m, of the plainest prediction from the strikes that learn: the mean displacement by speed and angle.
    pub plain: Option<f64>,
    pub nominal: Option<f64>,
    /// What repeats of one command scatter by, or the others where some stop far from where these do.
    pub floor: Option<f64>,
    /// How far objects slide.
    pub slide: Option<f64>,
    /// Standard errors, in m: of the model's stop error, and of how much farther it misses than the plainest prediction and than the nominal world.
    #[serde(default)]
    pub standard_errors: [f64; 3],
    /// Parameters of the world without a finite interval.
    pub unbounded: Vec<String>,
    /// Friction or restitution, where it is the greatest that is believed of anything.
    #[serde(default)]
    pub greatest: Vec<String>,
    /// Restitution, where it is the least: a table may have no friction.
    #[serde(default)]
    pub least: Vec<String>,
    /// What is said of strikes that stop far from where the others do, where they are the latest.
    #[serde(default)]
    pub another_now: Option<String>,
}

/// Judges the model that a version would be used with, by the latest strikes that are held out.
pub fn judge(
    run: &Run,
    strikes: &[Strike],
    fit: &Fit,
    diagnosis: Option<&Diagnosis>,
    floor: Option<StopErrors>,
    candidate: &Candidate,
) -> Result<FirstVersion, Error> {
    let part = |split| strikes.iter().filter(move |strike| strike.split == split);
    let mut held_out: Vec<&Strike> = part(Split::Test).collect();
    if held_out.len() < LEAST {
        held_out.extend(part(Split::Validation));
    }
    let held_out: Vec<&Strike> = latest(held_out);
    let judges: Vec<HeldOut> = held_out.iter().copied().map(HeldOut::from).collect();
    let rig = &candidate.model.rig;
    let by_nominal = stop_errors(run, &Model::of_world(rig, &World::nominal()), &judges)?;
    let by_model = stop_errors(run, &candidate.model, &judges)?;
    let plain = Plain::of(strikes.iter().filter(|s| s.split == Split::Train));
    let mut misses: Vec<[f64; 4]> = Vec::new();
    let mut validation = 0;
    for (i, strike) in held_out.iter().enumerate() {
        if let (Some(model), Some(nominal)) = (by_model[i], by_nominal[i]) {
            let plain = plain.stop(strike).distance(strike.stop);
            misses.push([model, plain, nominal, strike.path().norm()]);
            validation += usize::from(strike.split == Split::Validation);
        }
    }
    let count = misses.len();
    let mean = |of: &dyn Fn(&[f64; 4]) -> f64| misses.iter().map(of).sum::<f64>() / count as f64;
    let standard_error = |of: &dyn Fn(&[f64; 4]) -> f64| {
        let middle = mean(of);
        (mean(&|row| (of(row) - middle).powi(2)) / (count - 1) as f64).sqrt()
    };
    let [error, plain, nominal, slide] =
        [0, 1, 2, 3].map(|of| (count > 0).then(|| mean(&|row| row[of])));
    let standard_errors = match count {
        0 | 1 => [0.0; 3],
        _ => [
            standard_error(&|row| row[0]),
            standard_error(&|row| row[0] - row[1]),
            standard_error(&|row| row[0] - row[2]),
        ],
    };
    let is_unbounded = |name: &&String| {
        let estimate = fit.world.parameters.get(*name);
        let ends = estimate.and_then(|estimate| estimate.low.zip(estimate.high));
        !ends.is_some_and(|(low, high)| low.is_finite() && high.is_finite())
    };
    // Where a parameter lies in its range: 0 is the least, 1 the greatest that is believed.
    let place = |name: &String| {
        let of = world::parameter(name).ok()?;
        let value = fit.world.parameters.get(name)?.value;
        Some((value - of.low) / (of.high - of.low))
    };
    let is_greatest = |name: &&String| {
        let decides = ["friction", "restitution"].contains(&name.as_str());
        decides && place(name).is_some_and(|place| place > 1.0 - AT_END)
    };
    let is_least =
        |name: &&String| *name == "restitution" && place(name).is_some_and(|place| place < AT_END);
    let strays = diagnosis.and_then(|diagnosis| diagnosis.strays.as_ref()?.finding());
    Ok(FirstVersion {
        passed: false,
        strikes: strikes.len(),
        held_out: count,
        validation,
        model: candidate.name.clone(),
        error,
        plain,
        nominal,
        floor: floor.map(|floor| strays.map_or(floor.mean, |told| floor.mean.min(told.others))),
        slide,
        standard_errors,
        unbounded: fit.freed.iter().filter(is_unbounded).cloned().collect(),
        greatest: fit.freed.iter().filter(is_greatest).cloned().collect(),
        least: fit.freed.iter().filter(is_least).cloned().collect(),
        another_now: diagnosis
            .filter(|diagnosis| diagnosis.is_another_now)
            .and_then(|diagnosis| Some(diagnosis.strays.as_ref()?.to_string())),
    }
    .decided())
}

impl FirstVersion {
    fn decided(mut self) -> Self {
        self.passed = self.doubts().is_empty();
        self
    }

    /// Whether there are yet too few strikes to judge by.
    fn is_unjudged(&self) -> bool {
        self.held_out < LEAST || self.held_out == self.validation
    }

    /// Whether more strikes of the same kind may mend what it does not pass for: nobody need look yet.
    pub fn is_gathering(&self) -> bool {
        self.is_unjudged() || self.strikes < ENOUGH
    }

    /// Why more strikes judge here than in the table of stop errors; empty where as many do.
    fn of_validation(&self) -> String {
        match self.validation {
            0 => String::new(),
            n => format!(
                " ({n} of them are those that effects were chosen by, as fewer than {LEAST} others are held out: the table of stop errors is of the others alone)"
            ),
        }
    }

    /// Why it does not pass, and what to log next; empty where it passes.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        if self.is_unjudged() {
            let more = (FOR_ONE * LEAST.saturating_sub(self.held_out).max(1))
                .max(ENOUGH.saturating_sub(self.strikes));
            doubts.push(format!(
                "{} of {} strikes are held out to judge by{}, and a first version is judged by {LEAST} at the least, of which one or more took no part in anything: record {more} more, at other \
                 speeds, angles and places (one in five is held out; of {ENOUGH} strikes it is {LEAST} or more in 99 of 100 runs)",
                self.held_out,
                self.strikes,
                self.of_validation()
            ));
            return doubts;
        }
        let [of_error, beside_plain, beside_nominal] = self.standard_errors;
        let near_floor = |error: f64| {
            let is_near =
                |floor| error <= NEAR_FLOOR * floor || error - ABOVE_FLOOR * of_error <= floor;
            self.floor.is_some_and(is_near)
        };
        for (name, other, beside) in [
            (
                "the mean displacement by speed and angle",
                self.plain,
                beside_plain,
            ),
            ("the nominal world", self.nominal, beside_nominal),
        ] {
            let (Some(error), Some(other)) = (self.error, other) else {
                continue;
            };
            let is_tie = error <= NEAR_PLAIN * other || error - other <= BESIDE * beside;
            let is_alike = is_tie && near_floor(error);
            if error >= other && !is_alike {
                doubts.push(format!(
                    "`{}` misses {} held-out stops{} by {:.2} cm, and {name} by {:.2} cm: record strikes at more speeds, angles and places, and see `carom check` and the report for what the world lacks",
                    self.model,
                    self.held_out,
                    self.of_validation(),
                    error * 100.0,
                    other * 100.0
                ));
            }
        }
        if let (Some(error), Some(floor), Some(slide)) = (self.error, self.floor, self.slide) {
            let [error_cm, floor_cm, slide_cm] = [error, floor, slide].map(|length| length * 100.0);
            if error > (OF_SLIDE * slide).max(FLOORS * floor) {
                doubts.push(format!(
                    "`{}` misses {} held-out stops{} by {error_cm:.2} cm where objects slide {slide_cm:.0} cm and repeats scatter by {floor_cm:.2} cm: something great is missing or wrong; see `carom check`, and in the report what strikes depend on",
                    self.model,
                    self.held_out,
                    self.of_validation()
                ));
            }
        }
        if !self.unbounded.is_empty() {
            doubts.push(format!(
                "these strikes do not bound {}: record more, at other speeds and angles",
                self.unbounded.join(", ")
            ));
        }
        if !self.greatest.is_empty() {
            doubts.push(format!(
                "these logs ask for the greatest {} that is believed of anything: compare the object's shape and sizes in the rig file with the real \
                 one, and the units of commands and places",
                self.greatest.join(" and the greatest ")
            ));
        }
        if !self.least.is_empty() {
            doubts.push(format!(
                "these logs ask for the least {} that is believed of anything: objects leave far slower than a tip of the commanded speed strikes them; \
                 compare the units of commands and places (is the command in m/s?)",
                self.least.join(" and the least ")
            ));
        }
        if let Some(told) = &self.another_now {
            doubts.push(format!(
                "the latest strikes are of another table, object, tip or camera than this version would be of: {told}"
            ));
        }
        doubts
    }

    pub fn sentences(&self) -> Vec<String> {
        let doubts = self.doubts();
        if !doubts.is_empty() {
            return doubts;
        }
        let cm =
            |error: Option<f64>| error.map_or("unknown".into(), |e| format!("{:.2} cm", e * 100.0));
        vec![format!(
            "`{}` misses {} held-out stops{} by {}, the mean displacement by speed and angle by {}, the nominal world by {}",
            self.model,
            self.held_out,
            self.of_validation(),
            cm(self.error),
            cm(self.plain),
            cm(self.nominal)
        )]
    }
}

/// Displacement along and across the commanded direction, each a plane over speed and angle.
struct Plain([[f64; 3]; 2]);

impl Plain {
    fn of<'a>(strikes: impl Iterator<Item = &'a Strike>) -> Self {
        let rows: Vec<([f64; 3], Point)> = strikes
            .map(|s| (terms(s), s.path().rotated(-s.command.angle)))
            .collect();
        let fit = |of: fn(Point) -> f64| {
            let pairs: Vec<([f64; 3], f64)> = rows.iter().map(|(x, y)| (*x, of(*y))).collect();
            plane(&pairs)
        };
        Self([fit(|p| p.x), fit(|p| p.y)])
    }

    fn stop(&self, strike: &Strike) -> Point {
        let terms = terms(strike);
        let [along, across] = self
            .0
            .map(|plane| plane.iter().zip(&terms).map(|(a, x)| a * x).sum::<f64>());
        strike.initial + Point::new(along, across).rotated(strike.command.angle)
    }
}

fn terms(strike: &Strike) -> [f64; 3] {
    [1.0, strike.command.speed, strike.command.angle]
}

/// Least squares; what does not vary counts for nothing (a small ridge).
fn plane(rows: &[([f64; 3], f64)]) -> [f64; 3] {
    const RIDGE: f64 = 1e-6;
    let mut a = [[0.0; 4]; 3];
    for (x, y) in rows {
        for i in 0..3 {
            for j in 0..3 {
                a[i][j] += x[i] * x[j];
            }
            a[i][3] += x[i] * y;
        }
    }
    let scale = RIDGE * rows.len().max(1) as f64;
    for (i, row) in a.iter_mut().enumerate() {
        row[i] += scale;
    }
    // Positive definite: elimination needs no pivots.
    for i in 0..3 {
        for j in 0..3 {
            if i != j {
                let factor = a[j][i] / a[i][i];
                let pivot = a[i];
                for (cell, above) in a[j].iter_mut().zip(pivot) {
                    *cell -= factor * above;
                }
            }
        }
    }
    [0, 1, 2].map(|i| a[i][3] / a[i][i])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gate(held_out: usize, error: f64, plain: f64, nominal: f64) -> FirstVersion {
        FirstVersion {
            passed: false,
            strikes: 5 * held_out,
            held_out,
            validation: 0,
            model: "sysid".into(),
            error: Some(error),
            plain: Some(plain),
            nominal: Some(nominal),
            floor: Some(0.005),
            slide: Some(0.4),
            standard_errors: [0.0; 3],
            unbounded: Vec::new(),
            greatest: Vec::new(),
            least: Vec::new(),
            another_now: None,
        }
        .decided()
    }

    #[test]
    fn what_misses_by_a_great_part_of_the_slide_does_not_pass() {
        assert!(gate(20, 0.035, 0.1, 0.1).passed);
        let lacking = gate(20, 0.045, 0.1, 0.1);
        assert!(
            lacking.doubts()[0].contains("something great"),
            "{lacking:?}"
        );
        // Repeats scatter by as much as on a real table of 60 cm.
        let noisy = FirstVersion {
            floor: Some(0.06),
            slide: Some(0.6),
            ..gate(20, 0.08, 0.2, 0.2)
        };
        assert_eq!(noisy.doubts(), Vec::<String>::new());
    }

    #[test]
    fn what_few_strikes_judge_and_what_is_no_better_than_plain_means_does_not_pass() {
        assert!(gate(8, 0.01, 0.03, 0.1).passed);
        let few = gate(7, 0.01, 0.03, 0.1);
        assert!(!few.passed);
        assert!(few.doubts()[0].contains("record 45 more"), "{few:?}");
        assert!(few.is_gathering() && !few.doubts()[0].contains("table of stop errors"));
        let mixed = FirstVersion {
            validation: 4,
            ..gate(9, 0.2, 0.03, 0.1)
        };
        let told = "misses 9 held-out stops (4 of them are those that effects were chosen by";
        assert!(mixed.doubts()[0].contains(told), "{mixed:?}");
        // Worse than plain means: forty strikes may yet teach more, a hundred should have.
        assert!(!gate(8, 0.2, 0.03, 0.1).passed && gate(8, 0.2, 0.03, 0.1).is_gathering());
        assert!(!gate(20, 0.2, 0.03, 0.1).is_gathering());
        assert!(!gate(20, 0.03, 0.025, 0.1).passed);
        assert!(!gate(20, 0.02, 0.03, 0.015).passed);
        // One command over and over: its mean is the best that there is.
        assert!(gate(20, 0.0052, 0.005, 0.1).passed);
        // The nominal world is the real one: which misses less is chance, and so is whether few strikes lie above the floor.
        let tie = |error, of_error, beside| FirstVersion {
            standard_errors: [of_error, beside, beside],
            ..gate(13, error, 0.03, 0.008)
        };
        assert_eq!(tie(0.0081, 0.0015, 0.0001).doubts(), Vec::<String>::new());
        assert!(!tie(0.0081, 0.001, 0.0001).doubts().is_empty());
        assert_eq!(tie(0.0102, 0.0025, 0.0015).doubts(), Vec::<String>::new());
        assert!(!tie(0.0102, 0.0025, 0.001).doubts().is_empty());
        let unbounded = FirstVersion {
            unbounded: vec!["friction".into()],
            ..gate(20, 0.01, 0.03, 0.1)
        };
        assert!(unbounded.doubts()[0].contains("friction"));
        let greatest = FirstVersion {
            greatest: vec!["restitution".into()],
            ..gate(20, 0.01, 0.03, 0.1)
        };
        assert!(greatest.doubts()[0].contains("the greatest restitution"));
        let least = FirstVersion {
            least: vec!["restitution".into()],
            ..gate(20, 0.01, 0.03, 0.1)
        };
        assert!(least.doubts()[0].contains("the least restitution"));
        let another_now = FirstVersion {
            another_now: Some("15 of 150 strikes".into()),
            ..gate(20, 0.01, 0.03, 0.1)
        };
        assert!(another_now.doubts()[0].ends_with("15 of 150 strikes"));
    }

    #[test]
    fn a_plane_goes_through_its_points_also_where_one_term_stands_still() {
        let rows: Vec<([f64; 3], f64)> = (0..9)
            .map(|i| ([1.0, f64::from(i) * 0.1, 0.5], 0.2 + 0.3 * f64::from(i)))
            .collect();
        let found = plane(&rows);
        for (x, y) in &rows {
            let value: f64 = found.iter().zip(x).map(|(a, x)| a * x).sum();
            assert!((value - y).abs() < 1e-3, "{value} {y}");
        }
    }
}
