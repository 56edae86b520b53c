//! From evidence to a verdict, a world and its gap.

use std::collections::BTreeMap;

use values::{Point, Split, Strike};
use world::{AddedEffect, Estimate, World, effects};

use crate::{
    Diagnose, DiagnoseError, Found, Input,
    diagnosis::{Detectable, Diagnosis, Named, NextStrike, Parameter, Ranked, Verdict},
    evidence::{self, REAL},
    fit::{Field, Fitted, NINETY_FIVE},
    gap,
    model::{FRICTION, RESTITUTION, specification},
    next::next_strikes,
    screen::{Chance, Screened},
    search::{Searched, Standing, Step},
    smooth::Dependence,
    words,
};

/// A model explains a gap if it holds at least this share of the log-likelihood that it and the smooth rest gain together.
const EXPLAINS: f64 = 0.75;
/// Standard errors by which an effect must exceed what chance gains, to be found in four cases of five.
const POWER: f64 = 0.84;

/// Scatter of launches that no arm has: relative speed, angle (rad).
const WILD: (f64, f64) = (0.15, 0.15);

/// All that was found, before it is judged.
pub(crate) struct Case<'c, 'a> {
    pub(crate) stage: &'c Diagnose,
    pub(crate) input: &'c Input,
    pub(crate) field: &'c Field<'a>,
    pub(crate) null: &'c Fitted,
    pub(crate) screened: &'c [Screened],
    pub(crate) chance: &'c Chance,
    pub(crate) searched: &'c Searched,
    pub(crate) before: &'c [Dependence],
    pub(crate) after: &'c [Dependence],
    pub(crate) p_value: f64,
    /// Strikes left out, for their object does not leave the tip.
    pub(crate) pushed: usize,
    /// Strikes left out, for their object is pushed a second time.
    pub(crate) again: usize,
}

