//! What one file says, statement by statement.

use super::aggregate::Aggregate;
use super::candidate::{Candidate, candidate, pose};
use crate::ControllerError;
use crate::flow::{Active, FRAME, Flow, TOOL};
use crate::program::{Definition, Reference};
use crate::tokens::{Cursor, Kind, Lexis, tokens};

const LEXIS: Lexis = Lexis { comment: b';', quotes: b"\"'", header: Some(b'&'), escapes: false };
const TYPES: [&str; 5] = ["E6POS", "POS", "E6AXIS", "AXIS", "FRAME"];
const MOTIONS: [&str; 7] = ["PTP", "LIN", "CIRC", "SPTP", "SLIN", "SCIRC", "SPL"];

/// A motion to a name, or to something that is computed.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub(super) line: usize,
    /// As written.
    pub(super) shown: String,
    /// The name, where it is one alone.
    pub(super) name: Option<String>,
    /// Relative to where the robot is, or computed from this name.
    pub(super) computed: bool,
    pub(super) used: usize,
    /// Whether an aggregate stands there.
    pub(super) inline: bool,
}

#[derive(Debug, Clone)]
pub(super) struct File {
    pub(super) candidates: Vec<Candidate>,
    pub(super) motions: Vec<Motion>,
    pub(super) uses: Vec<Active>,
    pub(super) definitions: Vec<(String, Definition)>,
    /// Names of points with their types, as declared.
    pub(super) declared: Vec<(String, String)>,
    /// Names whose value is changed by a statement that is no literal, and its line.
    pub(super) changed: Vec<(String, usize)>,
}

struct Reader<'t> {
    text: &'t [u8],
    flow: Flow,
    file: File,
}

impl File {
    pub(super) fn read(text: &[u8]) -> Result<File, ControllerError> {
        let all = tokens(text, LEXIS)?;
        let file = File {
            candidates: Vec::new(),
            motions: Vec::new(),
            uses: Vec::new(),
            definitions: Vec::new(),
            declared: Vec::new(),
            changed: Vec::new(),
        };
        let mut reader = Reader { text, flow: Flow::new("it is not set before"), file };
        for line in all.split_inclusive(|token| token.kind == Kind::End) {
            reader.statement(&mut Cursor::new(text, line))?;
        }
        reader.file.uses = reader.flow.uses;
        Ok(reader.file)
    }
}

