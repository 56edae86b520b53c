//! A few nights of the soak; `soak --nights 100` is the whole of it.

use std::path::Path;

use tests::soak::{Settings, soak};

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
