//! Instructions: which points are reached, and which are displaced on the way.

use super::settings::{PAYLOAD, Selected, Setting, WHAT, setting};
use super::statements::{called, jumps, shown, statements};
use super::subprograms::Subprograms;
use crate::lines::Line;
use crate::note::Note;
use crate::reference::Reference;
use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug)]
pub(super) struct Motions<'s> {
    /// Places in the order of the program, whether the way is a line or an arc, and the line.
    pub(super) reached: Vec<(Place, bool, usize)>,
    /// Motions to position registers that have a value.
    pub(super) registered: Vec<Registered>,
    /// Position registers that get another value (none: one that is computed), with the line.
    pub(super) changed: Vec<(Option<i64>, usize)>,
    /// Points that an instruction displaces, and why.
    pub(super) displaced: Vec<(i64, String)>,
    /// Points with the payload that is active at a motion to them.
    pub(super) carried: BTreeMap<i64, Reference>,
    pub(super) notes: Vec<Note>,
    selected: Selected,
    /// Whether lines are left out or run in another order.
    jumps: bool,
    /// The line of an offset by touching that is on.
    touched: Option<usize>,
    subprograms: &'s Subprograms,
    /// Numbers of the points that have a value.
    known: BTreeSet<i64>,
    /// Those of position registers.
    registers: &'s BTreeSet<i64>,
}

/// Where a motion goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Place {
    /// `P[n]`
    Point(i64),
    /// `PR[n]`
    Register(i64),
    Elsewhere,
}

/// A motion to a position register.
#[derive(Debug)]
pub(super) struct Registered {
    pub(super) number: i64,
    pub(super) selected: Selected,
    /// Why it must not be changed.
    pub(super) fixed: Option<String>,
}

/// Parts of words behind a point that move it, or the robot relative to something, in the languages of the controllers.
const DISPLACING: [&str; 4] = ["OFFS", "VERSATZ", "DECAL", "DESPL"];
const DISPLACES: [&str; 8] = ["INC", "INK", "INKR", "INCR", "COORD", "KOORD", "SEARCH", "SUCHE"];

/// The tool stands still.
const REMOTE: &str = "RTCP";

/// Words behind a point that leave it where it is: speeds, terminations, conditions, processes.
const HARMLESS: [&str; 91] = [
    "MM",
    "CM",
    "INCH",
    "ZOLL",
    "DEG",
    "GRAD",
    "SEC",
    "SEK",
    "MSEC",
    "MSEK",
    "MIN",
    "S",
    "MAX_SPEED",
    "MAX_GESCHW",
    "MAX_VEL",
    "WELD_SPEED",
    "R",
    "AR",
    "FINE",
    "FEIN",
    "FIN",
    "CNT",
    "CR",
    "CD",
    "ACC",
    "WJNT",
    "HGELENK",
    "PTH",
    "EV",
    "IND",
    "IND.EV",
    "SKIP",
    "INTERRUPT",
    "LBL",
    "LABEL",
    "LPOS",
    "JPOS",
    "CTV",
    "AC",
    "P",
    "PR",
    "QUICK",
    "SKIPJUMP",
    "PSPD",
    "BREAK",
    "MROT",
    "LOCK",
    "RT_LD",
    "AP_LD",
    "DIST",
    "MPASS",
    "ARC",
    "WELD",
    "SPOT",
    "START",
    "END",
    "ON",
    "OFF",
    "EIN",
    "AUS",
    "AN",
    "SV",
    "GUN",
    "BU",
    "BACKUP",
    "PRESS",
    "PRESS_MOTN",
    "WS",
    "WE",
    "WEAVE",
    "SINE",
    "TRACK",
    "TAST",
    "AVC",
    "SS",
    "SE",
    "SEAL",
    "SEALING",
    "GLUE",
    "LASER",
    "PAINT",
    "VIA",
    "TANGENT",
    "ATT",
    "HOP",
    "TOUCHUP",
    "RSV",
    "LV",
    "LE",
    "LS",
    "PATH",
];

/// Words behind which an action is stated, with names of its own.
const ACTIONS: [&str; 14] = [
    "TA",
    "TB",
    "DB",
    "DA",
    "TIME",
    "ZEIT",
    "WEG",
    "TEMPS",
    "TIEMPO",
    "CALL",
    "AUFRUF",
    "DO",
    "DISTANCE",
    "POINT_LOGIC",
];

