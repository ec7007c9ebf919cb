//! Instructions: which points are reached, and which are displaced on the way.

use crate::lines::Line;
use crate::note::Note;
use crate::program::Reference;
use std::collections::{BTreeMap, BTreeSet};

#[derive(Debug)]
pub(super) struct Motions {
    /// Numbers of the points in the order of the program (none: another place), whether the way is a line or an arc, and the line.
    pub(super) reached: Vec<(Option<i64>, bool, usize)>,
    /// Points that an instruction displaces, and why.
    pub(super) displaced: Vec<(i64, String)>,
    /// Points with the payload that is active at a motion to them.
    pub(super) carried: BTreeMap<i64, Reference>,
    pub(super) notes: Vec<Note>,
    payload: Reference,
    /// Whether lines are left out or run in another order.
    jumps: bool,
    /// Numbers of the points that have a value.
    known: BTreeSet<i64>,
}

/// Parts of words behind a point that move it, or the robot relative to something, in the languages of the controllers.
const DISPLACING: [&str; 4] = ["OFFS", "VERSATZ", "DECAL", "DESPL"];
const DISPLACES: [&str; 8] = ["INC", "INK", "INKR", "INCR", "COORD", "KOORD", "SEARCH", "SUCHE"];

/// The tool stands still.
const REMOTE: &str = "RTCP";

/// Words behind a point that leave it where it is: speeds, terminations, conditions, processes.
const HARMLESS: [&str; 86] = [
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
    "SKIP",
    "INTERRUPT",
    "LBL",
    "LABEL",
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
const ACTIONS: [&str; 12] =
    ["TA", "TB", "DB", "TIME", "ZEIT", "TEMPS", "TIEMPO", "CALL", "AUFRUF", "DO", "DISTANCE", "POINT_LOGIC"];

pub(super) fn read(lines: &[Line<'_>], known: &[i64]) -> Motions {
    let mut found = Motions {
        reached: Vec::new(),
        displaced: Vec::new(),
        carried: BTreeMap::new(),
        notes: Vec::new(),
        payload: Reference::Unknown("no PAYLOAD is before it".into()),
        jumps: false,
        known: known.iter().copied().collect(),
    };
    let mut statement: Vec<u8> = Vec::new();
    let mut begun = 0;
    for line in lines {
        let text = line.trimmed();
        let digits = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let Some(rest) = text[digits..].strip_prefix(b":") else { continue };
        if digits > 0 {
            found.statement(&statement, begun);
            statement.clear();
            begun = line.number;
        }
        statement.extend_from_slice(rest);
        statement.push(b' ');
    }
    found.statement(&statement, begun);
    if found.jumps && found.carried.values().any(|load| *load != found.payload) {
        let unknown = Reference::Unknown("the program jumps, and has several PAYLOADs".into());
        found.carried.values_mut().for_each(|load| load.clone_from(&unknown));
    }
    found
}

impl Motions {
    fn statement(&mut self, bytes: &[u8], line: usize) {
        let text = String::from_utf8_lossy(bytes);
        let text = text.trim();
        if text.is_empty() || text.starts_with(['!', '/', '-']) {
            return;
        }
        let rest = text.strip_prefix(['J', 'L', 'C', 'A', 'S']).unwrap_or("");
        let goes = rest.trim_start().starts_with("P[") || rest.trim_start().starts_with("PR[");
        if goes {
            self.motion(rest, text, line);
        } else if let Some(rest) = ["PAYLOAD[", "TRAGLST["].iter().find_map(|word| text.strip_prefix(word)) {
            let number = rest.split(']').next().and_then(|number| number.trim().parse::<u32>().ok());
            let computed = || Reference::Unknown(format!("{} in line {line} is computed", shown(text)));
            self.payload =
                number.map_or_else(computed, |number| Reference::Named(format!("PAYLOAD[{number}]")));
        } else if text.starts_with("JMP") || text.starts_with("IF") || text.starts_with("SELECT") {
            self.jumps = true;
            self.odd(text, line);
        } else {
            self.odd(text, line);
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
        let stated = words.iter().position(|word| ACTIONS.contains(&word.as_str())).unwrap_or(words.len());
        let harmless =
            |word: &String| HARMLESS.contains(&word.trim_end_matches(|c: char| c.is_ascii_digit()));
        if why.is_none()
            && let Some(word) = words[..stated].iter().find(|word| !harmless(word))
        {
            let words = format!("`{word}` behind its point is not understood");
            self.notes.push(Note::refusing(line, shown(text), words));
        }
        let linear = !text.starts_with('J');
        // Register arguments behind Offset are none of the destinations: at most two stand in front.
        let places = if text.starts_with('C') { 2 } else { 1 };
        for (list, number) in all.into_iter().take(places) {
            match number.filter(|_| list == "P") {
                Some(number) if !self.known.contains(&number) => {
                    self.reached.push((None, linear, line));
                    self.notes.push(Note::missing(line, shown(text), format!("P[{number}]")));
                }
                Some(number) => {
                    let load = self.carried.entry(number).or_insert_with(|| self.payload.clone());
                    if *load != self.payload {
                        *load = Reference::Unknown("it is used with several PAYLOADs".into());
                    }
                    self.reached.push((Some(number), linear, line));
                    self.displaced.extend(why.clone().map(|words| (number, words)));
                }
                None => {
                    self.reached.push((None, linear, line));
                    let number = number.map_or("…".into(), |number| number.to_string());
                    self.notes.push(Note::missing(line, shown(text), format!("{list}[{number}]")));
                }
            }
        }
    }
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

fn shown(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").trim_end_matches(" ;").chars().take(60).collect()
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
