//! Aggregates: lists in brackets.

use crate::ControllerError;
use crate::error::syntax;
use crate::tokens::{Cursor, Kind};
use std::ops::Range;

/// A value.
#[derive(Debug, Clone)]
pub(super) enum Node {
    List(Vec<Node>),
    Number(f64, Range<usize>),
    /// In capitals.
    Word(String),
    /// A text, or something that is computed.
    Other,
}

impl Node {
    /// Behind the opening bracket.
    pub(super) fn list(at: &mut Cursor<'_>) -> Result<Node, ControllerError> {
        Node::nested(at, 0)
    }

    fn nested(at: &mut Cursor<'_>, depth: usize) -> Result<Node, ControllerError> {
        let begin = at.tokens.get(at.at.saturating_sub(1)).map_or(0, |token| token.range.start);
        if depth > 8 {
            return Err(syntax(at.text, begin, "brackets are nested deeper than any point's"));
        }
        let mut items = Vec::new();
        loop {
            items.push(Node::one(at, depth, begin)?);
            if at.take(b']') {
                return Ok(Node::List(items));
            }
            if !at.take(b',') {
                return Err(syntax(at.text, begin, "a list in brackets is not closed"));
            }
        }
    }

    fn one(at: &mut Cursor<'_>, depth: usize, begin: usize) -> Result<Node, ControllerError> {
        let from = at.at;
        let found = if at.take(b'[') {
            Some(Node::nested(at, depth + 1)?)
        } else if let Some((value, range)) = at.number() {
            Some(Node::Number(value, range))
        } else {
            at.word().map(|word| Node::Word(word.to_ascii_uppercase()))
        };
        if let Some(found) = found
            && at.peek().is_some_and(|token| token.is(b',') || token.is(b']'))
        {
            return Ok(found);
        }
        at.at = from;
        let mut open = 0;
        while let Some(token) = at.peek() {
            match token.kind {
                Kind::Sign(b'[' | b'(' | b'{') => open += 1,
                Kind::Sign(b',' | b']') if open == 0 => return Ok(Node::Other),
                Kind::Sign(b';') => break,
                Kind::Sign(b']' | b')' | b'}') => open -= 1,
                _ => {}
            }
            at.at += 1;
        }
        Err(syntax(at.text, begin, "a list in brackets is not closed"))
    }

    pub(super) fn items(&self) -> &[Node] {
        match self {
            Node::List(items) => items,
            _ => &[],
        }
    }

    /// Numbers and their places, if it is a list of so many.
    pub(super) fn numbers(&self, count: usize) -> Option<Vec<(f64, Range<usize>)>> {
        let items = self.items();
        let one = |node: &Node| match node {
            Node::Number(value, range) => Some((*value, range.clone())),
            _ => None,
        };
        (items.len() == count).then(|| items.iter().map(one).collect()).flatten()
    }

    pub(super) fn is_word(&self, word: &str) -> bool {
        matches!(self, Node::Word(found) if found == word)
    }
}
