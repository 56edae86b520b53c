//! The steps of a diagnosis, in their order.

use std::collections::BTreeMap;

use stage::{Progress, Stage};
use values::{Deliveries, Point, Sentence, Shape};
use world::{World, effects::Naming};

use crate::{
    Diagnose, DiagnoseError, Diagnosed, Input,
    arm::Arm,
    before::CameBefore,
    candidates::{Candidate, candidates, is_never_named, is_of_whole_strikes},
    carry::carried,
    conclude::Case,
    constancy,
    diagnosis::{Gap, StopResidual, Verdict},
    evidence::{self, Alarm, Statistic, replicates},
    facing::{gain_of_facing, is_rather_facing},
    fit::Goal,
    gap,
    heldout::{self, Gains},
    maps,
    model::Model,
    notes,
    null::{fit_anew, fit_null},
    question::{self, Answer},
    score::ScoreTest,
    screen::{Chance, screen_by},
    search::{
        Limits, SelectedEffect, Selection, least_that_moves_little, search, with_details,
        with_last_resorts, with_replacements, with_rivals, with_special_cases, with_wander,
        without,
    },
    sessions::is_by_session,
    strikes::{PreparedStrikes, RESOLVED},
    words::{Cause, Gathered, Note, StrayStrikes, Summary, WhyNot},
};

impl Stage for Diagnose {
    const NAME: &'static str = "diagnose";
    const VERSION: u32 = 74;
    type Input = Input;
    type Output = Diagnosed;
    type Error = DiagnoseError;

    fn run(&self, input: &Input, progress: &Progress) -> Result<Diagnosed, DiagnoseError> {
        if input.rig.object.shape() == Shape::Sphere {
            return Err(DiagnoseError::Rolls);
        }
        let (mut found, strays) = self.beside_strays(input, progress)?;
        let diagnosis = &mut found.diagnosis;
        let gap = &diagnosis.gap;
        let gathered = strays.told.as_ref().and_then(|told| told.gathered.as_ref());
        diagnosis.is_another_now = gathered.is_some_and(Gathered::is_latest);
        let of_strikes = input.strikes.iter();
        let ways: BTreeMap<&str, f64> = of_strikes
            .map(|s| (s.id.as_str(), s.path().norm()))
            .collect();
        let missed = missed_by_far(gap, &found.residuals, |r| ways[r.strike_id.as_str()]);
        let cause = match diagnosis.verdict {
            Verdict::Consistent if contradicts_its_strikes(gap, &found.residuals) => {
                Some(Cause::WorldOfOtherStrikes)
            }
            Verdict::Consistent | Verdict::Unexplained
                if strays.told.as_ref().is_some_and(StrayStrikes::are_a_gap)
                    && !strays.are_explained(diagnosis) =>
            {
                strays.told.clone().map(Cause::PartStrays)
            }
            Verdict::Consistent if is_part(missed, gap.heldout_strikes) => {
                let of = gap.heldout_strikes;
                Some(Cause::PartMissed { missed, of })
            }
            Verdict::Consistent if changes_greatly(gap, &found.residuals) => {
                notes::variation(gap).map(Cause::Varies)
            }
            _ => None,
        };
        if let Some(cause) = cause {
            diagnosis.verdict = Verdict::Unexplained;
            diagnosis.summary = Summary::Unexplained(Some(cause.clone())).into();
            diagnosis.cause = Some(cause.into());
        } else if let Some(told) = &strays.told
            && (diagnosis.verdict != Verdict::Unexplained || told.gathered.is_some())
        {
            let summary = Box::new(diagnosis.summary.clone());
            let note = Note::Strays(told.clone());
            diagnosis.summary = Summary::Beside(summary, vec![note]).into();
        }
        diagnosis.strays = strays.told.map(Sentence::from);
        diagnosis.stray_strikes = strays.ids;
        found.residuals.extend(strays.residuals);
        Ok(found)
    }
}

/// Wander of stops over the order of strikes, or their difference between sessions, in units of what repeats scatter by, from which on something is
/// missing that changes: tables and arms wander by less. So much do strikes that took no part miss by, where wander may stand for something else.
const CHANGES: f64 = 3.0;

/// Misses of the identified world, in units of the strikes' scatter, from which on it is not the world of these strikes, though a world fitted to
/// them alone leaves no gap: chance stays below it where as many judge.
const CONTRADICTS: f64 = 2.0;
const JUDGES: usize = 8;

