//! Runs command lines in this process.

use std::path::Path;

use carom::{Cli, Error, Outcome, Output, execute};
use clap::Parser;
use serde_json::Value;
use tempfile::TempDir;

pub fn carom(line: &str) -> Result<Output, Error> {
    let words = line.split_whitespace();
    let cli = Cli::try_parse_from(["carom", "--quiet"].into_iter().chain(words));
    execute(&cli.unwrap_or_else(|error| panic!("{line}: {error}")))
}

/// What a command says that does not fail.
pub fn answer(line: &str) -> Output {
    carom(line).unwrap_or_else(|error| panic!("{line}: failed to {error}"))
}

pub fn done(line: &str) -> Value {
    let said = answer(line);
    assert_eq!(said.outcome, Outcome::Done, "{line}: {}", said.text);
    said.json
}

/// A folder that goes when it is dropped, and its path as it is typed.
pub fn folder_and_path() -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().display().to_string();
    (folder, dir)
}

/// A folder and its path, with a demo of these options in its folder `rig`.
pub fn demo(options: &str) -> (TempDir, String) {
    let (folder, dir) = folder_and_path();
    done(&format!("demo {options} --out {dir}/rig"));
    (folder, dir)
}

pub fn computed(said: &Value) -> Vec<(String, u64)> {
    let stages = said["stages"].as_array().unwrap();
    let row = |stage: &Value| {
        let name = stage["name"].as_str().unwrap();
        (name.into(), stage["computed"].as_u64().unwrap())
    };
    stages.iter().map(row).collect()
}

/// The outcome of a command that fails, and what it says.
pub fn refusal(line: &str) -> (Outcome, String) {
    match carom(line) {
        Ok(said) => panic!("{line}: {}", said.text),
        Err(error) => (error.outcome(), error.to_string()),
    }
}

/// What a command says that was asked for what cannot be.
pub fn bad_input(line: &str) -> String {
    let (outcome, text) = refusal(line);
    assert_eq!(outcome, Outcome::BadInput, "{line}: {text}");
    text
}

/// The bytes of every file of a folder, by name.
pub fn bytes(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap();
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        (name, std::fs::read(entry.path()).unwrap())
    };
    let mut files: Vec<_> = entries.map(file).collect();
    files.sort();
    files
}

pub fn json(dir: &Path, file: &str) -> Value {
    let text = std::fs::read_to_string(dir.join(file)).expect(file);
    serde_json::from_str(&text).unwrap()
}

/// Whether the page forbids the browser to fetch anything, and names nothing to be fetched; `make report` watches one.
pub fn fetches_nothing(page: &str) -> bool {
    let named = "src=|href=\"http|url(|@import|fetch(|XMLHttpRequest|import(";
    page.contains("default-src 'none'") && named.split('|').all(|name| !page.contains(name))
}

pub fn write(path: &Path, text: &str) {
    std::fs::write(path, text).unwrap();
}
