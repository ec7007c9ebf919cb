//! What one module says.

use super::node::Node;
use crate::program::{Definition, Reference};
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

/// An instruction that moves.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) line: usize,
    pub(super) shown: String,
    /// Names of its destinations.
    pub(super) names: Vec<String>,
    /// Whether a destination is computed.
    pub(super) computed: bool,
    pub(super) tool: Reference,
    pub(super) frame: Reference,
}

#[derive(Debug, Clone, Default)]
pub(super) struct File {
    pub(super) candidates: Vec<Candidate>,
    pub(super) motions: Vec<Motion>,
    pub(super) definitions: Vec<(String, Definition)>,
    /// Names of points with their types.
    pub(super) declared: Vec<(String, bool)>,
    pub(super) changed: Vec<(String, usize)>,
    /// Line and name of an instruction that displaces the program.
    pub(super) displaced: Option<(usize, String)>,
}

impl File {
    pub(super) fn read(text: &[u8]) -> Result<File, ControllerError> {
        let all: Vec<Token> =
            tokens(text, LEXIS)?.into_iter().filter(|token| token.kind != Kind::End).collect();
        let mut file = File::default();
        let mut at = Cursor::new(text, &all);
        while let Some(token) = at.next() {
            if token.kind != Kind::Word {
                continue;
            }
            let before = at.at.checked_sub(2).and_then(|k| all.get(k));
            match at.str_of(token).to_ascii_uppercase().as_str() {
                "CONST" | "PERS" | "VAR" => file.declaration(&mut at)?,
                word if moves(word) && !joined(before) && begins(&at) => file.motion(&mut at, token)?,
                word if ["PDISPSET", "PDISPON", "EOFFSSET", "EOFFSON"].contains(&word) => {
                    file.displaced.get_or_insert((token.line, at.str_of(token).into()));
                }
                _ if !joined(before) => {
                    at.at -= 1;
                    file.assignment(&mut at)?;
                }
                _ => {}
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
        } else if !matches!(kind.as_str(), "WOBJDATA" | "TOOLDATA") {
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
            "TOOLDATA" => self.definitions.push((name, tool(&node))),
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

    /// `p10 := […];`, `p10.trans.x := …`; the name is next.
    fn assignment(&mut self, at: &mut Cursor<'_>) -> Result<(), ControllerError> {
        let line = at.peek().map_or(0, |token| token.line);
        let from = at.at + 1;
        let Some(name) = indexed(at) else { return Ok(()) };
        let mut part = false;
        while at.take(b'.') {
            part = true;
            at.word();
        }
        if !(at.take(b':') && at.take(b'=')) {
            at.at = from;
            return Ok(());
        }
        if part || !at.take(b'[') {
            self.changed.push((name, line));
            return Ok(());
        }
        let node = Node::list(at)?;
        let ends = at.peek().is_none_or(|token| token.is(b';'));
        match shape(&node) {
            Some(joints) if ends => {
                self.candidates.push(Candidate { name, line, node, joints, inline: None });
            }
            _ => self.changed.push((name, line)),
        }
        Ok(())
    }

    /// Behind the instruction's name.
    fn motion(&mut self, at: &mut Cursor<'_>, verb: &Token) -> Result<(), ControllerError> {
        let word = at.str_of(verb).to_owned();
        let number = self.motions.len();
        let mut motion = Motion {
            line: verb.line,
            shown: word.clone(),
            names: Vec::new(),
            computed: false,
            tool: Reference::Unknown(format!("{word} in line {} names none", verb.line)),
            frame: Reference::Identity,
        };
        let begin = verb.range.start;
        let joints_only = word.to_ascii_uppercase().starts_with("MOVEABSJ");
        let mut place = 0;
        while at.peek().is_some_and(|token| !token.is(b';')) {
            let last = self.argument(at, &mut motion, number, place, joints_only)?;
            if let Some(tool) = last {
                motion.tool = tool;
            }
            place += 1;
            if !at.take(b',') {
                break;
            }
        }
        let end = at.peek().map_or(at.text.len(), |token| token.range.start);
        let shown = String::from_utf8_lossy(&at.text[begin..end.max(begin)]).into_owned();
        motion.shown = shown.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(60).collect();
        self.motions.push(motion);
        Ok(())
    }

    /// One argument; what it is as a tool.
    fn argument(
        &mut self,
        at: &mut Cursor<'_>,
        motion: &mut Motion,
        number: usize,
        place: usize,
        joints_only: bool,
    ) -> Result<Option<Reference>, ControllerError> {
        let mut seen = None;
        let line = at.peek().map_or(0, |token| token.line);
        if at.take(b'[') {
            let node = Node::list(at)?;
            if let Some(joints) = shape(&node) {
                let name = format!("{} in line {}", motion.shown, motion.line);
                self.candidates.push(Candidate { name, line, node, joints, inline: Some(number) });
            } else {
                seen = Some(match tool(&node) {
                    Definition::Value(pose) => Reference::Value(pose),
                    _ => Reference::Unknown("its value is computed".into()),
                });
            }
        } else if at.peek_word().is_some() {
            let name = indexed(at).unwrap_or_default();
            let call = at.peek().is_some_and(|token| token.is(b'(') || token.is(b'.'));
            let point = place == 0 || self.declared.iter().any(|(declared, _)| *declared == bare(&name));
            if call && (place < 2 || point) {
                motion.computed |= place == 0 || ["OFFS", "RELTOOL"].contains(&name.as_str());
            } else if point || (place == 1 && motion.shown.to_ascii_uppercase().ends_with('C')) {
                motion.names.push(name.clone());
            }
            seen = Some(match (name.as_str(), call) {
                (_, true) => Reference::Unknown("it is computed".into()),
                ("TOOL0", _) => Reference::Identity,
                _ => Reference::Named(name),
            });
        }
        let mut depth = 0;
        while let Some(token) = at.peek() {
            match token.kind {
                Kind::Sign(b'(' | b'[' | b'{') => depth += 1,
                Kind::Sign(b')' | b']' | b'}') => depth -= 1,
                Kind::Sign(b',') if depth == 0 => break,
                Kind::Sign(b';') => break,
                Kind::Sign(b'\\') if depth == 0 => {
                    at.at += 1;
                    if at.peek_word().is_some_and(|word| word.eq_ignore_ascii_case("WObj")) && !joints_only {
                        at.at += 1;
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
        Ok(seen)
    }
}

/// Instructions with destinations.
fn moves(word: &str) -> bool {
    ["MOVE", "TRIGGJ", "TRIGGL", "TRIGGC", "TRIGGABSJ", "SEARCH"].iter().any(|start| word.starts_with(start))
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
fn indexed(at: &mut Cursor<'_>) -> Option<String> {
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
fn shape(node: &Node) -> Option<bool> {
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
        return Definition::Unusable("the robot holds the work object, which is not compensated".into());
    }
    if !fixed.is_word("TRUE") {
        return Definition::Unusable("its user frame moves with another unit (ufprog is FALSE)".into());
    }
    match (pose(user), pose(object)) {
        (Some(user), Some(object)) => Definition::Value(user * object),
        _ => computed(),
    }
}

fn tool(node: &Node) -> Definition {
    let [held, frame, _] = node.items() else {
        return Definition::Unusable("its value is not made of numbers".into());
    };
    if !held.is_word("TRUE") {
        return Definition::Unusable(
            "the tool stands still (robhold is FALSE), which is not compensated".into(),
        );
    }
    pose(frame).map_or(Definition::Unusable("its value is not made of numbers".into()), Definition::Value)
}
