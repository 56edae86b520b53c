//! Real strikes of a real arm, where they are beside the checkout.

use std::{fs, path::Path};

use serde_json::Value;

use crate::{carom, mean};

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
