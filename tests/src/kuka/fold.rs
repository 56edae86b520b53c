//! Which strikes are held out.

use std::collections::BTreeMap;

use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use values::Strike;

/// Parts that settings are dealt into.
const PARTS: usize = 5;

/// Strikes that are held out together, by their place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fold {
    /// The deal that it belongs to; what is random in learning follows from it, too.
    pub seed: u64,
    /// What is held out, by place.
    pub held_out: Vec<usize>,
    /// For a person.
    pub name: String,
}

/// Five folds by setting: strikes of one commanded speed and angle, to a hundredth of both, stay together.
pub fn setting_folds(strikes: &[Strike], seed: u64) -> Vec<Fold> {
    let hundredths = |value: f64| (100.0 * value).round() as i64;
    let mut settings: BTreeMap<(i64, i64), Vec<usize>> = BTreeMap::new();
    for (place, strike) in strikes.iter().enumerate() {
        let setting = (
            hundredths(strike.command.speed),
            hundredths(strike.command.angle),
        );
        settings.entry(setting).or_default().push(place);
    }
    let mut groups: Vec<Vec<usize>> = settings.into_values().collect();
    groups.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    (0..PARTS)
        .map(|part| {
            let mut held_out: Vec<usize> = groups
                .iter()
                .skip(part)
                .step_by(PARTS)
                .flatten()
                .copied()
                .collect();
            held_out.sort_unstable();
            Fold {
                seed,
                held_out,
                name: format!("settings {part}"),
            }
        })
        .collect()
}

/// Two folds by session: a and a2, whose boxes were measured as high, against b.
pub fn session_folds(strikes: &[Strike], seed: u64) -> Vec<Fold> {
    ["session_a", "session_b"]
        .into_iter()
        .map(|session| Fold {
            seed,
            held_out: (0..strikes.len())
                .filter(|place| strikes[*place].conditions.session.starts_with(session))
                .collect(),
            name: session.into(),
        })
        .collect()
}
