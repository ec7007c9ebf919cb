//! One module.

use super::instructions::{KEYWORDS, signature};
use super::load::{Grip, Held, load};
use super::node::Node;
use crate::definitions::Definition;
use crate::flow::{Head, Step};
use crate::reference::Reference;
use crate::tokens::{Cursor, Kind, Lexis, Token, tokens};
use crate::{ControllerError, Dialect};
use truepose_kinematics::Pose;

const LEXIS: Lexis = Lexis { comment: b'!', quotes: b"\"", header: None, escapes: false };

/// A literal point.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) name: String,
    pub(super) line: usize,
    pub(super) node: Node,
    pub(super) joints: bool,
    /// The motion that contains it.
    pub(super) inline: Option<usize>,
}

/// Where a motion goes.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Destination {
    Name(String),
    /// A literal, by its place among the candidates.
    Inline(usize),
    Computed,
}

/// An instruction that moves.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) head: Head,
    pub(super) destinations: Vec<Destination>,
    pub(super) tool: Reference,
    pub(super) frame: Reference,
    pub(super) load: Held,
}

/// An instruction that is no motion, with what a motion would have in it.
#[derive(Debug, Clone)]
pub(super) struct Odd {
    pub(super) line: usize,
    pub(super) shown: String,
    pub(super) names: Vec<String>,
    /// Whether a literal point is in it.
    pub(super) literal: bool,
}

#[derive(Debug, Clone, Default)]
pub(super) struct File {
    pub(super) candidates: Vec<Candidate>,
    pub(super) motions: Vec<Motion>,
    pub(super) steps: Vec<Step>,
    pub(super) odd: Vec<Odd>,
    pub(super) definitions: Vec<(String, Definition)>,
    /// Names of points with their types.
    pub(super) declared: Vec<(String, bool)>,
    pub(super) changed: Vec<(String, usize)>,
    /// Names of points to which external axes alone go.
    pub(super) external: Vec<String>,
    /// Line and name of an instruction that displaces the program.
    pub(super) displaced: Option<(usize, String)>,
    pub(super) grip: Grip,
}

impl File {
    pub(super) fn read(text: &[u8]) -> Result<File, ControllerError> {
        let all: Vec<Token> =
            tokens(text, LEXIS)?.into_iter().filter(|token| token.kind != Kind::End).collect();
        let mut file = File::default();
        let mut at = Cursor::new(text, &all);
        while let Some(token) = at.next() {
            if token.is(b'%') && at.peek().is_some_and(|token| matches!(token.kind, Kind::Text | Kind::Word))
            {
                file.late(&mut at, token);
            }
            if token.kind != Kind::Word {
                continue;
            }
            let before = at.at.checked_sub(2).and_then(|k| all.get(k));
            let word = at.str_of(token).to_ascii_uppercase();
            match word.as_str() {
                "CONST" | "PERS" | "VAR" => file.declaration(&mut at)?,
                _ if joined(before) => {}
                "PROC" | "TRAP" | "FUNC" => {
                    if word == "FUNC" {
                        at.word();
                    }
                    file.grip.begin();
                    file.steps.push(Step::Begin(at.word().unwrap_or("").to_ascii_uppercase()));
                }
                "ENDPROC" | "ENDTRAP" | "ENDFUNC" => file.steps.push(Step::End),
                "CONFL" | "CONFJ" if at.take(b'\\') => {
                    let followed = !at.word().is_some_and(|word| word.eq_ignore_ascii_case("Off"));
                    file.steps.push(Step::Control { linear: word == "CONFL", followed });
                }
                "GRIPLOAD" => {
                    file.steps.push(Step::Call(word));
                    file.grip.set(indexed(&mut at).unwrap_or_default());
                }
                word if KEYWORDS.contains(&word) => file.grip.block(word),
                "PDISPSET" | "PDISPON" | "EOFFSSET" | "EOFFSON" => {
                    file.displaced.get_or_insert((token.line, at.str_of(token).into()));
                }
                word => match signature(word) {
                    Some(signature) if begins(&at) => file.motion(&mut at, token, &signature)?,
                    _ => {
                        at.at -= 1;
                        if !file.assignment(&mut at)? {
                            file.instruction(&mut at, token);
                        }
                    }
                },
            }
        }
        Ok(file)
    }

