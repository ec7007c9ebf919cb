//! A Rust file as names and punctuation, without comments, literals and what is compiled for tests only.

/// One token. `::` and `=>`-like pairs are not joined, but for the `::` that paths need.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Token {
    /// An identifier, keyword, number, or `_`.
    Name(String),
    /// `::`.
    Path,
    /// Any other character.
    Mark(char),
}

impl Token {
    /// The identifier, if it is one.
    pub fn name(&self) -> Option<&str> {
        match self {
            Token::Name(name) => Some(name),
            _ => None,
        }
    }

    /// Whether it is this identifier.
    pub fn is(&self, name: &str) -> bool {
        self.name() == Some(name)
    }
}

/// Tokens of a file, tests left out.
pub fn of(text: &str) -> Vec<Token> {
    without_tests(all(text))
}

fn all(text: &str) -> Vec<Token> {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < chars.len() {
        let c = chars[i];
        match c {
            '/' if at(i + 1) == '/' => {
                while i < chars.len() && chars[i] != '\n' {
                    i += 1;
                }
            }
            '/' if at(i + 1) == '*' => i = behind_comment(&chars, i),
            '"' => i = behind_string(&chars, i),
            '\'' => i = behind_quote(&chars, i),
            ':' if at(i + 1) == ':' => {
                tokens.push(Token::Path);
                i += 2;
            }
            _ if c.is_alphanumeric() || c == '_' => {
                let from = i;
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
                let name: String = chars[from..i].iter().collect();
                match raw_string(&chars, i, &name) {
                    Some(behind) => i = behind,
                    None => tokens.push(Token::Name(name)),
                }
            }
            _ => {
                if !c.is_whitespace() {
                    tokens.push(Token::Mark(c));
                }
                i += 1;
            }
        }
    }
    tokens
}

fn behind_comment(chars: &[char], from: usize) -> usize {
    let (mut depth, mut i) = (0, from);
    while i < chars.len() {
        match (chars[i], chars.get(i + 1)) {
            ('/', Some('*')) => (depth, i) = (depth + 1, i + 2),
            ('*', Some('/')) => (depth, i) = (depth - 1, i + 2),
            _ => i += 1,
        }
        if depth == 0 {
            break;
        }
    }
    i
}

fn behind_string(chars: &[char], from: usize) -> usize {
    let mut i = from + 1;
    while i < chars.len() && chars[i] != '"' {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// Behind a character literal; behind the quote alone where it begins a lifetime.
fn behind_quote(chars: &[char], from: usize) -> usize {
    if chars.get(from + 1) == Some(&'\\') {
        let mut i = from + 3;
        while i < chars.len() && chars[i] != '\'' {
            i += 1;
        }
        return i + 1;
    }
    if chars.get(from + 2) == Some(&'\'') { from + 3 } else { from + 1 }
}

/// Behind `r"…"`, `r#"…"#`, `br"…"`, where the name in front of `at` is such a prefix.
fn raw_string(chars: &[char], at: usize, prefix: &str) -> Option<usize> {
    if !matches!(prefix, "r" | "br" | "b") {
        return None;
    }
    if prefix == "b" {
        return (chars.get(at) == Some(&'"')).then(|| behind_string(chars, at));
    }
    let hashes = chars[at.min(chars.len())..].iter().take_while(|c| **c == '#').count();
    if chars.get(at + hashes) != Some(&'"') {
        return None;
    }
    let mut i = at + hashes + 1;
    while i < chars.len() {
        if chars[i] == '"' && chars[i + 1..].iter().take(hashes).filter(|c| **c == '#').count() == hashes {
            return Some(i + 1 + hashes);
        }
        i += 1;
    }
    Some(chars.len())
}

/// Leaves out every item behind `#[cfg(test)]`.
fn without_tests(tokens: Vec<Token>) -> Vec<Token> {
    let gate = all("#[cfg(test)]");
    let mut kept = Vec::with_capacity(tokens.len());
    let mut i = 0;
    while i < tokens.len() {
        if tokens[i..].starts_with(&gate) {
            i = behind_item(&tokens, i + gate.len());
        } else {
            kept.push(tokens[i].clone());
            i += 1;
        }
    }
    kept
}

/// Behind the item that begins here: its `;`, or the bracket that closes its first `{`.
fn behind_item(tokens: &[Token], from: usize) -> usize {
    let mut depth = 0usize;
    for (i, token) in tokens.iter().enumerate().skip(from) {
        match token {
            Token::Mark('{' | '(' | '[') => depth += 1,
            Token::Mark('}' | ')' | ']') => {
                depth = depth.saturating_sub(1);
                // `use a::{b, c};` ends at its semicolon, which is no harm to keep.
                if depth == 0 && *token == Token::Mark('}') {
                    return i + 1;
                }
            }
            Token::Mark(';') if depth == 0 => return i + 1,
            _ => {}
        }
    }
    tokens.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_names(text: &str, expected: &[&str]) {
        let tokens = of(text);
        let names: Vec<&str> = tokens.iter().filter_map(Token::name).collect();
        assert_eq!(names, expected);
    }

    #[test]
    fn comments_and_literals_are_left_out() {
        check_names("a // b\n/* c /* d */ e */ f", &["a", "f"]);
        check_names(r##"a("b \" c", 'd', '\'', '\n', r#"e " f"#, b"g") h"##, &["a", "h"]);
        check_names("fn f<'a>(x: &'a str) {}", &["fn", "f", "a", "x", "a", "str"]);
        check_names("/// crate::a\nx", &["x"]);
    }

    #[test]
    fn what_is_for_tests_only_is_left_out() {
        check_names("a;\n#[cfg(test)]\nmod tests { use b; fn c() {} }\nd", &["a", "d"]);
        check_names("#[cfg(test)]\nmod tests;\nd", &["d"]);
        check_names("#[cfg(test)]\n#[derive(Debug)]\nstruct A { b: u8 }\nd", &["d"]);
    }
}
