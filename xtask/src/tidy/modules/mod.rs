//! In every folder of a crate, modules depend on each other in one direction.
//!
//! A module is its file together with everything below it. It depends on a sibling when one of its files imports or names an
//! item that is defined in the sibling; a re-export stands for the file that defines the item. A module may use its own
//! children and be used by them: it contains them. Declaring a module (`mod a;`) and handing on its items (`pub use a::A;`) is
//! no dependency unless the file also uses them. Read as text: methods are not followed to the file of their `impl`, and code
//! for tests is left out.

mod resolve;
mod source;
mod tokens;

use super::{Finding, SourceFile};
use resolve::Modules;
use std::collections::{BTreeMap, BTreeSet};

/// Looks at every crate: what lies below a `lib.rs` or `main.rs`.
pub fn check(files: &[SourceFile]) -> Vec<Finding> {
    let folders: BTreeSet<&str> = files
        .iter()
        .filter_map(|file| {
            let name = file.path.strip_suffix("lib.rs").or_else(|| file.path.strip_suffix("main.rs"))?;
            name.ends_with('/').then_some(name)
        })
        .collect();
    let mut findings = Vec::new();
    for folder in folders {
        let modules = Modules::below(folder, files);
        for (parent, siblings) in modules.dependencies() {
            for cycle in cycles(&siblings) {
                let text = words(&format!("{folder}{parent}"), &cycle);
                findings.push(Finding(text));
            }
        }
    }
    findings
}

/// For each of some siblings the siblings that it depends on, and what is taken from each: `user.rs: Item`.
type Dependencies = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// Dependencies within each largest group of siblings that all depend on each other.
fn cycles(dependencies: &Dependencies) -> Vec<Dependencies> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        dependencies.keys().map(|module| (module.as_str(), reachable(dependencies, module))).collect();
    let mut done: BTreeSet<&str> = BTreeSet::new();
    let mut found = Vec::new();
    for (module, beyond) in &reached {
        if done.contains(module) || !beyond.contains(module) {
            continue;
        }
        let back = |other: &&str| reached.get(other).is_some_and(|back| back.contains(module));
        let group: BTreeSet<&str> = beyond.iter().copied().filter(back).collect();
        done.extend(&group);
        let mut inside = dependencies.clone();
        inside.retain(|from, on| {
            on.retain(|to, _| group.contains(to.as_str()));
            group.contains(from.as_str())
        });
        found.push(inside);
    }
    found
}

/// Siblings that can be reached from one along one dependency or more.
fn reachable<'a>(dependencies: &'a Dependencies, from: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::new();
    let mut left: Vec<&str> = vec![from];
    while let Some(module) = left.pop() {
        for to in dependencies.get(module).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(to.as_str()) {
                left.push(to);
            }
        }
    }
    reached
}

fn words(parent: &str, cycle: &Dependencies) -> String {
    let mut text = format!("{parent}: {} modules depend on each other in a cycle:", cycle.len());
    for (from, on) in cycle {
        for (to, names) in on {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            text += &format!("\n    {from} → {to} ({})", names.join("; "));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_says(files: &[(&str, &str)], expected: &[&str]) {
        let files: Vec<SourceFile> = files
            .iter()
            .map(|(path, text)| SourceFile { path: format!("crates/a/src/{path}"), text: text.to_string() })
            .collect();
        let found: Vec<String> = check(&files).into_iter().map(|Finding(text)| text).collect();
        let lines: Vec<&str> = found.iter().flat_map(|text| text.lines().map(str::trim)).collect();
        assert_eq!(lines, expected);
    }

    #[test]
    fn two_files_that_import_each_other_are_found() {
        check_says(
            &[
                ("lib.rs", "mod x; mod y; pub use x::X;"),
                ("x.rs", "use crate::y::f; pub struct X;"),
                ("y.rs", "use super::x::X; pub fn f() {}"),
            ],
            &[
                "crates/a/src/: 2 modules depend on each other in a cycle:",
                "x → y (x.rs: f)",
                "y → x (y.rs: X)",
            ],
        );
    }

    #[test]
    fn a_cycle_through_re_exports_folders_and_paths_in_code_is_found() {
        check_says(
            &[
                ("lib.rs", "mod p; mod q; mod z; pub use p::Inner;"),
                ("p/mod.rs", "mod inner; mod other; pub use inner::Inner;"),
                ("p/inner.rs", "pub struct Inner;"),
                ("p/other.rs", "fn f() { crate::q::g() }"),
                ("q.rs", "mod r; pub fn g() { r::h() }"),
                ("q/r.rs", "use crate::z::alias; pub fn h(_: alias::X) {}"),
                ("z.rs", "pub mod alias { pub use crate::Inner as X; pub fn f(_: X) {} }"),
            ],
            &[
                "crates/a/src/: 3 modules depend on each other in a cycle:",
                "p → q (p/other.rs: g)",
                "q → z (q/r.rs: X; q/r.rs: alias)",
                "z → p (z.rs: Inner)",
            ],
        );
    }

    #[test]
    fn a_cycle_deep_in_a_folder_is_found() {
        check_says(
            &[
                ("lib.rs", "mod p;"),
                ("p/mod.rs", "mod c; mod d;"),
                ("p/c.rs", "use super::d::D; pub struct C;"),
                ("p/d.rs", "pub struct D; fn f(_: super::c::C) {}"),
            ],
            &[
                "crates/a/src/p: 2 modules depend on each other in a cycle:",
                "c → d (p/c.rs: D)",
                "d → c (p/d.rs: C)",
            ],
        );
    }

    #[test]
    fn a_glob_counts_as_its_module() {
        check_says(
            &[
                ("main.rs", "mod x; mod y; fn main() { x::a() }"),
                ("x.rs", "use crate::y::*; pub fn a() { b() }"),
                ("y.rs", "pub fn b() { crate::x::a() }"),
            ],
            &[
                "crates/a/src/: 2 modules depend on each other in a cycle:",
                "x → y (x.rs: *)",
                "y → x (y.rs: a)",
            ],
        );
    }

    #[test]
    fn trees_without_a_cycle_pass() {
        check_says(
            &[
                // Declared and handed on, and not used by the parent.
                ("lib.rs", "mod p; mod low; pub use p::{run, Options};"),
                // A parent and its child may use each other.
                ("p/mod.rs", "mod c; pub use c::run; pub struct Options; fn f() { run() }"),
                ("p/c.rs", "use super::Options; use crate::low; pub fn run() { low::f() }"),
                // Names of other crates and tests are no dependencies.
                ("low.rs", "use serde::p; pub fn f() {} #[cfg(test)] mod tests { use crate::p::run; }"),
            ],
            &[],
        );
    }
}
