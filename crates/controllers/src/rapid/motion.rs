//! Motions, their arguments and options.

use super::file::{Candidate, Destination, File, Motion, indexed, shape, tool};
use super::instructions::{Argument, Signature};
use super::load::Held;
use super::node::Node;
use crate::ControllerError;
use crate::definitions::Definition;
use crate::flow::{Head, Step};
use crate::reference::Reference;
use crate::tokens::{Cursor, Kind, Token};

/// An argument without a name.
enum Given {
    Literal(Node, usize),
    Name(String),
    /// A function, a component, an expression.
    Computed,
}

impl File {
    /// Behind the instruction's name.
    pub(super) fn motion(
        &mut self,
        at: &mut Cursor<'_>,
        verb: &Token,
        signature: &Signature,
    ) -> Result<(), ControllerError> {
        let word = at.str_of(verb);
        let mut motion = Motion {
            head: Head { line: verb.line, shown: word.to_owned(), linear: signature.linear, odd: None },
            destinations: Vec::new(),
            tool: Reference::Unknown(format!("{word} in line {} names none", verb.line)),
            frame: Reference::Identity,
            load: Held { total: None, used: self.grip.motion() },
        };
        let mut arguments = Vec::new();
        while at.peek().is_some_and(|token| !token.is(b';')) {
            arguments.extend(given(at)?);
            options(at, &mut motion, signature);
            if !at.take(b',') {
                break;
            }
        }
        let count = arguments.len();
        if count < signature.least() {
            motion.head.odd.get_or_insert_with(|| "it has not the arguments of this instruction".into());
        }
        for (place, given) in arguments.into_iter().enumerate() {
            match (signature.argument(place, count), given) {
                (Argument::Point, given) => {
                    let destination = self.destination(given, &motion);
                    motion.destinations.push(destination);
                }
                (Argument::Tool, given) => motion.tool = held(given),
                (Argument::External, Given::Name(name)) => self.external.push(name),
                (Argument::Result, Given::Name(name)) => self.changed.push((name, motion.head.line)),
                _ => {}
            }
        }
        let end = at.peek().map_or(at.text.len(), |token| token.range.start);
        let shown = String::from_utf8_lossy(&at.text[verb.range.start..end.max(verb.range.start)]);
        motion.head.shown = shown.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(60).collect();
        if !motion.destinations.is_empty() {
            self.steps.push(Step::Motion(self.motions.len()));
            self.motions.push(motion);
        }
        Ok(())
    }

    fn destination(&mut self, given: Given, motion: &Motion) -> Destination {
        match given {
            Given::Name(name) => Destination::Name(name),
            Given::Literal(node, line) => match shape(&node) {
                Some(joints) => {
                    let name = format!("{} in line {}", motion.head.shown, motion.head.line);
                    let inline = Some(self.motions.len());
                    self.candidates.push(Candidate { name, line, node, joints, inline });
                    Destination::Inline(self.candidates.len() - 1)
                }
                None => Destination::Computed,
            },
            Given::Computed => Destination::Computed,
        }
    }
}

/// An argument without a name; none where only options are.
fn given(at: &mut Cursor<'_>) -> Result<Option<Given>, ControllerError> {
    let line = at.peek().map_or(0, |token| token.line);
    if at.peek().is_some_and(|token| token.is(b'\\')) {
        return Ok(None);
    }
    let found = if at.take(b'[') {
        Given::Literal(Node::list(at)?, line)
    } else {
        indexed(at).map_or(Given::Computed, Given::Name)
    };
    let ends = |token: &Token| matches!(token.kind, Kind::Sign(b',' | b';' | b'\\'));
    Ok(Some(if at.peek().is_none_or(ends) { found } else { Given::Computed }))
}

/// To the next comma or the end: `\WObj:=w1`, `\NoEOffs`.
fn options(at: &mut Cursor<'_>, motion: &mut Motion, signature: &Signature) {
    let mut depth = 0;
    while let Some(token) = at.peek() {
        match token.kind {
            Kind::Sign(b'(' | b'[' | b'{') => depth += 1,
            Kind::Sign(b')' | b']' | b'}') => depth -= 1,
            Kind::Sign(b',') if depth == 0 => break,
            Kind::Sign(b';') => break,
            Kind::Sign(b'\\') if depth == 0 => {
                at.at += 1;
                let option = at.word().unwrap_or("").to_ascii_uppercase();
                if !signature.has(&option) {
                    motion.head.odd = Some(format!("its option \\{option} is not known"));
                }
                if option == "TLOAD" {
                    at.take(b':');
                    at.take(b'=');
                    let computed = || Reference::Unknown("its \\TLoad is computed".into());
                    let load = indexed(at).map_or_else(computed, Reference::Named);
                    // load0 stands for the tool's own.
                    motion.load.total = Some(load).filter(|load| *load != Reference::Named("LOAD0".into()));
                }
                if option == "WOBJ" {
                    at.take(b':');
                    at.take(b'=');
                    motion.frame = match indexed(at).as_deref() {
                        Some("WOBJ0") => Reference::Identity,
                        Some(name) => Reference::Named(name.into()),
                        None => Reference::Unknown("its value is computed".into()),
                    };
                }
                continue;
            }
            _ => {}
        }
        at.at += 1;
    }
}

/// An argument as a tool.
fn held(given: Given) -> Reference {
    match given {
        Given::Name(name) if name == "TOOL0" => Reference::Identity,
        Given::Name(name) => Reference::Named(name),
        Given::Computed => Reference::Unknown("it is computed".into()),
        Given::Literal(node, _) => match tool(&node) {
            Definition::Value(pose) => Reference::Value(pose),
            Definition::Excluded(words) => Reference::Excluded(words),
            _ => Reference::Unknown("its value is computed".into()),
        },
    }
}
