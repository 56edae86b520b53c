//! From 500 strike logs to a robot that hits: the paper's residual takes 81.6 % off sysid's error; at least 82 % here.

use std::{fs, path::Path};

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