/// Whether a world fitted to the strikes alone leaves no gap while the identified world, which slides that no strike began or the rig file have
/// taught as well, leaves a great one.
fn contradicts_its_strikes(gap: &Gap, residuals: &[StopResidual]) -> bool {
    missed(gap, residuals).is_some_and(|missed| missed > CONTRADICTS * scatter(gap))
}

/// Share of the strikes that took no part, and their number, from which on those that the world misses by far are no strays.
const PART: f64 = 0.2;
const FEW: usize = 2;

/// How many of the strikes that took no part the world misses by far more than they scatter; on a longer way than usual (`way`, in m) strikes scatter by more.
fn missed_by_far(
    gap: &Gap,
    residuals: &[StopResidual],
    way: impl Fn(&StopResidual) -> f64,
) -> usize {
    let far = gap::LONGEST * scatter(gap);
    let usual = gap::rms(
        residuals
            .iter()
            .map(|residual| Point::new(way(residual), 0.0)),
    );
    let judges = residuals.iter().filter(|residual| residual.is_heldout);
    let is_far = |judge: &&StopResidual| {
        let longer = (way(judge) / usual.max(f64::MIN_POSITIVE)).max(1.0);
        judge.before[0].hypot(judge.before[1]) > far * longer
    };
    judges.filter(is_far).count()
}

/// Whether so many of these are a part of the strikes, and no strays.
fn is_part(missed: usize, of: usize) -> bool {
    of >= JUDGES && missed >= FEW && missed as f64 >= PART * of as f64
}

/// Whether stops change over the order of strikes, or between sessions, by so much more than repeats scatter that something is missing.
fn changes_greatly(gap: &Gap, residuals: &[StopResidual]) -> bool {
    let great = CHANGES * gap.noise_floor;
    f64::max(gap.wander, gap.sessions) > great
        || gap.varies() && missed(gap, residuals).is_some_and(|missed| missed > great)
}

/// By how much strikes that took no part miss, root mean square in m; none where few judge. One that went astray counts for no more than itself.
fn missed(gap: &Gap, residuals: &[StopResidual]) -> Option<f64> {
    let judges = residuals.iter().filter(|residual| residual.is_heldout);
    let missed = judges.map(|residual| Point::new(residual.before[0], residual.before[1]));
    let missed = gap::clipped_rms(missed, gap::LONGEST * scatter(gap));
    (gap.heldout_strikes >= JUDGES).then_some(missed)
}

/// All that stops scatter by, or what is resolved of them, in m.
fn scatter(gap: &Gap) -> f64 {
    let scatter = gap.noise_floor.hypot(gap.wander).hypot(gap.sessions);
    scatter.max(RESOLVED)
}

impl Diagnose {
    /// The diagnosis of strikes as the arm delivered them, where its state is logged.
    pub(crate) fn as_delivered(
        &self,
        input: &Input,
        progress: &Progress,
    ) -> Result<Diagnosed, DiagnoseError> {
        let arm = match Deliveries::of(&input.strikes) {
            Deliveries::Unknown => return Ok(self.diagnose(input, None, progress)?.0),
            Deliveries::NotFollowed => return self.beside_the_state(input, progress),
            Deliveries::Known(strikes) => Arm::of(input, strikes)?,
        };
        let (found, model) = self.diagnose(&arm.input, Some(&arm), progress)?;
        // What the arm does beside its laws is no scatter, and objects do not follow a state that is wrong: strikes as they were commanded
        // tell both, and then are diagnosed themselves.
        let verdict = found.diagnosis.verdict;
        let by_laws = arm.moves(input)?;
        let is_explained = |asked: &Answer| match verdict {
            Verdict::Unexplained => arm.has_no_law() || !asked.is_of_launches(),
            Verdict::Named => !asked.is_beyond(f64::INFINITY),
            Verdict::Consistent => !asked.is_beyond(by_laws),
        };
        match self.as_commanded(input, &arm.with_laws(model)) {
            Ok((asked, variation)) if is_explained(&asked) => arm.complete(found, input, variation),
            Ok(_) | Err(DiagnoseError::NoFit { .. }) => self.beside_the_state(input, progress),
            Err(error) => Err(error),
        }
    }

