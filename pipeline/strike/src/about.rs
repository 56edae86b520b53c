//! What a build is: what `--version` prints, and what the log of a strike says of the program.

use std::sync::OnceLock;

/// The commit, where the program told it. A program's `main` alone knows it at compile time: a new commit then rebuilds no library.
static COMMIT: OnceLock<&str> = OnceLock::new();

/// Tells what the program was built from, before anything else is done; none or nothing where its build was not told.
pub fn built_from(commit: Option<&'static str>) {
    if let Some(commit) = commit.filter(|commit| !commit.is_empty()) {
        // The first one stays.
        let _ = COMMIT.set(commit);
    }
}

/// The program, for the log of a strike: its version and, where that is known, its commit.
pub(crate) fn program() -> String {
    named(COMMIT.get().copied())
}

fn named(commit: Option<&str>) -> String {
    let commit = commit.map_or(String::new(), |commit| format!(" ({commit})"));
    format!("carom {}{commit}", env!("CARGO_PKG_VERSION"))
}

/// A program's version, the commit that it was built from, its engine, and the versions of the formats that it reads and writes.
pub fn about(formats: &[(&str, u32)]) -> String {
    described(COMMIT.get().copied(), formats)
}

fn described(commit: Option<&str>, formats: &[(&str, u32)]) -> String {
    let commit = commit.unwrap_or("not known: built without make");
    let formats: Vec<String> = formats
        .iter()
        .map(|(name, version)| format!("{name} {version}"))
        .collect();
    format!(
        "{} (commit {commit})\nengine: MuJoCo {}\nformats: {}",
        env!("CARGO_PKG_VERSION"),
        world::mujoco_version(),
        formats.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_says_its_commit_its_engine_and_its_formats() {
        let text = described(Some("0123456789ab"), &[("versions", 2), ("tables", 3)]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with("(commit 0123456789ab)"), "{text}");
        assert!(lines[1].starts_with("engine: MuJoCo 3."), "{text}");
        assert_eq!(lines[2], "formats: versions 2, tables 3");
        assert!(described(None, &[]).contains("not known"));
        assert!(named(Some("0123456789ab")).ends_with(" (0123456789ab)"));
        assert!(!named(None).contains('('));
    }
}