impl<'t> Reader<'t> {
    fn statement(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        let Some(first) = at.peek_word().map(str::to_ascii_uppercase) else { return Ok(()) };
        match first.as_str() {
            "IF" | "SWITCH" => self.flow.open(false),
            "ELSE" | "CASE" | "DEFAULT" => self.flow.branch(),
            "FOR" | "WHILE" | "LOOP" | "REPEAT" => self.flow.open(true),
            "ENDIF" | "ENDSWITCH" | "ENDFOR" | "ENDWHILE" | "ENDLOOP" | "UNTIL" => self.flow.close(),
            "DEF" | "DEFFCT" => {
                let unknown = || Reference::Unknown("it is not set before".into());
                self.flow.restart([unknown(), unknown()]);
            }
            "DECL" | "GLOBAL" | "CONST" => return self.declaration(at),
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

    /// `DECL E6POS XP1={…}, XP2`.
    fn declaration(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        let mut kind = String::new();
        while let Some(word) = at.word() {
            kind = word.to_ascii_uppercase();
            if kind == "DEF" || kind == "DEFFCT" {
                let unknown = || Reference::Unknown("it is not set before".into());
                self.flow.restart([unknown(), unknown()]);
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
            self.file.changed.push((name, line));
            return Ok(());
        }
        if at.take(b'(') {
            if name != "PULSE" {
                for which in [FRAME, TOOL] {
                    let words = format!("{name} is called before, which may change it");
                    self.flow.set(which, Reference::Unknown(words));
                }
            }
            return Ok(());
        }
        if !at.take(b'=') {
            return Ok(());
        }
        match name.as_str() {
            "$BASE" | "$TOOL" => {
                let which = if name == "$BASE" { FRAME } else { TOOL };
                let to = self.reference(at, which)?;
                self.flow.set(which, to);
            }
            "$IPO_MODE" => {
                at.take(b'#');
                if !at.word().is_some_and(|word| word.eq_ignore_ascii_case("BASE")) {
                    self.fixed_tool();
                }
            }
            "FDAT_ACT" => {
                if let Some(data) = self::name(at) {
                    self.flow.set(FRAME, Reference::Named(format!("{data}.BASE_NO")));
                    self.flow.set(TOOL, Reference::Named(format!("{data}.TOOL_NO")));
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

    fn fixed_tool(&mut self) {
        for which in [FRAME, TOOL] {
            let words = "the tool stands still ($IPO_MODE = #TCP), which is not compensated";
            self.flow.set(which, Reference::Unknown(words.into()));
        }
    }

    /// `BAS(#BASE,2)`.
    fn bas(&mut self, at: &mut Cursor<'t>) {
        at.word();
        at.take(b'(');
        at.take(b'#');
        let what = at.word().map(str::to_ascii_uppercase);
        let which = match what.as_deref() {
            Some("BASE") => FRAME,
            Some("TOOL") => TOOL,
            _ => return,
        };
        let list = if which == FRAME { "BASE_DATA" } else { "TOOL_DATA" };
        at.take(b',');
        let to = match at.number() {
            Some((number, _)) if at.take(b')') => Reference::Named(format!("{list}[{number:.0}]")),
            _ => Reference::Unknown("its number is computed".into()),
        };
        self.flow.set(which, to);
    }

    /// The right side of `$BASE =`.
    fn reference(&mut self, at: &mut Cursor<'t>, which: usize) -> Result<Reference, ControllerError> {
        let line = at.peek().map_or(0, |token| token.line);
        let found = if at.take(b'{') {
            let aggregate = Aggregate::read(at, line)?;
            pose(&aggregate).map_or(Reference::Unknown("its value is computed".into()), Reference::Value)
        } else {
            match name(at).as_deref() {
                Some("$NULLFRAME") => Reference::Identity,
                Some("STOOL2" | "STOOL" | "SBASE") if at.take(b'(') => {
                    let data = name(at).unwrap_or_default();
                    at.skip_closed();
                    let part = if which == FRAME { "BASE_NO" } else { "TOOL_NO" };
                    Reference::Named(format!("{data}.{part}"))
                }
                Some(name) => Reference::Named(name.into()),
                None => Reference::Unknown("its value is computed".into()),
            }
        };
        let ends = at.peek().is_none_or(|token| token.kind == Kind::End || token.is(b','));
        Ok(if ends { found } else { Reference::Unknown("its value is computed".into()) })
    }

    /// `FDAT FP1={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE}`.
    fn frame_data(&mut self, name: &str, aggregate: &Aggregate<'_>) {
        let still = aggregate.entry("IPO_FRAME").is_some_and(|entry| {
            entry
                .tokens
                .last()
                .is_some_and(|token| self.text[token.range.clone()].eq_ignore_ascii_case(b"TCP"))
        });
        for (part, list) in [("BASE_NO", "BASE_DATA"), ("TOOL_NO", "TOOL_DATA")] {
            let definition = match aggregate.value(part) {
                _ if still => Definition::Unusable(format!(
                    "the tool stands still (IPO_FRAME #TCP in {name}), which is not compensated"
                )),
                Some(number) => Definition::SameAs(format!("{list}[{number:.0}]")),
                None => Definition::Unusable(format!("{name} has no {part}")),
            };
            self.file.definitions.push((format!("{name}.{part}"), definition));
        }
    }

    /// A literal under a name: a frame, or what may be a point.
    fn value(&mut self, name: &str, aggregate: &Aggregate<'_>, kind: Option<&str>) {
        let list = bare(name);
        if name.starts_with('$') || list == "BASE_DATA" || list == "TOOL_DATA" {
            if let Some(pose) = pose(aggregate) {
                self.file.definitions.push((name.into(), Definition::Value(pose)));
            }
            return;
        }
        let declared = self.file.declared.iter().find(|(declared, _)| declared == list);
        let frame = kind.or(declared.map(|(_, kind)| kind.as_str())) == Some("FRAME");
        if let Some(pose) = pose(aggregate).filter(|_| frame) {
            self.file.definitions.push((name.into(), Definition::Value(pose)));
        }
        let typed = kind.is_some() || declared.is_some();
        if let Some(candidate) = candidate(self.text, name, aggregate, frame, typed) {
            self.file.candidates.push(candidate);
        }
    }

    /// `LIN XP1 C_DIS`, `CIRC {…}, {…}`, `SPTP XP1 WITH $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO)`.
    fn motion(&mut self, at: &mut Cursor<'t>, relative: bool) -> Result<(), ControllerError> {
        let verb = at.word().unwrap_or("").to_ascii_uppercase();
        let before = self.flow.clone();
        let with = at.tokens.iter().position(|token| {
            token.kind == Kind::Word && self.text[token.range.clone()].eq_ignore_ascii_case(b"WITH")
        });
        if let Some(with) = with {
            self.with(&mut Cursor { at: with + 1, ..at.clone() })?;
        }
        let used = self.flow.motion();
        // Settings behind WITH are of this motion alone.
        let uses = std::mem::take(&mut self.flow.uses);
        if with.is_some() {
            self.flow = before;
        }
        self.flow.uses = uses;
        let places = if verb.contains("CIRC") { 2 } else { 1 };
        for place in 0..places {
            if place > 0 && !at.take(b',') {
                break;
            }
            self.destination(at, &verb, relative, used)?;
        }
        Ok(())
    }

    fn destination(
        &mut self,
        at: &mut Cursor<'t>,
        verb: &str,
        relative: bool,
        used: usize,
    ) -> Result<(), ControllerError> {
        let Some(token) = at.peek() else { return Ok(()) };
        let (line, start) = (token.line, token.range.start);
        let mut motion =
            Motion { line, shown: verb.into(), name: None, computed: relative, used, inline: false };
        if at.take(b'{') {
            let aggregate = Aggregate::read(at, line)?;
            motion.inline = true;
            if at.peek().is_some_and(|token| token.is(b':')) {
                motion.computed = true;
            } else if !relative {
                let named = format!("{verb} in line {line}");
                let found = candidate(self.text, &named, &aggregate, false, true);
                self.file.candidates.extend(found.map(|c| Candidate { inline: Some(used), ..c }));
            }
        } else {
            motion.name = name(at);
            // `XP1 : F`, `f(XP1)`, `XP1.X`.
            let more = [b':', b'(', b'.'].iter().any(|&sign| at.peek().is_some_and(|token| token.is(sign)));
            motion.computed |= more;
        }
        while at.peek().is_some_and(|token| !matches!(token.kind, Kind::End | Kind::Sign(b','))) {
            if at.next().is_some_and(|token| matches!(token.kind, Kind::Sign(b'(' | b'{' | b'['))) {
                at.skip_closed();
            }
        }
        let end = at.tokens[..at.at.min(at.tokens.len())].last().map_or(start, |token| token.range.end);
        motion.shown =
            format!("{verb} {}", String::from_utf8_lossy(&self.text[start..end.max(start)]).trim());
        self.file.motions.push(motion);
        Ok(())
    }

    fn with(&mut self, at: &mut Cursor<'t>) -> Result<(), ControllerError> {
        while let Some(token) = at.next() {
            let which = match &self.text[token.range.clone()] {
                word if word.eq_ignore_ascii_case(b"$BASE") => FRAME,
                word if word.eq_ignore_ascii_case(b"$TOOL") => TOOL,
                _ => continue,
            };
            if at.take(b'=') {
                let to = self.reference(at, which)?;
                self.flow.set(which, to);
            }
        }
        Ok(())
    }
}

/// A name in capitals, with a literal index; `[*]` for any other.
fn name(at: &mut Cursor<'_>) -> Option<String> {
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
