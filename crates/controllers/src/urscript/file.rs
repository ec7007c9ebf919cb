//! What one script says, statement by statement.

use super::expression::{Expression, arguments, unnamed};
use crate::ControllerError;
use crate::flow::{Active, FRAME, Flow, TOOL};
use crate::program::Reference;
use crate::tokens::{Cursor, Kind, Lexis, Token, tokens};

const LEXIS: Lexis = Lexis { comment: b'#', quotes: b"\"'", header: None, escapes: true };
const MOTIONS: [&str; 6] = ["movej", "movel", "movep", "movec", "servoj", "servoc"];

/// A destination of a motion.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) line: usize,
    pub(super) verb: String,
    pub(super) target: Expression,
    pub(super) used: usize,
}

#[derive(Debug, Clone)]
pub(super) struct File {
    pub(super) motions: Vec<Motion>,
    pub(super) uses: Vec<Active>,
    /// Name, value, line.
    pub(super) assigned: Vec<(String, Expression, usize)>,
    /// Names of which an element is set.
    pub(super) changed: Vec<(String, usize)>,
}

impl File {
    pub(super) fn read(text: &[u8]) -> Result<File, ControllerError> {
        let all = tokens(text, LEXIS)?;
        let statements = statements(&all);
        let setters = setters(text, &statements);
        let file = File { motions: Vec::new(), uses: Vec::new(), assigned: Vec::new(), changed: Vec::new() };
        let mut flow = Flow::new("set_tcp is not called before");
        flow.set(FRAME, Reference::Identity);
        let mut reader = Reader { text, file, flow, depth: 0, setters };
        for statement in &statements {
            reader.statement(statement);
        }
        reader.file.uses = reader.flow.uses;
        Ok(reader.file)
    }
}

/// Lines; those inside of brackets are joined.
fn statements(all: &[Token]) -> Vec<Vec<Token>> {
    let mut found = Vec::new();
    let mut statement: Vec<Token> = Vec::new();
    let mut depth = 0;
    for token in all {
        match token.kind {
            Kind::Sign(b'(' | b'[') => depth += 1,
            Kind::Sign(b')' | b']') => depth = (depth - 1).max(0),
            Kind::End if depth == 0 => {
                found.push(std::mem::take(&mut statement));
                continue;
            }
            Kind::End => continue,
            _ => {}
        }
        statement.push(token.clone());
    }
    found.push(statement);
    found.retain(|statement| !statement.is_empty());
    found
}

/// Routines that set the tool, directly or by calling one that does.
fn setters(text: &[u8], statements: &[Vec<Token>]) -> Vec<String> {
    let mut routines: Vec<(String, Vec<String>)> = Vec::new();
    let mut stack: Vec<Option<usize>> = Vec::new();
    for statement in statements {
        let mut at = Cursor::new(text, statement);
        match at.word() {
            Some("def" | "thread") => {
                routines.push((at.word().unwrap_or("").into(), Vec::new()));
                stack.push(Some(routines.len() - 1));
            }
            Some("if" | "while") => stack.push(None),
            Some("end") => {
                stack.pop();
            }
            Some(word) => {
                for routine in stack.iter().flatten() {
                    routines[*routine].1.push(word.into());
                }
            }
            None => {}
        }
    }
    let mut found: Vec<String> = vec!["set_tcp".into()];
    // Each round takes in the callers of those found; there are at most as many rounds as routines.
    for _ in 0..=routines.len() {
        for (name, called) in &routines {
            if !found.contains(name) && called.iter().any(|word| found.contains(word)) {
                found.push(name.clone());
            }
        }
    }
    found.remove(0);
    found
}

struct Reader<'t> {
    text: &'t [u8],
    file: File,
    flow: Flow,
    depth: usize,
    setters: Vec<String>,
}

impl Reader<'_> {
    fn statement(&mut self, tokens: &[Token]) {
        let mut at = Cursor::new(self.text, tokens);
        let line = tokens[0].line;
        let Some(first) = at.word() else { return };
        match first {
            "def" | "thread" => {
                self.flow.open(false);
                if self.depth > 0 {
                    let words = "a routine may be called with another tool";
                    self.flow.set(TOOL, Reference::Unknown(words.into()));
                }
                self.depth += 1;
            }
            "if" => self.flow.open(false),
            "elif" | "else" => self.flow.branch(),
            "while" => self.flow.open(true),
            "end" => {
                self.flow.close();
                self.depth = self.depth.saturating_sub(usize::from(tokens.len() == 1 && self.depth > 1));
            }
            _ => {
                if matches!(first, "global" | "local") {
                    self.assignment(tokens, 1, line);
                } else if at.take(b'(') {
                    self.call(first, tokens, line);
                } else {
                    self.assignment(tokens, 0, line);
                }
            }
        }
    }

    fn assignment(&mut self, tokens: &[Token], from: usize, line: usize) {
        let mut at = Cursor { at: from, ..Cursor::new(self.text, tokens) };
        let Some(name) = at.word().map(str::to_owned) else { return };
        if at.take(b'[') {
            at.skip_closed();
            if at.take(b'=') {
                self.file.changed.push((name, line));
            }
            return;
        }
        if at.take(b'=') && !at.done() && !at.peek().is_some_and(|token| token.is(b'=')) {
            let value = Expression::read(self.text, &tokens[at.at..]);
            self.file.assigned.push((name, value, line));
        }
    }

    fn call(&mut self, verb: &str, tokens: &[Token], line: usize) {
        let closed = tokens.last().is_some_and(|token| token.is(b')'));
        let parts = tokens.get(2..tokens.len() - 1).filter(|_| closed).and_then(arguments);
        let parts: Vec<&[Token]> =
            parts.unwrap_or_default().into_iter().map(|part| unnamed(self.text, part)).collect();
        if verb == "set_tcp" {
            let tool = match parts.first().map(|part| Expression::read(self.text, part)) {
                Some(Expression::Pose(six)) => {
                    crate::Dialect::UrScript.pose(&six.values).map(Reference::Value)
                }
                Some(Expression::Name(name)) => Some(Reference::Named(name)),
                _ => None,
            };
            self.flow.set(TOOL, tool.unwrap_or(Reference::Unknown("its value is computed".into())));
            return;
        }
        if self.setters.iter().any(|setter| setter == verb) {
            let words = format!("{verb} is called before, which sets it");
            self.flow.set(TOOL, Reference::Unknown(words));
            return;
        }
        if !MOTIONS.contains(&verb) {
            return;
        }
        let used = self.flow.motion();
        let count = if matches!(verb, "movec" | "servoc") { 2 } else { 1 };
        let count = if verb == "servoc" { 1 } else { count };
        for k in 0..count {
            let target = match parts.get(k) {
                Some(part) => Expression::read(self.text, part),
                None => Expression::Computed,
            };
            self.file.motions.push(Motion { line, verb: verb.into(), target, used });
        }
    }
}
