//! What a file declares, imports, exports and names.

use super::tokens::{self, Token};
use std::collections::{BTreeMap, BTreeSet};

/// An imported path and the name that it has in the file: `use a::b as c` is `[a, b]` named `c`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Import {
    /// The path's segments; the last is `*` for everything.
    pub path: Vec<String>,
    /// Its name here; `*` for everything.
    pub name: String,
    /// Whether it is handed on (`pub use`, `pub(crate) use`).
    pub public: bool,
}

/// A file without what is for tests only.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// Modules in files of their own (`mod a;`).
    pub modules: BTreeSet<String>,
    /// Names of items that are defined here.
    pub items: BTreeSet<String>,
    /// Imports, wherever they stand.
    pub imports: Vec<Import>,
    /// Paths of two segments and more in code, such as `crate::a::f` and `a::f`.
    pub paths: BTreeSet<Vec<String>>,
    /// All names in code apart from imports.
    pub names: BTreeSet<String>,
}

const DEFINING: [&str; 9] =
    ["fn", "struct", "enum", "trait", "type", "const", "static", "union", "macro_rules"];

/// Reads a file.
pub fn read(text: &str) -> Source {
    let tokens = tokens::of(text);
    let mut source = Source::default();
    // Inline modules and the depth of brackets at which each ends: `super` in them begins further in.
    let mut inline: Vec<usize> = Vec::new();
    let mut depth = 0;
    let mut i = 0;
    while i < tokens.len() {
        let next = |k: usize| tokens.get(i + k);
        match &tokens[i] {
            Token::Name(word) if word == "use" && next(1).is_some_and(begins_path) => {
                let public = handed_on(&tokens[..i]);
                let mut found = BTreeMap::new();
                i = tree(&tokens, i + 1, &mut Vec::new(), &mut found);
                for (path, name) in found {
                    let name = name.unwrap_or_else(|| path.last().cloned().unwrap_or_default());
                    if let Some(path) = outward(path, inline.len()) {
                        source.imports.push(Import { path, name, public });
                    }
                }
            }
            Token::Name(word) if word == "mod" && next(1).is_some_and(|t| t.name().is_some()) => {
                let name = next(1).and_then(Token::name).unwrap_or_default().to_owned();
                if next(2) == Some(&Token::Mark(';')) {
                    source.modules.insert(name);
                } else {
                    inline.push(depth);
                    source.items.insert(name);
                }
                i += 2;
            }
            Token::Name(first) => {
                if DEFINING.contains(&first.as_str()) {
                    let behind = if first == "macro_rules" { 2 } else { 1 };
                    source.items.extend(next(behind).and_then(Token::name).map(String::from));
                }
                let mut path = vec![first.clone()];
                i += 1;
                while let (Some(Token::Path), Some(Token::Name(name))) = (tokens.get(i), tokens.get(i + 1)) {
                    path.push(name.clone());
                    i += 2;
                }
                source.names.extend(path.iter().cloned());
                if path.len() > 1 {
                    source.paths.extend(outward(path, inline.len()));
                }
            }
            token => {
                match token {
                    Token::Mark('{') => depth += 1,
                    Token::Mark('}') => {
                        depth = usize::saturating_sub(depth, 1);
                        inline.pop_if(|opened| *opened >= depth);
                    }
                    _ => {}
                }
                i += 1;
            }
        }
    }
    source
}

/// `pub` or `pub(…)` ends here.
fn handed_on(before: &[Token]) -> bool {
    match before {
        [.., Token::Name(word)] => word == "pub",
        [.., Token::Mark(')')] => {
            let open = before.iter().rposition(|t| *t == Token::Mark('('));
            open.is_some_and(|open| open > 0 && before[open - 1].is("pub"))
        }
        _ => false,
    }
}

fn begins_path(token: &Token) -> bool {
    matches!(token, Token::Name(_) | Token::Path | Token::Mark('{'))
}

/// A tree of imports behind `at`; returns where it ends.
fn tree(
    tokens: &[Token],
    mut at: usize,
    front: &mut Vec<String>,
    found: &mut BTreeMap<Vec<String>, Option<String>>,
) -> usize {
    let depth = front.len();
    loop {
        match tokens.get(at) {
            Some(Token::Name(word)) if word == "as" => {
                let name = tokens.get(at + 1).and_then(Token::name).map(String::from);
                found.insert(front.clone(), name);
                front.truncate(depth);
                at += 2;
                continue;
            }
            Some(Token::Name(word)) => front.push(word.clone()),
            Some(Token::Mark('*')) => front.push("*".into()),
            Some(Token::Path) => {}
            Some(Token::Mark('{')) => {
                at = tree(tokens, at + 1, front, found);
                front.truncate(depth);
                continue;
            }
            Some(Token::Mark(',')) => {
                leaf(front, depth, found);
            }
            Some(Token::Mark('}')) => {
                leaf(front, depth, found);
                return at + 1;
            }
            _ => {
                leaf(front, depth, found);
                return at;
            }
        }
        at += 1;
    }
}

fn leaf(front: &mut Vec<String>, depth: usize, found: &mut BTreeMap<Vec<String>, Option<String>>) {
    if front.len() > depth {
        let mut path = front.clone();
        // `use a::{self}` is a.
        path.pop_if(|last| last == "self");
        found.entry(path).or_insert(None);
        front.truncate(depth);
    }
}

/// A path of an inline module as the file has it: one `super` less for each level. None: it stays inside.
fn outward(mut path: Vec<String>, inline: usize) -> Option<Vec<String>> {
    for _ in 0..inline {
        match path.first().map(String::as_str) {
            Some("super") => drop(path.remove(0)),
            Some("crate") => return Some(path),
            _ => return None,
        }
    }
    if inline > 0 && !matches!(path.first().map(String::as_str), Some("super" | "crate" | "self")) {
        path.insert(0, "self".into());
    }
    Some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn imports(text: &str) -> Vec<String> {
        let source = read(text);
        let words = |import: &Import| {
            let public = if import.public { "pub " } else { "" };
            format!("{public}{} as {}", import.path.join("::"), import.name)
        };
        source.imports.iter().map(words).collect()
    }

    #[test]
    fn trees_of_imports_are_taken_apart() {
        assert_eq!(imports("use crate::a::B;"), ["crate::a::B as B"]);
        assert_eq!(imports("pub(crate) use a::{b::C, D as E};"), ["pub a::D as E", "pub a::b::C as C"]);
        assert_eq!(
            imports("use super::{self, x::{self, Y}};"),
            ["super as super", "super::x as x", "super::x::Y as Y"]
        );
        assert_eq!(imports("use super::*; fn f() { use crate::g; }"), ["super::* as *", "crate::g as g"]);
    }

    #[test]
    fn paths_in_code_and_definitions_are_read() {
        let source = read("mod a; struct S; fn f() { crate::b::g(); a::h() } macro_rules! m { () => {} }");
        let paths: Vec<String> = source.paths.iter().map(|path| path.join("::")).collect();
        assert_eq!(paths, ["a::h", "crate::b::g"]);
        assert!(source.modules.contains("a"));
        assert_eq!(source.items.iter().collect::<Vec<_>>(), ["S", "f", "m"]);
    }

    #[test]
    fn inline_modules_count_as_their_file() {
        let source = read("mod inner { use super::super::other::X; use super::Y; use Z; } use crate::W;");
        let paths: Vec<String> = source.imports.iter().map(|import| import.path.join("::")).collect();
        assert_eq!(paths, ["super::other::X", "self::Y", "crate::W"]);
    }
}
