//! `tests/KUKA.md`.

use std::collections::BTreeMap;
use std::fmt::Write;

use diagnose::{Diagnosis, Verdict};
use train::Kind;
use values::Strike;

use super::Judged;
use super::judged::MODELS;

const CM: f64 = 100.0;

/// The page about folds by setting, folds by session, and the diagnosis of all strikes.
pub fn page(
    strikes: &[Strike],
    by_setting: &[Judged],
    by_session: &[Judged],
    diagnosis: &Diagnosis,
) -> anyhow::Result<String> {
    let pushed = strikes
        .iter()
        .filter(|strike| strike.is_pushed_again())
        .count();
    let seeds = by_seed(by_setting);
    let mut text = format!(
        "# Real strikes of a KUKA arm\n\nMade by `make kuka`. {} strikes that another lab recorded, of a light box and an arm commanded 0.5 to \
         2.75 m/s, in three logs of two sessions (a and a2, b). In {pushed} the arm pushes the box a second time: these take no part in a \
         fit but a launch map's, where that predicts better with them, and count in every error. The strikes themselves are not part of this repository.\n\n\
         ## Stop errors\n\nEvery model learns from the strikes that are left, as a run does, and predicts those held out; mean distance \
         between measured and predicted stop. By setting: commanded speed and angle are held out together, five folds, {} deals; the \
         deviation is that of the deals' means. By session: a and a2 against b, both ways. `default` is the model that the training \
         strikes choose.\n\n",
        strikes.len(),
        seeds.len()
    );
    let by_session: Vec<&Judged> = by_session.iter().collect();
    writeln!(
        text,
        "| model | by setting (cm) | sd (cm) | worst deal (cm) | × `sysid` | without a stop | by session (cm) | × `sysid` |\n\
         |---|---|---|---|---|---|---|---|"
    )?;
    let sysid = mean(&means(&seeds, "sysid"));
    let sysid_session = mean_error(&by_session, "sysid");
    for model in MODELS {
        let means = means(&seeds, model);
        let worst = means.iter().copied().fold(0.0, f64::max);
        let session = mean_error(&by_session, model);
        writeln!(
            text,
            "| `{model}` | {:.1} | {:.1} | {:.1} | {:.2} | {} | {:.1} | {:.2} |",
            mean(&means) * CM,
            deviation(&means) * CM,
            worst * CM,
            mean(&means) / sysid,
            by_setting
                .iter()
                .map(|judged| failed(judged, model))
                .sum::<usize>(),
            session * CM,
            session / sysid_session
        )?;
    }
    text += &deals(&seeds)?;
    text += &sessions(&by_session)?;
    text += &named(by_setting)?;
    text += &whole(diagnosis)?;
    text += CHECK;
    Ok(text)
}

type Seeds<'a> = BTreeMap<u64, Vec<&'a Judged>>;

fn by_seed(judged: &[Judged]) -> Seeds<'_> {
    let mut seeds = Seeds::new();
    for one in judged {
        seeds.entry(one.fold.seed).or_default().push(one);
    }
    seeds
}

fn means(seeds: &Seeds, model: &str) -> Vec<f64> {
    seeds
        .values()
        .map(|folds| mean_error(folds, model))
        .collect()
}

/// Over all strikes that have a stop.
fn mean_error(folds: &[&Judged], model: &str) -> f64 {
    let errors = folds.iter().flat_map(|fold| &fold.errors[model]);
    mean(&errors.flatten().copied().collect::<Vec<_>>())
}