    /// The diagnosis of strikes as they were commanded, whatever the arm's state says.
    fn beside_the_state(
        &self,
        input: &Input,
        progress: &Progress,
    ) -> Result<Diagnosed, DiagnoseError> {
        let (mut found, _) = self.diagnose(input, None, progress)?;
        found.diagnosis.notes.push(Note::AsCommanded.into());
        Ok(found)
    }

    /// What the question answers of strikes as they were commanded about this model, and how their stops vary.
    fn as_commanded(
        &self,
        input: &Input,
        model: &Model,
    ) -> Result<(Answer, question::Variation), DiagnoseError> {
        let usable = self.usable(input)?;
        let (prepared, _) =
            PreparedStrikes::of(&input.rig, &input.world, &usable.strikes, &self.thresholds)?;
        let greatest_wander = self.thresholds.small_wander;
        let (prepared, fitted) = fit_anew(prepared, &input.world, model, greatest_wander)?;
        let asked = question::ask(&prepared, &fitted, &before(input, &prepared), self.seed);
        let variation = question::variation(&prepared, &fitted, &asked);
        Ok((asked, variation))
    }

    /// The diagnosis of strikes as they were commanded, or as they were delivered, which no effect of the arm explains; with the model that it ends in.
    fn diagnose(
        &self,
        input: &Input,
        arm: Option<&Arm>,
        progress: &Progress,
    ) -> Result<(Diagnosed, Model), DiagnoseError> {
        let is_delivered = arm.is_some();
        let rig = &input.rig;
        progress.set_message("how the object leaves the tip");
        let usable = self.usable(input)?;
        let (prepared, pushed) =
            PreparedStrikes::of(rig, &input.world, &usable.strikes, &self.thresholds)?;

        progress.set_message("the world without effects, and the noise about it");
        let (prepared, null) = fit_null(prepared, &input.world, self.thresholds.small_wander)?;
        let came_before = before(input, &prepared);
        let asked = question::ask(&prepared, &null, &came_before, self.seed);

        progress.set_message("every candidate by its score");
        let named = |naming| candidates(rig, &prepared.strikes, naming);
        let mut candidates = named(Naming::Ordinary);
        candidates.retain(|candidate| !arm.is_some_and(|arm| arm.does(candidate.name)));
        let replicates = replicates(self.seed);
        let test = ScoreTest::new(&prepared, &null, &[], replicates).ok_or_else(|| {
            DiagnoseError::NoFit {
                why: "friction and restitution cannot be distinguished".into(),
            }
        })?;
        let mut screened = screen_by(&prepared, &null, &test, &candidates)?;
        let mut chance = evidence::chance(&screened);
        let alarm = Alarm::new(&Statistic::all(&screened));
        let p_value = alarm.p_value();
        // Flips guard against noise of another form than the one that was drawn. The question believes no form of it, and no camera errs by far
        // more than is stated.
        let is_beyond_noise = asked.is_gap()
            || !question::has_repeats(&prepared) && null.is_unlike_scatter(&prepared);
        let is_real = p_value.is_real() || p_value.is_real_as_drawn() && is_beyond_noise;
        let is_sought = is_real && !usable.are_pushed_again;
        let mut last_resorts = if is_sought {
            named(Naming::LastResort)
        } else {
            Vec::new()
        };
        let screened_last = screen_by(&prepared, &null, &test, &last_resorts)?;
        chance.extend(evidence::chance(&screened_last));
        drop(test);

        progress.set_message("which effects");
        let limits = |is_sought, alarm, first| Limits {
            effects: if is_sought { self.most_effects } else { 0 },
            first,
            flips: evidence::flips(self.seed),
            alarm,
        };
        let all = limits(is_sought, &alarm, 0.0);
        let mut selection = search(&prepared, &null, &screened, &candidates, &chance, &all)?;
        let is_astray = is_astray(&selection);
        if is_astray {
            candidates.retain(|candidate| is_of_whole_strikes(candidate.name));
            screened.retain(|screened| is_of_whole_strikes(screened.name));
            last_resorts.clear();
            // What the others said is no evidence for these, and what they would hold is left: the first is another effect already.
            let alarm = Alarm::new(&Statistic::all(&screened));
            let another = self.thresholds.another;
            let of_these = limits(alarm.p_value().is_real(), &alarm, another);
            selection = search(&prepared, &null, &screened, &candidates, &chance, &of_these)?;
        }
        // A patch that is oblong or fades out is no field.
        let selection = with_details(selection, &candidates, &chance)?;
        let selection = with_last_resorts(selection, &last_resorts, &chance)?;
        let of_any_shape = named(Naming::InPlace);
        let replacements = [&of_any_shape[..], &named(Naming::Never)].concat();
        let mut selection =
            with_replacements(selection, &replacements, &mut chance, replicates, false)?;
        let ask = |Selection {
                       prepared, fitted, ..
                   }: &Selection<'_>| {
            question::ask(prepared, fitted, &came_before, self.seed)
        };
        // What still pushes objects by where they are, beside a slope or a bowl, is a table of another shape.
        let is_table = selection.effects.len() == 1 && !is_never_named(selection.effects[0].name);
        if !is_astray && is_table && ask(&selection).is_pushed_by_place() {
            selection = with_replacements(selection, &of_any_shape, &mut chance, replicates, true)?;
        }
        let selection = with_special_cases(selection, &candidates, &chance)?;
        let selection = with_details(selection, &candidates, &chance)?;
        let is_wander = |selection: &Selection<'_>| {
            let by_session = selection
                .effects
                .iter()
                .any(|held| is_by_session(held.name));
            !ask(selection).has_form_of_an_effect(by_session)
        };
        let acts_in_part = |selection: &Selection<'_>, place: usize| {
            let changing = constancy::changing(selection, self.seed);
            changing.is_some_and(|changing| changing.name == selection.effects[place].name)
        };
        let judged = Pruning {
            is_wander: &is_wander,
            acts_in_part: &acts_in_part,
        };
        let (selection, little) = pruned(selection, &candidates, &chance, &judged)?;
        let Paying {
            selection,
            gains,
            unpaid,
            note,
        } = paying(selection)?;
        let found = unpaid.as_ref().unwrap_or(&selection);
        // A box that leaves every slide shows nothing of how it lies.
        let faces = !is_astray
            && gain_of_facing(rig, &input.world, &usable.strikes, &self.thresholds, &null)?
                .is_some_and(|gain| is_rather_facing(gain, &found.effects));
        // Effects that are no chance, and may be others: that they move stops is no scatter.
        let moves_unpaid = match &unpaid {
            Some(unpaid) => {
                let beside = question::variation(&unpaid.prepared, &unpaid.fitted, &ask(unpaid));
                moved_by_all(unpaid)? > beside.repeats.value
            }
            None => false,
        };
        let mut notes: Vec<Note> = note.into_iter().collect();
        notes.extend(notes::little(&little));
        notes.extend(notes::left_out(&usable, pushed));
        notes.extend(notes::turned(rig, &selection.prepared.strikes));
        notes.extend(is_astray.then_some(Note::Astray));

        progress.set_message("how far the gap shrinks");
        let maps = if is_real {
            maps::maps(&selection.prepared, &selection.null)?
        } else {
            Vec::new()
        };
        let selection = about_itself(selection, &input.world)?;
        // Where tracks differ from any slide of the world, what is left of them says nothing against the effects.
        let remaining = match selection.effects.is_empty() || is_astray {
            true => Answer::default(),
            false => ask(&selection),
        };
        if !faces {
            notes.extend(notes::wrong_sizes(rig, &selection.fitted, is_delivered));
            notes.extend(notes::arm_or_sizes(rig, &selection.fitted));
        }
        let mut found = Case {
            stage: self,
            input,
            selection: &selection,
            screened: &screened,
            chance: &chance,
            is_astray,
            gains: gains.clone(),
            moves_unpaid,
            p_value,
            is_real,
            asked,
            remaining,
            is_delivered,
            faces,
            are_pushed_again: usable.are_pushed_again,
            maps: maps.clone(),
            notes,
        }
        .conclude()?;
        // What the arm does to its commands stands in another world.
        let is_gap = found.diagnosis.verdict == Verdict::Unexplained && is_sought;
        if is_gap && !is_delivered {
            progress.set_message("what predicts better, named or not");
            let (fields, identified) = (&last_resorts, &input.world);
            let carried = carried(&selection, &gains, fields, &maps, &chance, identified)?;
            if let Some((world, note)) = carried {
                found.carried = Some(world);
                found.diagnosis.notes.push(note.into());
            }
        }
        let model = match found.world {
            Some(_) => selection.fitted.model.clone(),
            None => selection.null.model.clone(),
        };
        Ok((found, model))
    }
}

