//! Files of a crate import each other in no circle: what two files share is in a third.
//!
//! An edge runs from the file that names an item (`use crate::…`, `super::…`, `child::…`) to the file that defines it. A `pub use`
//! that only hands an item on is no edge. Test modules are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, Macro, MetaList, UseTree, Visibility};

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
    /// Names that are handed on (re-exported).
    handed_on: BTreeSet<String>,
    /// Paths in the code.
    paths: Vec<Vec<String>>,
    /// All identifiers of the code.
    words: BTreeSet<String>,
}

impl Module {
    /// Paths of this crate that the code depends on.
    fn named(&self) -> impl Iterator<Item = &Vec<String>> {
        let is_used = |name: &str| !self.handed_on.contains(name) || self.words.contains(name);
        let imports = self.imports.iter().filter(move |(name, _)| is_used(name));
        imports.map(|(_, path)| path).chain(&self.paths)
    }

    /// What stands in a macro or an attribute.
    fn scan(&mut self, tokens: &str) {
        let is_in_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        for word in tokens.replace(" :: ", "::").split(|c| !is_in_path(c)) {
            let parts: Vec<String> = word.split("::").map(String::from).collect();
            self.words.extend(parts.iter().cloned());
            if parts.len() > 1 {
                self.paths.push(parts);
            }
        }
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    let is_test = |list: &MetaList| list.path.is_ident("cfg") && list.tokens.to_string() == "test";
    let lists = attributes.iter().filter_map(|a| a.meta.require_list().ok());
    lists.into_iter().any(is_test)
}

impl<'s> Visit<'s> for Module {
    fn visit_item(&mut self, item: &'s Item) {
        let attributes = match item {
            Item::Const(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Mod(item) => &item.attrs,
            Item::Static(item) => &item.attrs,
            Item::Struct(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'s ItemMod) {
        self.children.insert(item.ident.to_string());
        let inside = item.content.iter().flat_map(|(_, items)| items);
        inside.for_each(|item| self.visit_item(item));
    }

    fn visit_item_use(&mut self, item: &'s ItemUse) {
        let mut found = Vec::new();
        expand(&item.tree, &[], &mut found);
        if !matches!(item.vis, Visibility::Inherited) {
            let names = found.iter().map(|(name, _)| name.clone());
            self.handed_on.extend(names);
        }
        self.imports.extend(found);
    }

    fn visit_path(&mut self, path: &'s syn::Path) {
        let parts = path.segments.iter().map(|part| part.ident.to_string());
        if path.leading_colon.is_none() && path.segments.len() > 1 {
            self.paths.push(parts.collect());
        }
        visit::visit_path(self, path);
    }

    fn visit_ident(&mut self, ident: &'s syn::Ident) {
        self.words.insert(ident.to_string());
    }

    fn visit_macro(&mut self, item: &'s Macro) {
        self.visit_path(&item.path);
        self.scan(&item.tokens.to_string());
    }

    fn visit_meta_list(&mut self, list: &'s MetaList) {
        self.scan(&list.tokens.to_string());
    }
}

/// Each name that a tree below a path brings into scope, and its path.
fn expand(tree: &UseTree, at: &[String], found: &mut Vec<(String, Vec<String>)>) {
    let below = |name: String| [at, &[name]].concat();
    match tree {
        UseTree::Path(path) => expand(&path.tree, &below(path.ident.to_string()), found),
        UseTree::Group(group) => group.items.iter().for_each(|tree| expand(tree, at, found)),
        UseTree::Name(name) if name.ident == "self" => {
            found.push((at.last().cloned().unwrap_or_default(), at.to_vec()));
        }
        UseTree::Name(name) => found.push((name.ident.to_string(), below(name.ident.to_string()))),
        UseTree::Rename(name) => {
            found.push((name.rename.to_string(), below(name.ident.to_string())));
        }
        UseTree::Glob(_) => found.push(("*".into(), below("*".into()))),
    }
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
        let mut module = Module {
            file: file.to_path_buf(),
            ..Module::default()
        };
        let parsed = syn::parse_file(&text(file));
        module.visit_file(&parsed.unwrap_or_else(|error| panic!("{}: {error}", file.display())));
        for child in &module.children {
            let file = [format!("{child}.rs"), format!("{child}/mod.rs")].map(|f| folder.join(f));
            // A module in braces is part of its file.
            if let Some(file) = file.iter().find(|file| file.is_file()) {
                let path = [path.clone(), vec![child.clone()]].concat();
                self.add(path, file, &folder.join(child));
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
            let files = module.named().filter_map(|named| self.file(path, named, 0));
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
