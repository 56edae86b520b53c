//! A few nights of the soak; `soak --nights 100` is the whole of it.

use std::path::Path;

use tests::soak::{Settings, soak};

#[test]
fn nights_with_faults_lose_no_strike_and_keep_the_right_version_in_use() {
    let settings = Settings {
        nights: 8,
        // Enough for all that a later night does.
        first: 30,
        strikes: 2,
        seed: 3,
    };
    let faulty = Path::new(env!("CARGO_BIN_EXE_faulty"));
    let soaked = soak(faulty, settings, &mut |line| println!("{line}"))
        .unwrap_or_else(|error| panic!("{error:#}"));
    assert!(soaked.strikes > 40 && soaked.faults.len() > 3, "{soaked:?}");
    assert!(
        soaked.memory_is_steady(),
        "the memory grows: {:?} bytes in the first and the second half of the nights",
        soaked.largest_peaks()
    );
}
