//! One script, statement by statement.

use super::expression::{Expression, arguments, unnamed};
use crate::ControllerError;
use crate::definitions::Definition;
use crate::flow::{Active, FRAME, Flow, Head, LOAD, Outer, Step, TOOL};
use crate::reference::Reference;
use crate::tokens::{Cursor, Kind, Lexis, Token, tokens};

const LEXIS: Lexis = Lexis { comment: b'#', quotes: b"\"'", header: None, escapes: true };
const MOTIONS: [&str; 7] = ["movej", "movel", "movep", "movec", "servoj", "servoc", "servol"];
/// Motions without a destination.
const AWAY: [&str; 5] = ["speedj", "speedl", "speed_until", "stopj", "stopl"];
/// Beginnings of functions with poses or joints to which nothing moves.
const HARMLESS: [&str; 17] = [
    "textmsg",
    "popup",
    "varmsg",
    "set_",
    "get_",
    "is_",
    "pose_",
    "point_",
    "interpolate_",
    "force_mode",
    "freedrive",
    "rtde_",
    "write_",
    "modbus_",
    "norm",
    "str_",
    "to_str",
];
/// Functions that state the load.
const LOADS: [&str; 4] = ["set_payload", "set_target_payload", "set_payload_mass", "set_payload_cog"];
const NO_LOAD: &str = "set_payload is not called before";
/// Beginnings of functions behind which motions are displaced.
const DISPLACING: [&str; 2] = ["track_conveyor", "path_offset_set"];

/// A destination of a motion.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) head: Head,
    pub(super) target: Expression,
    pub(super) used: usize,
}

#[derive(Debug, Clone, Default)]
pub(super) struct File {
    pub(super) motions: Vec<Motion>,
    pub(super) steps: Vec<Step>,
    /// Line, name and arguments of calls of functions that are not known.
    pub(super) odd: Vec<(usize, String, Vec<Expression>)>,
    /// Line, name and reason of statements that are refused.
    pub(super) refused: Vec<(usize, String, &'static str)>,
    /// Loads that are stated.
    pub(super) loads: Vec<(String, Definition)>,
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
        let called = |words: &[&str]| setters(text, &statements, words);
        let (setters, movers) =
            ([&["set_tcp"][..], &LOADS].map(called), called(&[&MOTIONS[..], &AWAY].concat()));
        let routines = routines(text, &statements);
        let mut flow = Flow::new("set_tcp is not called before");
        flow.set(FRAME, Reference::Identity);
        flow.set(LOAD, Reference::Unknown(NO_LOAD.into()));
        let tool = only_tool(text, &statements);
        let mut reader =
            Reader { text, file: File::default(), flow, open: Vec::new(), setters, movers, routines, tool };
        for statement in &statements {
            reader.statement(statement);
        }
        reader.file.uses = reader.flow.uses;
        Ok(reader.file)
    }
}

/// The tool of all calls of set_tcp, where it is one.
fn only_tool(text: &[u8], statements: &[Vec<Token>]) -> Option<Reference> {
    let mut only: Option<Reference> = None;
    for statement in statements {
        if Cursor::new(text, statement).word() == Some("set_tcp") {
            let tool = called(text, statement).first().map(|part| tool(text, part))?;
            if matches!(tool, Reference::Unknown(_)) || only.as_ref().is_some_and(|only| *only != tool) {
                return None;
            }
            only = Some(tool);
        }
    }
    only
}

/// The arguments of a call that is a statement.
fn called<'t>(text: &[u8], tokens: &'t [Token]) -> Vec<&'t [Token]> {
    let closed = tokens.last().is_some_and(|token| token.is(b')'));
    let parts = tokens.get(2..tokens.len() - 1).filter(|_| closed).and_then(arguments);
    parts.unwrap_or_default().into_iter().map(|part| unnamed(text, part)).collect()
}

/// The argument of set_tcp.
fn tool(text: &[u8], part: &[Token]) -> Reference {
    let tool = match Expression::read(text, part) {
        Expression::Pose(six) => crate::Dialect::UrScript.pose(&six.values).map(Reference::Value),
        Expression::Name(name) => Some(Reference::Named(name)),
        _ => None,
    };
    tool.unwrap_or(Reference::Unknown("its value is computed".into()))
}