pub(super) fn read<'s>(
    lines: &[Line<'_>],
    known: &[i64],
    registers: &'s BTreeSet<i64>,
    subprograms: &'s Subprograms,
) -> Motions<'s> {
    let mut found = Motions {
        reached: Vec::new(),
        registered: Vec::new(),
        changed: Vec::new(),
        displaced: Vec::new(),
        carried: BTreeMap::new(),
        notes: Vec::new(),
        selected: WHAT.map(|word| Reference::Unknown(format!("no {word} is before it"))),
        jumps: false,
        touched: None,
        subprograms,
        registers,
        known: known.iter().copied().collect(),
    };
    for (text, line) in statements(lines) {
        found.statement(&text, line);
    }
    let several = |word: &str| Reference::Unknown(format!("the program jumps, and has several {word}s"));
    if found.jumps && found.carried.values().any(|load| *load != found.selected[PAYLOAD]) {
        let unknown = several(WHAT[PAYLOAD]);
        found.carried.values_mut().for_each(|load| load.clone_from(&unknown));
    }
    for (which, word) in WHAT.iter().enumerate().filter(|_| found.jumps) {
        if found.registered.iter().any(|used| used.selected[which] != found.selected[which]) {
            found.registered.iter_mut().for_each(|used| used.selected[which] = several(word));
        }
    }
    found
}

impl Motions<'_> {
    fn statement(&mut self, text: &str, line: usize) {
        // `PR[3]=LPOS`, `PR[3,2]=…`, `Skip,LBL[1],PR[5]=LPOS`.
        let ends = text.match_indices(']').filter(|(at, _)| text[at + 1..].trim_start().starts_with('='));
        let written = ends.filter_map(|(at, _)| references(&text[..=at]).pop());
        let changed = written.filter(|(list, _)| *list == "PR").map(|(_, number)| (number, line));
        self.changed.extend(changed.collect::<Vec<_>>());
        if let Some(rest) = destinations(text) {
            self.motion(rest, text, line);
        } else if let Some(setting) = setting(text, line) {
            match setting {
                Setting::To(which, to) => self.selected[which] = to,
                Setting::OfAnotherGroup => return,
            }
        } else {
            self.jumps |= jumps(text);
            let plain = text.to_uppercase().replace(' ', "");
            if plain.starts_with("TOUCHOFFSET") {
                self.touched = (!plain.starts_with("TOUCHOFFSETEND")).then_some(line);
            }
            self.odd(text, line);
        }
        for name in called(text) {
            self.subprograms.call(&name, line, &mut self.selected);
        }
    }

    /// A statement that is no motion.
    fn odd(&mut self, text: &str, line: usize) {
        if references(text).iter().any(|name| name.0 == "P") {
            let words = match text.starts_with("PR[") {
                true => {
                    "a position register is computed from a point: from a compensated one it comes out displaced"
                }
                false => "it has a point and is not understood: whether the robot moves there is not known",
            };
            self.notes.push(Note::refusing(line, shown(text), words.into()));
        }
    }

    fn motion(&mut self, rest: &str, text: &str, line: usize) {
        let all = references(rest);
        let linear = !text.starts_with('J');
        if all.is_empty() {
            self.reached.push((Place::Elsewhere, linear, line));
            let words = "its position is that of no list of the program: where the robot moves is not known";
            self.notes.push(Note::refusing(line, shown(text), words.into()));
            return;
        }
        let words = behind(rest);
        let displaces = |word: &&String| {
            DISPLACES.contains(&word.as_str()) || DISPLACING.iter().any(|part| word.contains(part))
        };
        let displacing = words.iter().find(displaces);
        let mut why =
            displacing.map(|word| format!("{word} in line {line} displaces it while the program runs"));
        if words.iter().any(|word| word == REMOTE) {
            why = Some(format!("{REMOTE} in line {line}: the tool stands still, which is not compensated"));
        }
        if let (None, Some(line)) = (&why, self.touched) {
            why = Some(format!("Touch Offset in line {line} displaces it while the program runs"));
        }
        let stated = words.iter().position(|word| ACTIONS.contains(&word.as_str())).unwrap_or(words.len());
        let harmless =
            |word: &String| HARMLESS.contains(&word.trim_end_matches(|c: char| c.is_ascii_digit()));
        if why.is_none()
            && let Some(word) = words[..stated].iter().find(|word| !harmless(word))
        {
            let words = format!("`{word}` behind its point is not understood");
            self.notes.push(Note::refusing(line, shown(text), words));
        }
        // Register arguments behind Offset are none of the destinations: at most two stand in front.
        let places = if text.starts_with('C') { 2 } else { 1 };
        for (list, number) in all.into_iter().take(places) {
            match number.filter(|_| list == "P") {
                Some(number) if !self.known.contains(&number) => {
                    self.reached.push((Place::Elsewhere, linear, line));
                    self.notes.push(Note::missing(line, shown(text), format!("P[{number}]")));
                }
                Some(number) => {
                    let payload = &self.selected[PAYLOAD];
                    let load = self.carried.entry(number).or_insert_with(|| payload.clone());
                    if load != payload {
                        *load = Reference::Unknown("it is used with several PAYLOADs".into());
                    }
                    self.reached.push((Place::Point(number), linear, line));
                    self.displaced.extend(why.clone().map(|words| (number, words)));
                }
                None if number.is_some_and(|number| self.registers.contains(&number)) => {
                    let number = number.unwrap_or_default();
                    self.reached.push((Place::Register(number), linear, line));
                    let (selected, fixed) = (self.selected.clone(), why.clone());
                    self.registered.push(Registered { number, selected, fixed });
                }
                None => {
                    self.reached.push((Place::Elsewhere, linear, line));
                    let number = number.map_or("…".into(), |number| number.to_string());
                    self.notes.push(Note::missing(line, shown(text), format!("{list}[{number}]")));
                }
            }
        }
    }
}

