//! The four floors of the workspace: a crate depends on crates of its own floor and of those below.

use std::collections::BTreeMap;
use std::path::Path;

const FLOORS: [&str; 4] = ["pipeline", "stages", "artifacts", "datasets"];

#[test]
fn no_dependency_runs_up_a_floor() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let manifest = read(&root.join("Cargo.toml"));
    let workspace = manifest["workspace"].as_table().unwrap();
    let folders: BTreeMap<&str, &str> = workspace["dependencies"]
        .as_table()
        .unwrap()
        .iter()
        .filter_map(|(name, spec)| Some((name.as_str(), spec.get("path")?.as_str()?)))
        .collect();
    let members = workspace["members"].as_array().unwrap();
    assert!(members.len() >= 19, "{members:?}");
    let mut up = Vec::new();
    for member in members.iter().map(|member| member.as_str().unwrap()) {
        // The tests of the whole belong to no floor.
        if member.starts_with("tests") {
            continue;
        }
        let crate_manifest = read(&root.join(member).join("Cargo.toml"));
        for kind in ["dependencies", "dev-dependencies", "build-dependencies"] {
            let Some(dependencies) = crate_manifest.get(kind).and_then(|d| d.as_table()) else {
                continue;
            };
            let within = dependencies.keys().filter_map(|name| folders.get(&**name));
            for dependency in within.filter(|to| floor(to) < floor(member)) {
                up.push(format!("{member} -> {dependency}"));
            }
        }
    }
    assert!(up.is_empty(), "these arrows run up: {up:?}");
}

fn read(path: &Path) -> toml::Table {
    let text =
        std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.parse()
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// 0 at the top.
fn floor(folder: &str) -> usize {
    let top = folder.split('/').next().unwrap();
    FLOORS
        .iter()
        .position(|floor| *floor == top)
        .unwrap_or_else(|| panic!("{folder} stands on no floor of {FLOORS:?}"))
}
