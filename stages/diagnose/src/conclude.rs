//! From evidence to a verdict, a world and its gap.

use std::f64::consts::FRAC_1_SQRT_2;

use values::{Point, Sentence, Strike};
use world::{
    World,
    effects::{AddedEffect, Origin, effect},
};

use crate::{
    Diagnose, DiagnoseError, Diagnosed, Input,
    alias::{self, Alias},
    camera_drift,
    candidates::is_never_named,
    constancy,
    diagnosis::{
        Detectable, Diagnosis, Gap, GapDependence, NamedEffect, NextStrike, Noise, Parameter,
        Ranked, SmoothMap, Verdict,
    },
    evidence::PValue,
    facing::turns_launches,
    fit::Fitted,
    fitted_world::{fitted_world, scatter},
    gap,
    heldout::{self, Gains},
    model::{FRICTION, RESTITUTION, added, specification},
    next::{next_strikes, repeats},
    notes,
    question::{self, Answer, EffectsByOrder, Finding},
    score::DRAWN,
    screen::{Chance, Screened},
    search::{CandidateFit, SelectedEffect, Selection},
    sessions::is_by_session,
    words::{Cause, Dependence, Note, Purpose, Stated, Summary, WhyNot},
};

/// Standard errors beyond the chance level at which an effect is found in four cases of five.
const POWER: f64 = 0.84;

/// Ratio of stop errors to the scatter of repeats above which something else moves stops by as much as that scatter.
const GREAT: f64 = std::f64::consts::SQRT_2;
/// What is left beside names is told from this share of repeats' scatter on: it makes a tenth of it more.
const TOLD_LEFT: f64 = 0.5;

/// All findings that the verdict is drawn from.
pub(crate) struct Case<'c, 'a> {
    pub(crate) stage: &'c Diagnose,
    pub(crate) input: &'c Input,
    pub(crate) selection: &'c Selection<'a>,
    pub(crate) screened: &'c [Screened],
    pub(crate) chance: &'c Chance,
    /// Whether tracks differ from every world tried by far more than the camera's noise.
    pub(crate) is_astray: bool,
    /// What the effects gain on strikes that were left out of their fit.
    pub(crate) gains: Gains,
    /// Whether effects were found that do not pay on strikes left out of their fit, and move stops by more than repeats scatter.
    pub(crate) moves_unpaid: bool,
    pub(crate) p_value: PValue,
    /// Whether the gap is beyond chance.
    pub(crate) is_real: bool,
    /// What the question finds in the strike table beside no effect.
    pub(crate) asked: Answer,
    /// What the question still finds in the strike table beside the effects.
    pub(crate) remaining: Answer,
    /// Whether launches are those that the arm's logged state delivered.
    pub(crate) is_delivered: bool,
    /// Whether these strikes are rather those of a box that lies turned to face each of them.
    pub(crate) faces: bool,
    /// Whether nearly every object is pushed a second time, so that all were kept.
    pub(crate) are_pushed_again: bool,
    pub(crate) maps: Vec<SmoothMap>,
    /// Notes from the steps before.
    pub(crate) notes: Vec<Note>,
}

/// A verdict, with the world that comes of it.
struct Conclusion {
    verdict: Verdict,
    world: Option<World>,
    gap: Gap,
    before: Vec<Option<Point>>,
    after: Vec<Option<Point>>,
    /// What was not named, and why.
    note: Option<Note>,
    /// What stands behind a gap that no candidate explains, where that is known.
    cause: Option<Cause>,
}

