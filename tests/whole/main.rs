//! The whole of carom, as its users run it.

#[expect(clippy::unwrap_used, reason = "the workspace's own files are read")]
mod circles;
mod end_to_end;
mod faults;
#[expect(clippy::unwrap_used, reason = "the workspace's own files are read")]
mod floors;
mod fuzz;
mod reproducible;
mod rows;
mod sessions;

/// Runs a `carom` command line that must succeed.
fn carom(line: &str) -> carom::Output {
    tests::carom(line).unwrap_or_else(|error| panic!("{error:#}"))
}

/// Mean stop error in m of a model in a table of models.
fn mean(table: &serde_json::Value, model: &str) -> f64 {
    table[model]["mean"]
        .as_f64()
        .unwrap_or_else(|| panic!("no {model} in {table}"))
}
