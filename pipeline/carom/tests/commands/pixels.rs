//! Runs that start from a camera's images.

use std::path::Path;

use carom::Outcome;

use crate::fixture::{answer, bad_input, carom, demo, done, write};

/// Strikes are shown beside the images that they were tracked in: some of each, at the times of the strike.
fn is_shown_with_images(folder: &Path) {
    let dir = folder.display();
    let shown = done(&format!("view {dir}/run -o {dir}/run/view.mcap"));
    let bytes = std::fs::read(folder.join("run/view.mcap")).unwrap();
    let mut of_strikes: Vec<Vec<u64>> = Vec::new();
    let mut begins = Vec::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        match schema.name.as_str() {
            "strike.Strike" => {
                begins.push(message.log_time);
                of_strikes.push(Vec::new());
            }
            "foxglove.CompressedImage" => {
                let images = of_strikes.last_mut().unwrap();
                images.push(message.log_time);
            }
            _ => {}
        }
    }
    assert_eq!(of_strikes.len(), 12);
    let all: usize = of_strikes.iter().map(Vec::len).sum();
    assert_eq!(shown["shown"]["images"], all);
    for (images, begin) in of_strikes.iter().zip(begins) {
        // Half a second before first motion, the slide, a second after it.
        assert!((10..=120).contains(&images.len()), "{}", images.len());
        let first = images[0] - begin;
        assert!(first < 100_000_000, "{first}");
        assert!(images.is_sorted());
    }
}

#[test]
fn a_run_starts_from_images_tracks_them_once_and_is_rebuilt_from_them() {
    let (folder, dir) = demo("--strikes 12 --seed 3 --hide none --camera");

    let said = done(&format!(
        "track {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}/tracked"
    ));
    let frames = &said["tracked"][0]["frames"];
    assert_eq!(frames["frames"], frames["centroids"], "{said}");
    assert!(frames["frames"].as_u64() > Some(500), "{said}");

    let run = format!("run {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}/run");
    // So few strikes give a candidate.
    let candidate = || {
        let said = answer(&run);
        assert_eq!(said.outcome, Outcome::Refused, "{}", said.text);
        said.json
    };
    assert_eq!(candidate()["strikes"], 12);
    let kept = || -> Vec<_> {
        let folders = std::fs::read_dir(folder.path().join("run/tracked")).unwrap();
        let logs = folders.map(|entry| entry.unwrap().path().join("session_000.mcap"));
        logs.map(|log| (log.metadata().unwrap().modified().ok(), log))
            .collect()
    };
    let once = kept();
    assert_eq!(once.len(), 1, "{once:?}");
    candidate();
    assert_eq!(kept(), once, "tracked once");
    done(&format!("rebuild v0001 --artifacts {dir}/run"));
    is_shown_with_images(folder.path());

    // A view is written beside what is read and written, never over it.
    let log = folder.path().join("rig/logs/session_000.mcap");
    let before = std::fs::read(&log).unwrap();
    let line = format!(
        "track {} --rig {dir}/rig/rig.toml --out {dir}/again",
        log.display()
    );
    let link = folder.path().join("again/session_000.mcap");
    std::fs::create_dir(folder.path().join("again")).unwrap();
    std::fs::hard_link(&log, &link).unwrap();
    for view in [log.clone(), link.clone()] {
        let why = bad_input(&format!("{line} --view {}", view.display()));
        assert!(why.contains("another file with --view"), "{why}");
    }
    done(&format!("{line} --view {dir}/view.mcap"));
    assert_eq!(std::fs::read(&log).unwrap(), before);
    let tracked = folder.path().join("tracked/session_000.mcap");
    assert_eq!(
        std::fs::read(&link).unwrap(),
        std::fs::read(tracked).unwrap()
    );
    let left: Vec<_> = std::fs::read_dir(folder.path().join("again"))
        .unwrap()
        .collect();
    assert_eq!(left.len(), 1, "{left:?}");

    // The colour is found in the log itself.
    let tuned = done(&format!(
        "camera tune {dir}/rig/logs/session_000.mcap --rig {dir}/rig/rig.toml --out {dir}/found.png"
    ));
    assert!(tuned["area"].as_u64() > Some(100), "{tuned}");
    assert_eq!(tuned["found"]["trusted"], true, "{tuned}");
    let rig = std::fs::read_to_string(folder.path().join("rig/rig.toml")).unwrap();
    let large = rig.replace("radius = 0.03\n", "radius = 0.05\n");
    assert_ne!(rig, large);
    write(&folder.path().join("large.toml"), &large);
    let tuned = done(&format!(
        "camera tune {dir}/rig/logs/session_000.mcap --rig {dir}/large.toml --out {dir}/large.png"
    ));
    assert_eq!(tuned["found"]["trusted"], false, "{tuned}");
    assert!(tuned["found"]["reason"].is_string(), "{tuned}");

    // Another colour is another question: nothing of it is seen.
    let blue = rig.replace("hue = [340.0, 20.0]", "hue = [200.0, 240.0]");
    assert_ne!(rig, blue);
    write(&folder.path().join("blue.toml"), &blue);
    let unseen = carom(&format!(
        "track {dir}/rig/logs --rig {dir}/blue.toml --out {dir}/unseen"
    ));
    let unseen = unseen.unwrap();
    assert_eq!(unseen.outcome, Outcome::Rejected, "{}", unseen.text);
    assert!(unseen.text.contains("camera tune"), "{}", unseen.text);
    let said = answer(&format!(
        "run {dir}/rig/logs --rig {dir}/blue.toml --out {dir}/run"
    ));
    assert_eq!(said.outcome, Outcome::Refused, "{}", said.text);
    assert!(said.text.contains("no_object"), "{}", said.text);

    // A rig that names no images says how to name them.
    let (before, _) = rig.split_once("[topics.image]").unwrap();
    write(&folder.path().join("blind.toml"), before);
    let said = carom(&format!(
        "run {dir}/rig/logs --rig {dir}/blind.toml --out {dir}/blind"
    ));
    let why = said.expect_err("no centroids").to_string();
    assert!(why.contains("[topics.image]"), "{why}");
}