/// Questions to be answered before an effect is left out.
struct Pruning<'p> {
    /// Whether what is left without the effect depends on the order in no other form than a wander.
    is_wander: &'p dyn Fn(&Selection<'_>) -> bool,
    /// Whether the effect at this place acts in a part of the strikes alone: fitted to all, it moves stops by less than it does where it acts.
    acts_in_part: &'p dyn Fn(&Selection<'_>, usize) -> bool,
}

/// The selection without three kinds of effects: those whose strength may be neutral; those by the order without which
/// nothing is left that is no wander; and those that move stops by little in all strikes, whose names are returned.
fn pruned<'a>(
    mut selection: Selection<'a>,
    candidates: &[Candidate],
    chance: &Chance,
    judged: &Pruning<'_>,
) -> Result<(Selection<'a>, Vec<&'static str>), DiagnoseError> {
    let mut little = Vec::new();
    loop {
        if let Some(unsure) = selection.fitted.unsure() {
            selection = without(selection, unsure, chance)?;
        } else if let Some(wandering) = with_wander(&selection, chance, judged.is_wander)? {
            selection = wandering;
        } else if let Some(place) = least_that_moves_little(&selection)?
            && !(judged.acts_in_part)(&selection, place)
        {
            little.push(selection.effects[place].name);
            selection = without(selection, place, chance)?;
        } else {
            break;
        }
    }
    // They are known where the search ended here.
    let has_rivals = |effect: &SelectedEffect| !effect.rivals.is_empty();
    if !selection.effects.iter().any(has_rivals) {
        selection = with_rivals(selection, candidates, chance)?;
    }
    Ok((selection, little))
}