impl Case<'_, '_> {
    pub(crate) fn conclude(self) -> Result<Diagnosed, DiagnoseError> {
        let strikes: Vec<&Strike> = self
            .input
            .strikes
            .iter()
            .filter(|strike| self.are_pushed_again || !strike.is_pushed_again())
            .collect();
        let mut judged = self.judge(&strikes)?;
        let named = match &judged.world {
            Some(world) => self.named(world, &strikes)?,
            None => Vec::new(),
        };
        let verdict = judged.verdict;
        let mut notes = self.notes.clone();
        match verdict {
            Verdict::Unexplained if self.faces => judged.cause = Some(Cause::Facing),
            _ if self.faces => notes.push(Note::Facing),
            _ => {}
        }
        notes.extend(judged.note.clone());
        let noise = self.noise();
        notes.extend(notes::noise(&noise, &self.selection.fitted, verdict));
        // What no prediction knows is said with the verdict: it is no scatter of repeats, and a model that is right misses by it.
        let mut beside = Vec::new();
        if verdict == Verdict::Named {
            let left = self.remaining.findings.first();
            let left = left.filter(|left| left.size > TOLD_LEFT * judged.gap.noise_floor);
            let left = left.map(|left| Note::StillDepends(left.into()));
            beside.extend(left.or_else(|| notes::not_all(&judged.gap)));
        }
        beside.extend(notes::variation(&judged.gap).map(Note::Varies));
        match verdict {
            Verdict::Named => notes.extend(self.at_ends()),
            Verdict::Unexplained => notes.push(Note::ValuesHoldTheGap),
            Verdict::Consistent if self.p_value.is_real() => notes.push(Note::ValuesHoldTheGap),
            Verdict::Consistent => {}
        }
        notes.extend(judged.world.iter().flat_map(notes::beside_effects));
        let at_end = self.selection.fitted.model.world_at_end();
        notes.extend(at_end.map(|(name, value)| Note::WorldAtEnd {
            name: name.into(),
            value,
        }));
        let values = &self.selection.fitted.model.values;
        notes.push(Note::CameraScale {
            friction: values[FRICTION],
            restitution: values[RESTITUTION],
        });
        notes.extend(notes::few_judges(judged.gap.heldout_strikes));
        let p_value = self.p_value;
        let summary = match verdict {
            Verdict::Consistent if p_value.is_real() => Summary::ConsistentAtRest(p_value),
            Verdict::Consistent if p_value.is_real_as_drawn() => {
                Summary::ConsistentByFlips(p_value)
            }
            Verdict::Consistent => Summary::Consistent(p_value),
            Verdict::Unexplained => Summary::Unexplained(judged.cause.clone()),
            Verdict::Named => {
                let effects = judged.world.iter().flat_map(|world| world.effects.clone());
                let stated = effects.zip(&named).map(|(effect, named)| Stated {
                    effect,
                    equivalent: named.equivalent.clone(),
                });
                Summary::Named(stated.collect())
            }
        };
        Ok(Diagnosed {
            residuals: gap::residuals(&strikes, &judged.before, &judged.after),
            diagnosis: Diagnosis {
                summary: Summary::Beside(Box::new(summary.into()), beside).into(),
                verdict,
                cause: judged.cause.map(Sentence::from),
                strays: None,
                stray_strikes: Vec::new(),
                is_another_now: false,
                p_value: self.p_value.drawn,
                p_value_signs: self.p_value.flipped,
                replicates: DRAWN,
                noise,
                strikes: self.selection.prepared.strikes.len(),
                r#where: match verdict {
                    Verdict::Consistent => Vec::new(),
                    _ => found(&self.asked),
                },
                effects: named,
                ranking: self.ranking(),
                gap: judged.gap,
                next_strikes: match self.is_stated() {
                    true => Vec::new(),
                    false => self.next(verdict)?,
                },
                detectable: self.detectable(),
                notes: notes.into_iter().map(Sentence::from).collect(),
                maps: match verdict {
                    Verdict::Consistent => Vec::new(),
                    _ => self.maps.clone(),
                },
            },
            world: judged.world,
            carried: None,
        })
    }

    /// Notes on forms at the ends of their ranges.
    fn at_ends(&self) -> Vec<Note> {
        let fitted = &self.selection.fitted;
        let (model, at_end) = (&fitted.model, fitted.forms_at_end());
        let forms = model.forms().filter(|(i, _, _)| at_end.contains(i));
        let notes = forms.map(|(i, part, name)| {
            let (effect, value) = (model.parts[part].name, model.values[i]);
            Note::AtEnd {
                effect: effect.into(),
                parameter: name.into(),
                value,
                unit: specification(effect, name).unit.into(),
            }
        });
        notes.collect()
    }

    /// Whether one of the effects is stated as the cause, and never named.
    fn is_stated(&self) -> bool {
        self.names().into_iter().any(is_never_named)
    }

    /// Whether effects were found, in a world whose values are possible.
    fn explains(&self) -> bool {
        let is_possible = self.selection.fitted.model.world_at_end().is_none();
        !self.selection.effects.is_empty() && is_possible
    }

    fn judge(&self, strikes: &[&Strike]) -> Result<Conclusion, DiagnoseError> {
        let rig = &self.input.rig;
        let Selection {
            prepared,
            null,
            fitted,
            ..
        } = self.selection;
        let part = |residuals: &[_], heldout| gap::of_part(strikes, residuals, heldout);
        // The identified world, or what it became in the fit here, whichever serves the strikes that were fitted better.
        let identified = gap::stop_residuals(rig, &self.input.world, strikes)?;
        let plain = fitted_world(&self.input.world, null, prepared.noise)?;
        let refitted = gap::stop_residuals(rig, &plain, strikes)?;
        let fits =
            |residuals: &[Option<Point>]| gap::rms(part(residuals, false).into_iter().flatten());
        let before = if fits(&identified) < fits(&refitted) {
            identified
        } else {
            refitted
        };
        let answer = match self.selection.effects.is_empty() {
            true => &self.asked,
            false => &self.remaining,
        };
        let floor = question::variation(prepared, fitted, answer);
        let gap_to = |after: &[Option<Point>], floor| {
            gap::gap(&part(&before, true), &part(after, true), floor)
        };
        let unnamed = |verdict, cause, note| {
            // Whichever of both worlds leaves less: what changes with the order may be seen in one of them alone.
            let floor = match self.selection.effects.is_empty() {
                true => floor,
                false => floor.or_less(question::variation(prepared, null, &self.asked)),
            };
            Conclusion {
                verdict,
                world: None,
                gap: gap_to(&before, floor),
                after: before.clone(),
                before: before.clone(),
                note,
                cause,
            }
        };
        if self.are_pushed_again {
            let cause = Some(Cause::PushedAgain);
            return Ok(unnamed(Verdict::Unexplained, cause, None));
        }
        // A score that no effect takes, of strikes that depend on nothing that was commanded, on no order and no place, is noise of another
        // form than the one that was drawn.
        // Where no command was repeated, what no question finds is taken for scatter, so that stops alone cannot say that there is no gap: tracks that
        // leave the world's by far more than the camera's noise do, and friction that scatters by as much as is allowed for.
        // Where hardly any strike rests, tracks are all that there is to judge by.
        let by_tracks = !Strike::most_rest(prepared.strikes.iter().copied());
        let is_gap = self.asked.is_gap()
            || self.is_real && by_tracks
            || !question::has_repeats(prepared) && self.is_real && null.is_unlike_scatter(prepared);
        let is_tried = !self.gains.likelihood.is_empty() || !self.selection.effects.is_empty();
        if !(is_gap || self.is_real && is_tried) {
            return Ok(unnamed(Verdict::Consistent, None, None));
        }
        // Tracks that differ from the world's in a way that moves no stop beyond what repeats scatter by are no gap that strikes would show. Held-out
        // strikes count here, too: they name nothing, and may say that something is missing.
        let moved = gap::rms(before.iter().copied().flatten());
        let is_great = self.moves_unpaid || moved > GREAT * floor.at_most();
        let unexplained = match is_gap || is_great {
            true => Verdict::Unexplained,
            false => Verdict::Consistent,
        };
        if !self.is_real {
            let cause = self.asked.findings.first().map(depends);
            return Ok(unnamed(Verdict::Unexplained, cause, None));
        }
        let fitted_world = || fitted_world(&self.input.world, fitted, prepared.noise);
        // A table that wanders looks like one that differs by place or direction there; an arm does not.
        let names = self.names();
        let is_of_table = |name: &&str| effect(name).is_ok_and(|spec| spec.origin == Origin::Table);
        let are_of_table = !names.is_empty() && names.iter().all(is_of_table);
        if !is_gap && self.asked.runs_with_order && are_of_table {
            let note = notes::not_named(&names, WhyNot::RunsWithOrder);
            let cause = (unexplained == Verdict::Unexplained).then_some(Cause::RunsWithOrder);
            return Ok(unnamed(unexplained, cause, Some(note)));
        }
        if self.is_stated() {
            let (never_named, others): (Vec<AddedEffect>, Vec<AddedEffect>) = fitted_world()?
                .effects
                .into_iter()
                .partition(|added| is_never_named(&added.name));
            let cause = Some(Cause::NeverNamed(never_named));
            let note = (!others.is_empty()).then_some(Note::BesideNeverNamed(others));
            return Ok(unnamed(Verdict::Unexplained, cause, note));
        }
        if !self.explains() {
            let is_found = !self.selection.effects.is_empty();
            let note = is_found.then(|| notes::not_named(&self.names(), WhyNot::NoSuchWorld));
            let left = self.remaining.findings.first();
            let left = left.map(|left| self.without_effects(left));
            let unpaid = self.moves_unpaid.then_some(Cause::Unpaid);
            let cause = left.or(self.asked.findings.first());
            let cause = cause.map(depends).or(unpaid);
            let cause = cause.filter(|_| unexplained == Verdict::Unexplained);
            return Ok(unnamed(unexplained, cause, note));
        }
        if let Some(name) = fitted.at_its_strongest() {
            // What it stands for predicts strikes that took no part: there is a gap, whatever it is.
            let why = WhyNot::AtItsStrongest { name: name.into() };
            let cause = self.asked.findings.first().map(depends);
            let note = notes::not_named(&self.names(), why);
            return Ok(unnamed(Verdict::Unexplained, cause, Some(note)));
        }
        let is_by_order = |name: &&str| effect(name).is_ok_and(|spec| spec.family.is_by_order());
        let (by_session, drifts): (Vec<&str>, Vec<&str>) = self
            .names()
            .into_iter()
            .filter(is_by_order)
            .partition(|name| is_by_session(name));
        let effects = EffectsByOrder {
            by_session: !by_session.is_empty(),
            drift: !drifts.is_empty(),
        };
        let is_by_order = effects.by_session || effects.drift;
        let contradicting = self.asked.contradicts(effects);
        if let Some(finding) = contradicting.filter(|_| is_by_order) {
            let note = notes::not_named(&self.names(), WhyNot::OtherForm);
            let cause = Some(depends(finding));
            return Ok(unnamed(Verdict::Unexplained, cause, Some(note)));
        }
        let last = |last: f64, strike: &&Strike| last.max(strike.conditions.order);
        if camera_drift::could_be(fitted, prepared.strikes.iter().fold(0.0, last))
            || camera_drift::could_be_by_session(prepared, fitted)?
        {
            let note = notes::not_named(&self.names(), WhyNot::CameraDrifts);
            let cause = Some(Cause::CameraDrifts);
            return Ok(unnamed(unexplained, cause, Some(note)));
        }
        if self.faces && self.names().into_iter().any(turns_launches) {
            let note = notes::not_named(&self.names(), WhyNot::Facing);
            return Ok(unnamed(unexplained, None, Some(note)));
        }
        let alias = Alias::of(rig, strikes);
        let parts = fitted.model.fitted_parts(&fitted.model.values);
        let mut drifts = false;
        for part in &parts {
            drifts |= alias::is_drift_of_heading(rig, strikes, &added(part))?;
        }
        if drifts {
            let note = notes::not_named(&self.names(), WhyNot::HeadingDrifts);
            let cause = Some(Cause::HeadingInOrder);
            return Ok(unnamed(unexplained, cause, Some(note)));
        }
        if alias.is_along_every_slide(&parts) {
            let note = notes::not_named(&self.names(), WhyNot::OnePlace);
            let cause = Some(Cause::OnePlace);
            return Ok(unnamed(unexplained, cause, Some(note)));
        }
        if let Some(changing) = constancy::changing(self.selection, self.stage.seed) {
            let note = notes::not_named(&self.names(), WhyNot::ActsInPart);
            let cause = Some(Cause::ActsInPart {
                name: changing.name.into(),
                is_by_session: changing.is_by_session,
            });
            return Ok(unnamed(Verdict::Unexplained, cause, Some(note)));
        }
        if fitted.is_far_from_round(prepared) {
            let note = notes::not_named(&self.names(), WhyNot::TracksStillDiffer);
            return Ok(unnamed(Verdict::Unexplained, None, Some(note)));
        }
        // A box may tip and turn in its own way, but not by where it is; and no launch pushes on the way.
        let by_place = self.asked.push_by_place(GREAT * floor.at_most());
        let is_of_launch = |name: &&str| {
            effect(name).is_ok_and(|spec| matches!(spec.origin, Origin::Arm | Origin::Contact))
        };
        let on_the_way = self.asked.push_above_all();
        let pushed = [
            (by_place.filter(|_| self.is_astray), WhyNot::PushedByPlace),
            (
                on_the_way.filter(|_| self.names().iter().all(is_of_launch)),
                WhyNot::PushedOnTheWay,
            ),
        ];
        for (finding, why) in pushed {
            if let Some(finding) = finding {
                let cause = Some(depends(finding));
                let note = notes::not_named(&self.names(), why);
                return Ok(unnamed(Verdict::Unexplained, cause, Some(note)));
            }
        }
        let world = fitted_world()?;
        let after = gap::stop_residuals(rig, &world, strikes)?;
        let gap = gap_to(&after, floor);
        let accounted = floor.at_most();
        let stops = part(&after, false).into_iter().flatten();
        let stops = gap::clipped_rms(stops, gap::LONGEST * accounted);
        // From delivered launches strikes repeat without the arm's scatter, which is most of what repeats of a command scatter by; where some
        // meet a fence, or none rests, those that rest are no fair choice among all.
        let all_rest = strikes.iter().all(|strike| strike.has_stop());
        let is_judged = all_rest && !(self.is_astray || self.is_delivered);
        let great = if is_judged { GREAT } else { f64::INFINITY };
        let is_much_left = stops > great * accounted;
        // What tells two groups apart takes most of what they differ by.
        let groups = self.asked.groups_above_all();
        let groups = groups.filter(|found| stops > FRAC_1_SQRT_2 * found.size);
        let certainty = floor.repeats.high / floor.repeats.value.max(f64::MIN_POSITIVE);
        let finding = groups.or_else(|| match is_much_left {
            true => self.remaining.findings.first(),
            false => self.remaining.great_beside(&self.asked, great * certainty),
        });
        if is_much_left || finding.is_some() {
            let note = notes::not_named(&self.names(), WhyNot::MuchIsLeft);
            return Ok(unnamed(
                Verdict::Unexplained,
                finding.map(|left| depends(self.without_effects(left))),
                Some(note),
            ));
        }
        if !heldout::pays(&self.gains.stop) {
            let note = notes::not_named(&self.names(), notes::does_not_pay(&self.gains));
            return Ok(unnamed(unexplained, None, Some(note)));
        }
        Ok(Conclusion {
            verdict: Verdict::Named,
            world: Some(world),
            gap,
            before,
            after,
            note: None,
            cause: None,
        })
    }

    /// A dependence that effects leave, as it is without them where that is found too: what they take of a step has another form.
    fn without_effects<'f>(&'f self, left: &'f Finding) -> &'f Finding {
        let is_alike = |f: &&Finding| f.what == left.what && f.covariate == left.covariate;
        self.asked.findings.iter().find(is_alike).unwrap_or(left)
    }

    fn names(&self) -> Vec<&'static str> {
        let effects = self.selection.effects.iter();
        effects.map(|effect| effect.name).collect()
    }

    fn noise(&self) -> Noise {
        let prepared = &self.selection.prepared;
        let scatter = scatter(&self.selection.fitted, prepared.noise);
        Noise {
            speed: scatter.speed,
            angle: scatter.angle,
            friction: scatter.friction,
            camera: scatter.camera,
            camera_correlation: scatter.camera_correlation,
            stamp_jitter: scatter.stamp_jitter,
            frames_left_out: prepared.frames_left_out(),
        }
    }

    fn named(&self, world: &World, strikes: &[&Strike]) -> Result<Vec<NamedEffect>, DiagnoseError> {
        let rig = &self.input.rig;
        let alias = Alias::of(rig, strikes);
        world
            .effects
            .iter()
            .zip(&self.selection.effects)
            .map(|(added, selected)| {
                // What drifts at the impact changes speeds, and turns no launch.
                let turns = alias::turned(rig, strikes, added)?.is_some();
                Ok(NamedEffect {
                    name: added.name.clone(),
                    parameters: added
                        .parameters
                        .iter()
                        .map(|(name, e)| {
                            let unit = specification(selected.name, name).unit.to_string();
                            let parameter = Parameter {
                                value: e.value,
                                low: e.low.unwrap_or(e.value),
                                high: e.high.unwrap_or(e.value),
                                unit,
                            };
                            (name.clone(), parameter)
                        })
                        .collect(),
                    statement: added.clone().into(),
                    evidence: selected.evidence,
                    equivalent: {
                        let mut alike = selected.equivalent.clone();
                        let more = alias.alike(selected.name).into_iter();
                        let disc = alias::is_curved(added).then_some("friction_patch");
                        let more = more.filter(|_| !turns).chain(disc);
                        let names = self.names();
                        let more = more.filter(|n| !names.contains(n) && !alike.contains(n));
                        alike.extend(more.collect::<Vec<_>>());
                        alike.into_iter().map(String::from).collect()
                    },
                    rivals: selected
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

    /// Strikes that separate the effect that stands least firmly from its rival; where nothing is missing, repeats if there were none.
    fn next(&self, verdict: Verdict) -> Result<Vec<NextStrike>, DiagnoseError> {
        if self.stage.next_strikes == 0 {
            return Ok(Vec::new());
        }
        if verdict == Verdict::Consistent {
            let prepared = &self.selection.prepared;
            return Ok(match question::has_repeats(prepared) {
                true => Vec::new(),
                false => repeats(&prepared.strikes, self.stage),
            });
        }
        let margin = |s: &&SelectedEffect| {
            let rival = s.rivals.first();
            rival.map_or(f64::INFINITY, |rival| s.evidence - rival.evidence)
        };
        let closest = self
            .selection
            .effects
            .iter()
            .min_by(|a, b| margin(a).total_cmp(&margin(b)));
        let Some(selected) = closest.filter(|s| !s.rivals.is_empty()) else {
            return Ok(Vec::new());
        };
        // All that could stand in its place, or else who comes nearest.
        let rivals: Vec<&CandidateFit> = selected
            .rivals
            .iter()
            .enumerate()
            .filter(|(i, rival)| *i == 0 || selected.equivalent.contains(&rival.name))
            .map(|(_, rival)| rival)
            .collect();
        let names = rivals.iter().map(|rival| rival.name.into());
        let why = Purpose::Separate([selected.name.into()].into_iter().chain(names).collect());
        let fitted: Vec<&Fitted> = rivals.iter().map(|rival| &rival.fitted).collect();
        Ok(next_strikes(
            &self.selection.prepared,
            &self.input.world,
            &self.selection.fitted,
            &fitted,
            &why,
            self.stage,
        )?)
    }
}

/// A finding of the question as what stands behind the gap.
fn depends(finding: &Finding) -> Cause {
    Cause::Dependence(finding.into())
}

/// What the question found, the largest first: of each covariate, the finding that moves stops most.
fn found(answer: &Answer) -> Vec<GapDependence> {
    let mut first: Vec<&Finding> = Vec::new();
    for found in &answer.findings {
        if first.iter().all(|other| other.covariate != found.covariate) {
            first.push(found);
        }
    }
    let all: f64 = first.iter().map(|found| found.size.powi(2)).sum();
    let dependence = |found: &&Finding| GapDependence {
        covariate: found.covariate.into(),
        description: Dependence::from(*found).into(),
        p_value: found.p_value,
        share: found.size.powi(2) / all.max(f64::MIN_POSITIVE),
    };
    first.iter().map(dependence).collect()
}
