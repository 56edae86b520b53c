//! Files of a crate import each other in no circle: what two files share is in a third.
//!
//! An edge runs from the file that names an item (`use crate::…`, `super::…`, `child::…`) to the file that defines it. A `pub use`
//! that only hands an item on is no edge. Test modules are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn no_circle_of_files_imports_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let manifest: toml::Table = text(&root.join("Cargo.toml")).parse().unwrap();
    let members = manifest["workspace"]["members"].as_array().unwrap().clone();
    let mut found = Vec::new();
    let mut files = 0;
    for member in members.iter().map(|member| member.as_str().unwrap()) {
        let sources = Crate::read(&root.join(member).join("src"));
        files += sources.modules.len();
        let circles = sources.circles();
        let named = circles
            .into_iter()
            .map(|circle| format!("{member}: {circle:?}"));
        found.extend(named);
    }
    assert!(files > 200, "only {files} files were read");
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_circle_is_found_through_re_exports_and_inline_paths() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = dir.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    write("lib.rs", "mod a;\nmod b;\nmod c;\npub use a::A;\n");
    write("a.rs", "pub struct A;\nfn f() { super::b::g() }\n");
    write("b.rs", "use crate::{A, c::{self, C}};\npub fn g() {}\n");
    write(
        "c/mod.rs",
        "mod d;\npub use d::D;\n// use crate::a::A;\npub struct C;\n#[cfg(test)]\nmod tests { use crate::b::g; }\n",
    );
    write("c/d.rs", "pub struct D;\n");
    let circles = Crate::read(dir.path()).circles();
    assert_eq!(circles, [["a.rs", "b.rs"]]);
}

/// A module: its file, what it declares and what it names.
#[derive(Default)]
struct Module {
    file: PathBuf,
    children: BTreeSet<String>,
    /// Names brought into scope, and their paths.
    imports: BTreeMap<String, Vec<String>>,
    /// Paths that the code depends on.
    named: Vec<Vec<String>>,
}

/// The modules of a crate by their path from its root.
struct Crate {
    modules: BTreeMap<Vec<String>, Module>,
    source: PathBuf,
}

impl Crate {
    fn read(source: &Path) -> Self {
        let mut this = Self {
            modules: BTreeMap::new(),
            source: source.to_path_buf(),
        };
        let root = ["lib.rs", "main.rs"].map(|name| source.join(name));
        if let Some(root) = root.iter().find(|file| file.is_file()) {
            this.add(Vec::new(), root, source);
        }
        this
    }

    /// Reads a module and those that it declares, which lie in `folder`.
    fn add(&mut self, path: Vec<String>, file: &Path, folder: &Path) {
        let code = without_tests(&without_comments(&text(file)));
        let (uses, body) = split_uses(&code);
        let mut module = Module {
            file: file.to_path_buf(),
            children: declared(&body),
            ..Module::default()
        };
        let words = words(&body);
        for (is_public, tree) in uses {
            for (name, target) in expand(&tree) {
                if !is_public || words.contains(&name) {
                    module.named.push(target.clone());
                }
                module.imports.insert(name, target);
            }
        }
        module.named.extend(paths(&body, &module.children));
        for child in module.children.clone() {
            let file = [format!("{child}.rs"), format!("{child}/mod.rs")].map(|f| folder.join(f));
            // A module in braces is part of its file.
            if let Some(file) = file.iter().find(|file| file.is_file()) {
                let path = [path.clone(), vec![child.clone()]].concat();
                self.add(path, file, &folder.join(&child));
            }
        }
        self.modules.insert(path, module);
    }

    /// The file that defines `named` in module `from`; none for another crate's.
    fn file(&self, from: &[String], named: &[String], depth: usize) -> Option<&Path> {
        let (first, mut rest) = named.split_first()?;
        let mut at = from.to_vec();
        match first.as_str() {
            "crate" => at.clear(),
            "self" => {}
            "super" => {
                at.pop();
            }
            _ => {
                if !self.modules.get(from)?.children.contains(first) {
                    return None;
                }
                rest = named;
            }
        }
        while let Some((next, after)) = rest.split_first() {
            let module = self.modules.get(&at)?;
            let below = [at.clone(), vec![next.clone()]].concat();
            if next == "super" {
                at.pop();
            } else if self.modules.contains_key(&below) {
                at = below;
            } else {
                // Handed on from elsewhere, or defined here.
                let handed_on = module.imports.get(next).filter(|_| depth < 8);
                let elsewhere = handed_on.and_then(|path| self.file(&at, path, depth + 1));
                return elsewhere.or(Some(&module.file));
            }
            rest = after;
        }
        Some(&self.modules.get(&at)?.file)
    }

    /// The circles, each as the sorted names of its files.
    fn circles(&self) -> Vec<Vec<String>> {
        let mut to: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
        for (path, module) in &self.modules {
            let files = module
                .named
                .iter()
                .filter_map(|named| self.file(path, named, 0));
            let others = files.filter(|file| *file != module.file);
            to.entry(&module.file).or_default().extend(others);
        }
        let reached: BTreeMap<&Path, BTreeSet<&Path>> =
            to.keys().map(|file| (*file, reach(&to, file))).collect();
        let mut circles = BTreeSet::new();
        for (file, from_here) in &reached {
            if from_here.contains(file) {
                let together = from_here
                    .iter()
                    .filter(|other| reached[*other].contains(file));
                let name = |file: &&Path| {
                    let name = file.strip_prefix(&self.source).unwrap_or(file);
                    name.display().to_string()
                };
                circles.insert(together.map(name).collect::<Vec<_>>());
            }
        }
        circles.into_iter().collect()
    }
}

