//! Text into a tree of calls.

use crate::SolveError;

/// `name(arguments)`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Call {
    pub name: String,
    pub arguments: Vec<Argument>,
}

/// One argument, with its key if it has one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Argument {
    pub key: Option<String>,
    pub value: Value,
}

/// A number, or a word that may be a call.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Number(f64),
    Call(Call),
}

pub(super) fn parse(text: &str) -> Result<Call, SolveError> {
    let mut cursor = Cursor { text, characters: text.chars().collect(), at: 0, depth: 0 };
    let call = cursor.call("the name of a solver")?;
    cursor.blank();
    if cursor.at < cursor.characters.len() { Err(cursor.expected("the end")) } else { Ok(call) }
}

struct Cursor<'a> {
    text: &'a str,
    characters: Vec<char>,
    at: usize,
    /// Brackets that are open.
    depth: usize,
}

/// Characters of a text that a message shows.
const SHOWN: usize = 80;

/// Brackets within brackets that are read; no solver has more than two solvers inside.
const DEEPEST: usize = 16;

impl Cursor<'_> {
    fn expected(&self, expected: &'static str) -> SolveError {
        let mut text: String = self.text.chars().take(SHOWN).collect();
        if text.len() < self.text.len() {
            text.push('…');
        }
        SolveError::Grammar { text, expected, at: self.at }
    }

    fn blank(&mut self) {
        while self.characters.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
    }

    fn eat(&mut self, wanted: char) -> bool {
        self.blank();
        let found = self.characters.get(self.at) == Some(&wanted);
        self.at += usize::from(found);
        found
    }

    fn take(&mut self, wanted: impl Fn(char) -> bool) -> String {
        self.blank();
        let from = self.at;
        while self.characters.get(self.at).is_some_and(|c| wanted(*c)) {
            self.at += 1;
        }
        self.characters[from..self.at].iter().collect()
    }

    fn word(&mut self) -> String {
        self.blank();
        if self.characters.get(self.at).is_some_and(|c| c.is_ascii_alphabetic() || *c == '_') {
            self.take(|c| c.is_ascii_alphanumeric() || c == '_')
        } else {
            String::new()
        }
    }

    fn call(&mut self, expected: &'static str) -> Result<Call, SolveError> {
        let name = self.word();
        if name.is_empty() {
            return Err(self.expected(expected));
        }
        Ok(Call { name, arguments: self.arguments()? })
    }

    fn arguments(&mut self) -> Result<Vec<Argument>, SolveError> {
        let mut arguments = Vec::new();
        if !self.eat('(') || self.eat(')') {
            return Ok(arguments);
        }
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.expected("fewer brackets within brackets"));
        }
        loop {
            arguments.push(self.argument()?);
            if self.eat(')') {
                self.depth -= 1;
                return Ok(arguments);
            }
            if !self.eat(',') {
                return Err(self.expected("`,` or `)`"));
            }
        }
    }

    fn argument(&mut self) -> Result<Argument, SolveError> {
        let value = self.value()?;
        match value {
            Value::Call(Call { name, arguments }) if arguments.is_empty() && self.eat('=') => {
                Ok(Argument { key: Some(name), value: self.value()? })
            }
            value => Ok(Argument { key: None, value }),
        }
    }

    fn value(&mut self) -> Result<Value, SolveError> {
        const EXPECTED: &str = "a number or a word";
        let word = self.word();
        if !word.is_empty() {
            return Ok(Value::Call(Call { name: word, arguments: self.arguments()? }));
        }
        let from = self.at;
        let number = self.take(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '+' | '-'));
        number.parse().map(Value::Number).map_err(|_| {
            self.at = from;
            self.expected(EXPECTED)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_nest() {
        let call = parse("huber(svd(rcond=1e-10), k = 2, fast)").unwrap();
        assert_eq!((call.name.as_str(), call.arguments.len()), ("huber", 3));
        assert_eq!(call.arguments[1], Argument { key: Some("k".into()), value: Value::Number(2.0) });
        assert!(
            matches!(&call.arguments[0].value, Value::Call(c) if c.name == "svd" && c.arguments.len() == 1)
        );
        assert!(parse("a(1..2)").is_err() && parse("a(,)").is_err() && parse("a b").is_err());
    }
}
