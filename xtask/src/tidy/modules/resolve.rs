//! From a path in a file to the file that defines what it names.

use super::source::{self, Import, Source};
use super::{Dependencies, SourceFile};
use std::collections::BTreeMap;

/// Re-exports of re-exports are followed so far.
const DEPTH: usize = 16;

/// A module: its path from the crate's root.
type ModulePath = Vec<String>;

/// The modules of one crate.
pub struct Modules {
    of: BTreeMap<ModulePath, (String, Source)>,
}

/// What a path leads to.
enum Place {
    Module(ModulePath),
    /// Something that this module defines.
    ItemOf(ModulePath),
}

impl Modules {
    /// All files below a folder with a `lib.rs` or `main.rs`; files of tests only are left out.
    pub fn below(folder: &str, files: &[SourceFile]) -> Modules {
        let mut of = BTreeMap::new();
        for file in files {
            let Some(inside) = file.path.strip_prefix(folder) else { continue };
            let Some(stem) = inside.strip_suffix(".rs") else { continue };
            let mut path: ModulePath = stem.split('/').map(String::from).collect();
            if path.last().is_some_and(|last| last == "tests") {
                continue;
            }
            let root = path.len() == 1 && matches!(stem, "lib" | "main");
            if root || path.last().is_some_and(|last| last == "mod") {
                path.pop();
            }
            of.insert(path, (inside.to_owned(), source::read(&file.text)));
        }
        Modules { of }
    }

    /// For each module with children: which of these depends on which, and for what.
    pub fn dependencies(&self) -> BTreeMap<String, Dependencies> {
        let mut all: BTreeMap<String, Dependencies> = BTreeMap::new();
        for (from, (file, source)) in &self.of {
            for (to, name) in self.taken(from, source) {
                let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
                let (Some(user), Some(used)) = (from.get(common), to.get(common)) else {
                    continue; // one contains the other
                };
                all.entry(from[..common].join("/"))
                    .or_default()
                    .entry(user.clone())
                    .or_default()
                    .entry(used.clone())
                    .or_default()
                    .insert(format!("{file}: {name}"));
            }
        }
        all
    }

    /// The modules from which one takes something, and the names.
    fn taken(&self, module: &ModulePath, source: &Source) -> Vec<(ModulePath, String)> {
        let mut taken = Vec::new();
        let named = |path: &[String]| path.last().cloned().unwrap_or_default();
        for import in &source.imports {
            if import.name == "*" {
                let front = &import.path[..import.path.len() - 1];
                if let (false, Some(Place::Module(on))) = (import.public, self.place(module, front, 0)) {
                    taken.push((on, "*".into()));
                }
            } else if (!import.public || source.names.contains(&import.name))
                && let Some(Place::ItemOf(on)) = self.place(module, &import.path, 0)
            {
                taken.push((on, named(&import.path)));
            }
        }
        for path in &source.paths {
            if let Some(Place::ItemOf(on)) = self.place(module, path, 0) {
                taken.push((on, named(path)));
            }
        }
        taken
    }

    /// Where a path leads that stands in a module; none outside of the crate.
    fn place(&self, module: &ModulePath, path: &[String], depth: usize) -> Option<Place> {
        if depth > DEPTH {
            return None;
        }
        let mut here = module.clone();
        let mut left = path;
        match path.first()?.as_str() {
            "crate" => (here, left) = (ModulePath::new(), &path[1..]),
            "self" => left = &path[1..],
            "super" => {}
            // A name that is neither a module nor imported here is another crate's, or local.
            first => {
                return match self.member(module, first, depth + 1)? {
                    Place::Module(next) => self.within(next, &path[1..], depth),
                    item => Some(item),
                };
            }
        }
        while left.first().is_some_and(|word| word == "super") {
            here.pop()?;
            left = &left[1..];
        }
        self.within(here, left, depth)
    }

    /// Where the rest of a path leads, from a module of this crate.
    fn within(&self, mut here: ModulePath, left: &[String], depth: usize) -> Option<Place> {
        for name in left {
            match self.member(&here, name, depth + 1) {
                Some(Place::Module(next)) => here = next,
                Some(item) => return Some(item),
                // Made by a macro, as far as can be seen.
                None => return self.of.contains_key(&here).then_some(Place::ItemOf(here)),
            }
        }
        Some(Place::Module(here))
    }

    /// What a name means in a module: a child, a definition, or what it imports.
    fn member(&self, module: &ModulePath, name: &str, depth: usize) -> Option<Place> {
        if depth > DEPTH {
            return None;
        }
        let (_, source) = self.of.get(module)?;
        if source.modules.contains(name) {
            let mut child = module.clone();
            child.push(name.to_owned());
            if self.of.contains_key(&child) {
                return Some(Place::Module(child));
            }
        }
        if source.items.contains(name) {
            return Some(Place::ItemOf(module.clone()));
        }
        let imported =
            |import: &&Import| import.name == name && import.path.last().is_some_and(|last| last != "*");
        if let Some(import) = source.imports.iter().find(imported) {
            // `use a;` of a crate a must not lead back to itself.
            let itself = import.path.len() == 1;
            return if itself { None } else { self.place(module, &import.path, depth + 1) };
        }
        source.imports.iter().filter(|import| import.name == "*" && import.public).find_map(|import| {
            match self.place(module, &import.path[..import.path.len() - 1], depth + 1)? {
                Place::Module(from) => self.member(&from, name, depth + 1),
                item => Some(item),
            }
        })
    }
}
