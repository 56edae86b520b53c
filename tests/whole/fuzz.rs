//! A short run of every fuzz target; `make fuzz` takes ten minutes each.

use std::time::Duration;

use tests::fuzz::{Budget, fuzz, targets};

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
