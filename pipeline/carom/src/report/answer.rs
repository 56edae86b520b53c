//! The first screen: what is missing, how sure that is, how much better it is where it will be used, and what to do next.

use diagnose::{Diagnosis, Purpose, Verdict};
use judge::Evaluation;
use maud::{Markup, html};
use store::Model;
use values::StopErrors;

use super::diagnosis::verdict;
use super::input::ReportInput;
use super::markup::title;
use crate::outputs::NEXT_STRIKES;
use crate::publishing::best_model;
use crate::results::Worlds;
use crate::summary::diagnosis::{changes, numbers, probability};

/// Half the width of a 95 % interval of a mean, in standard errors.
const HALF_95: f64 = 1.96;

/// Four answers side by side.
pub fn answers(shown: &ReportInput<'_>) -> Markup {
    html! {
        section.answers aria-label="The answers" {
            div.answer { h2 { "What is missing" } (missing(shown)) }
            div.answer { h2 { "How sure" } (how_sure(shown)) }
            div.answer { h2 { "How much better" } (better(shown)) }
            div.answer { h2 { "What to do next" } (next(shown)) }
        }
    }
}

fn missing(shown: &ReportInput<'_>) -> Markup {
    let results = shown.results;
    if results.read.check.is_meaningless() {
        return html! { p.said { "The logs do not mean what the rig file says: nothing was fitted." } };
    }
    let Some(found) = results.found() else {
        let why = results.worlds.as_ref().and_then(Worlds::no_diagnosis);
        return html! {
            p.said { "Not known." }
            @if let Some(why) = why { p { (why) "." } }
        };
    };
    let diagnosis = &found.diagnosis;
    html! {
        p.said {
            @match diagnosis.verdict {
                Verdict::Consistent if diagnosis.gap.varies() => { "Nothing by command or place; but stops change over the order of strikes." },
                Verdict::Consistent if diagnosis.strays.is_some() => { "Nothing that most of these strikes show; some are others." },
                Verdict::Consistent => { "Nothing that these strikes show." },
                Verdict::Unexplained => { "Something that no effect of the library explains." },
                Verdict::Named => {
                    @for (place, effect) in diagnosis.effects.iter().enumerate() {
                        @if place > 0 { ", " }
                        code { (effect.name) }
                    }
                },
            }
        }
        @if diagnosis.verdict == Verdict::Named {
            (more(html! { @for effect in &diagnosis.effects { li { (effect.statement) } } }))
        } @else {
            p { (diagnosis.summary.trim_end_matches('.')) "." }
        }
    }
}

fn how_sure(shown: &ReportInput<'_>) -> Markup {
    let Some(found) = shown.results.found() else {
        return html! { p { "Nothing was asked." } };
    };
    let diagnosis = &found.diagnosis;
    html! {
        p.said { (verdict(diagnosis.verdict)) }
        p {
            @match diagnosis.verdict {
                Verdict::Consistent if diagnosis.gap.varies() => { "Stops are off by their scatter, and by what changes over the order of strikes. Tracks that differ as much from the world's come " },
                Verdict::Consistent if diagnosis.strays.is_some() => { "Without the strikes that are others, stops are off by no more than their scatter. Tracks that differ as much from the world's come " },
                Verdict::Unexplained if diagnosis.strays.is_some() => { "Without the strikes that are others, a gap like what is left comes " },
                Verdict::Consistent => { "Stops are off by no more than their scatter. Tracks that differ as much from the world's come " },
                Verdict::Unexplained | Verdict::Named => { "A gap like this comes " },
            }
            "by chance with probability "
            (probability(diagnosis.least_p_value(), diagnosis.replicates)) " (" (diagnosis.strikes) " strikes)."
        }
        (more(html! {
            @for effect in &diagnosis.effects {
                @if let Some((name, parameter)) = effect.parameters.iter().find(|(_, p)| p.low != p.high) {
                    @let [value, low, high] = numbers(parameter);
                    li {
                        code { (effect.name) "." (name) } " " (value) " [" (low) ", " (high) "]"
                        @if !parameter.unit.is_empty() { " " (parameter.unit) }
                    }
                }
                @if !effect.equivalent.is_empty() {
                    li { code { (effect.name) } " cannot be told apart from " (effect.equivalent.join(", ")) "." }
                }
            }
            @if !diagnosis.effects.is_empty() { li { "Intervals in brackets: 95 %." } }
            @if diagnosis.gap.heldout_strikes > 0 {
                li { "Gap on " (diagnosis.gap.heldout_strikes) " strikes that took no part: " (gap(diagnosis)) }
            }
        }))
    }
}

fn gap(diagnosis: &Diagnosis) -> String {
    let mm = |length: f64| format!("{:.1}", length * 1e3);
    let gap = &diagnosis.gap;
    match gap.after == gap.before {
        true => format!("{} mm.", mm(gap.before)),
        false => format!("{} → {} mm.", mm(gap.before), mm(gap.after)),
    }
}

/// Which strikes judge what a strike of tomorrow will miss by, and their stop errors.
struct Judged<'a> {
    /// Where they are of.
    of: String,
    /// What is said where the used model is not better there.
    no_better: &'static str,
    /// The identified simulator's.
    plain: &'a StopErrors,
    /// The used model's.
    used: &'a StopErrors,
}

