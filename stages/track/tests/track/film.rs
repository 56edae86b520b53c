//! A demo's strikes from pixels beside the same strikes from centroids.

use ingest::{Ingest, LogOutcome, ingest_log};
use rig::Hidden;
use rig::demo::{Settings, write};
use track::track_log;
use values::Shape;

#[test]
fn strikes_from_pixels_are_those_from_centroids() {
    let dir = tempfile::tempdir().expect("folder");
    let mut settings = Settings::new(Shape::Cylinder, 3, 5, Some(Hidden::default()));
    let plain = write(&settings, &dir.path().join("plain")).expect("written");
    settings.truth.rig = rig::film::with_camera(settings.truth.rig);
    let written = write(&settings, &dir.path().join("filmed")).expect("filmed");
    let rig = settings.truth.rig;
    let ingested = |log: &std::path::Path| -> LogOutcome {
        ingest_log(log, &rig, &Ingest::default()).expect("ingested")
    };
    let seen = ingested(&plain.logs[0]);
    let error = ingest_log(&written.logs[0], &rig, &Ingest::default()).expect_err("no centroids");
    assert!(error.to_string().contains("[topics.image]"), "{error}");

    let tracked = dir.path().join("tracked.mcap");
    let outcome = track_log(&written.logs[0], &rig, &tracked, None).expect("tracked");
    assert_eq!(outcome.frames, outcome.centroids, "{outcome:?}");
    let found = ingested(&tracked);
    assert_eq!(
        (found.strikes.len(), found.rejects.len()),
        (3, 0),
        "{found:?}"
    );
    for (seen, found) in seen.strikes.iter().zip(&found.strikes) {
        // The centroids have a noise of 0.7 mm each; a stop is the mean of some.
        for (seen, found) in [(seen.initial, found.initial), (seen.stop, found.stop)] {
            assert!(seen.distance(found) < 2e-3, "{seen:?} {found:?}");
        }
        assert!((seen.track.len() as f64 - found.track.len() as f64).abs() < 4.0);
    }
}