    /// Behind CONST, PERS or VAR.
    fn declaration(&mut self, at: &mut Cursor<'_>) -> Result<(), ControllerError> {
        let Some(kind) = at.word().map(str::to_ascii_uppercase) else { return Ok(()) };
        let Some(token) = at.peek() else { return Ok(()) };
        let line = token.line;
        let Some(name) = at.word().map(str::to_ascii_uppercase) else { return Ok(()) };
        let point = matches!(kind.as_str(), "ROBTARGET" | "JOINTTARGET");
        let joints = kind == "JOINTTARGET";
        if point {
            self.declared.push((name.clone(), joints));
        } else if !matches!(kind.as_str(), "WOBJDATA" | "TOOLDATA" | "LOADDATA") {
            return Ok(());
        }
        let mut lists = 0;
        if at.take(b'{') {
            lists = 1;
            while let Some(token) = at.next().filter(|token| !token.is(b'}')) {
                lists += usize::from(token.is(b','));
            }
        }
        if !(at.take(b':') && at.take(b'=')) {
            return Ok(());
        }
        if !at.take(b'[') {
            self.changed.push((name, line));
            return Ok(());
        }
        let line = at.tokens[at.at - 1].line;
        let node = Node::list(at)?;
        match kind.as_str() {
            "WOBJDATA" => self.definitions.push((name, work_object(&node))),
            "TOOLDATA" => {
                self.definitions.push((format!("{name}.TLOAD"), load(node.items().get(2))));
                self.definitions.push((name, tool(&node)));
            }
            "LOADDATA" => self.definitions.push((name, load(Some(&node)))),
            _ => self.listed(name, node, joints, lists, line),
        }
        Ok(())
    }

    fn listed(&mut self, name: String, node: Node, joints: bool, lists: usize, line: usize) {
        if lists == 0 || lists > 3 {
            self.candidates.push(Candidate { name, line, node, joints, inline: None });
            return;
        }
        for (k, item) in node.items().iter().enumerate() {
            let name = if name.ends_with('}') {
                format!("{},{}}}", name.trim_end_matches('}'), k + 1)
            } else {
                format!("{name}{{{}}}", k + 1)
            };
            self.listed(name, item.clone(), joints, lists - 1, line);
        }
    }

    /// `p10 := […];`, `p10.trans.x := …`; the name is next. Whether it was one; if not, behind the name.
    fn assignment(&mut self, at: &mut Cursor<'_>) -> Result<bool, ControllerError> {
        let line = at.peek().map_or(0, |token| token.line);
        let from = at.at + 1;
        let Some(name) = indexed(at) else { return Ok(false) };
        let mut part = false;
        while at.take(b'.') {
            part = true;
            at.word();
        }
        if !(at.take(b':') && at.take(b'=')) {
            at.at = from;
            return Ok(false);
        }
        if part || !at.take(b'[') {
            self.changed.push((name, line));
            return Ok(true);
        }
        let node = Node::list(at)?;
        let ends = at.peek().is_none_or(|token| token.is(b';'));
        match shape(&node) {
            Some(joints) if ends => {
                self.candidates.push(Candidate { name, line, node, joints, inline: None });
            }
            _ => self.changed.push((name, line)),
        }
        Ok(true)
    }

    /// `%"pick"% p10;`, `%name% p10;`: a procedure by its name as a text.
    fn late(&mut self, at: &mut Cursor<'_>, first: &Token) {
        at.at += 1;
        if at.take(b'%') {
            let verb = Token { range: first.range.start..at.tokens[at.at - 1].range.end, ..first.clone() };
            self.instruction(at, &verb);
        }
    }

