//! A slice of what runs for long: of every fuzz target (`make fuzz`), of the soak (`make soak`), of the hidden-effect benchmark (`make
//! blind`) on seeds that it does not use.

use std::path::Path;
use std::time::Duration;

use rayon::prelude::*;
use tests::blind::{is_right, run, slice};
use tests::fuzz::{Budget, fuzz, targets};
use tests::soak::{Settings, soak};

#[test]
fn what_is_read_from_outside_is_read_or_refused() {
    // Threads of its own: in those of all tests an input would wait for their work, and be taken for slow.
    let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    threads.expect("a thread").install(every_target);
}

fn every_target() {
    let budget = Budget {
        tries: 3000,
        time: Duration::from_secs(10),
    };
    for target in targets() {
        let tally = match fuzz(&target, 7, budget) {
            Ok(tally) => tally,
            Err(finding) => panic!("{}: {}: {:?}", target.name, finding.what, finding.input),
        };
        println!("{}: {tally:?}", target.name);
        let seeds = target.seeds.len() as u64;
        // A signature holds, or fails in a few ways.
        let kinds = if target.name == "signature" { 3 } else { 5 };
        assert!(
            tally.tries > seeds && tally.kinds > kinds,
            "{}: {tally:?}",
            target.name
        );
        assert!(
            tally.read > 0,
            "{}: no input was read: {tally:?}",
            target.name
        );
    }
}

/// Largest peak memory of a night here, in bytes. Measured: 86 MiB. A few nights say nothing of growth, for each does other work after
/// its fault; a hundred do (`make soak`).
const MOST_MEMORY: u64 = 120 << 20;

#[test]
fn nights_with_faults_lose_no_strike_and_keep_the_right_version_in_use() {
    let settings = Settings {
        nights: 8,
        // All of them lie in the session that is logged.
        first: 19,
        strikes: 2,
        seed: 3,
    };
    let faulty = Path::new(env!("CARGO_BIN_EXE_faulty"));
    let soaked = soak(faulty, settings, &mut |line| println!("{line}"))
        .unwrap_or_else(|error| panic!("{error:#}"));
    assert!(soaked.strikes > 20 && soaked.faults.len() > 3, "{soaked:?}");
    assert!(
        soaked.memory.iter().all(|peak| *peak < MOST_MEMORY),
        "{soaked:?}"
    );
}

#[test]
fn hidden_effects_are_named_and_nothing_else_is() {
    let outcomes: Vec<_> = slice().par_iter().map(run).collect();
    let mut wrong = Vec::new();
    for outcome in &outcomes {
        println!(
            "{}: {} {:?}, p = {:.1e}",
            outcome.case.id, outcome.answer.verdict, outcome.answer.named, outcome.answer.p_value
        );
        if !is_right(outcome) {
            wrong.push(outcome.case.id.as_str());
        }
    }
    // The benchmark's own rates, not these few sets, are the measure: one may go wrong.
    assert!(wrong.len() <= 1, "{wrong:?}");
    // What would be worst: a control that is called something else.
    assert!(
        outcomes
            .iter()
            .filter(|o| o.case.hidden.is_empty())
            .all(is_right),
        "{wrong:?}"
    );
}
