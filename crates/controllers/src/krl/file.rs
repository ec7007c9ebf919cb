//! One file, statement by statement.

use super::aggregate::Aggregate;
use super::candidate::{Candidate, candidate, pose};
use crate::ControllerError;
use crate::definitions::Definition;
use crate::flow::{Active, FRAME, Flow, Head, LOAD, Outer, Step, TOOL, unknown};
use crate::reference::Reference;
use crate::tokens::{Cursor, Kind, Lexis, tokens};

const LEXIS: Lexis = Lexis { comment: b';', quotes: b"\"'", header: Some(b'&'), escapes: false };
/// Why points are not compensated where the tool stands still.
pub(super) const FIXED_TOOL: &str =
    "the tool stands still and the robot holds the work ($IPO_MODE = #TCP), which is not compensated";
const TYPES: [&str; 5] = ["E6POS", "POS", "E6AXIS", "AXIS", "FRAME"];
/// Statements behind which nothing moves, whatever is in them.
const STILL: [&str; 12] =
    ["BOOL", "INT", "REAL", "CHAR", "RETURN", "WAIT", "SIGNAL", "ENUM", "STRUC", "EXT", "EXTFCT", "IMPORT"];
/// No mode is set: the tool is on the robot.
const ON_ROBOT: Active = [Reference::Identity, Reference::Identity, Reference::Identity];
/// Keywords of the flow.
const CONTROLS: [&str; 10] =
    ["IF", "SWITCH", "ELSE", "CASE", "DEFAULT", "FOR", "WHILE", "LOOP", "REPEAT", "UNTIL"];

pub(super) const MOTIONS: [&str; 7] = ["PTP", "LIN", "CIRC", "SPTP", "SLIN", "SCIRC", "SPL"];

/// A motion to a name, or to something that is computed.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) head: Head,
    /// The name, where it is one alone.
    pub(super) name: Option<String>,
    /// Relative to where the robot is, or computed from this name.
    pub(super) computed: bool,
    pub(super) used: usize,
    /// Whether an aggregate stands there.
    pub(super) inline: bool,
}

#[derive(Debug, Clone, Default)]
pub(super) struct File {
    pub(super) candidates: Vec<Candidate>,
    pub(super) motions: Vec<Motion>,
    pub(super) uses: Vec<Active>,
    pub(super) definitions: Vec<(String, Definition)>,
    /// Names of points with their types, as declared.
    pub(super) declared: Vec<(String, String)>,
    /// Names whose value is changed by a statement that is no literal, and its line.
    pub(super) changed: Vec<(String, usize)>,
    pub(super) steps: Vec<Step>,
    /// Statements that are no motions but have something of one: line, statement, the names in it, and whether a literal point is in it.
    pub(super) odd: Vec<(usize, String, Vec<String>, bool)>,
}

pub(super) struct Reader<'t> {
    pub(super) text: &'t [u8],
    pub(super) flow: Flow,
    /// Whether the tool is on the robot, in the place of the frame.
    pub(super) mode: Flow,
    /// What was active in front of a spline.
    pub(super) outside: Option<[Outer; 2]>,
    pub(super) file: File,
}

impl File {
    pub(super) fn read(text: &[u8]) -> Result<File, ControllerError> {
        let all = tokens(text, LEXIS)?;
        let mut mode = Flow::new("");
        mode.restart(ON_ROBOT);
        let mut flow = Flow::new("");
        flow.restart(unset());
        let mut reader = Reader { text, flow, mode, outside: None, file: File::default() };
        for line in all.split_inclusive(|token| token.kind == Kind::End) {
            reader.statement(&mut Cursor::new(text, line))?;
        }
        reader.file.uses = reader.flow.uses;
        for (active, mode) in reader.file.uses.iter_mut().zip(&reader.mode.uses) {
            if mode[FRAME] != Reference::Identity {
                active[..LOAD].fill(Reference::Excluded(FIXED_TOOL.into()));
            }
        }
        Ok(reader.file)
    }
}

