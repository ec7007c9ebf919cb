//! `{X 1.0, Y 2.0, …}`.

use crate::ControllerError;
use crate::error::syntax;
use crate::number::{Form, Slot};
use crate::tokens::{Cursor, Kind, Token};
use std::ops::Range;

/// Components and their values.
#[derive(Debug, Clone)]
pub(super) struct Aggregate<'t> {
    pub(super) entries: Vec<Entry<'t>>,
    pub(super) line: usize,
}

#[derive(Debug, Clone)]
pub(super) struct Entry<'t> {
    /// In capitals.
    pub(super) name: String,
    /// Of a literal.
    pub(super) value: Option<Literal>,
    pub(super) tokens: &'t [Token],
}

#[derive(Debug, Clone)]
pub(super) struct Literal {
    pub(super) value: f64,
    pub(super) range: Range<usize>,
    pub(super) bits: bool,
}

impl<'t> Aggregate<'t> {
    /// Behind its opening brace.
    pub(super) fn read(at: &mut Cursor<'t>, line: usize) -> Result<Self, ControllerError> {
        let begin = at.tokens.get(at.at.saturating_sub(1)).map_or(0, |token| token.range.start);
        let open = || syntax(at.text, begin, "an aggregate is not closed in its line");
        let mut entries = Vec::new();
        if at.tokens.get(at.at + 1).is_some_and(|token| token.is(b':')) {
            at.at += 2;
        }
        loop {
            let name = at.word().map(str::to_ascii_uppercase);
            if at.take(b'[') {
                at.skip_closed();
            }
            let from = at.at;
            let mut depth = 0;
            loop {
                let Some(token) = at.peek() else { return Err(open()) };
                match token.kind {
                    Kind::End => return Err(open()),
                    Kind::Sign(b'{' | b'(' | b'[') => depth += 1,
                    Kind::Sign(b'}' | b',') if depth == 0 => break,
                    Kind::Sign(b'}' | b')' | b']') => depth -= 1,
                    _ => {}
                }
                at.at += 1;
            }
            let tokens = &at.tokens[from..at.at];
            entries.push(Entry { name: name.unwrap_or_default(), value: literal(at.text, tokens), tokens });
            if !at.take(b',') {
                break;
            }
        }
        at.take(b'}');
        Ok(Aggregate { entries, line })
    }

    pub(super) fn entry(&self, name: &str) -> Option<&Entry<'t>> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    pub(super) fn value(&self, name: &str) -> Option<f64> {
        self.entry(name).and_then(|entry| entry.value.as_ref()).map(|literal| literal.value)
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.entry(name).is_some()
    }

    /// The slots of these components, all of them literal.
    pub(super) fn slots(&self, text: &[u8], names: &[&str], least: &[usize]) -> Option<Vec<Slot>> {
        let one = |(name, &least): (&&str, &usize)| {
            let literal = self.entry(name)?.value.as_ref().filter(|literal| !literal.bits)?;
            Some(Slot::padded(text, literal.range.clone(), Form::Real(least)))
        };
        names.iter().zip(least).map(one).collect()
    }
}

/// A number, or `'B0101'` and `'H1F'`.
fn literal(text: &[u8], tokens: &[Token]) -> Option<Literal> {
    let mut at = Cursor::new(text, tokens);
    if let Some((value, range)) = at.number() {
        return at.done().then_some(Literal { value, range, bits: false });
    }
    let [token] = tokens else { return None };
    let shown = std::str::from_utf8(&text[token.range.clone()]).ok()?;
    let digits = shown.strip_prefix('\'')?.strip_suffix('\'')?;
    let digits = digits.strip_prefix(['B', 'b'])?;
    let value = i64::from_str_radix(digits, 2).ok().filter(|value| (0..1 << 16).contains(value))?;
    Some(Literal { value: value as f64, range: token.range.clone(), bits: true })
}