fn failed(judged: &Judged, model: &str) -> usize {
    judged.errors[model]
        .iter()
        .filter(|error| error.is_none())
        .count()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn deviation(values: &[f64]) -> f64 {
    let middle = mean(values);
    let squares: f64 = values.iter().map(|value| (value - middle).powi(2)).sum();
    (squares / (values.len().max(2) - 1) as f64).sqrt()
}

fn deals(seeds: &Seeds) -> anyhow::Result<String> {
    let mut text = format!(
        "\nEach deal, in cm:\n\n| seed | {} |\n|",
        MODELS.join(" | ")
    );
    text += &"---|".repeat(MODELS.len() + 1);
    text += "\n";
    for (seed, folds) in seeds {
        let row = MODELS.map(|model| format!("{:.1}", mean_error(folds, model) * CM));
        writeln!(text, "| {seed} | {} |", row.join(" | "))?;
    }
    Ok(text)
}

fn sessions(by_session: &[&Judged]) -> anyhow::Result<String> {
    let mut text = String::from("\nWhole sessions held out:\n\n");
    for judged in by_session {
        let errors =
            MODELS.map(|model| format!("`{model}` {:.1}", mean_error(&[judged], model) * CM));
        let named = if judged.named.is_empty() {
            "nothing".into()
        } else {
            judged.named.join(", ")
        };
        writeln!(
            text,
            "- {} held out ({} strikes): {} cm; named: {named}; added: {} to `sysid`, {} to `effect`.",
            judged.fold.name,
            judged.fold.held_out.len(),
            errors.join(", "),
            judged.added[0].name(),
            judged.added[1].name()
        )?;
    }
    Ok(text)
}

fn named(folds: &[Judged]) -> anyhow::Result<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in folds.iter().flat_map(|fold| &fold.named) {
        *counts.entry(name).or_default() += 1;
    }
    let mut text = format!(
        "\n## What is named\n\nIn how many of the {} folds by setting:\n\n",
        folds.len()
    );
    for (name, count) in &counts {
        writeln!(
            text,
            "- `{name}`: {count} ({:.0} %)",
            100.0 * *count as f64 / folds.len() as f64
        )?;
    }
    let nothing = folds.iter().filter(|fold| fold.named.is_empty()).count();
    writeln!(text, "- nothing: {nothing}\n\nWhat is added:\n")?;
    for (place, world) in ["sysid", "effect"].into_iter().enumerate() {
        let count = |kind| {
            folds
                .iter()
                .filter(|fold| fold.added[place] == kind)
                .count()
        };
        writeln!(
            text,
            "- to `{world}`: nothing {}, a launch map {}, networks {}",
            count(Kind::None),
            count(Kind::LaunchMap),
            count(Kind::Networks)
        )?;
    }
    Ok(text)
}

/// The diagnosis of all strikes, a tenth of which judge.
fn whole(diagnosis: &Diagnosis) -> anyhow::Result<String> {
    let verdict = match diagnosis.verdict {
        Verdict::Named => "named",
        Verdict::Consistent => "consistent",
        Verdict::Unexplained => "unexplained",
    };
    let gap = &diagnosis.gap;
    let mut text = format!(
        "\n## The diagnosis of all strikes\n\n{} of them fit and choose, {} judge.\n\n**`{verdict}`**: {}.\n\nOn the held-out strikes stops \
         are off by {:.1} cm root mean square before and {:.1} cm after ({}); repeats would scatter by {:.1} cm by the scatter that the fit \
         needs.\n\n",
        diagnosis.strikes,
        gap.heldout_strikes,
        diagnosis.summary,
        CM * gap.before,
        CM * gap.after,
        gap.change_in_words(),
        CM * gap.noise_floor
    );
    for effect in &diagnosis.effects {
        writeln!(
            text,
            "- `{}`: {}; evidence {:.0}.",
            effect.name, effect.statement, effect.evidence
        )?;
    }
    writeln!(
        text,
        "\n| candidate alone | evidence (gain in log-likelihood beyond chance) |\n|---|---|"
    )?;
    for ranked in diagnosis.ranking.iter().take(8) {
        writeln!(text, "| `{}` | {:.0} |", ranked.name, ranked.evidence)?;
    }
    writeln!(text, "\nWhere the gap lies, the strongest first:\n")?;
    for found in &diagnosis.r#where {
        writeln!(text, "- {}: {}", found.covariate, found.description)?;
    }
    for note in &diagnosis.notes {
        writeln!(text, "- note: {note}")?;
    }
    Ok(text)
}

const CHECK: &str = "
![Speed after the impact against commanded speed](kuka/launches.svg)
![Stops beyond simulation against commanded speed](kuka/gaps.svg)

## What a person would check next on that robot

1. What the arm delivers. The object leaves ever more slowly than commanded the faster the command (first picture): the arm does not
   reach its speed before it touches, or saturates. Log `/striker/state`, or start further away.
2. Whether the arm lets go. In several tracks the box speeds up again: the arm catches up with it. These strikes must be struck again
   with an arm that stops at contact.
3. The two sessions apart. No speed was struck in both, so that friction by session, friction that changes with speed and an arm that
   saturates stand for one another. Ten strikes at 1 m/s in the second session would separate them. Within the first session neither
   launches nor the time from command to first motion separate a ceiling of the speed from an arm that is late: what is predicted for the
   second from the first is a launch map that holds what was delivered at the fastest command, not a ceiling that was found.
4. Repeats of one command: without any, scatter and missing physics are distinguished by smoothness alone.
";