impl<'t> Reader<'t> {
    fn statement(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        let Some(first) = at.peek_word().map(str::to_ascii_uppercase) else { return Ok(()) };
        if CONTROLS.contains(&first.as_str()) {
            self.inline(&mut at.clone(), &first);
        }
        match first.as_str() {
            "IF" | "SWITCH" => self.both(|flow| flow.open(false)),
            "ELSE" | "CASE" | "DEFAULT" => self.both(Flow::branch),
            "FOR" | "WHILE" | "LOOP" | "REPEAT" => self.both(|flow| flow.open(true)),
            "ENDIF" | "ENDSWITCH" | "ENDFOR" | "ENDWHILE" | "ENDLOOP" | "UNTIL" => self.both(Flow::close),
            "DEF" | "DEFFCT" | "DECL" | "GLOBAL" | "CONST" => return self.declaration(at),
            "END" | "ENDFCT" => self.file.steps.push(Step::End),
            "SPLINE" | "PTP_SPLINE" => return self.spline(at),
            "ENDSPLINE" => self.ends(),
            "BAS" => self.bas(at),
            _ if MOTIONS.contains(&first.as_str()) => return self.motion(at, false),
            _ if first.strip_suffix("_REL").is_some_and(|word| MOTIONS.contains(&word)) => {
                return self.motion(at, true);
            }
            _ if TYPES.contains(&first.as_str()) || first == "FDAT" => return self.declaration(at),
            _ => return self.assignment(at),
        }
        Ok(())
    }

    fn both(&mut self, step: impl Fn(&mut Flow)) {
        step(&mut self.flow);
        step(&mut self.mode);
    }

    /// `DEF name( )`: the name is next.
    fn routine(&mut self, at: &mut Cursor<'t>, typed: bool) {
        self.flow.restart(unset());
        self.mode.restart(ON_ROBOT);
        if typed {
            at.word();
        }
        self.file.steps.push(Step::Begin(name(at).unwrap_or_default()));
    }

    /// `DECL E6POS XP1={…}, XP2`.
    fn declaration(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        let mut kind = String::new();
        while let Some(word) = at.word() {
            kind = word.to_ascii_uppercase();
            if kind == "DEF" || kind == "DEFFCT" {
                self.routine(at, kind == "DEFFCT");
                return Ok(());
            }
            if !matches!(kind.as_str(), "DECL" | "GLOBAL" | "CONST") {
                break;
            }
        }
        let point = TYPES.contains(&kind.as_str());
        loop {
            let Some(name) = name(at) else { return Ok(()) };
            if point {
                self.file.declared.push((bare(&name).into(), kind.clone()));
            }
            if at.take(b'=') {
                let line = at.peek().map_or(0, |token| token.line);
                if !at.take(b'{') {
                    return Ok(());
                }
                let aggregate = Aggregate::read(at, line)?;
                if point {
                    self.value(&name, &aggregate, Some(&kind));
                } else if kind == "LOAD" {
                    self.load(&name, &aggregate);
                } else if kind == "FDAT" {
                    self.frame_data(&name, &aggregate);
                }
            }
            if !at.take(b',') {
                return Ok(());
            }
        }
    }

    /// `XP1 = {…}`, `$BASE = …`, `XP1.X = …`, `FDAT_ACT = FP1`, `call()`.
    fn assignment(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        let line = at.peek().map_or(0, |token| token.line);
        let Some(name) = name(at) else { return Ok(()) };
        if at.take(b'.') {
            if let Some(which) = ["$BASE", "$TOOL", "$LOAD"].iter().position(|active| *active == name) {
                self.flow.set(which, Reference::Unknown(format!("a part of it is set in line {line}")));
            }
            self.file.changed.push((name, line));
            return Ok(());
        }
        if at.take(b'(') {
            if name != "PULSE" {
                for which in [FRAME, TOOL, LOAD] {
                    let words = format!("{name} is called before, which may change it");
                    self.flow.set(which, Reference::Unknown(words));
                }
            }
            self.odd(at, &name, line);
            self.file.steps.push(Step::Call(name));
            return Ok(());
        }
        if !at.take(b'=') {
            self.odd(at, &name, line);
            return Ok(());
        }
        match name.as_str() {
            "$BASE" | "$TOOL" | "$LOAD" => {
                let which = match name.as_str() {
                    "$BASE" => FRAME,
                    "$TOOL" => TOOL,
                    _ => LOAD,
                };
                let to = self.reference(at, which)?;
                self.flow.set(which, to);
            }
            "$IPO_MODE" => self.mode(at),
            "FDAT_ACT" => {
                if let Some(data) = self::name(at) {
                    self.flow.set(FRAME, Reference::Named(format!("{data}.BASE_NO")));
                    self.flow.set(TOOL, Reference::Named(format!("{data}.TOOL_NO")));
                    self.flow.set(LOAD, Reference::Named(format!("{data}.LOAD_NO")));
                }
            }
            _ if at.take(b'{') => {
                let aggregate = Aggregate::read(at, line)?;
                if at.take(b':') {
                    self.file.changed.push((name, line));
                } else {
                    self.value(&name, &aggregate, None);
                }
            }
            _ => self.file.changed.push((name, line)),
        }
        Ok(())
    }

