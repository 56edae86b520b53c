//! Right or wrong, by one rule for the plain and the hard benchmark.

use super::cases::CLASSES;
use super::hard::{right, said};
use super::outcome::Outcome;
use super::set::Answer;

/// Whether an answer says just what is hidden: each phenomenon by a right name, in a class that was said, or by the verdict that is
/// right for it, and nothing else.
pub fn says_just(answer: &Answer, hidden: &[String]) -> bool {
    let is_right_for_all = |verdict| hidden.iter().all(|h| right(h).contains(&verdict));
    match answer.verdict.as_str() {
        "consistent" => is_right_for_all("consistent"),
        "unexplained" => !hidden.is_empty() && is_right_for_all("unexplained"),
        "named" => {
            answer.named.len() == hidden.len() && said(hidden, &answer.named) == hidden.len()
        }
        _ => false,
    }
}

/// Whether a set of the plain benchmark is right.
pub fn is_right(outcome: &Outcome) -> bool {
    says_just(&outcome.answer, &outcome.case.hidden)
}

/// Whether every name is just what is hidden.
pub fn is_exact(outcome: &Outcome) -> bool {
    let (answer, hidden) = (&outcome.answer, &outcome.case.hidden);
    answer.verdict == "named"
        && answer.named.len() == hidden.len()
        && answer.named.iter().all(|(name, _)| hidden.contains(name))
}

/// Whether an effect is of no class that is the same by construction.
pub fn is_of_its_own(outcome: &Outcome) -> bool {
    let in_class = |effect: &String| CLASSES.iter().any(|class| class.contains(&effect.as_str()));
    !outcome.case.hidden.iter().any(in_class)
}

/// Whether the diagnosis claims its names alone, without a class.
pub fn is_claimed_alone(outcome: &Outcome) -> bool {
    let named = &outcome.answer.named;
    !named.is_empty() && named.iter().all(|(_, equivalent)| equivalent.is_empty())
}
