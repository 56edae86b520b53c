//! Drift: is the table where a version has it, or did friction, launch or heading change?

use judge::{Model, Observe};
use serde::{Deserialize, Serialize};
use stage::Run;
use statrs::distribution::{ContinuousCDF, StudentsT};
use store::Artifact;
use values::Strike;
use world::{Session, Shift, Varies, World};

use crate::Error;

/// Fewer strikes show no change: one or two of them may be bad.
pub const LEAST: usize = 5;
/// Chance calls a table that is as it was changed once in so many tests, over its three quantities.
const CHANCE: f64 = 1e-3;
/// Steps to where strikes have the table: what the last one leaves is of the third order.
const STEPS: usize = 2;

/// What new strikes show of a table beside a version's default model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    strikes: usize,
    /// Friction, gain and heading.
    quantities: Vec<Quantity>,
    /// Whether chance gives any of them less often than [`CHANCE`], sessions differing as the version holds.
    beyond_chance: bool,
}

/// One quantity beside the version's own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Quantity {
    name: String,
    /// Mean over the strikes: ln of the factor on friction or launch speed, or heading in rad.
    by: f64,
    /// Its standard error, of which a session's usual difference is part.
    error: f64,
    /// Two-sided p-value by Student's t.
    p: f64,
}

impl Drift {
    /// Signed means of each strike's own friction, gain and heading, by Student's t with the strikes' own scatter; none of too few.
    pub fn of(varies: &Varies, seen: &Session) -> Option<Self> {
        let shown: Vec<[f64; 3]> = seen
            .0
            .iter()
            .filter_map(|(_, seen)| varies.shown_by(seen))
            .collect();
        if shown.len() < LEAST {
            return None;
        }
        let usual = varies.between.next();
        let quantities: Vec<Quantity> = Shift::NAMES
            .iter()
            .enumerate()
            .map(|(i, name)| {
                let between = usual[i].powi(2) + varies.certainty[i][i];
                let values: Vec<f64> = shown.iter().map(|shift| shift[i]).collect();
                quantity(name, &values, between, varies.between.freedom())
            })
            .collect();
        let least = quantities.iter().map(|q| q.p).fold(1.0, f64::min);
        Some(Self {
            strikes: shown.len(),
            beyond_chance: least < CHANCE / quantities.len() as f64,
            quantities,
        })
    }

    /// Whether the table changed.
    pub fn is_beyond_chance(&self) -> bool {
        self.beyond_chance
    }

    pub fn sentence(&self) -> String {
        let [friction, gain, heading] = [0, 1, 2].map(|i| self.quantities[i].by);
        let shift = Shift {
            friction,
            gain,
            heading,
        };
        let level = CHANCE / self.quantities.len() as f64;
        let changed: Vec<&str> = self
            .quantities
            .iter()
            .filter(|quantity| quantity.p < level)
            .map(|quantity| match quantity.name.as_str() {
                "gain" => "launch",
                "heading" => "heading or camera",
                name => name,
            })
            .collect();
        let verdict = if changed.is_empty() {
            "no change beyond chance".into()
        } else {
            format!("changed beyond chance: {}", changed.join(", "))
        };
        format!("{} new strikes show {shift}: {verdict}", self.strikes)
    }
}

fn quantity(name: &str, values: &[f64], between: f64, freedom: f64) -> Quantity {
    let n = values.len() as f64;
    let by = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - by).powi(2)).sum();
    let within = (squares / (n - 1.0) / n).max(1e-18);
    let variance = within + between;
    // Welch and Satterthwaite's degrees of freedom.
    let freedom = variance.powi(2) / (within.powi(2) / (n - 1.0) + between.powi(2) / freedom);
    let error = variance.sqrt();
    let student = StudentsT::new(0.0, 1.0, freedom.max(1.0));
    let p = student.map_or(1.0, |student| 2.0 * student.sf((by / error).abs()));
    Quantity {
        name: name.into(),
        by,
        error,
        p,
    }
}

/// What strikes show of the table beside a version's default model; none of too few.
pub fn drift(run: &Run, artifact: &Artifact, strikes: &[Strike]) -> Result<Option<Drift>, Error> {
    let seen = observed(run, artifact, strikes)?;
    Ok(Drift::of(&varies(artifact), &seen))
}

/// How the table varies beside a version's default model.
pub fn varies(artifact: &Artifact) -> Varies {
    let model = artifact.manifest.provenance.default_model;
    let known = artifact.manifest.provenance.varies.get(&model).cloned();
    known.unwrap_or_else(|| Varies::assumed(&default_model(artifact).world))
}

/// A model of a version; none that it does not hold.
pub fn model_of(artifact: &Artifact, name: store::Model) -> Option<Model> {
    let (world, residual) = artifact.model(name)?;
    Some(Model {
        rig: artifact.rig.clone(),
        world,
        residual: residual.cloned(),
    })
}

