//! From strike logs to a robot that hits.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::{carom, mean};

fn read(path: &Path) -> Value {
    let text =
        fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).expect("JSON")
}

fn residual_hits(object: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let dir = folder.path().display();
    carom(&format!(
        "demo --strikes 500 --seed 11 --object {object} --out {dir}/rig"
    ));
    carom(&format!(
        "run {dir}/rig/logs --rig {dir}/rig/rig.toml --out {dir}"
    ));
    carom(&format!("trial --artifacts {dir} --robot sim:{dir}/rig"));

    let evaluation = read(&folder.path().join("evaluation.json"));
    let (sysid, residual) = (
        mean(&evaluation, "sysid"),
        mean(&evaluation, "sysid_residual"),
    );
    println!("{object}, held out: sysid {sysid:.4} m, with residual {residual:.4} m");
    assert!(sysid < mean(&evaluation, "nominal"));
    // What the demo hides leaves identification centimetres, and repeats millimetres.
    let floor = evaluation["noise_floor"]["mean"].as_f64().expect("a floor");
    assert!((0.03..0.10).contains(&sysid), "{object}: {sysid} m");
    assert!((0.003..0.008).contains(&floor), "{object}: {floor} m");
    assert!(
        residual < 0.18 * sysid,
        "{object}: {residual} of {sysid} m left on held-out strikes"
    );

    let trial = read(&folder.path().join("trial.json"));
    for (part, models) in [("Figure 8", &trial["figure_8"]), ("random targets", &trial)] {
        let (sysid, residual) = (mean(models, "sysid"), mean(models, "sysid_residual"));
        println!("{object}, {part}: sysid {sysid:.4} m, with residual {residual:.4} m");
        assert!(
            residual < 0.18 * sysid,
            "{object}, {part}: {residual} of {sysid} m left"
        );
    }
}

#[test]
fn the_residual_takes_82_per_cent_off_sysid_for_a_cylinder() {
    residual_hits("cylinder");
}

#[test]
fn the_residual_takes_82_per_cent_off_sysid_for_a_box() {
    residual_hits("box");
}

#[test]
fn real_strikes_run_whole() {
    let strikes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/kuka-strikes");
    if !strikes.is_dir() {
        println!("skipped: no real strikes beside this checkout");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (dir, from) = (folder.path().display(), strikes.display());
    let said = carom(&format!(
        "run {from}/logs --rig {from}/rig.toml --out {dir}"
    ));
    assert_eq!(said.json["strikes"], 50, "{}", said.text);
    let text = fs::read_to_string(folder.path().join("evaluation.json")).expect("evaluated");
    let evaluation: Value = serde_json::from_str(&text).expect("JSON");
    for model in ["nominal", "sysid", "sysid_residual"] {
        println!("{model}: {:.4} m held out", mean(&evaluation, model));
    }
    assert!(mean(&evaluation, "sysid") < mean(&evaluation, "nominal"));
}
