//! Places by URL, without a server: in memory, and folders.

use store::objects::{ObjectError, Place};

fn both() -> (tempfile::TempDir, [Place; 2]) {
    let dir = tempfile::tempdir().expect("folder");
    let url = format!("file://{}", dir.path().join("store").display());
    let folder = Place::open(&url).expect("a place");
    (dir, [Place::in_memory(), folder])
}

#[test]
fn objects_are_listed_read_by_ranges_and_written_on_conditions() {
    let (_dir, places) = both();
    for place in places {
        assert!(place.list().expect("empty").is_empty());
        assert!(place.create("a/b.mcap", b"0123456789").expect("creates"));
        assert!(place.create("a/b.mcap", b"0123456789").expect("is there"));
        assert!(!place.create("a/b.mcap", b"another").expect("is another's"));
        let listed = place.list().expect("lists");
        assert_eq!(
            (listed.len(), &*listed[0].name, listed[0].size),
            (1, "a/b.mcap", 10)
        );
        assert_eq!(place.read(&listed[0], 2..5).expect("reads"), b"234");
        let error = place.get("none").expect_err("nothing there");
        assert!(error.is_not_found(), "{error}");

        assert!(place.swap("latest", b"1", None).expect("first"));
        assert!(!place.swap("latest", b"2", None).expect("is there"));
        let (_, tag) = place.get("latest").expect("there");
        assert!(place.swap("latest", b"2", tag.as_deref()).expect("swaps"));
        assert!(
            !place
                .swap("latest", b"3", tag.as_deref())
                .expect("overtaken")
        );
        assert_eq!(place.get("latest").expect("there").0, b"2");
    }
}

#[test]
fn a_log_that_is_replaced_while_it_is_read_is_an_error() {
    let place = Place::in_memory();
    place.create("a.mcap", b"0123456789").expect("creates");
    let listed = place.list().expect("lists").remove(0);
    let (_, tag) = place.get("a.mcap").expect("there");
    place
        .swap("a.mcap", b"abcdefghij", tag.as_deref())
        .expect("swaps");
    let error = place.read(&listed, 0..5).expect_err("another content");
    assert!(matches!(error, ObjectError::Changed { .. }), "{error}");
}

#[test]
fn no_error_repeats_a_secret_of_a_url() {
    for url in [
        "s3://key:SECRET@bucket/logs",
        "az://container/logs?sig=SECRET",
        "https://user:SECRET@host/logs",
        "s3://SECRET@bucket",
        "nonsense://SECRET@x?SECRET#SECRET",
    ] {
        let error = Place::open(url).expect_err("refused");
        let text = format!("{error} {error:?}");
        assert!(!text.contains("SECRET"), "{text}");
    }
}