/// What follows the letter of a motion: `L P[1] …`, `J @P[2] …`, `L PAL_1[BTM] …`.
fn destinations(text: &str) -> Option<&str> {
    let rest = text.strip_prefix(['J', 'L', 'C', 'A', 'S'])?;
    let to = rest.trim_start().trim_start_matches('@');
    let name = to.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    let blank = rest.starts_with(|c: char| c.is_whitespace() || c == '@');
    let list = to.starts_with("P[") || to.starts_with("PR[");
    (list || blank && name.len() < to.len() && name.starts_with('[')).then_some(to)
}

/// Words behind the first point in capitals, without what is in brackets and quotes.
fn behind(rest: &str) -> Vec<String> {
    let mut plain = String::new();
    let (mut depth, mut quoted) = (0usize, false);
    for c in rest.chars() {
        match c {
            '"' | '\'' => quoted = !quoted,
            '[' if !quoted => depth += 1,
            ']' if !quoted => depth = depth.saturating_sub(1),
            _ if depth > 0 || quoted => continue,
            c => {
                plain.push(c);
                continue;
            }
        }
        plain.push(' ');
    }
    let words = plain.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '.'));
    let words = words.map(|word| word.trim_matches('.').to_uppercase());
    // `.5sec`, `500mm`: a number and its unit.
    let unit = |word: String| word.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').to_owned();
    words.map(unit).filter(|word| !word.is_empty()).collect()
}

/// `P[3:name]`, `PR[1]`, `P[R[2]]`: list and number, none where that is computed.
fn references(text: &str) -> Vec<(&str, Option<i64>)> {
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(at) = text[from..]
        .find("P[")
        .map(|at| from + at)
        .into_iter()
        .chain(text[from..].find("PR[").map(|at| from + at))
        .min()
    {
        let joined = text[..at].ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
        let list = if text[at..].starts_with("PR[") { "PR" } else { "P" };
        let inside = &text[at + list.len() + 1..];
        from = at + list.len() + 1;
        if joined {
            continue;
        }
        let digits: String = inside.trim_start().chars().take_while(char::is_ascii_digit).collect();
        let behind = inside.trim_start()[digits.len()..].trim_start();
        let whole = behind.starts_with(']') || behind.starts_with(':') || behind.starts_with(',');
        found.push((list, digits.parse().ok().filter(|_| whole)));
        // A name behind the number may hold anything.
        from += inside.find(']').map_or(inside.len(), |end| end + 1);
    }
    found
}
