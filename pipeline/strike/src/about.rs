//! What `--version` prints.

/// A program's version, the commit that it was built from (none where its build was not told), its engine, and the versions of the
/// formats that it reads and writes.
pub fn about(commit: Option<&str>, formats: &[(&str, u32)]) -> String {
    let commit = commit
        .filter(|commit| !commit.is_empty())
        .unwrap_or("not known: built without make");
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
        let text = about(Some("0123456789ab"), &[("versions", 2), ("tables", 3)]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].ends_with("(commit 0123456789ab)"), "{text}");
        assert!(lines[1].starts_with("engine: MuJoCo 3."), "{text}");
        assert_eq!(lines[2], "formats: versions 2, tables 3");
        for none in [None, Some("")] {
            assert!(about(none, &[]).contains("not known"));
        }
    }
}