/// The strikes that judge: those of sessions that the model has not seen where models know sessions, for the next one will be such.
fn judged(evaluation: &Evaluation, model: Model) -> Option<Judged<'_>> {
    let (models, of, no_better) = match evaluation.differing_sessions() {
        Some(new) => (
            &new.models,
            format!(
                "in a session that it has not seen ({} left out in turn)",
                new.sessions
            ),
            "No better in a new session",
        ),
        None => (
            &evaluation.models,
            "on strikes that took no part".into(),
            "No better",
        ),
    };
    Some(Judged {
        of,
        no_better,
        plain: models.get(Model::Sysid.name())?,
        used: models.get(model.name())?,
    })
}

fn better(shown: &ReportInput<'_>) -> Markup {
    let worlds = shown.results.worlds.as_ref();
    let evaluated = worlds.and_then(|w| Some((w.evaluation.as_ref()?, best_model(w))));
    let Some((evaluation, model)) = evaluated else {
        return html! { p.said { "Not judged yet." } };
    };
    let is_judged = |judged: &Judged<'_>| judged.used.n > 0 && judged.plain.mean > 0.0;
    let Some(judged) = judged(evaluation, model).filter(is_judged) else {
        return html! {
            p.said { "Not known." }
            p { "No strike was left that took no part in learning: record more." }
        };
    };
    let (plain, used) = (mean(judged.plain), mean(judged.used));
    let share = 100.0 * (judged.used.mean / judged.plain.mean - 1.0);
    let share = format!("{share:+.0}").replace('-', "−");
    let known = evaluation
        .differing_sessions()
        .and_then(|_| evaluation.models.get(model.name()));
    html! {
        @if model == Model::Sysid {
            p.said { (plain) " cm" }
            p { "The identified simulator serves by itself: nothing that was learnt on top is better." }
        } @else {
            p.said { @if judged.used.mean < judged.plain.mean { (share) " % stop error" } @else { (judged.no_better) } }
            p { (plain) " → " strong { (used) } " cm, " (title(model.name())) " beside the identified simulator, " (judged.of) "; "
                (judged.used.n) " strikes, means with 95 % intervals." }
        }
        (more(html! {
            @if evaluation.new_sessions.is_none() {
                li { "All strikes are of one session: how another would differ is not known." }
            }
            @if let Some(known) = known { li { "In sessions that it knows: " (mean(known)) " cm." } }
            @if let Some(floor) = &evaluation.noise_floor {
                li { "Repeats of one command: " (format!("{:.2}", floor.mean * 100.0)) " cm; a model that errs by less does so by chance." }
            }
        }))
    }
}

/// A mean and the half width of its 95 % interval, in cm.
fn mean(errors: &StopErrors) -> String {
    let half = HALF_95 * errors.sd / (errors.n.max(1) as f64).sqrt();
    format!("{:.2} ± {:.2}", errors.mean * 100.0, half * 100.0)
}

fn next(shown: &ReportInput<'_>) -> Markup {
    let results = shown.results;
    let diagnosis = results.found().map(|found| &found.diagnosis);
    let planned = diagnosis.map_or(0, |diagnosis| diagnosis.next_strikes.len());
    let repeats = Purpose::Repeats.to_string();
    let are_repeats = diagnosis
        .and_then(|diagnosis| diagnosis.next_strikes.first())
        .is_some_and(|strike| *strike.why == *repeats);
    let gate = results.version().map(|version| &version.gate);
    let doubts = gate.filter(|gate| !gate.passed);
    let doubts: Vec<String> = doubts.iter().flat_map(|gate| gate.doubts()).collect();
    let evaluation = results.evaluation();
    let knows_sessions =
        evaluation.is_some_and(|evaluation| evaluation.differing_sessions().is_some());
    let can_strike = doubts.is_empty() && shown.provenance.version.is_some();
    html! {
        p.said {
            @if results.read.check.is_meaningless() { "Mend the logs or the rig file." }
            @else if !doubts.is_empty() { "Record more before you strike." }
            @else if can_strike && knows_sessions { "Strike, with " code { "--adapt" } " in a new session." }
            @else if can_strike { "Strike." }
            @else { "Finish the run." }
        }
        (more(html! {
            @for doubt in &doubts { li { (doubt) } }
            @if can_strike {
                li { code { "strike --artifacts DIR --to X Y" } " plans with it, or says why not." }
            }
            @if can_strike && knows_sessions {
                li { "With " code { "--adapt" } " plans follow a new session's table by its first strikes." }
            }
            @if let Some(told) = diagnosis.and_then(|diagnosis| changes(&diagnosis.gap)) { li { (told) "." } }
            @if planned > 0 {
                li {
                    "The " (planned) " strikes in " code { (NEXT_STRIKES) }
                    (if are_repeats { " repeat one command, and tell what repeats scatter by: " } else { " tell the candidates apart: " })
                    code { "carom collect --plan" } "."
                }
            }
            @if !results.read.check.findings.is_empty() { li { a href="#before-anything-is-fitted" { "What the check of the logs found" } "." } }
            @if !results.read.rejects.is_empty() {
                li { a href="#rejected-strikes" { (results.read.rejects.len()) " of " (results.read.rejects.len() + results.read.strikes.len()) " strikes were rejected" } "." }
            }
            @for warning in results.warnings().iter().take(2) { li { (warning) } }
        }))
    }
}

/// What a wide screen shows at once; on a narrow one `page.js` folds it, so that all answers are on the first screen.
fn more(points: Markup) -> Markup {
    html! { details.more open { summary { "more" } ul { (points) } } }
}
