//! All logs together: one row for each strike, in order of time.

use std::collections::BTreeMap;

use values::{Reject, RejectReason, Strike};

use crate::LogOutcome;

/// Joins what came out of the logs, in whatever order they come: strikes by time, then id, each with its rank in
/// `conditions.order`; rejects by log, then index.
///
/// Of a strike that several logs hold, the one with most frames is kept (logs may be cut differently), then that of the
/// first log by name; the others are rejected as duplicates.
pub fn assemble(outcomes: Vec<LogOutcome>) -> (Vec<Strike>, Vec<Reject>) {
    let mut by_id: BTreeMap<String, Vec<(Strike, String)>> = BTreeMap::new();
    let mut rejects = Vec::new();
    for outcome in outcomes {
        rejects.extend(outcome.rejects);
        for strike in outcome.strikes {
            by_id
                .entry(strike.id.clone())
                .or_default()
                .push((strike, outcome.sha256.clone()));
        }
    }
    let mut strikes = Vec::new();
    for (_, mut same) in by_id {
        same.sort_by(|(a, a_hash), (b, b_hash)| {
            let frames = b.track.len().cmp(&a.track.len());
            frames.then_with(|| (&a.log, a.index, a_hash).cmp(&(&b.log, b.index, b_hash)))
        });
        let mut same = same.into_iter().map(|(strike, _)| strike);
        let Some(kept) = same.next() else {
            continue;
        };
        rejects.extend(same.map(|strike| Reject {
            detail: format!("it is strike {} of {} ({})", kept.index, kept.log, kept.id),
            log: strike.log,
            index: strike.index,
            t_start: strike.t_start,
            reason: RejectReason::Duplicate,
        }));
        strikes.push(kept);
    }
    strikes.sort_by(|a, b| {
        a.t_start
            .total_cmp(&b.t_start)
            .then_with(|| a.id.cmp(&b.id))
    });
    let mut order = 0.0;
    for strike in &mut strikes {
        strike.conditions.order = order;
        order += 1.0;
    }
    rejects.sort_by(|a, b| {
        (&a.log, a.index, a.reason.name(), &a.detail).cmp(&(
            &b.log,
            b.index,
            b.reason.name(),
            &b.detail,
        ))
    });
    (strikes, rejects)
}