/// `[0, 0, 0.05]`
fn three(text: &[u8], part: &[Token]) -> Option<[f64; 3]> {
    let mut at = Cursor::new(text, part);
    let mut values = [0.0; 3];
    for (k, value) in values.iter_mut().enumerate() {
        *value = at.take(if k == 0 { b'[' } else { b',' }).then(|| at.number()).flatten()?.0;
    }
    (at.take(b']') && at.done()).then_some(values)
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

/// Names of the routines of a file.
fn routines(text: &[u8], statements: &[Vec<Token>]) -> Vec<String> {
    let name = |statement: &Vec<Token>| {
        let mut at = Cursor::new(text, statement);
        matches!(at.word()?, "def" | "thread" | "sec").then(|| at.word().map(str::to_owned)).flatten()
    };
    statements.iter().filter_map(name).collect()
}

/// Routines that call one of these functions, directly or by calling one that does.
fn setters(text: &[u8], statements: &[Vec<Token>], words: &[&str]) -> Vec<String> {
    let mut routines: Vec<(String, Vec<String>)> = Vec::new();
    let mut stack: Vec<Option<usize>> = Vec::new();
    for statement in statements {
        let mut at = Cursor::new(text, statement);
        match at.word() {
            Some("def" | "thread" | "sec") => {
                routines.push((at.word().unwrap_or("").into(), Vec::new()));
                stack.push(Some(routines.len() - 1));
            }
            Some("if" | "while" | "for") => stack.push(None),
            Some("run") => {
                let word = at.word().unwrap_or("");
                for routine in stack.iter().flatten() {
                    routines[*routine].1.push(word.into());
                }
            }
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
    let mut found: Vec<String> = words.iter().map(ToString::to_string).collect();
    // Each round takes in the callers of those found; there are at most as many rounds as routines.
    for _ in 0..=routines.len() {
        for (name, called) in &routines {
            if !found.contains(name) && called.iter().any(|word| found.contains(word)) {
                found.push(name.clone());
            }
        }
    }
    found.split_off(words.len())
}

struct Reader<'t> {
    text: &'t [u8],
    file: File,
    flow: Flow,
    /// Blocks that are open; of a routine what was active outside.
    open: Vec<Option<Outer>>,
    /// Routines that set the tool, and the load.
    setters: [Vec<String>; 2],
    /// Routines that move the robot.
    movers: Vec<String>,
    /// All routines of the file.
    routines: Vec<String>,
    /// The tool of all calls of set_tcp, where it is one.
    tool: Option<Reference>,
}

impl Reader<'_> {
    fn statement(&mut self, tokens: &[Token]) {
        let mut at = Cursor::new(self.text, tokens);
        let line = tokens[0].line;
        let Some(first) = at.word() else { return };
        self.functions(tokens, line);
        let inside = tokens.iter().zip(tokens.iter().skip(1)).skip(1).find(|(token, next)| {
            token.kind == Kind::Word && next.is(b'(') && MOTIONS.contains(&at.str_of(token))
        });
        if let Some((token, _)) = inside {
            let words = "a motion that is not at the beginning of its statement is not read";
            self.file.refused.push((line, at.str_of(token).into(), words));
        }
        match first {
            "def" | "thread" | "sec" => self.routine(at.word().unwrap_or("")),
            "if" => self.block(false),
            "elif" | "else" => self.flow.branch(),
            "while" | "for" => self.block(true),
            "end" => match self.open.pop() {
                Some(Some(outer)) => {
                    self.flow.leave(outer);
                    self.file.steps.push(Step::End);
                }
                Some(None) => self.flow.close(),
                None => {}
            },
            "run" => {
                let thread = at.word().unwrap_or("");
                self.sets(thread);
                self.file.steps.push(Step::Call(thread.into()));
            }
            "global" | "local" => self.assignment(tokens, 1, line),
            _ if at.take(b'(') => self.call(first, tokens, line),
            _ => self.assignment(tokens, 0, line),
        }
        // `if x: y end` in one line.
        let ends = tokens.len() > 1 && tokens.last().is_some_and(|token| self.word(token) == "end");
        if ends && matches!(first, "if" | "while" | "for") && self.open.pop().is_some() {
            self.flow.close();
        }
    }

    fn word(&self, token: &Token) -> &str {
        std::str::from_utf8(&self.text[token.range.clone()]).unwrap_or("")
    }

    /// Functions in the middle of a statement that are not known: they may move to what they are given.
    fn functions(&mut self, tokens: &[Token], line: usize) {
        for (k, pair) in tokens.windows(2).enumerate().skip(1) {
            let name = self.word(&pair[0]).to_owned();
            let call = pair[0].kind == Kind::Word
                && pair[1].is(b'(')
                && !matches!(name.as_str(), "and" | "or" | "not" | "if" | "elif" | "while" | "return");
            let known = MOTIONS.contains(&&*name) || HARMLESS.iter().any(|word| name.starts_with(word));
            let still = self.routines.contains(&name) && !self.movers.contains(&name);
            if !call || known || still || matches!(self.word(&tokens[k - 1]), "def" | "thread" | "sec") {
                continue;
            }
            let mut at = Cursor { at: k + 2, ..Cursor::new(self.text, tokens) };
            at.skip_closed();
            let parts = called(self.text, &tokens[k..at.at.min(tokens.len())]);
            let parts = parts.iter().map(|part| Expression::read(self.text, part)).collect();
            self.file.odd.push((line, name, parts));
        }
    }

    fn block(&mut self, loops: bool) {
        self.flow.open(loops);
        self.open.push(None);
    }

    /// A routine begins: what it does to the tool is done where it is called.
    fn routine(&mut self, name: &str) {
        let nested = self.open.iter().any(Option::is_some);
        let words =
            if nested { "a routine may be called with another tool" } else { "set_tcp is not called before" };
        let tool = self.tool.clone().filter(|_| nested);
        let tool = tool.unwrap_or_else(|| Reference::Unknown(words.into()));
        let words = if nested { "a routine may be called with another load" } else { NO_LOAD };
        let outer = self.flow.enter([Reference::Identity, tool, Reference::Unknown(words.into())]);
        self.open.push(Some(outer));
        self.file.steps.push(Step::Begin(name.into()));
    }

    /// A routine is called that may set the tool or the load.
    fn sets(&mut self, name: &str) {
        for (which, setters) in [TOOL, LOAD].into_iter().zip(&self.setters) {
            if setters.iter().any(|setter| setter == name) {
                let words = format!("{name} is called before, which sets it");
                self.flow.set(which, Reference::Unknown(words));
            }
        }
    }

    /// `set_payload(2.5, [0, 0, 0.05])`
    fn load(&mut self, verb: &str, parts: &[&[Token]], line: usize) {
        let name = format!("{verb} in line {line}");
        let number = |part: &[Token]| {
            let mut at = Cursor::new(self.text, part);
            at.number().filter(|_| at.done()).map(|(value, _)| value)
        };
        let mass = parts.first().and_then(|part| number(part));
        let center = parts.get(1).and_then(|part| three(self.text, part));
        let definition = match (verb, mass, center) {
            ("set_payload" | "set_target_payload", Some(mass), Some(center)) => {
                Definition::Load(mass, center.into())
            }
            _ => Definition::Unusable(format!(
                "{name} has not a mass and a centre of gravity that are numbers"
            )),
        };
        self.file.loads.push((name.clone(), definition));
        self.flow.set(LOAD, Reference::Named(name));
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
        let parts = called(self.text, tokens);
        let begins = |words: &[&str]| words.iter().any(|word| verb.starts_with(word));
        if verb == "set_tcp" {
            let tool = parts.first().map(|part| tool(self.text, part));
            self.flow.set(TOOL, tool.unwrap_or(Reference::Unknown("its value is computed".into())));
        } else if MOTIONS.contains(&verb) {
            self.motion(verb, &parts, line);
        } else if AWAY.contains(&verb) {
            self.file.steps.push(Step::Away { linear: verb.ends_with('l'), line });
        } else if begins(&DISPLACING) {
            self.file.refused.push((line, verb.into(), "it displaces positions while the program runs"));
        } else if LOADS.contains(&verb) {
            self.load(verb, &parts, line);
        } else if !begins(&HARMLESS) {
            self.sets(verb);
            self.file.steps.push(Step::Call(verb.into()));
            let parts = parts.iter().map(|part| Expression::read(self.text, part)).collect();
            self.file.odd.push((line, verb.into(), parts));
        }
    }

    fn motion(&mut self, verb: &str, parts: &[&[Token]], line: usize) {
        let used = self.flow.motion();
        for k in 0..if verb == "movec" { 2 } else { 1 } {
            let target = match parts.get(k) {
                Some(part) => Expression::read(self.text, part),
                None => Expression::Computed,
            };
            self.file.steps.push(Step::Motion(self.file.motions.len()));
            let linear = !matches!(verb, "movej" | "servoj");
            let head = Head { line, shown: verb.into(), linear, odd: None };
            self.file.motions.push(Motion { head, target, used });
        }
    }
}