    /// A motion or a point behind a keyword, where the language has none.
    fn inline(&mut self, at: &mut Cursor<'t>, name: &str) {
        let line = at.peek().map_or(0, |token| token.line);
        let from = self.file.odd.len();
        at.word();
        self.odd(at, name, line);
        // Names alone are a condition.
        if self.file.odd.last().is_some_and(|(.., literal)| !literal) {
            self.file.odd.truncate(from);
        }
    }

    /// A statement that is no motion: what a motion would have in it.
    fn odd(&mut self, at: &mut Cursor<'t>, name: &str, line: usize) {
        if STILL.contains(&name) {
            return;
        }
        let (mut names, mut literal, mut verb) = (Vec::new(), false, false);
        while let Some(token) = at.next() {
            match token.kind {
                Kind::Word => {
                    let word = at.str_of(token).to_ascii_uppercase();
                    verb |= MOTIONS.contains(&word.as_str());
                    names.push(word);
                }
                Kind::Sign(b'{') => {
                    let parts = [at.tokens.get(at.at), at.tokens.get(at.at + 2)];
                    let mut words =
                        parts.into_iter().flatten().map(|token| at.str_of(token).to_ascii_uppercase());
                    literal |= words.any(|word| ["X", "Y", "Z", "A1", "A2"].contains(&word.as_str()));
                }
                _ => {}
            }
        }
        if literal || verb || !names.is_empty() {
            self.file.odd.push((line, name.into(), names, literal || verb));
        }
    }

    /// A literal under a name: a frame, or what may be a point.
    fn value(&mut self, name: &str, aggregate: &Aggregate<'_>, kind: Option<&str>) {
        let list = bare(name);
        if list == "LOAD_DATA" {
            return self.load(name, aggregate);
        }
        if name.starts_with('$') || list == "BASE_DATA" || list == "TOOL_DATA" {
            if let Some(pose) = pose(aggregate) {
                self.file.definitions.push((name.into(), Definition::Value(pose)));
            }
            return;
        }
        let declared = || self.file.declared.iter().find(|(declared, _)| declared == list);
        let kind = kind.map(str::to_owned).or_else(|| declared().map(|(_, kind)| kind.clone()));
        let frame = kind.as_deref() == Some("FRAME");
        if let Some(pose) = pose(aggregate).filter(|_| frame) {
            self.file.definitions.push((name.into(), Definition::Value(pose)));
        }
        if let Some(candidate) = candidate(self.text, name, aggregate, frame, kind.is_some()) {
            self.file.candidates.push(candidate);
        }
    }
}

/// Before anything is set.
fn unset() -> Active {
    let [frame, tool, _] = unknown("it is not set before");
    [frame, tool, Reference::Unknown("$LOAD is not set before".into())]
}

/// A name in capitals, with a literal index; `[*]` for any other.
pub(super) fn name(at: &mut Cursor<'_>) -> Option<String> {
    let mut name = at.word()?.to_ascii_uppercase();
    if at.take(b'[') {
        let index = at.number().filter(|_| at.peek().is_some_and(|token| token.is(b']')));
        name.push_str(&index.map_or("[*]".into(), |(index, _)| format!("[{index:.0}]")));
        at.skip_closed();
    }
    Some(name)
}

/// Without its index.
pub(super) fn bare(name: &str) -> &str {
    name.split('[').next().unwrap_or(name)
}