    /// An instruction that is no motion, behind its name.
    fn instruction(&mut self, at: &mut Cursor<'_>, verb: &Token) {
        let word = at.str_of(verb).to_ascii_uppercase();
        let ends = |at: &Cursor<'_>| at.peek().is_none_or(|token| token.is(b';'));
        if ends(at) {
            self.grip.call(&word);
        }
        self.steps.push(Step::Call(word.clone()));
        if at.peek_word().is_some_and(|word| KEYWORDS.contains(&&*word.to_ascii_uppercase())) || !begins(at) {
            return;
        }
        let mut odd =
            Odd { line: verb.line, shown: at.str_of(verb).into(), names: Vec::new(), literal: false };
        while let Some(token) = at.peek().filter(|token| !token.is(b';')) {
            let word = at.peek_word().map(str::to_ascii_uppercase);
            if word.as_ref().is_some_and(|word| KEYWORDS.contains(&word.as_str())) {
                break;
            }
            if word.as_ref().is_some_and(|word| signature(word).is_some()) {
                // `IF flag MoveL p10,…;`: what is in front is a condition.
                return;
            }
            at.at += 1;
            if let Some(word) = word {
                at.at -= 1;
                let name = indexed(at).unwrap_or(word);
                // A component is read of a point.
                if !at.peek().is_some_and(|token| token.is(b'.')) {
                    odd.names.push(name);
                }
            } else if token.is(b'[') {
                let mut ahead = at.clone();
                if let Ok(node) = Node::list(&mut ahead) {
                    odd.literal |= shape(&node).is_some();
                    at.at = ahead.at;
                }
            }
        }
        // A condition ends with a keyword.
        if ends(at) {
            self.grip.call(&word);
        }
        if odd.literal || !odd.names.is_empty() {
            self.odd.push(odd);
        }
    }
}

/// Whether a word is joined to something in front of it: an option, a component, a declared name's type.
fn joined(before: Option<&Token>) -> bool {
    before.is_some_and(|token| {
        matches!(token.kind, Kind::Sign(b'\\' | b'.' | b'(' | b'[' | b',' | b'=' | b'%'))
    })
}

/// Whether an argument follows.
fn begins(at: &Cursor<'_>) -> bool {
    at.peek().is_some_and(|token| matches!(token.kind, Kind::Word | Kind::Sign(b'[' | b'\\' | b'*')))
}

/// A name in capitals with its index: `P{3}`, `P{*}`.
pub(super) fn indexed(at: &mut Cursor<'_>) -> Option<String> {
    let mut name = at.word()?.to_ascii_uppercase();
    if at.take(b'{') {
        let index = at.number().filter(|_| at.peek().is_some_and(|token| token.is(b'}')));
        name.push_str(&index.map_or("{*}".into(), |(index, _)| format!("{{{index:.0}}}")));
        at.skip_closed();
    }
    Some(name)
}

/// Without its index.
pub(super) fn bare(name: &str) -> &str {
    name.split('{').next().unwrap_or(name)
}

/// Whether a value is a jointtarget (true) or a robtarget (false); none: neither.
pub(super) fn shape(node: &Node) -> Option<bool> {
    let lengths: Vec<usize> = node.items().iter().map(|item| item.items().len()).collect();
    match lengths[..] {
        [3, 4, 4, 6] => Some(false),
        [6, 6] => Some(true),
        _ => None,
    }
}

/// A pose `[[x,y,z],[q1,q2,q3,q4]]`.
fn pose(node: &Node) -> Option<Pose> {
    let [place, turn] = node.items() else { return None };
    let numbers: Vec<f64> =
        place.numbers(3)?.iter().chain(&turn.numbers(4)?).map(|(value, _)| *value).collect();
    Dialect::Rapid.pose(&numbers)
}

fn work_object(node: &Node) -> Definition {
    let computed = || Definition::Unusable("its value is not made of numbers".into());
    let [held, fixed, _, user, object] = node.items() else { return computed() };
    if !held.is_word("FALSE") {
        return Definition::Excluded(
            "the robot holds the work object (robhold is TRUE), which is not compensated".into(),
        );
    }
    match (pose(user), pose(object)) {
        (Some(user), Some(object)) if fixed.is_word("TRUE") => Definition::Value(user * object),
        // The user frame is in the axes of the mechanical unit (ufprog is FALSE).
        (Some(user), Some(object)) => Definition::Carried(Reference::Value(user * object)),
        _ => computed(),
    }
}

pub(super) fn tool(node: &Node) -> Definition {
    let [held, frame, _] = node.items() else {
        return Definition::Unusable("its value is not made of numbers".into());
    };
    if !held.is_word("TRUE") {
        return Definition::Excluded(
            "the tool stands still (robhold is FALSE), which is not compensated".into(),
        );
    }
    pose(frame).map_or(Definition::Unusable("its value is not made of numbers".into()), Definition::Value)
}
