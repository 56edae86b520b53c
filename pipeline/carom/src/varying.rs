//! How the table varies beside each model of a version, from the strikes that it learnt from.

use std::collections::BTreeMap;

use judge::Observe;
use stage::Run;
use store::Model;
use strike::SESSION_GAP;
use values::{Rig, Split, Strike};
use world::{Session, Varies};

use crate::Error;
use crate::results::{Results, Worlds};

/// The latest so many strikes say how a table varies: enough to know scatter to a twentieth.
const MOST: usize = 240;
/// A log of fewer strikes is none of a session's own: an executor writes one for each strike.
const LEAST_OF_A_LOG: usize = 3;

/// Beside every model of the results that learnt from strikes.
pub fn varies(
    run: &Run,
    rig: &Rig,
    results: &Results,
    worlds: &Worlds,
) -> Result<BTreeMap<Model, Varies>, Error> {
    let learnt_from = |strike: &&Strike| strike.split != Split::Test;
    let learnt_from: Vec<&Strike> = results.strikes.iter().filter(learnt_from).collect();
    let latest = &learnt_from[learnt_from.len().saturating_sub(MOST)..];
    let latest: Vec<Strike> = latest.iter().map(|strike| (*strike).clone()).collect();
    let sessions = sessions(&latest);
    let mut varies = BTreeMap::new();
    for (name, of_world) in worlds.each() {
        let plain = std::iter::once((name, None));
        let residual = of_world.residual();
        for (name, residual) in plain.chain(residual.map(|r| (name.with_residual(), Some(r)))) {
            let seen = run.items(&Observe, &of_world.model(rig, residual), &latest)?;
            let mut of_sessions =
                vec![Session::default(); sessions.iter().max().map_or(0, |last| last + 1)];
            for ((strike, seen), session) in latest.iter().zip(seen).zip(&sessions) {
                if let Some(seen) = seen {
                    of_sessions[*session]
                        .0
                        .push((strike.conditions.order, seen));
                }
            }
            varies.insert(name, Varies::of(&of_world.world, &of_sessions));
        }
    }
    Ok(varies)
}

/// The number of each strike's session, rising; the strikes are in the order of time.
fn sessions(strikes: &[Strike]) -> Vec<usize> {
    let mut sizes: BTreeMap<&str, usize> = BTreeMap::new();
    for strike in strikes {
        *sizes.entry(&strike.log).or_default() += 1;
    }
    let is_large = |strike: &Strike| sizes[strike.log.as_str()] >= LEAST_OF_A_LOG;
    let mut session = 0;
    let mut numbers = Vec::with_capacity(strikes.len());
    for (place, strike) in strikes.iter().enumerate() {
        if let Some(before) = place.checked_sub(1).map(|before| &strikes[before]) {
            let is_later = strike.t_start - before.t_start > SESSION_GAP;
            let is_other = strike.log != before.log && (is_large(strike) || is_large(before));
            session += usize::from(is_later || is_other);
        }
        numbers.push(session);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use values::{Command, Point};

    use super::*;

    #[test]
    fn a_log_is_a_session_unless_it_holds_a_strike_alone() {
        let strike = |(log, t_start): &(&str, f64)| Strike {
            log: (*log).into(),
            t_start: *t_start,
            ..Strike::bare(Command::new(1.0, 0.0), Point::default(), Point::default())
        };
        let made = [
            ("monday", 0.0),
            ("monday", 5.0),
            ("monday", 10.0),
            ("strike_1", 60.0),
            ("strike_2", 70.0),
            ("strike_3", 70.0 + 1.1 * SESSION_GAP),
        ];
        let strikes: Vec<Strike> = made.iter().map(strike).collect();
        assert_eq!(sessions(&strikes), [0, 0, 0, 1, 1, 2]);
    }
}