/// What came before each strike.
fn before(input: &Input, prepared: &PreparedStrikes<'_>) -> Vec<CameBefore> {
    let each = prepared.strikes.iter();
    let came = each.map(|strike| input.came_before.get(&strike.id).copied());
    came.map(Option::unwrap_or_default).collect()
}

/// Whether tracks of a box leave the world's, all effects found included. A box may tip and turn in ways that no centroid shows: what its track
/// shows on the way is then no evidence, but its launch, and its friction as a whole, are.
fn is_astray(selection: &Selection<'_>) -> bool {
    let prepared = &selection.prepared;
    !prepared.rig.object.shape().is_round() && selection.fitted.is_far_from(prepared)
}

/// The effects, if together they predict strikes that took no part in their fit better, beyond chance. Otherwise none, with those that do not as
/// `unpaid`, and a note that says so.
fn paying(selection: Selection<'_>) -> Result<Paying<'_>, DiagnoseError> {
    if selection.effects.is_empty() {
        return Ok(Paying::all(selection, Gains::default()));
    }
    let gains = heldout::gains(&selection.prepared, &selection.null, &selection.fitted)?;
    let likelihood = heldout::limited(
        &gains.likelihood,
        selection.prepared.thresholds.typical_gains,
    );
    if heldout::is_beyond_chance(&likelihood) {
        return Ok(Paying::all(selection, gains));
    }
    let (gain, error) = heldout::total(&likelihood);
    let names: Vec<&str> = selection.effects.iter().map(|effect| effect.name).collect();
    let note = notes::not_named(&names, WhyNot::PredictsNoBetter { gain, error });
    let none = Selection {
        prepared: selection.prepared.clone(),
        null: selection.null.clone(),
        fitted: selection.null.clone(),
        effects: Vec::new(),
    };
    Ok(Paying {
        selection: none,
        gains,
        unpaid: Some(selection),
        note: Some(note),
    })
}

/// By how much all effects together move the stops of these commands, root mean square, in m.
fn moved_by_all(selection: &Selection<'_>) -> Result<f64, DiagnoseError> {
    let Selection {
        prepared,
        null,
        fitted,
        ..
    } = selection;
    let (with, without) = (prepared.ends(&fitted.model)?, prepared.ends(&null.model)?);
    Ok(gap::rms_between(&with, &without))
}

/// The effects that pay on strikes left out of their fit.
struct Paying<'a> {
    selection: Selection<'a>,
    gains: Gains,
    /// The effects that were found and do not pay, and the note that says so.
    unpaid: Option<Selection<'a>>,
    note: Option<Note>,
}

