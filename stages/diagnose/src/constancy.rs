//! Whether each effect that is held acts alike in all strikes: in each session, early and late.
//!
//! An effect that acts in a share q of the strikes alone is fitted at q times its strength; with a strength for each group of strikes it gains
//! (1 − q)/q of that again. The score of its strengths by groups says so (tests of structural change: Zeileis and Hornik 2007).

use nalgebra::DMatrix;
use world::effects::effect;

use crate::{
    evidence::{self, REAL},
    question,
    score::{ScoreTest, StrikeColumns},
    search::Selection,
};

/// Share of an effect's evidence that strengths by group gain on top, at the least, where it acts in two strikes of three.
const ACTS_IN_PART: f64 = 0.5;
/// Groups of strikes by their order.
const GROUPS: usize = 4;

/// An effect that acts in a part of the strikes alone.
pub(crate) struct Changing {
    pub(crate) name: &'static str,
    /// Whether it changes from session to session; otherwise with the number of strikes.
    pub(crate) is_by_session: bool,
}

/// The effect whose strength changes most from group to group, if it acts in a part of the strikes alone.
pub(crate) fn changing(selection: &Selection<'_>, seed: u64) -> Option<Changing> {
    let Selection {
        prepared, fitted, ..
    } = selection;
    let test = ScoreTest::new(prepared, fitted, &[], evidence::flips(seed))?;
    let n = prepared.strikes.len();
    let groups = [
        (true, question::sessions(prepared)),
        (false, (0..n).map(|i| GROUPS * i / n).collect()),
    ];
    let mut most: Option<(f64, Changing)> = None;
    for (is_by_session, group) in &groups {
        for (place, held) in selection.effects.iter().enumerate() {
            // How one of these changes with the order is its form, which the question about the order judges.
            let is_by_order = effect(held.name).is_ok_and(|spec| spec.family.is_by_order());
            if is_by_order {
                continue;
            }
            let Some((count, moved)) = by_group(selection, place, group) else {
                continue;
            };
            let Some(score) = test.scores(count, &moved).score(&vec![false; count]) else {
                continue;
            };
            let flips = score.by_chance.len() as f64;
            let by_chance = score.by_chance.iter().sum::<f64>() / flips;
            let beyond = score.by_chance.iter().filter(|gain| **gain >= score.gain);
            let p_value = (1.0 + beyond.count() as f64) / (1.0 + flips);
            let again = (score.gain - by_chance) / held.evidence;
            if p_value < REAL
                && again > ACTS_IN_PART
                && most.as_ref().is_none_or(|(most, _)| again > *most)
            {
                let changing = Changing {
                    name: held.name,
                    is_by_session: *is_by_session,
                };
                most = Some((again, changing));
            }
        }
    }
    most.map(|(_, changing)| changing)
}

/// Columns of an effect's strengths in each group of strikes but the first, and their number; none where there is but one.
fn by_group(
    selection: &Selection<'_>,
    place: usize,
    group: &[usize],
) -> Option<(usize, StrikeColumns)> {
    let fitted = &selection.fitted;
    let free = fitted.model.free.iter().enumerate();
    let strengths: Vec<usize> = free
        .filter(|(_, free)| {
            free.is_strength && free.of.as_ref().is_some_and(|(of, _)| *of == place)
        })
        .map(|(i, _)| i)
        .collect();
    let count = strengths.len() * group.iter().max()?;
    let strikes = fitted.linearisation.whitened.iter().zip(group);
    let moved = strikes.map(|(whitened, group)| {
        let first = group.checked_sub(1)? * strengths.len();
        let mut columns = DMatrix::zeros(whitened.values.nrows(), count);
        for (k, strength) in strengths.iter().enumerate() {
            columns.set_column(first + k, &whitened.values.column(*strength));
        }
        Some(columns)
    });
    (count > 0).then(|| (count, moved.collect()))
}