impl Case<'_, '_> {
    pub(crate) fn conclude(&self) -> Result<Found, DiagnoseError> {
        let fitted = &self.searched.fitted;
        let gained = fitted.likelihood() - self.null.likelihood();
        let left = evidence::left(self.after);
        let share = gained / (gained + left).max(1e-9);
        let verdict = if self.p_value >= REAL {
            Verdict::Consistent
        } else if self.searched.standing.is_empty() || share < EXPLAINS {
            Verdict::Unexplained
        } else {
            Verdict::Named
        };
        let world = (verdict == Verdict::Named)
            .then(|| self.world(fitted))
            .transpose()?;
        let plain = self.world(self.null)?;

        let rig = &self.input.rig;
        let all: Vec<(&Strike, bool)> = self
            .input
            .strikes
            .iter()
            .filter(|strike| !strike.is_pushed_again())
            .map(|strike| (strike, strike.split == Split::Test))
            .collect();
        let strikes: Vec<&Strike> = all.iter().map(|(strike, _)| *strike).collect();
        // The identified world, or what it became in the fit here, whichever serves the strikes that were fitted better.
        let identified = gap::stop_residuals(rig, &self.input.world, &strikes)?;
        let refitted = gap::stop_residuals(rig, &plain, &strikes)?;
        let fits = |residuals: &[Option<Point>]| {
            let fitted = all
                .iter()
                .zip(residuals)
                .filter(|((_, is_heldout), _)| !is_heldout);
            gap::rms(fitted.filter_map(|(_, r)| *r))
        };
        let before = if fits(&identified) < fits(&refitted) {
            identified
        } else {
            refitted
        };
        let after = match &world {
            Some(world) => gap::stop_residuals(rig, world, &strikes)?,
            None => before.clone(),
        };
        let judged = |residuals: &[Option<Point>]| {
            all.iter()
                .zip(residuals)
                .filter(|((_, is_heldout), _)| *is_heldout)
                .map(|(_, r)| *r)
                .collect::<Vec<_>>()
        };
        let gap = gap::gap(
            &judged(&before),
            &judged(&after),
            gap::noise_floor(self.field, fitted)?,
        );
        let named = match &world {
            Some(world) => self.named(world)?,
            None => Vec::new(),
        };
        let mut notes = Vec::new();
        if self.again > 0 {
            notes.push(format!(
                "strikes left out, for the object speeds up again after it slowed down, as if the arm went on behind it: {}",
                self.again
            ));
        }
        if self.pushed > 0 {
            notes.push(format!(
                "{} strikes were left out: in the identified world their object does not leave the tip",
                self.pushed
            ));
        }
        if verdict == Verdict::Named && left > 0.0 {
            notes.push(format!(
                "{:.0} % of the gap's evidence is left beside the effects named; the residual model carries it",
                100.0 * (1.0 - share)
            ));
        }
        let [speed, angle, ..] = self.null.estimated.spread.nuisance;
        if verdict != Verdict::Consistent && (speed > WILD.0 || angle > WILD.1) {
            notes.push(format!(
                "launches scatter by {:.0} % of speed and {:.0}° without effects, more than an arm does: look at how it delivers its blows",
                100.0 * speed,
                angle.to_degrees()
            ));
        }
        if gap.heldout_strikes < 10 {
            let judges = match gap.heldout_strikes {
                1 => "only one strike judges".into(),
                count => format!("only {count} strikes judge"),
            };
            notes.push(format!("{judges} the gap: its figures are coarse"));
        }
        Ok(Found {
            looks: gap::looks(&all, &before, &after),
            diagnosis: Diagnosis {
                summary: summary(verdict, &named, self.p_value, share),
                verdict,
                p_value: self.p_value,
                strikes: self.field.strikes.len(),
                r#where: match verdict {
                    Verdict::Consistent => Vec::new(),
                    _ => words::r#where(self.before),
                },
                effects: named,
                ranking: self.ranking(),
                gap,
                next_strikes: self.next(verdict)?,
                detectable: self.detectable(),
                notes,
            },
            world,
        })
    }

    /// The identified world with the model's values and effects, each with its interval.
    fn world(&self, fitted: &Fitted) -> Result<World, DiagnoseError> {
        let model = &fitted.model;
        let covariance = fitted.covariance().ok_or_else(|| DiagnoseError::NoFit {
            why: "its parameters cannot be told apart".into(),
        })?;
        let estimate = |place: usize| {
            let (value, error) = (
                model.values[place],
                covariance[(place, place)].max(0.0).sqrt(),
            );
            let free = &model.free[place];
            let bound = |v: f64| v.clamp(free.low, free.high);
            Estimate::with_interval(
                value,
                bound(value - NINETY_FIVE * error),
                bound(value + NINETY_FIVE * error),
            )
        };
        let mut world = self.input.world.clone();
        let spread = &fitted.estimated.spread;
        world.scatter.speed = spread.nuisance[0];
        world.scatter.angle = spread.nuisance[1];
        world.scatter.camera = spread.camera;
        world
            .parameters
            .insert("friction".into(), estimate(FRICTION));
        world
            .parameters
            .insert("restitution".into(), estimate(RESTITUTION));
        for (place, part) in model.fitted_parts(&model.values).iter().enumerate() {
            let mut parameters: BTreeMap<String, Estimate> = part
                .parameters
                .iter()
                .map(|(name, value)| (name.clone(), Estimate::fixed(*value)))
                .collect();
            for (i, free) in model.free.iter().enumerate() {
                if let Some((_, name)) = free.of.as_ref().filter(|(of, _)| *of == place) {
                    parameters.insert(name.clone(), estimate(i));
                }
            }
            world.effects.push(AddedEffect {
                name: part.name.into(),
                parameters,
            });
        }
        world.check()?;
        Ok(world)
    }

    fn named(&self, world: &World) -> Result<Vec<Named>, DiagnoseError> {
        world
            .effects
            .iter()
            .zip(&self.searched.standing)
            .map(|(added, standing)| {
                Ok(Named {
                    name: added.name.clone(),
                    parameters: added
                        .parameters
                        .iter()
                        .map(|(name, e)| {
                            let unit = specification(standing.name, name).unit.to_string();
                            let parameter = Parameter {
                                value: e.value,
                                low: e.low.unwrap_or(e.value),
                                high: e.high.unwrap_or(e.value),
                                unit,
                            };
                            (name.clone(), parameter)
                        })
                        .collect(),
                    statement: effects::statement(added)?,
                    evidence: standing.evidence,
                    equivalent: standing.equivalent.iter().map(|n| n.to_string()).collect(),
                    rivals: standing
                        .rivals
                        .iter()
                        .map(|rival| Ranked {
                            name: rival.name.into(),
                            evidence: rival.evidence,
                        })
                        .collect(),
                })
            })
            .collect()
    }

    fn ranking(&self) -> Vec<Ranked> {
        let mut ranking: Vec<Ranked> = self
            .screened
            .iter()
            .map(|s| Ranked {
                name: s.name.into(),
                evidence: s.gain() - self.chance[s.name],
            })
            .collect();
        ranking.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        ranking
    }

    fn detectable(&self) -> Vec<Detectable> {
        self.screened
            .iter()
            .filter(|s| s.strength.1 > 0.0)
            .map(|s| Detectable {
                name: s.name.into(),
                parameter: s.strength.0.clone(),
                least: s.strength.1 * ((2.0 * self.chance[s.name]).sqrt() + POWER),
                unit: specification(s.name, &s.strength.0).unit.into(),
            })
            .collect()
    }

    /// Strikes that separate the effect that stands least firmly from its rival.
    fn next(&self, verdict: Verdict) -> Result<Vec<NextStrike>, DiagnoseError> {
        if verdict == Verdict::Consistent || self.stage.next_strikes == 0 {
            return Ok(Vec::new());
        }
        let margin = |s: &&Standing| {
            let rival = s.rivals.first();
            rival.map_or(f64::INFINITY, |rival| s.evidence - rival.evidence)
        };
        let closest = self
            .searched
            .standing
            .iter()
            .min_by(|a, b| margin(a).total_cmp(&margin(b)));
        let Some(standing) = closest.filter(|s| !s.rivals.is_empty()) else {
            return Ok(Vec::new());
        };
        // All that could stand in its place, or else who comes nearest.
        let rivals: Vec<&Step> = standing
            .rivals
            .iter()
            .enumerate()
            .filter(|(i, rival)| *i == 0 || standing.equivalent.contains(&rival.name))
            .map(|(_, rival)| rival)
            .collect();
        let names: Vec<&str> = rivals.iter().map(|rival| rival.name).collect();
        let why = format!("{} or {}", standing.name, names.join(" or "));
        let fitted: Vec<&Fitted> = rivals.iter().map(|rival| &rival.fitted).collect();
        Ok(next_strikes(
            &self.input.rig,
            &self.input.world,
            &self.searched.fitted,
            &fitted,
            &self.field.strikes,
            &why,
            self.stage,
        )?)
    }
}

fn summary(verdict: Verdict, named: &[Named], p_value: f64, share: f64) -> String {
    match verdict {
        Verdict::Consistent => format!(
            "no gap beyond noise (p = {p_value:.2}); see `detectable` for the least that would have shown"
        ),
        Verdict::Unexplained => {
            "a real gap that no candidate explains; see `where` for what it depends on".into()
        }
        Verdict::Named => format!(
            "{}; this holds {:.0} % of the gap's evidence",
            named
                .iter()
                .map(|n| n.statement.as_str())
                .collect::<Vec<_>>()
                .join(", and "),
            100.0 * share
        ),
    }
}