impl<'a> Paying<'a> {
    fn all(selection: Selection<'a>, gains: Gains) -> Self {
        Self {
            selection,
            gains,
            unpaid: None,
            note: None,
        }
    }
}

/// The selection fitted again with launches about the impacts that its own model predicts.
fn about_itself<'a>(
    mut selection: Selection<'a>,
    world: &World,
) -> Result<Selection<'a>, DiagnoseError> {
    let prepared = selection.prepared.about(world, &selection.fitted.model)?;
    if !selection.effects.is_empty() {
        let from = &selection.fitted;
        if let Some(fitted) = prepared.fit_from(from, &from.model, Goal::Settled)? {
            selection.fitted = fitted;
        }
    }
    selection.prepared = prepared;
    Ok(selection)
}

#[cfg(test)]
mod tests {
    use values::{Command, Split, Strike};

    use super::*;

    /// Held-out strikes that miss by these errors (m), where repeats scatter by 4 mm and stops wander by this much.
    fn missed_by(errors: &[f64], wander: f64) -> (Gap, Vec<StopResidual>) {
        let variation = question::Variation {
            repeats: question::StandardDeviation::known(0.004),
            wander: question::StandardDeviation::known(wander),
            ..question::Variation::default()
        };
        let strike = Strike {
            split: Split::Test,
            ..Strike::bare(
                Command::new(0.5, 0.0),
                Point::default(),
                Point::new(0.3, 0.0),
            )
        };
        let strikes = vec![&strike; errors.len()];
        let stops: Vec<_> = errors.iter().map(|e| Some(Point::new(*e, 0.0))).collect();
        let residuals = gap::residuals(&strikes, &stops, &stops);
        (gap::gap(&stops, &stops, variation), residuals)
    }

    #[test]
    fn a_wander_that_misses_by_far_more_than_repeats_scatter_is_not_consistent() {
        let changes = |errors: &[f64], wander| {
            let (gap, residuals) = missed_by(errors, wander);
            changes_greatly(&gap, &residuals)
        };
        assert!(changes(&[0.001; 8], 0.0121));
        assert!(!changes(&[0.001; 8], 0.0119));
        assert!(changes(&[0.0121; 8], 0.006));
        assert!(!changes(&[0.0119; 8], 0.006));
        // Where nothing wanders, or few judge, misses say nothing of it.
        assert!(!changes(&[0.0121; 8], 0.003));
        assert!(!changes(&[0.0121; 7], 0.006));
    }

    #[test]
    fn a_world_that_misses_by_far_more_than_strikes_scatter_is_not_theirs() {
        let contradicts = |errors: &[f64]| {
            let (gap, residuals) = missed_by(errors, 0.003);
            contradicts_its_strikes(&gap, &residuals)
        };
        assert!(contradicts(&[0.0101; 8]));
        assert!(!contradicts(&[0.0099; 8]));
        // Beyond three times the scatter is chance once or twice in a thousand; a fifth of them is none.
        let part = |errors: &[f64]| {
            let (gap, residuals) = missed_by(errors, 0.003);
            is_part(
                missed_by_far(&gap, &residuals, |_| 0.3),
                gap.heldout_strikes,
            )
        };
        let near = [0.004; 8];
        assert!(part(&[&near[..], &[0.05, 0.02]].concat()));
        assert!(!part(&[&near[..], &[0.05]].concat()));
        assert!(!part(&[&near[..], &near[..], &[0.05, 0.02]].concat()));
        // On ways twice as long as usual strikes scatter by twice as much.
        let (gap, residuals) = missed_by(&[&near[..], &[0.02, 0.02]].concat(), 0.003);
        let of_way = |long: f64| {
            let way = |r: &StopResidual| if r.before[0] > 0.01 { long } else { 0.3 };
            missed_by_far(&gap, &residuals, way)
        };
        assert_eq!((of_way(0.3), of_way(1.0)), (2, 0));
        // So few may miss by chance, and so may one by any length.
        assert!(!contradicts(&[0.0101; 7]));
        assert!(!contradicts(&[
            0.2, 0.005, 0.005, 0.005, 0.005, 0.005, 0.005, 0.005
        ]));
    }
}