/// Every file that can be reached from one, itself only by a circle.
fn reach<'a>(to: &BTreeMap<&'a Path, BTreeSet<&'a Path>>, from: &Path) -> BTreeSet<&'a Path> {
    let mut reached = BTreeSet::new();
    let mut next: Vec<&Path> = to[from].iter().copied().collect();
    while let Some(file) = next.pop() {
        if reached.insert(file) {
            next.extend(to.get(file).into_iter().flatten());
        }
    }
    reached
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Code without line comments and without ordinary string literals.
fn without_comments(code: &str) -> String {
    let mut out = String::new();
    for line in code.lines() {
        let mut chars = line.chars().peekable();
        let mut in_text = false;
        while let Some(c) = chars.next() {
            match c {
                '\\' if in_text => drop(chars.next()),
                '"' => {
                    in_text = !in_text;
                    out.push(c);
                }
                '/' if !in_text && chars.peek() == Some(&'/') => break,
                _ if in_text => {}
                _ => out.push(c),
            }
        }
        out.push('\n');
    }
    // Braces as characters would close what they do not.
    out.replace("'{'", "' '")
        .replace("'}'", "' '")
        .replace("'\"'", "' '")
}

/// Code without the items that follow `#[cfg(test)]`.
fn without_tests(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut out = String::new();
    let mut rest = code;
    while let Some(start) = rest.find(MARK) {
        out.push_str(&rest[..start]);
        rest = &rest[start + MARK.len()..];
        let mut depth = 0_usize;
        let end = rest.char_indices().find(|(_, c)| {
            match c {
                '{' => depth += 1,
                '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            depth == 0 && matches!(c, '}' | ';')
        });
        rest = end.map_or("", |(end, _)| &rest[end + 1..]);
    }
    out + rest
}

/// The `use` items, whether each is public and its tree, and the code without them.
fn split_uses(code: &str) -> (Vec<(bool, String)>, String) {
    let mut uses = Vec::new();
    let mut body = String::new();
    let mut tree: Option<(bool, String)> = None;
    for line in code.lines() {
        let line = line.trim();
        let start = line.find("use ").filter(|at| {
            let before = line[..*at].trim();
            before.is_empty() || before.starts_with("pub")
        });
        match (&mut tree, start) {
            (None, Some(at)) => tree = Some((at > 0, line[at + 4..].to_string())),
            (Some((_, tree)), _) => tree.push_str(line),
            (None, None) => {
                body.push_str(line);
                body.push('\n');
            }
        }
        if let Some((is_public, text)) = tree.take_if(|(_, text)| text.ends_with(';')) {
            uses.push((is_public, text.trim_end_matches(';').to_string()));
        }
    }
    (uses, body)
}

fn declared(body: &str) -> BTreeSet<String> {
    let declared = body.lines().filter_map(|line| {
        let at = line.find("mod ")?;
        let before = line[..at].trim();
        let is_declaration = before.is_empty() || before.starts_with("pub");
        let name = line[at + 4..].trim_end_matches([';', '{', ' ']);
        (is_declaration && line.ends_with([';', '{'])).then(|| name.to_string())
    });
    declared.collect()
}

/// Each name that a tree brings into scope, and its path.
fn expand(tree: &str) -> Vec<(String, Vec<String>)> {
    let tree = tree.trim();
    if let Some(open) = tree.find('{') {
        let prefix = parts(tree[..open].trim_end_matches("::"));
        let inside = tree[open + 1..].trim_end().trim_end_matches('}');
        // Only the last brace is this tree's.
        let close = tree.rfind('}').unwrap_or(tree.len());
        let inside = if close > open {
            &tree[open + 1..close]
        } else {
            inside
        };
        let branches = split_commas(inside)
            .into_iter()
            .flat_map(|branch| expand(&branch));
        return branches
            .map(|(name, path)| {
                let is_self = path == ["self"];
                let whole = [prefix.clone(), if is_self { Vec::new() } else { path }].concat();
                let name = if is_self {
                    prefix.last().cloned().unwrap_or_default()
                } else {
                    name
                };
                (name, whole)
            })
            .collect();
    }
    let (path, name) = match tree.split_once(" as ") {
        Some((path, name)) => (parts(path), name.trim().to_string()),
        None => (
            parts(tree),
            tree.rsplit("::")
                .next()
                .unwrap_or_default()
                .trim()
                .to_string(),
        ),
    };
    if path.is_empty() {
        Vec::new()
    } else {
        vec![(name, path)]
    }
}

fn parts(path: &str) -> Vec<String> {
    let parts = path.split("::").map(|part| part.trim().to_string());
    parts.filter(|part| !part.is_empty()).collect()
}

fn split_commas(text: &str) -> Vec<String> {
    let mut found = vec![String::new()];
    let mut depth = 0_usize;
    for c in text.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if c == ',' && depth == 0 {
            found.push(String::new());
        } else if let Some(last) = found.last_mut() {
            last.push(c);
        }
    }
    found
}

/// All identifiers but the names of declared modules.
fn words(body: &str) -> BTreeSet<String> {
    let is_outside = |c: char| !c.is_alphanumeric() && c != '_';
    body.lines()
        .filter(|line| !(line.contains("mod ") && line.ends_with(';')))
        .flat_map(|line| line.split(is_outside))
        .map(String::from)
        .collect()
}

/// Paths in the code that begin in this crate: at `crate`, `self`, `super` or a child module.
fn paths(body: &str, children: &BTreeSet<String>) -> Vec<Vec<String>> {
    let is_in_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let candidates = body
        .split(|c: char| !is_in_path(c))
        .filter(|word| word.contains("::"));
    candidates
        .filter(|word| !word.starts_with("::"))
        .map(parts)
        .filter(|path| {
            let first = path[0].as_str();
            ["crate", "self", "super"].contains(&first) || children.contains(first)
        })
        .collect()
}
