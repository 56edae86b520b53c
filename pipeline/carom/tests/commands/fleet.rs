//! A night over several rigs.

use std::fs;

use carom::Outcome;
use serde_json::Value;

use crate::fixture::{
    answer, bad_input, bytes, done, fetches_nothing, folder_and_path, json, write,
};

#[test]
fn each_rig_is_decided_on_by_itself_and_what_they_share_is_said() {
    let (folder, dir) = folder_and_path();
    let path = folder.path();
    let bias = |degrees: f64| format!("--hide striker_angle_bias={}", degrees.to_radians());
    for (rig, seed, hidden) in [("left", 1, bias(3.0)), ("right", 2, bias(-4.0))] {
        done(&format!(
            "demo --strikes 100 --seed {seed} {hidden} --out {dir}/{rig}"
        ));
    }
    let recipes = |names: &[&str]| {
        let recipe =
            |name: &&str| format!("[{name}]\nlogs = ['{name}/logs']\nrig = '{name}/rig.toml'\n");
        names.iter().map(recipe).collect::<String>()
    };
    // The first has no rig file, the last no logs.
    fs::create_dir_all(path.join("none/logs")).unwrap();
    fs::copy(path.join("left/rig.toml"), path.join("none/rig.toml")).unwrap();
    write(
        &path.join("fleet.toml"),
        &recipes(&["broken", "left", "none", "right"]),
    );
    fs::create_dir_all(path.join("broken/logs")).unwrap();

    let night = answer(&format!(
        "nightly --fleet {dir}/fleet.toml --out {dir}/runs"
    ));
    assert_eq!(night.outcome, Outcome::BadInput, "{}", night.text);
    assert_eq!(night.json, json(&path.join("runs"), "fleet.json"));
    let rigs = night.json["rigs"].as_array().unwrap();
    let exits: Vec<_> = rigs.iter().map(|rig| rig["exit"].as_u64()).collect();
    assert_eq!(
        exits,
        [Some(2), Some(0), Some(2), Some(0)],
        "{}",
        night.text
    );
    assert!(night.text.contains("carom rig init") && night.text.contains("find logs in"));
    let page = fs::read_to_string(path.join("runs/fleet.html")).unwrap();
    assert!(fetches_nothing(&page) && page.contains("left/report.html"));

    // What a rig's night alone would have published.
    done(&format!(
        "nightly {dir}/left/logs --rig {dir}/left/rig.toml --out {dir}/alone"
    ));
    let version = |run: &str| bytes(&path.join(run).join("versions/v0001"));
    assert_eq!(version("runs/left"), version("alone"));

    let known = night.json["known"].as_array().unwrap();
    let of = |name: &str| {
        let mut known = known.iter().filter(|one| one["name"] == name);
        known.next().unwrap_or_else(|| panic!("{name}: {known:?}"))
    };
    // The rigs have one table; their angles are off by what is each one's own, be it the arm or the camera.
    let friction = of("friction");
    assert_eq!(friction["part"], "table");
    assert!(friction["p_value"].as_f64().is_some(), "{friction}");
    let own = known.iter().filter(|one| one["shared"] == "own");
    let is_of_both = |one: &&Value| one["rigs"].as_object().is_some_and(|rigs| rigs.len() == 2);
    let mut of_both = own.filter(is_of_both);
    let turned = of_both.next().unwrap();
    assert!(
        turned["part"] != "table" && turned["common"].is_null(),
        "{turned}"
    );

    // The next night has nothing to decide.
    let next = answer(&format!(
        "nightly --fleet {dir}/fleet.toml --out {dir}/runs"
    ));
    assert_eq!(next.json["rigs"][1]["night"]["status"], "nothing_new");
    let why = bad_input(&format!("nightly --fleet {dir}/none.toml --out {dir}/runs"));
    assert!(why.contains("none.toml"), "{why}");
}