/// A version's default model.
pub fn default_model(artifact: &Artifact) -> Model {
    let name = artifact.manifest.provenance.default_model;
    // Loading has checked that it is there.
    model_of(artifact, name)
        .unwrap_or_else(|| Model::of_world(&artifact.rig, &artifact.sysid.world))
}

/// What strikes show beside a version's default model, those that show a free slide.
fn observed(run: &Run, artifact: &Artifact, strikes: &[Strike]) -> Result<Session, Error> {
    observed_on(run, artifact, Shift::default(), strikes)
}

/// A strike beside a model on a table that differs so from its own.
fn observed_on(
    run: &Run,
    artifact: &Artifact,
    shift: Shift,
    strikes: &[Strike],
) -> Result<Session, Error> {
    let mut model = default_model(artifact);
    model.world = moved(&model.world, shift);
    let seen = run.items(&Observe, &model, strikes)?;
    let orders = strikes.iter().map(|strike| strike.conditions.order);
    let seen = orders.zip(seen);
    Ok(Session(
        seen.filter_map(|(order, seen)| Some((order, seen?)))
            .collect(),
    ))
}

/// Where strikes have the table.
pub struct Fitted {
    /// How it differs from the version's own.
    pub shift: Shift,
    /// Covariance of that, row by row.
    pub certainty: [[f64; 3]; 3],
    /// Where slopes were taken, as near as makes no difference.
    pub about: Shift,
    /// What the strikes show beside the version's model there.
    pub seen: Session,
}

/// Where strikes have the table beside a version's default model: slopes are taken there, for on a table that changed by a tenth they are
/// others than on the version's own. None of too few strikes.
pub fn fitted(run: &Run, artifact: &Artifact, strikes: &[Strike]) -> Result<Option<Fitted>, Error> {
    let known = varies(artifact);
    let mut fitted: Option<Fitted> = None;
    for _ in 0..STEPS {
        let about = fitted.map_or(Shift::default(), |fitted| fitted.shift);
        let seen = observed_on(run, artifact, about, strikes)?;
        let Some((step, certainty)) = known.fit(&seen) else {
            return Ok(None);
        };
        fitted = Some(Fitted {
            shift: about.and(step),
            certainty,
            about,
            seen,
        });
    }
    Ok(fitted)
}

/// The place of the first of these strikes that was made on another table than those before it; 0 where they show one table only.
pub fn step(run: &Run, artifact: &Artifact, strikes: &[Strike]) -> Result<usize, Error> {
    let seen = observed(run, artifact, strikes)?;
    let place = varies(artifact).step(&seen);
    let order = place.map(|place| seen.0[place].0);
    let is_it = |strike: &Strike| order == Some(strike.conditions.order);
    Ok(strikes.iter().position(is_it).unwrap_or(0))
}

/// A world on a table that differs so from its own.
pub fn moved(world: &World, shift: Shift) -> World {
    World {
        shift: world.shift.and(shift),
        ..world.clone()
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};
    use world::Observation;

    use super::*;

    /// Strikes that show these shifts, in a world whose distance goes as gain squared over friction.
    fn session(shifts: &[[f64; 3]]) -> Session {
        let seen = |[friction, gain, heading]: &[f64; 3]| Observation {
            about: Shift::default(),
            away: [*gain, 2.0 * gain - friction, *heading],
            slopes: [[0.0, 1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, 1.0]],
        };
        Session(shifts.iter().map(|shift| (0.0, seen(shift))).collect())
    }

    fn assumed() -> Varies {
        Varies::assumed(&world::World::nominal())
    }

    #[test]
    fn a_table_that_is_as_it_was_is_called_changed_as_rarely_as_is_promised() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut normal = |sd: f64| Normal::new(0.0, sd).expect("a sd").sample(&mut random);
        let scatter = [0.02, 0.01, 0.006];
        for strikes in [8, 14] {
            let mut called = 0;
            let tests = 20_000;
            for _ in 0..tests {
                let shifts: Vec<[f64; 3]> =
                    (0..strikes).map(|_| scatter.map(&mut normal)).collect();
                let drift = Drift::of(&assumed(), &session(&shifts)).expect("enough");
                called += usize::from(drift.beyond_chance);
            }
            // 20 are expected at the level; five standard deviations more are too many.
            assert!(called <= 42, "{called} of {tests} with {strikes}");
        }
        let changed: Vec<[f64; 3]> = (0..10)
            .map(|_| [0.12 + normal(0.02), normal(0.01), normal(0.006)])
            .collect();
        let drift = Drift::of(&assumed(), &session(&changed)).expect("enough");
        assert!(drift.beyond_chance, "{drift:?}");
        let said = drift.sentence();
        assert!(said.ends_with("changed beyond chance: friction"), "{said}");
        assert_eq!(Drift::of(&assumed(), &session(&changed[..4])), None);
    }
}
