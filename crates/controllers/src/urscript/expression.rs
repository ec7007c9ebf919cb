//! The few expressions that are read.

use crate::tokens::{Cursor, Kind, Token};
use std::ops::Range;

/// Six numbers with their places.
#[derive(Debug, Clone)]
pub(super) struct Six {
    pub(super) values: [f64; 6],
    pub(super) ranges: Vec<Range<usize>>,
    /// From 1.
    pub(super) line: usize,
}

#[derive(Debug, Clone)]
pub(super) enum Expression {
    Pose(Six),
    Joints(Six),
    Name(String),
    /// `pose_trans(frame, target)`
    In(Box<Expression>, Box<Expression>),
    /// `get_inverse_kin(target, qnear)`
    Inverse(Box<Expression>, Option<Box<Expression>>),
    Computed,
}

impl Expression {
    /// Of all these tokens.
    pub(super) fn read(text: &[u8], tokens: &[Token]) -> Expression {
        Expression::known(text, tokens, 0).unwrap_or(Expression::Computed)
    }

    fn known(text: &[u8], tokens: &[Token], depth: usize) -> Option<Expression> {
        let mut at = Cursor::new(text, tokens);
        if depth > 4 {
            return None;
        }
        let Some(word) = at.peek_word() else {
            return at.take(b'[').then(|| six(&mut at)).flatten().map(Expression::Joints);
        };
        at.at += 1;
        if at.done() {
            return Some(Expression::Name(word.into()));
        }
        if word == "p" && at.take(b'[') {
            return six(&mut at).map(Expression::Pose);
        }
        let inside = tokens.get(2..tokens.len().checked_sub(1)?)?;
        if !at.take(b'(') || !tokens.last()?.is(b')') {
            return None;
        }
        let parts = arguments(inside)?;
        let read = |tokens: &[Token]| Expression::known(text, tokens, depth + 1);
        match (word, &parts[..]) {
            ("pose_trans", [frame, target]) => {
                Some(Expression::In(Box::new(read(frame)?), Box::new(read(target)?)))
            }
            ("get_inverse_kin", parts) => {
                let of = |name: &str, place: usize| argument(text, parts, name, place);
                // With a tool of its own it is not the active one's.
                if of("tcp", 4).is_some() {
                    return None;
                }
                let near = of("qnear", 1).and_then(read).map(Box::new);
                Some(Expression::Inverse(Box::new(read(of("x", 0)?)?), near))
            }
            _ => None,
        }
    }
}

/// The argument of this name, or without a name at this place.
fn argument<'t>(text: &[u8], parts: &[&'t [Token]], name: &str, place: usize) -> Option<&'t [Token]> {
    let named = |part: &&&[Token]| {
        unnamed(text, part).len() < part.len() && Cursor::new(text, part).peek_word() == Some(name)
    };
    let found = parts.iter().find(named).map(|part| unnamed(text, part));
    found.or_else(|| parts.get(place).copied().filter(|part| unnamed(text, part).len() == part.len()))
}

/// `name=value` without its name.
pub(super) fn unnamed<'t>(text: &[u8], tokens: &'t [Token]) -> &'t [Token] {
    let named = Cursor::new(text, tokens).peek_word().is_some()
        && tokens.get(1).is_some_and(|token| token.is(b'='))
        && !tokens.get(2).is_some_and(|token| token.is(b'='));
    if named { &tokens[2..] } else { tokens }
}

/// Between commas outside of brackets; none where brackets do not match.
pub(super) fn arguments(tokens: &[Token]) -> Option<Vec<&[Token]>> {
    let mut parts = Vec::new();
    let (mut from, mut depth) = (0, 0i32);
    for (k, token) in tokens.iter().enumerate() {
        match token.kind {
            Kind::Sign(b'(' | b'[') => depth += 1,
            Kind::Sign(b')' | b']') => depth -= 1,
            Kind::Sign(b',') if depth == 0 => {
                parts.push(&tokens[from..k]);
                from = k + 1;
            }
            _ => {}
        }
        if depth < 0 {
            return None;
        }
    }
    parts.push(&tokens[from..]);
    (depth == 0).then_some(parts)
}

/// Behind the opening bracket; to the end of the tokens.
fn six(at: &mut Cursor<'_>) -> Option<Six> {
    let line = at.peek()?.line;
    let mut six = Six { values: [0.0; 6], ranges: Vec::new(), line };
    for k in 0..6 {
        let (value, range) = at.number()?;
        six.values[k] = value;
        six.ranges.push(range);
        if !at.take(if k < 5 { b',' } else { b']' }) {
            return None;
        }
    }
    at.done().then_some(six)
}
