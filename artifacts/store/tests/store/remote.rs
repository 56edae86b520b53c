//! Stores by URL, in memory.

use std::sync::{Arc, Barrier};
use std::thread;

use store::objects::Place;
use store::*;

use crate::fixture::{contents, names};
use crate::signing::Signing;

/// Publishes contents with this friction where this version is in use; gives its name.
fn put(place: &Place, friction: f64, instead_of: Option<&str>) -> String {
    push(&contents(friction), place, instead_of, None).unwrap()
}

fn fresh() -> (tempfile::TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(dir.path());
    (dir, store)
}

#[test]
fn what_is_pushed_is_pulled_and_a_copy_is_used_where_the_store_fails() {
    let place = Place::in_memory();
    assert_eq!(put(&place, 0.2, None), "v0001");
    assert_eq!(put(&place, 0.2, None), "v0001");
    assert_eq!(put(&place, 0.3, Some("v0001")), "v0002");
    let error = push(&contents(0.4), &place, Some("v0001"), None).expect_err("overtaken");
    assert!(error.to_string().contains("v0002 is in use now"), "{error}");

    let (dir, copy) = fresh();
    assert_eq!(pull(&place, &copy, None, None).unwrap(), None);
    let loaded: Contents = copy.load(None).unwrap().into();
    assert_eq!(loaded, contents(0.3));
    assert_eq!(
        names(&dir.path().join("versions")),
        [".lock", "v0002"].map(String::from).into()
    );
    assert_eq!(pull(&place, &copy, Some("v0001"), None).unwrap(), None);
    assert_eq!(copy.latest().unwrap(), "v0002");

    // Half a version there, which `latest` should never name: what was copied before stays in use.
    let tag = place.get("latest").unwrap().1;
    assert!(place.swap("latest", b"v0003\n", tag.as_deref()).unwrap());
    let half = place.create("versions/v0003/manifest.json", b"{\"schema\": 2}");
    assert!(half.unwrap());
    let said = pull(&place, &copy, None, None).unwrap().unwrap();
    assert!(said.contains("v0002 is used"), "{said}");
    assert_eq!(copy.load(None).unwrap().version, "v0002");
    let (_none, nothing) = fresh();
    pull(&place, &nothing, None, None).expect_err("no copy, and half a version");
    assert!(nothing.latest().is_err());
    // Publishing anew mends it.
    assert_eq!(put(&place, 0.5, None), "v0004");
    assert_eq!(pull(&place, &nothing, None, None).unwrap(), None);
}

#[test]
fn what_the_key_does_not_trust_takes_no_copys_place() {
    let place = Place::in_memory();
    let signing = Signing::new();
    push(&contents(0.2), &place, None, Some(signing.clone())).unwrap();
    let (dir, copy) = fresh();
    let key = Some(signing.key());
    assert_eq!(pull(&place, &copy, None, key).unwrap(), None);
    let kept = names(&dir.path().join("versions/v0001"));
    let signature = "versions/v0001/manifest.json.minisig";
    let tag = place.get(signature).unwrap().1;
    let another = b"untrusted comment: none";
    place.swap(signature, another, tag.as_deref()).unwrap();
    let said = pull(&place, &copy, None, key).unwrap();
    assert!(said.unwrap().contains("v0001 is used"));
    assert_eq!(names(&dir.path().join("versions/v0001")), kept);
    copy.load_trusted(None, signing.key()).unwrap();
    let (none, nothing) = fresh();
    pull(&place, &nothing, None, key).expect_err("no copy, and nobody vouches");
    assert!(nothing.latest().is_err() && !none.path().join("versions/v0001").exists());
}

#[test]
fn a_place_without_versions_leaves_nothing_in_a_copy() {
    let (dir, copy) = fresh();
    pull(&Place::in_memory(), &copy, None, None).expect_err("nothing there");
    pull(&Place::in_memory(), &copy, Some("v0001"), None).expect_err("nothing there");
    assert!(names(dir.path()).is_empty());
}

#[test]
fn what_a_stopped_publisher_left_is_passed_over() {
    let place = Place::in_memory();
    put(&place, 0.2, None);
    assert!(place.create("versions/v0002/rig.toml", b"begun").unwrap());
    assert_eq!(put(&place, 0.3, None), "v0003");
    let (_dir, copy) = fresh();
    pull(&place, &copy, None, None).unwrap();
    assert_eq!(copy.latest().unwrap(), "v0003");
}

#[test]
fn a_path_in_a_manifest_leads_nowhere() {
    let place = Place::in_memory();
    place.create("latest", b"../../etc\n").unwrap();
    let (_dir, copy) = fresh();
    assert!(matches!(
        pull(&place, &copy, None, None),
        Err(ArtifactError::BadLatest { .. })
    ));
}

#[test]
fn of_six_publishers_at_once_one_wins_and_the_others_are_told() {
    for race in 0..10 {
        let place = Place::in_memory();
        put(&place, 0.1, None);
        let start = Arc::new(Barrier::new(6));
        let racers = (0..6).map(|number| {
            let (place, start) = (place.clone(), Arc::clone(&start));
            thread::spawn(move || {
                let contents = contents(0.2 + 0.01 * f64::from(number));
                start.wait();
                (push(&contents, &place, Some("v0001"), None), contents)
            })
        });
        let racers: Vec<_> = racers.collect();
        let results: Vec<_> = racers
            .into_iter()
            .map(|racer| racer.join().unwrap())
            .collect();
        let won: Vec<_> = results
            .iter()
            .filter(|(result, _)| result.is_ok())
            .collect();
        assert_eq!(won.len(), 1, "race {race}");
        for (result, _) in &results {
            let is_clear = matches!(result, Ok(_) | Err(ArtifactError::Overtaken { .. }));
            assert!(is_clear, "race {race}: {result:?}");
        }
        let (_dir, copy) = fresh();
        pull(&place, &copy, None, None).unwrap();
        let used: Contents = copy.load(None).unwrap().into();
        assert_eq!(used, won[0].1);
    }
}
