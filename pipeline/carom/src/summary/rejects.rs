//! Rejected strikes, counted by reason and with an example of each.

use std::collections::BTreeMap;

use values::Reject;

/// Such as "3 off_table, 1 truncated".
pub fn reasons(rejects: &[Reject]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for reject in rejects {
        *counts.entry(reject.reason.name()).or_default() += 1;
    }
    let counts: Vec<String> = counts
        .iter()
        .map(|(reason, count)| format!("{count} {reason}"))
        .collect();
    counts.join(", ")
}

/// The first of each reason, in words.
pub fn examples(rejects: &[Reject]) -> Vec<String> {
    let mut firsts: BTreeMap<&str, &Reject> = BTreeMap::new();
    for reject in rejects {
        firsts.entry(reject.reason.name()).or_insert(reject);
    }
    let example = |(reason, first): (&str, &Reject)| {
        let Reject {
            log, index, detail, ..
        } = first;
        format!("{reason}, such as strike {index} of {log}: {detail}")
    };
    firsts.into_iter().map(example).collect()
}
